"""Distribution of layers and waves over processes: one process, or several ranks.

A layer is transformed on its rank. Then waves are distributed: every rank receives its columns of
the spectra of all layers, sweeps them over the depth without communication, and returns them.
Layers are assigned to the ranks cyclically, so that yielding layers, which are neighbors, are
spread over all ranks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.ranks import PendingExchange, Ranks
from roughcontact.errors import InputError
from roughcontact.halfspace.fft import Workspace

Array = NDArray[Any]
Found = TypeVar("Found")

Write = Callable[[int, int, Array], None]
"""``write(layer, component, parts)`` writes the spectrum of the local waves."""

Parts = Callable[[int], Array]
"""``parts(component)`` returns the spectrum of all waves; it may be overwritten."""

MAX_MESSAGE_BYTES = 1 << 23
"""Bytes of the spectra of layers that a rank sends at a time, unless one layer needs more."""


class VolumePartition(Protocol):
    """Local layers and waves of a process, and their exchange with other processes.

    Attributes
    ----------
    workspace : Workspace
        Threads of the process.
    count, here : int
        Number of processes that hold the volume, and of those on this node.
    """

    workspace: Workspace
    count: int
    here: int

    def layers(self, count: int) -> range:
        """Return the local layers out of all layers."""

    def waves(self, width: int) -> slice:
        """Return the local waves along x out of all waves."""

    def spread(
        self, transform: Callable[[int, Array], bool], spectra: Array, width: int
    ) -> NDArray[np.bool_]:
        """Transform the local layers, and send each process its waves.

        Parameters
        ----------
        transform : callable
            ``transform(number, out)`` writes the spectrum of a local layer for all waves, shape
            ``(components, 2, my, width)``, and returns whether the layer has strain; called from
            several threads.
        spectra : ndarray, shape (nz, components, 2, my, columns)
            Array to fill with the local waves of all layers; zero for layers without strain.
        width : int
            Number of waves along x.

        Returns
        -------
        ndarray of bool, shape (nz,)
            Whether each layer has strain.
        """

    def collect(
        self,
        write: Write,
        read: Callable[[int, Parts], None],
        shape: tuple[int, int, int, int],
        dtype: type,
    ) -> None:
        """Send each process the spectra of its layers for all waves.

        Parameters
        ----------
        write : callable
            See `Write`; for all layers, called from several threads.
        read : callable
            ``read(number, parts)`` receives the spectra of a local layer; see `Parts`.
        shape : (int, int, int, int)
            Layers, components, rows and waves along x.
        dtype : type
            Real type of the spectra.
        """

    def gather_columns(self, spectrum: Array, width: int) -> Array:
        """Return a spectrum of all waves, shape (my, width), from the local columns."""

    def gather_layers(self, values: Array, count: int) -> Array:
        """Return an array over all layers from one over the local layers."""

    def any(self, value: bool) -> bool:
        """Return whether the value is true on any process."""

    def require(self, layers: int, shape: tuple[int, int]) -> None:
        """Raise `InputError` unless each process gets at least one layer and one wave."""

    def largest(self, value: float) -> float:
        """Return the largest value of all processes."""

    def run_on_all(self, task: Callable[[], Found]) -> Found:
        """Return the local result of a task, or raise an error of one process on all."""

    def broadcast_from_first(self, task: Callable[[], Found]) -> Found:
        """Return on all processes the result of a task of the first process."""


class SingleProcess:
    """Partition of a single process: all layers and waves are local.

    Parameters
    ----------
    workspace : Workspace
        Threads of this process.
    """

    count = here = 1

    def __init__(self, workspace: Workspace) -> None:
        self.workspace = workspace

    def layers(self, count: int) -> range:
        """Return all layers."""
        return range(count)

    def waves(self, width: int) -> slice:
        """Return all waves along x."""
        return slice(0, width)

    def spread(
        self, transform: Callable[[int, Array], bool], spectra: Array, width: int
    ) -> NDArray[np.bool_]:
        """Transform all layers; see `VolumePartition.spread`."""
        loud = np.zeros(len(spectra), bool)

        def forward(layer: int) -> None:
            loud[layer] = transform(layer, spectra[layer])
            if not loud[layer]:
                spectra[layer] = 0

        self.workspace.each(forward, range(len(spectra)))
        return loud

    def collect(
        self,
        write: Write,
        read: Callable[[int, Parts], None],
        shape: tuple[int, int, int, int],
        dtype: type,
    ) -> None:
        """Pass the spectra of all layers to ``read``; see `VolumePartition.collect`."""
        layers, _, my, width = shape

        def backward(layer: int) -> None:
            def parts(component: int) -> Array:
                out = _scratch(self.workspace, (2, my, width), dtype)
                write(layer, component, out)
                return out

            read(layer, parts)

        self.workspace.each(backward, range(layers))

    def gather_columns(self, spectrum: Array, width: int) -> Array:
        """Return the spectrum."""
        return spectrum

    def gather_layers(self, values: Array, count: int) -> Array:
        """Return the array."""
        return values

    def require(self, layers: int, shape: tuple[int, int]) -> None:
        """Accept any volume."""

    def any(self, result: bool) -> bool:
        """Return the local value."""
        return bool(result)

    def largest(self, value: float) -> float:
        """Return the local value."""
        return value

    def run_on_all(self, task: Callable[[], Found]) -> Found:
        """Return the result of a task."""
        return task()

    def broadcast_from_first(self, task: Callable[[], Found]) -> Found:
        """Return the result of a task."""
        return task()


class DistributedPartition:
    """Partition over several ranks; all ranks make the same calls in the same order.

    Parameters
    ----------
    ranks : Ranks
        Ranks that hold the volume.
    workspace : Workspace
        Threads of this rank.
    """

    def __init__(self, ranks: Ranks, workspace: Workspace) -> None:
        self.ranks, self.workspace = ranks, workspace
        self.count, self.here = ranks.count, ranks.node_size()

    def layers(self, count: int) -> range:
        """Return the local layers: with n ranks, every n-th layer."""
        return self._layers(self.ranks.number, count)

    def _layers(self, rank: int, count: int) -> range:
        return range(rank, count, self.count)

    def waves(self, width: int) -> slice:
        """Return the local waves along x out of all waves."""
        return self._waves(self.ranks.number, width)

    def _waves(self, rank: int, width: int) -> slice:
        return slice(rank * width // self.count, (rank + 1) * width // self.count)

    def require(self, layers: int, shape: tuple[int, int]) -> None:
        """Raise `InputError` unless each rank gets at least one layer and one wave."""
        maximum = min(layers, shape[1] // 2)
        if self.count > maximum:
            raise InputError(
                f"{self.count} ranks share {layers} layers of {shape[0]} × {shape[1]} points: "
                f"start {maximum} ranks at most"
            )

    def spread(
        self, transform: Callable[[int, Array], bool], spectra: Array, width: int
    ) -> NDArray[np.bool_]:
        """Transform the local layers and distribute waves; see `VolumePartition.spread`."""
        batches = self._batches(len(spectra), 10 * spectra.shape[-2] * width * spectra.itemsize)
        loud = np.zeros(len(spectra), bool)
        spectra[...] = 0
        before: tuple[PendingExchange, list[list[int]]] | None = None
        for number, batch in enumerate(batches):
            begun = self._send(transform, batch, loud, spectra, width, number)
            if before is not None:
                self._store_received(*before, spectra)
            before = begun
        assert before is not None
        self._store_received(*before, spectra)
        return loud

    def _batches(self, layers: int, size: int) -> list[list[list[int]]]:
        """Return, for each round, the layers that each rank sends."""
        step = max(self.workspace.workers, MAX_MESSAGE_BYTES // size, 1)
        # The same on all ranks, whose thread counts may differ.
        step = int(self.largest(step))
        rounds = -(-len(self._layers(0, layers)) // step)
        return [
            [
                list(self._layers(rank, layers))[i * step : (i + 1) * step]
                for rank in range(self.count)
            ]
            for i in range(rounds)
        ]

    def _send(
        self,
        transform: Callable[[int, Array], bool],
        batch: list[list[int]],
        loud: NDArray[np.bool_],
        spectra: Array,
        width: int,
        number: int,
    ) -> tuple[PendingExchange, list[list[int]]]:
        """Transform the local layers of a round, and send those with strain."""
        own = batch[self.ranks.number]
        shape = spectra.shape[1:-1]
        planes: Array = self._memory("planes", 0, (len(own), *shape, width), spectra.dtype)
        result = np.zeros(len(own), np.uint8)

        def forward(place: int) -> None:
            result[place] = transform(own[place] // self.count, planes[place])

        self.workspace.each(forward, range(len(own)))
        joined = self.ranks.allgatherv(result, [len(layers) for layers in batch])
        for layer, any_strain in zip((n for layers in batch for n in layers), joined, strict=True):
            loud[layer] = any_strain
        me, places = self.ranks.number, np.flatnonzero(result)
        moving = [
            [layer for layer in layers if loud[layer] and rank != me]
            for rank, layers in enumerate(batch)
        ]
        entries = math.prod(shape)
        parts = [
            len(places) * entries * self._width(rank, width) * (rank != me)
            for rank in range(self.count)
        ]
        outgoing: Array = self._memory("going", number % 2, (sum(parts),), spectra.dtype)

        def pack(task: tuple[int, Array, int]) -> None:
            rank, out, place = task
            out[...] = planes[place][..., self._waves(rank, width)]

        tasks: list[tuple[int, Array, int]] = []
        for rank, part in enumerate(np.split(outgoing, np.cumsum(parts)[:-1])):
            outs: Any = [spectra[own[place]] for place in places]
            if rank != me:
                outs = part.reshape(len(places), *shape, self._width(rank, width))
            tasks += [(rank, out, place) for out, place in zip(outs, places.tolist(), strict=True)]
        self.workspace.each(pack, tasks)
        sizes = [len(layers) * entries * spectra.shape[-1] for layers in moving]
        coming = self._memory("coming", number % 2, (sum(sizes),), spectra.dtype)
        return self.ranks.exchange(outgoing, parts, coming, sizes), moving

    def _store_received(
        self, exchange: PendingExchange, moving: list[list[int]], spectra: Array
    ) -> None:
        """Store the received spectra of a round."""
        arrived = exchange.wait()
        tasks = [
            (layer, plane)
            for layers, part in zip(moving, arrived, strict=True)
            for layer, plane in zip(
                layers, part.reshape(len(layers), *spectra.shape[1:]), strict=True
            )
        ]

        def store_plane(task: tuple[int, Array]) -> None:
            layer, plane = task
            spectra[layer] = plane

        self.workspace.each(store_plane, tasks)

    def collect(
        self,
        write: Write,
        read: Callable[[int, Parts], None],
        shape: tuple[int, int, int, int],
        dtype: type,
    ) -> None:
        """Send each rank the spectra of its layers; see `VolumePartition.collect`."""
        layers, components, my, width = shape
        size = 2 * components * my * width * np.dtype(dtype).itemsize
        before: tuple[PendingExchange, Array] | None = None
        for number, batch in enumerate(batches := self._batches(layers, size)):
            begun = self._return(write, batch, (components, my, width), dtype, number)
            if before is not None:
                self._visit_received(*before, batches[number - 1], read, width)
            before = begun
        assert before is not None
        self._visit_received(*before, batches[-1], read, width)

    def _return(
        self,
        write: Write,
        batch: list[list[int]],
        shape: tuple[int, int, int],
        dtype: type,
        number: int,
    ) -> tuple[PendingExchange, Array]:
        """Write the local waves of the layers of a round, and send those of remote layers."""
        (components, my, width), me = shape, self.ranks.number
        here, own = self._width(me, width), batch[me]
        entries = 2 * components * my
        parts = [len(layers) * entries * here for layers in batch]
        own_part = self._memory("kept", number % 2, (parts[me],), np.dtype(dtype))
        parts[me] = 0
        outgoing = self._memory("going", number % 2, (sum(parts),), np.dtype(dtype))
        blocks = np.split(outgoing, np.cumsum(parts)[:-1])
        blocks[me] = own_part
        tasks = []
        for layers, part in zip(batch, blocks, strict=True):
            block = part.reshape(len(layers), components, 2, my, here)
            tasks += [
                (layer, component, block[place, component])
                for place, layer in enumerate(layers)
                for component in range(components)
            ]
        self.workspace.each(lambda task: write(*task), tasks)
        sizes = [
            len(own) * entries * self._width(rank, width) * (rank != me)
            for rank in range(self.count)
        ]
        coming = self._memory("coming", number % 2, (sum(sizes),), np.dtype(dtype))
        own_part = own_part.reshape(len(own), components, 2, my, here)
        return self.ranks.exchange(outgoing, parts, coming, sizes), own_part

    def _visit_received(
        self,
        exchange: PendingExchange,
        own_part: Array,
        batch: list[list[int]],
        read: Callable[[int, Parts], None],
        width: int,
    ) -> None:
        """Pass the layers of a round to ``read``, from received and from local waves."""
        own, (my, _) = batch[self.ranks.number], own_part.shape[-2:]
        blocks = [
            own_part
            if rank == self.ranks.number
            else part.reshape(*own_part.shape[:-1], self._width(rank, width))
            for rank, part in enumerate(exchange.wait())
        ]

        def backward(place: int) -> None:
            def parts(component: int) -> Array:
                out = _scratch(self.workspace, (2, my, width), own_part.dtype.type)
                for rank, block in enumerate(blocks):
                    out[..., self._waves(rank, width)] = block[place, component]
                return out

            read(own[place] // self.count, parts)

        self.workspace.each(backward, range(len(own)))

    def _width(self, rank: int, width: int) -> int:
        return len(range(*self._waves(rank, width).indices(width)))

    def _memory(self, name: str, number: int, shape: Sequence[int], dtype: np.dtype[Any]) -> Array:
        """Return a message buffer; ``number`` separates this round from the next."""
        flat = self.workspace.scratch(f"{name} {number}", (1, math.prod(shape)), dtype.type)
        return flat.reshape(shape)

    def gather_columns(self, spectrum: Array, width: int) -> Array:
        """Return a spectrum of all waves from the local columns."""
        counts = [self._width(rank, width) for rank in range(self.count)]
        return np.ascontiguousarray(self.ranks.allgatherv(spectrum.T, counts).T)

    def gather_layers(self, values: Array, count: int) -> Array:
        """Return an array over all layers from one over the local layers."""
        layers = [self._layers(rank, count) for rank in range(self.count)]
        by_rank = self.ranks.allgatherv(values, [len(own) for own in layers])
        ordered = np.empty_like(by_rank)
        ordered[[layer for own in layers for layer in own]] = by_rank
        return ordered

    def any(self, result: bool) -> bool:
        """Return whether the value is true on any rank."""
        return bool(self.ranks.allgather(float(result)).any())

    def largest(self, value: float) -> float:
        """Return the largest value of all ranks."""
        return float(self.ranks.allgather(value).max())

    def run_on_all(self, task: Callable[[], Found]) -> Found:
        """Return the local result of a task, or raise an error of one rank on all ranks."""
        return self.ranks.run_on_all(task)

    def broadcast_from_first(self, task: Callable[[], Found]) -> Found:
        """Return on all ranks the result of a task of the first rank."""
        return self.ranks.broadcast_from_first(task)


def _scratch(workspace: Workspace, shape: tuple[int, ...], dtype: type) -> Array:
    """Return memory of this thread for one component."""
    return workspace.scratch("parts", (1, math.prod(shape)), dtype).reshape(shape)
