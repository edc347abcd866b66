"""Convolution on a GPU, with PyTorch, for the contacts of a block of code.

The pressure of the loaded pixels is uploaded, the displacement downloaded: of the whole map in
blocks of rows, which the threads of the host receive in parallel, or of the loaded pixels alone.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import ArgumentRef, InputError, InsufficientMemoryError, require_choice
from roughcontact.halfspace.convolution import Convolution, Support, Visit

P = ParamSpec("P")
R = TypeVar("R")

# Bytes of a block of columns, and of the blocks of rows of all threads; a block takes about four
# times as much.
_BLOCK_BYTES = 1 << 27

# Device of PyTorch, set only by `use_device`, for the calls in its block; None is the host.
_device: ContextVar[Any] = ContextVar("device", default=None)


@contextmanager
def use_device(name: str | None) -> Iterator[None]:
    """Compute the displacement of contacts in the block on a device.

    Parameters
    ----------
    name : {"cpu", "cuda"}, optional
        The processor or the current CUDA device; by default the device of the enclosing block.

    Raises
    ------
    InputError
        If PyTorch cannot be imported, or finds no CUDA device.
    InsufficientMemoryError
        If the memory of the device is too small.
    """
    if name is None:
        yield
        return
    require_choice(("cpu", "cuda"), device=name)
    token = _device.set(None if name == "cpu" else _find_device(name))
    # On the host there is no such error.
    out_of_memory = getattr(sys.modules.get("torch"), "OutOfMemoryError", ())
    try:
        yield
    except out_of_memory as error:
        raise InsufficientMemoryError(
            "the free memory of the GPU is too small for this map; solve with "
            f"{ArgumentRef('precision', 'single')}, on a coarser grid, or with "
            f"{ArgumentRef('device', 'cpu')}"
        ) from error
    finally:
        _device.reset(token)


def _find_device(name: str) -> Any:
    """Return a device of PyTorch."""
    unusable = functools.partial(InputError, argument="device", value=name)
    try:
        import torch
    except ImportError as error:
        raise unusable(
            f"= {name!r} needs PyTorch, which cannot be imported ({error}); run pip install "
            "'roughcontact[gpu]'"
        ) from None
    if not torch.cuda.is_available():
        raise unusable(
            f"= {name!r}, but PyTorch {torch.__version__} finds no CUDA device; check its driver "
            f"with nvidia-smi and that PyTorch is built for CUDA, or leave {ArgumentRef('device')} "
            "out"
        )
    # By its number: each thread has a current device.
    return torch.device(name, torch.cuda.current_device())


def runs_on_device(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function that runs on the device of its keyword argument ``device``."""

    @functools.wraps(function)
    def call(*positional: P.args, **named: P.kwargs) -> R:
        with use_device(cast("str | None", named.get("device"))):
            return function(*positional, **named)

    return call


def to_device(operator: Convolution) -> Convolution:
    """Return an operator on the device of the block, or the operator itself on the host."""
    device = _device.get()
    if device is None:
        return operator
    result = DeviceConvolution(
        operator.spectrum,
        operator.shape,
        operator.padded,
        workspace=operator.workspace,
        precision="single" if operator.real is np.float32 else "double",
        softness=operator.softness,
        device=device,
    )
    result.surface, result.self_displacement = operator.surface, operator.self_displacement
    return result


