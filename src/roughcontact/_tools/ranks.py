"""MPI ranks that share one map: the only module that calls MPI.

All ranks run the same program and call these functions in the same order. Values that must agree
on all ranks are broadcast by one, or computed by each from the same numbers in the same order.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, RoughcontactError

Result = TypeVar("Result")

# Environment variables with the number of processes of an MPI run (MPICH, Open MPI, PMIx).
_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
# Seconds of waiting after which a rank releases its core, and for which it then sleeps.
_PATIENCE, _NAP = 2e-4, 5e-5
# Seconds within which other ranks must reach the same error.
_GRACE = 5.0
# Seconds in which the launcher forwards the last message of a rank; at an abort it drops the rest.
_FORWARDING = 0.5
# Errors with a message for the user, and no traceback.
_REPORTED_ERRORS = (RoughcontactError, OSError, MemoryError)


def is_parallel_run() -> bool:
    """Return whether ``mpiexec`` started this process together with others."""
    return any(os.environ.get(name, "1") not in ("", "1") for name in _SIZES)


def world() -> Ranks:
    """Return the ranks of all processes that ``mpiexec`` started."""
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise InputError(
            f"started by mpiexec, but mpi4py cannot be used ({error}); install "
            "roughcontact[mpi], or start a single process"
        ) from None
    if is_parallel_run() and MPI.COMM_WORLD.Get_size() == 1:
        raise InputError(
            "started by mpiexec, but mpi4py sees one process: it belongs to another MPI; start "
            "with the mpiexec of the MPI that mpi4py was installed with"
        )
    return Ranks(MPI.COMM_WORLD, MPI.COMM_WORLD.Dup())


@dataclass
class PendingExchange:
    """Pending exchange of parts of arrays between ranks."""

    ranks: Ranks  # Exchanging ranks
    request: Any  # Pending MPI request
    coming: NDArray[Any]  # (n,) Receive buffer
    sizes: Sequence[int]  # Entries received from each rank

    def wait(self) -> list[NDArray[Any]]:
        """Wait for the exchange, and return the parts received from each rank."""
        self.ranks.wait(self.request)
        return np.split(self.coming, np.cumsum(self.sizes)[:-1])


class Ranks:
    """MPI communicator."""

    def __init__(self, communicator: Any, end: Any = None) -> None:
        self.communicator = communicator
        self.number: int = communicator.Get_rank()
        self.count: int = communicator.Get_size()
        self.seconds, self.sent = 0.0, 0
        self._end = end

    @property
    def is_root(self) -> bool:
        """Whether this rank prints and writes."""
        return self.number == 0

    def node_size(self) -> int:
        """Return the number of ranks on this machine."""
        from mpi4py import MPI

        here = self.communicator.Split_type(MPI.COMM_TYPE_SHARED)
        number: int = here.Get_size()
        here.Free()
        return number

    def allgather(self, value: float) -> NDArray[np.float64]:
        """Return the values of all ranks, in the order of the ranks."""
        values = np.empty(self.count)
        self.wait(self.communicator.Iallgather(np.array([value], np.float64), values))
        return values

    def allreduce_scalar(self, value: float) -> float:
        """Return the sum of a value over all ranks."""
        return math.fsum(self.allgather(value))

    def allreduce(self, parts: NDArray[Any]) -> NDArray[Any]:
        """Return the elementwise sum over all ranks of arrays of one shape."""
        # Reduce on one rank: sums computed by each rank may differ in the last bit.
        sums = np.empty_like(parts)
        self.wait(self.communicator.Ireduce(np.ascontiguousarray(parts), sums))
        self.wait(self.communicator.Ibcast(sums))
        return sums

    def allgatherv(self, part: NDArray[Any], counts: Sequence[int]) -> NDArray[Any]:
        """Return the concatenated rows of all ranks; ``counts`` is the number of each rank."""
        whole = np.empty((sum(counts), *part.shape[1:]), part.dtype)
        entries = np.array(counts) * math.prod(part.shape[1:])
        here = np.ascontiguousarray(part)
        self.wait(self.communicator.Iallgatherv(here, [whole, entries]))
        return whole

    def wait(self, request: Any) -> None:
        """Wait for the pending MPI requests, without occupying a core."""
        began = time.perf_counter()
        while not request.Test():
            if time.perf_counter() - began > _PATIENCE:
                time.sleep(_NAP)
        self.seconds += time.perf_counter() - began

    def exchange(
        self,
        outgoing: NDArray[Any],
        parts: Sequence[int],
        coming: NDArray[Any],
        sizes: Sequence[int],
    ) -> PendingExchange:
        """Start to send parts of an array to all ranks, and to receive theirs."""
        began = time.perf_counter()
        request = self.communicator.Ialltoallv([outgoing, parts], [coming, sizes])
        self.seconds += time.perf_counter() - began
        self.sent += outgoing.nbytes
        return PendingExchange(self, request, coming, sizes)

    def shift(self, part: NDArray[Any]) -> NDArray[Any]:
        """Return the array of the next rank, cyclically; all have the same shape."""
        result = np.empty_like(part)
        before, after = (self.number - 1) % self.count, (self.number + 1) % self.count
        self.communicator.Sendrecv(np.ascontiguousarray(part), before, recvbuf=result, source=after)
        return result

    def sent_to_first(self, part: NDArray[Any], sender: int) -> NDArray[Any]:
        """Send an array to the root rank; only the sender and the root call this."""
        if self.is_root and sender:
            self.communicator.Recv(part, sender)
        elif sender == self.number and sender:
            self.communicator.Send(np.ascontiguousarray(part), 0)
        return part

    def broadcast_flag(self, value: bool | None) -> bool:
        """Return the flag of the root rank; the values of other ranks are ignored."""
        flag = np.array([bool(value)], np.int8)
        self.wait(self.communicator.Ibcast(flag))
        return bool(flag[0])

    def run_on_all(self, task: Callable[[], Result]) -> Result:
        """Run a task on each rank; an error on one rank is raised on all."""
        error: BaseException | None = None
        try:
            result = task()
        except _REPORTED_ERRORS as raised:
            error = raised
        # A rank that has finished leaves its core to the others.
        self.wait(self.communicator.Ibarrier())
        errors = [other for other in self.communicator.allgather(error) if other is not None]
        if errors:
            raise error or errors[0]
        return result

    def broadcast_from_first(self, task: Callable[[], Result]) -> Result:
        """Run a task on the root rank, and return its result on all ranks."""
        text: tuple[Any, BaseException | None] = None, None
        if self.is_root:
            try:
                text = task(), None
            except _REPORTED_ERRORS as raised:
                text = None, raised
        # A waiting rank leaves its core to the root rank.
        self.wait(self.communicator.Ibarrier())
        answer, error = self.communicator.bcast(text)
        if error is not None:
            raise error
        return answer

    def all_end(self) -> bool:
        """Return whether all ranks call this within a few seconds."""
        if self._end is None:
            return False
        request, began = self._end.Ibarrier(), time.perf_counter()
        while not request.Test():
            if time.perf_counter() - began > _GRACE:
                return False
            time.sleep(_NAP)
        return True

    def abort(self, status: int) -> NoReturn:
        """Terminate all ranks, once the launcher had time to forward the error message."""
        time.sleep(_FORWARDING)
        self.communicator.Abort(status)
        raise SystemExit(status)
