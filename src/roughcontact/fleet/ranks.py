"""Contacts on processes that MPI has started: one hands out, the others work."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from typing import cast

from roughcontact.errors import InputError
from roughcontact.fleet.engine import Engine
from roughcontact.halfspace.fft import default_workers

_START = (
    "start it by mpiexec -n 3 roughcontact run …, which is one that hands out and two that work"
)


@contextmanager
def first() -> Iterator[Engine | None]:
    """Give the processes of MPI to the first of them.

    Yields
    ------
    Engine or None
        Nothing in the others: they have worked, and the first has come to its end.

    Raises
    ------
    InputError
        If mpi4py is not installed or finds no MPI, or there is only one process.
    """
    try:
        from mpi4py import MPI
        from mpi4py.futures import MPICommExecutor
    except (ImportError, RuntimeError) as error:
        raise InputError(
            f"mpi needs mpi4py and an MPI ({error}); run pip install 'roughcontact[mpi]'",
            argument="engine",
        ) from None
    world = MPI.COMM_WORLD
    if world.size < 2:
        raise InputError(f"mpi needs two processes or more: {_START}", argument="engine")
    here = world.Split_type(MPI.COMM_TYPE_SHARED)
    # On the machine of the first, which only waits, there is one more core.
    threads = max(1, default_workers() // max(1, here.size - (world.rank == 0)))
    with MPICommExecutor(world, root=0) as given:
        # Its annotations do not know what it gives.
        executor = cast("Executor | None", given)
        if executor is None:
            yield None
        else:
            stop = partial(executor.shutdown, wait=False, cancel_futures=True)
            yield Engine(executor, lambda: world.size - 1, threads, stop, far=True)