class DeviceConvolution(Convolution):
    """Convolution on a device.

    Parameters
    ----------
    *problem, **options
        As for `Convolution`.
    device : torch.device
        Device of PyTorch, which holds the spectrum of the kernel and of the rows.
    """

    def __init__(self, *problem: Any, device: Any, **options: Any) -> None:
        import torch

        super().__init__(*problem, **options)
        self._torch, self._device = torch, device
        self._symbol = self._upload(self.spectrum)
        self._types = self._symbol.dtype, self._symbol.dtype.to_complex()
        # Found out before the solve; PyTorch keeps the memory.
        torch.empty(self._rows, dtype=self._types[1], device=device)
        rows, workers = self._blocks[0].stop, self.workspace.workers
        fit = _BLOCK_BYTES // (workers * rows * self.padded[1] * self._symbol.itemsize)
        count = len(self._blocks)
        step = max(1, min(fit, -(-count // workers)))
        self._chunks = [range(start, min(start + step, count)) for start in range(0, count, step)]

    def support(self, index: NDArray[np.int64]) -> Support:
        """Return the support of pixels, with its positions on the device."""
        result = super().support(index)
        return replace(result, position=self._upload(result.position))

    def spread(self, support: Support, pressure: NDArray[Any], visit: Visit) -> None:
        """Pass the displacement of the whole map to a callback; see `Convolution.spread`."""
        spectra = self._convolve(support, pressure)

        def download(numbers: range) -> None:
            block = self._displaced_rows(spectra, numbers)[:, : self.shape[1]]
            memory = {"dtype": block.dtype, "pin_memory": block.is_cuda}
            displacement = self._torch.empty(block.shape, **memory).copy_(block).numpy()
            top = self._blocks[numbers[0]].start
            for number in numbers:
                rows = self._blocks[number]
                visit(number, rows, displacement[rows.start - top : rows.stop - top])

        self.workspace.each(download, self._chunks)

    def gather(self, support: Support, pressure: NDArray[Any]) -> NDArray[Any]:
        """Return the displacement of the loaded pixels, selected on the device."""
        spectra = self._convolve(support, pressure)
        displacement = np.empty(support.index.size)
        for numbers, part, positions in self._loaded_blocks(support):
            rows = self._displaced_rows(spectra, numbers)
            displacement[part] = rows.view(-1)[positions].cpu().numpy()
        return displacement

    def _derive(self, *problem: Any, **options: Any) -> Convolution:
        return super()._derive(*problem, device=self._device, **options)

    def _upload(self, array: NDArray[Any]) -> Any:
        return self._torch.tensor(array, device=self._device)

    def _rows_of(self, numbers: range) -> slice:
        return slice(self._blocks[numbers[0]].start, self._blocks[numbers[-1]].stop)

    def _loaded_blocks(self, support: Support) -> Iterator[tuple[range, slice, Any]]:
        """Yield blocks with load, their entries, and the positions of these in the block."""
        for numbers in self._chunks:
            part = slice(support.starts[numbers[0]], support.starts[numbers[-1] + 1])
            if part.stop > part.start:
                top = self._rows_of(numbers).start * self.padded[1]
                yield numbers, part, support.position[part] - top

    def _convolve(self, support: Support, pressure: NDArray[Any]) -> Any:
        """Return the spectra of the rows of the displacement."""
        torch, (my, mx) = self._torch, self.padded
        real, complex_type = self._types
        values = self._upload(pressure) * (self.softness / (my * mx))
        spectra = torch.zeros(self._rows, dtype=complex_type, device=self._device)
        for numbers, part, positions in self._loaded_blocks(support):
            rows = self._rows_of(numbers)
            padded = torch.zeros((rows.stop - rows.start, mx), dtype=real, device=self._device)
            padded.view(-1)[positions] = values[part].to(real)
            spectra[rows] = torch.fft.rfft(padded)
        half = my // 2 + 1
        step = max(1, _BLOCK_BYTES // (my * spectra.itemsize))
        for first in range(0, self._rows[1], step):
            columns, symbol = (array[:, first : first + step] for array in (spectra, self._symbol))
            waves = torch.fft.fft(columns, n=my, dim=0)
            # The symbol is even.
            waves[:half] *= symbol
            waves[half:] *= symbol[1 : my - half + 1].flip(0)
            columns[...] = torch.fft.ifft(waves, dim=0, norm="forward")[: self.shape[0]]
        return spectra

    def _displaced_rows(self, spectra: Any, numbers: range) -> Any:
        """Return the padded rows of the displacement of some blocks."""
        waves = spectra[self._rows_of(numbers)]
        return self._torch.fft.irfft(waves, n=self.padded[1], norm="forward")
