"""Contacts on a Dask cluster: one of other machines, or one that is started here."""

from __future__ import annotations

import logging
import os
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING

from roughcontact import processes
from roughcontact.errors import InputError
from roughcontact.fleet.engine import AWAY, GONE, THERE, Engine
from roughcontact.halfspace.fft import default_workers
from roughcontact.units import counted

if TYPE_CHECKING:
    from distributed import Client, LocalCluster, Security

# Seconds within which a scheduler must answer, at first and where it was lost.
_PATIENCE = 30
# Seconds for which a scheduler may be without workers.
_WORKERLESS = 600
_LARGE = "distributed.admin.large-graph-warning-threshold"
# Seconds for which the number of workers is taken as known.
_KNOWN = 1.0
# Seconds that a process may take to end when it is told to, and from look to look.
_DYING, _LOOK = 2.0, 0.005


@contextmanager
def connected(scheduler: str | None, workers: int) -> Iterator[Engine]:
    """Give a Dask cluster.

    Parameters
    ----------
    scheduler : str or None
        Address of its scheduler; each thread of its workers works on one contact. Without it, a
        cluster is started on this machine, which ends with the block and serves nobody else.
    workers : int
        Processes of the cluster that is started. Cores that are left over are shared.

    Yields
    ------
    Engine
        The cluster.

    Raises
    ------
    InputError
        If Dask is not installed, or the scheduler does not answer.
    """
    try:
        import dask
        from distributed import Client, Security
        from distributed.utils import silence_logging_cmgr

        # Whoever reaches a scheduler has it run what he likes: one of our own knows this run alone.
        security = None if scheduler else Security.temporary()
    except ImportError:
        raise InputError(
            "dask needs Dask and cryptography; run pip install 'roughcontact[cluster]'",
            argument="engine",
        ) from None
    with ExitStack() as stack:
        # One sentence tells what matters of what Dask logs; files that travel are meant to.
        stack.enter_context(silence_logging_cmgr(logging.CRITICAL))
        stack.enter_context(dask.config.set({_LARGE: "1GiB"}))
        own = None if scheduler else stack.enter_context(_started(workers, security))
        address = own.scheduler_address if own is not None else scheduler
        try:
            client = stack.enter_context(Client(address, timeout=_PATIENCE, security=security))
        except (OSError, ValueError, TypeError, ImportError) as error:
            # Of protocols that need more than was given.
            raise InputError(
                f"does not answer at {scheduler!r} ({' '.join(str(error).split())}); is it the "
                "address that dask scheduler has printed?", argument="scheduler",
                value=scheduler,
            ) from None  # fmt: skip
        executor = client.get_executor(pure=False)
        yield Engine(
            executor,
            _slots(client),
            1 if scheduler else max(1, default_workers() // workers),
            stop=partial(_end, executor, own),
            far=scheduler is not None,
            state=partial(_state, client),
            lost=partial(_lost, client, f"the scheduler at {address}"),
            shared=_shared,
            dashboard=client.dashboard_link or "",
            workers=f"of the scheduler at {address} (dask worker {address})",
            patience=_WORKERLESS,
        )


@contextmanager
def _started(workers: int, security: Security) -> Iterator[LocalCluster]:
    """Give a cluster of processes of this machine."""
    from distributed import LocalCluster

    with ExitStack() as stack:
        # Its processes do not hear Ctrl-C, which this one answers, when it can end them.
        with processes.deaf():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                # The program asks for the memory itself, before it begins with a contact.
                memory_limit=0,
                host="127.0.0.1",
                security=security,
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
            stack.enter_context(cluster)
        yield cluster


def _end(executor: Executor, own: LocalCluster | None) -> None:
    """Hand out nothing more, and let processes of this machine not go on with what they have."""
    executor.shutdown(wait=False)
    # A list: the cluster forgets those that have ended.
    nannies = [] if own is None else list(own.workers.values())
    for nanny in nannies:
        # Else it begins another one.
        nanny.close_gracefully()
        with suppress(OSError, TypeError):
            os.kill(nanny.pid, signal.SIGTERM)
    # What they were writing can be removed when they are gone.
    last = time.monotonic() + _DYING
    while any(nanny.is_alive() for nanny in nannies) and time.monotonic() < last:
        time.sleep(_LOOK)


def _slots(client: Client) -> Callable[[], int]:
    """Return what tells how many threads the workers have, which come and go."""
    known = [0, -_KNOWN]

    def slots() -> int:
        if time.monotonic() - known[1] > _KNOWN and _state(client) == THERE:
            # Where the scheduler is just being lost, that is told otherwise.
            with suppress(OSError, AttributeError):
                known[:] = sum(client.nthreads().values()), time.monotonic()
        return int(known[0])

    return slots


def _state(client: Client) -> str:
    return {"running": THERE, "connecting": AWAY}.get(client.status, GONE)


def _shared(error: BaseException) -> bool:
    """Return whether what was lost shared its workers: they may have died of something else."""
    from distributed import KilledWorker

    return isinstance(error, KilledWorker)


def _lost(client: Client, scheduler: str, error: BaseException) -> str:
    """Return why a contact has no answer."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        times = counted(error.allowed_failures + 1, "time")
        return (
            f"its worker ended {times}, the last one at {error.last_worker.address}; is there "
            "enough memory?"
        )
    if _state(client) == GONE:
        return f"{scheduler} is gone"
    if isinstance(error, CancelledError):
        return f"{scheduler} was lost while it was under way"
    return f"{type(error).__name__} ({' '.join(str(error).split())}) from {scheduler}"
