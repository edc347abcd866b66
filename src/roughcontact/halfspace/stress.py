"""Elastic stress below a loaded surface, slice by slice.

The body fills z > 0, tension is positive, and x, y are the axes of the map (``[y, x]``). A
tensor is an array whose first axis holds xx, yy, zz, yz, xz, xy, in this order. The surface
carries the normal pressure p, so that σ_zz = -p there, and a traction q on the body, so that
σ_xz = -q_x and σ_yz = -q_y: with friction μ p in one direction of the plane, or any map. The effect
of q on the pressure is neglected, as usual (Goodman's approximation; exact for equal bodies).

Each depth is computed separately: a few kernels are sampled, transformed and multiplied with the
spectrum of the pressure, and a callback receives the stress row block by row block. The volume is
never stored.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import InputError, input_error, require_choice, require_pixel
from roughcontact.halfspace import fft, stress_kernels
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, free_period
from roughcontact.halfspace.tensors import YY


class Term(NamedTuple):
    """Kernel of `Responses`.

    Parameters
    ----------
    odd : (bool, bool)
        Whether the kernel is odd in y, and in x; else it is even.
    shares : sequence of (int, float)
        Responses to which the kernel contributes, with factors.
    """

    odd: tuple[bool, bool]
    shares: Sequence[tuple[int, float]]


@dataclass(frozen=True, eq=False)
class Symbols:
    """Kernels of `Responses` as functions of the wave vector.

    Parameters
    ----------
    highest : (int, int)
        Highest wave numbers along y and x; waves beyond have no response.
    block : callable
        ``block(columns)`` returns an array of shape ``(terms, highest[0] + 1, columns)`` of real
        numbers S that the caller may overwrite; called from several threads. The transform of a
        term for wave numbers ≥ 0 is S if the term is even, -i S if it is odd in one direction, and
        -S if it is odd in both.
    """

    highest: tuple[int, int]
    block: Callable[[slice], NDArray[Any]]


class Responses:
    """Responses to real maps: sums of circular convolutions with even or odd kernels.

    The spectra of the maps are computed once; each set of kernels then costs one inverse transform
    per response. Responses are passed to a callback and not stored.

    Parameters
    ----------
    source : ndarray, shape (ny, nx) or (m, ny, nx)
        One map or several. A response is the sum over all maps: of n responses, those to the first
        map have the indices 0 to n - 1 in `Term`, those to the second n to 2 n - 1.
    padded : (int, int)
        Period ``(my, mx)`` of the convolutions, at least the shape of the map, which is padded
        with zeros.
    terms : sequence of Term
        The kernels; at least one for each response.
    workspace : Workspace
        Threads and memory; no other operator may use them at the same time.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    """

    def __init__(
        self,
        source: NDArray[Any],
        padded: Shape,
        terms: Sequence[Term],
        *,
        workspace: Workspace,
        precision: str = "single",
    ) -> None:
        self.real: type = np.float32 if precision == "single" else np.float64
        self._complex: type = np.complex64 if precision == "single" else np.complex128
        self.shape: Shape = source.shape[-2], source.shape[-1]
        sources = source.reshape(-1, *self.shape)
        self.padded, self.terms, self.workspace = padded, tuple(terms), workspace
        numbers = 1 + max(response for term in self.terms for response, _ in term.shares)
        self.count = numbers // len(sources)
        # Kernels of each response, by their parity in y, and by whether the parity in x differs.
        self._shares = {
            (response, in_y, mixed): [
                (number, -factor if all(term.odd) else factor)
                for number, term in enumerate(self.terms)
                for response_of, factor in term.shares
                if response_of == response and term.odd == (in_y, in_y != mixed)
            ]
            for response in range(numbers)
            for in_y in (False, True)
            for mixed in (False, True)
        }
        (ny, _), (my, mx) = self.shape, padded
        self._width = mx // 2 + 1
        itemsize = np.dtype(self._complex).itemsize
        # About four copies of a block of columns are in use, and one of rows for each response.
        self._column_step = max(4, fft.COLUMN_BYTES // (4 * my * itemsize))
        step = max(1, min(ny, 2 * fft.ROW_BYTES // (self.count * mx * itemsize // 2)))
        self._rows = [slice(top, min(top + step, ny)) for top in range(0, ny, step)]
        self._samples = np.empty(0, self.real)
        self._spectra = np.zeros((len(sources), my, self._width), self._complex)
        workspace.reserve(self.count * ny * self._width * itemsize)
        for spectrum, one in zip(self._spectra, sources, strict=True):
            self._transform(one, spectrum)

    def sample(
        self,
        sample: Callable[[NDArray[np.int64], NDArray[np.int64]], Iterable[NDArray[np.float64]]],
        every: tuple[int, int] = (1, 1),
    ) -> Symbols:
        """Return the symbols of kernels from their samples.

        Parameters
        ----------
        sample : callable
            ``sample(rows, columns)`` yields the kernels one by one at these offsets ≥ 0, in steps
            of ``every``, each of shape ``(columns, rows)``; called from several threads. Periods
            are even; at half a period, beyond the offsets of the map, a kernel may have any value.
        every : (int, int)
            Steps along y and x, divisors of half the period. Kernels that are smooth on this
            scale need no more samples: shorter waves are omitted.

        Returns
        -------
        Symbols
            Valid until the next call of this method.
        """
        (my, mx), count = self.padded, len(self.terms)
        highest = my // 2 // every[0], mx // 2 // every[1]
        lines = (highest[1] + 1, highest[0] + 1)
        size = count * lines[0] * lines[1]
        if self._samples.size < size:
            self._samples = np.empty(size, self.real)
        samples = self._samples[:size].reshape(count, *lines)
        columns = np.arange(0, mx // 2 + 1, every[1])
        weight = every[0] * every[1]
        step = max(4, fft.ROW_BYTES // (8 * lines[0]))

        def fill(top: int) -> None:
            bottom = min(top + step, lines[1])
            rows = every[0] * np.arange(top, bottom)
            line = self.workspace.scratch("half line", (lines[0], bottom - top), self.real)
            kernels = sample(rows, columns)
            for number, (term, kernel) in enumerate(zip(self.terms, kernels, strict=True)):
                np.multiply(kernel, weight, out=line, casting="same_kind")
                fft.half_line_transform(line, term.odd[1])
                samples[number, :, top:bottom] = line

        self.workspace.each(fill, range(0, lines[1], step))

        def block(columns: slice) -> NDArray[Any]:
            size = columns.stop - columns.start
            symbol = self.workspace.scratch("symbol", (count * lines[1], size), self.real)
            symbol = symbol.reshape(count, lines[1], size)
            for number, term in enumerate(self.terms):
                symbol[number] = samples[number, columns].T
                fft.half_line_transform(symbol[number], term.odd[0])
            return symbol

        return Symbols(highest, block)

    def stream(
        self, symbols: Symbols, visit: Callable[[slice, NDArray[Any]], None], first_row: int = 0
    ) -> None:
        """Pass the responses of the whole map to a callback, block by block.

        Parameters
        ----------
        symbols : Symbols
            The kernels.
        visit : callable
            ``visit(rows, responses)`` receives each row block, shape ``(responses, rows, nx)``,
            from one of several threads; the array is only valid during the call.
        first_row : int
            A row of the first block.
        """
        (ny, nx), (_, mx) = self.shape, self.padded
        width = symbols.highest[1] + 1
        spectra = self.workspace.shared_array((self.count * ny, width), self._complex)
        spectra = spectra.reshape(self.count, ny, width)

        def columns(part: slice) -> None:
            for response, product in self._products(symbols, part):
                spectra[response, :, part] = fft.fft_columns(product, forward=False)[:ny]

        self.workspace.each(columns, self._columns(width))

        def rows(part: slice) -> None:
            size = part.stop - part.start
            lines = self.workspace.scratch("lines", (self.count * size, _stride(mx)), self.real)
            lines = lines[:, :mx].reshape(self.count, size, mx)
            whole = self.workspace.scratch("whole", (size, self._width), self._complex)
            for line, spectrum in zip(lines, spectra[:, part], strict=True):
                if width == self._width:
                    whole = spectrum
                else:
                    whole[:, :width] = spectrum
                    whole[:, width:] = 0
                inverse = fft.irfft_rows(whole, mx, line)
                if inverse is not line:
                    line[...] = inverse
            visit(part, lines[:, :, :nx])

        first = first_row // (self._rows[0].stop - self._rows[0].start)
        self.workspace.each(rows, self._rows[first:] + self._rows[:first])

    def _columns(self, width: int) -> list[slice]:
        step = self._column_step
        return [slice(first, min(first + step, width)) for first in range(0, width, step)]

    def _transform(self, source: NDArray[Any], spectrum: NDArray[Any]) -> None:
        (_, nx), (my, mx) = self.shape, self.padded
        scale = 1 / (my * mx)

        def rows(part: slice) -> None:
            line = self.workspace.scratch("lines", (part.stop - part.start, _stride(mx)), self.real)
            line = line[:, :mx]
            np.multiply(source[part], scale, out=line[:, :nx], casting="same_kind")
            line[:, nx:] = 0
            fft.rfft_rows(line, spectrum[part])

        self.workspace.each(rows, self._rows)

        def columns(part: slice) -> None:
            size = part.stop - part.start
            column = self.workspace.scratch("column", (my, size), self._complex)
            column[...] = spectrum[:, part]
            spectrum[:, part] = fft.fft_columns(column, forward=True)

        self.workspace.each(columns, self._columns(self._width))

    def _products(self, symbols: Symbols, part: slice) -> Iterator[tuple[int, NDArray[Any]]]:
        """Yield the spectra of the responses on some columns, one by one."""
        my, size = self.padded[0], part.stop - part.start
        # Wave numbers 0 to `lower` - 1 come first, the negative ones last.
        lower = symbols.highest[0] + 1
        upper = min(symbols.highest[0], my - lower)
        scratch = self.workspace.scratch
        block = symbols.block(part)
        shape, bases = (lower + upper, size), []
        for source, spectrum in enumerate(self._spectra):
            plain = scratch(f"plain {source}", shape, self._complex)
            plain[:lower] = spectrum[:lower, part]
            plain[lower:] = spectrum[my - upper :, part]
            turned = np.multiply(plain, -1j, out=scratch(f"turned {source}", shape, self._complex))
            first = source * self.count
            bases += [(first, plain, False), (first, turned, True)]
        product = scratch("column", (my, size), self._complex)
        extra = scratch("extra", shape, self._complex)
        for response in range(self.count):
            product[lower : my - upper] = 0
            front, back = product[:lower], product[my - upper :]
            added = False
            for first, base, mixed in bases:
                symbol = self._symbol(block, first + response, mixed)
                if symbol is None:
                    continue
                to = (extra[:lower], extra[lower:]) if added else (front, back)
                np.multiply(base[:lower], symbol[0], out=to[0])
                np.multiply(base[lower:], symbol[1][upper:0:-1], out=to[1])
                if added:
                    front += to[0]
                    back += to[1]
                added = True
            yield response, product

    def _symbol(
        self, block: NDArray[Any], response: int, mixed: bool
    ) -> tuple[NDArray[Any], NDArray[Any]] | None:
        """Return the symbol of a response for waves of q_y ≥ 0 and < 0, each from q_y = 0.

        If ``mixed``, by the kernels that are odd in one direction only, else by the others; None if
        the response has no such kernel.
        """
        even, odd = (
            self._sum(block, self._shares[response, in_y, mixed], f"odd {in_y}")
            for in_y in (False, True)
        )
        if odd is None:
            return None if even is None else (even, even)
        back = self.workspace.scratch("behind", (odd.shape[0], odd.shape[1]), block.dtype.type)
        if even is None:
            return odd, np.negative(odd, out=back)
        np.subtract(even, odd, out=back)
        front = self.workspace.scratch("ahead", (odd.shape[0], odd.shape[1]), block.dtype.type)
        return np.add(even, odd, out=front), back

    def _sum(
        self, block: NDArray[Any], shares: list[tuple[int, float]], name: str
    ) -> NDArray[Any] | None:
        """Return the sum of arrays of the block times factors, or None without shares."""
        if not shares:
            return None
        number, factor = shares[0]
        first: NDArray[Any] = block[number]
        if len(shares) == 1 and factor == 1:
            return first
        total = self.workspace.scratch(name, (first.shape[0], first.shape[1]), first.dtype.type)
        share = self.workspace.scratch("share", total.shape, first.dtype.type)
        np.multiply(first, factor, out=total)
        for number, factor in shares[1:]:
            total += np.multiply(block[number], factor, out=share)
        return total


def _stride(length: int) -> int:
    # Rows a power of two apart share a few cache lines: the transforms of 16 rows at once by SciPy
    # and ducc0 would take four times as long.
    return length + 16


Offsets = NDArray[np.int64]

# Whether each component by a normal load is odd in y, and in x; a traction flips one of the two.
_ODD_COMPONENTS = ((False, False),) * 3 + ((True, False), (False, True), (True, True))
# Minimum number of samples of a kernel per depth in single precision: waves of two samples are
# damped to e^(-5π) = 2e-7. Beyond the map, over a quarter of its edge, a kernel blends into its
# periodic image by an error function, which is equally smooth with this number of samples.
_SAMPLES = 5
_COARSEST = 16
_BLEND = 1.25
_BLEND_SAMPLES = 0.1
_STEEPNESS = 3.8
# Pixel edge of a profile along y over its length: the relative deviation from plane strain is the
# inverse of this number.
_LONG = 1e6
# Waves on a periodic map are omitted where e^(-qz) is below rounding.
_DAMPED = {"single": 18.0, "double": 40.0}


@dataclass(frozen=True, eq=False)
class Field:
    """Stress field of one pressure map, in units of its largest pressure.

    ``in_depth(depth)`` returns the operator and the kernels of the response to the pressure,
    ``residual(depth)`` the stress in the plane before any load.
    """

    unit: float
    shape: Shape
    real: type
    in_depth: Callable[[float], tuple[Responses, Symbols]]
    residual: Callable[[float], float] = lambda depth: 0.0

    def stream(
        self, depth: float, visit: Callable[[slice, NDArray[Any]], None], first_row: int = 0
    ) -> None:
        """Pass the stress at a depth to a callback in row blocks; see `Responses.stream`."""
        responses, symbols = self.in_depth(depth)
        residual = self.residual(depth)

        def add_residual(rows: slice, block: NDArray[Any]) -> None:
            block[: YY + 1] += residual
            visit(rows, block)

        responses.stream(symbols, add_residual if residual else visit, first_row)


def field_of(
    pressure: ArrayLike,
    pixel: Pixel,
    poisson: float,
    boundary: str,
    friction: float,
    direction: float,
    precision: str,
    workspace: Workspace,
    traction: ArrayLike | None = None,
) -> Field:
    """Return the stress field below a pressure; arguments as for `stress.slices`.

    A single row that is periodic along y is a profile in plane strain: its pixels are so long that
    their ends have no effect.
    """
    require_pixel(pixel)
    stress_kernels.require_poisson(poisson)
    source = _checked_source(pressure)
    boundary = Boundary(boundary)
    if source.shape[0] == 1 and boundary is Boundary.PERIODIC_Y:
        boundary, pixel = Boundary.FREE, (_LONG * source.shape[1] * pixel[1], pixel[1])
    boundary.require_known_below("the stress below the surface")
    require_choice(("double", "single"), precision=precision)
    pulls = [(axis, share, 0) for axis, share in pulls_of(friction, direction)]
    unit = float(np.abs(source).max()) or 1.0
    shape = (source.shape[0], source.shape[1])
    if traction is not None:
        along_y, along_x = checked_traction(traction, shape, friction)
        source, pulls = np.stack([source, along_x, along_y]), [("x", 1.0, 1), ("y", 1.0, 2)]
    source = source / unit
    loads = UnitLoads(pixel, poisson, tuple(pulls))
    terms = loads.wave_terms() if not boundary.free_axes else loads.terms()

    def responses(padded: Shape) -> Responses:
        return Responses(source, padded, terms, workspace=workspace, precision=precision)

    if not boundary.free_axes:
        period = responses(shape)
        damped = _DAMPED[precision]
        return Field(
            unit,
            shape,
            period.real,
            lambda depth: (period, _waves(loads, terms, shape, depth, damped)),
        )
    near = responses(free_period(shape))
    far: list[Responses] = []

    def free(depth: float) -> tuple[Responses, Symbols]:
        every = steps(shape, pixel, depth) if precision == "single" else (1, 1)
        if max(every) == 1:
            return near, near.sample(partial(loads.sample_pixels, depth))
        if not far:
            far.append(responses(_blending_period(shape)))
        sample = partial(blend, partial(loads.sample_points, depth), terms, shape, far[0].padded)
        return far[0], _spread_forces(far[0].sample(sample, every), pixel, far[0].padded)

    return Field(unit, shape, near.real, free)


def _checked_source(pressure: ArrayLike) -> Array:
    source = np.asarray(pressure, dtype=np.float64)
    finite = np.isfinite(source).all()
    if source.ndim != 2 or not source.size or not finite:
        raise InputError(
            f"must be a finite map [y, x], got shape {source.shape}"
            f"{'' if finite else ' with NaN or infinite values'}",
            argument="pressure",
        )
    return source


def checked_traction(traction: ArrayLike, shape: Shape, friction: float) -> Array:
    """Return a valid traction map with components (y, x), or raise `InputError`."""
    try:
        values = np.asarray(traction, dtype=np.float64)
    except (OverflowError, ValueError):
        values = np.empty(0)
    if values.shape != (2, *shape) or not np.isfinite(values).all():
        raise InputError(
            f"must be finite with shape {(2, *shape)}, got shape {values.shape}",
            argument="traction",
        )
    if friction:
        raise InputError(
            "cannot be combined with friction: it is the whole traction", argument="traction"
        )
    return values


def pulls_of(friction: float, direction: float) -> list[tuple[str, float]]:
    """Return the nonzero tractions along x and y, per pressure.

    Parameters
    ----------
    friction, direction : float
        As for `stress.slices`.

    Raises
    ------
    InputError
        If friction or direction is not finite.
    """
    for name, number in (("friction", friction), ("direction", direction)):
        if not math.isfinite(number):
            raise input_error(name, number, "must be finite")
    # The cosine of a right angle is 6e-17, which must not become a traction.
    return [
        (axis, friction * share)
        for axis, share in (("x", math.cos(direction)), ("y", math.sin(direction)))
        if abs(friction * share) > 1e-15 * abs(friction)
    ]


@dataclass(frozen=True)
class UnitLoads:
    """Unit pressure and tractions; arrays of offsets are in pixels.

    Each traction has an axis, a size, and the index of its map: 0 is the pressure.
    """

    pixel: tuple[float, float]
    poisson: float
    pulls: tuple[tuple[str, float, int], ...] = ()

    def terms(self) -> list[Term]:
        """Return the kernels that `sample_pixels` and `sample_points` yield."""
        if not self.pulls:
            return [Term(odd, [(number, 1.0)]) for number, odd in enumerate(_ODD_COMPONENTS)]
        shares: list[list[tuple[int, float]]] = [[] for _ in stress_kernels.PARTS_ODD]
        for source in range(1 + self.pulls[-1][2]):
            pulls = [(axis, share) for axis, share, of in self.pulls if of == source]
            parts = stress_kernels.shares_of_parts(self.poisson, float(not source), pulls)
            for found, part in zip(shares, parts, strict=True):
                found += [
                    (len(_ODD_COMPONENTS) * source + number, factor) for number, factor in part
                ]
        return [Term(*term) for term in zip(stress_kernels.PARTS_ODD, shares, strict=True)]

    def wave_terms(self) -> list[Term]:
        """Return the terms of `stress_kernels.waves`: of the pressure, then of each traction."""
        flips = [(0, False, False), *((of, axis == "y", axis == "x") for axis, _, of in self.pulls)]
        return [
            Term((odd[0] != in_y, odd[1] != in_x), [(len(_ODD_COMPONENTS) * source + number, 1.0)])
            for source, in_y, in_x in flips
            for number, odd in enumerate(_ODD_COMPONENTS)
        ]

    def waves(self, qy: Array, qx: Array, z: float) -> list[Array]:
        """Return the symbols of `wave_terms` at a depth."""
        pulls = [(axis, share) for axis, share, _ in self.pulls]
        return stress_kernels.waves(qy, qx, z, self.poisson, pulls)

    def sample_pixels(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield kernels of the stress under loads spread over the pixel at the origin."""
        y: Array = (np.append(rows, rows[-1] + 1) - 0.5) * self.pixel[0]
        x: Array = (np.append(columns, columns[-1] + 1) - 0.5) * self.pixel[1]
        sample = stress_kernels.uniform_parts if self.pulls else stress_kernels.uniform_pressure
        return sample(x, y, z, self.poisson)

    def sample_points(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield kernels of the stress under unit forces at the origin."""
        y = rows.astype(np.float64) * self.pixel[0]
        x = columns.astype(np.float64) * self.pixel[1]
        sample = stress_kernels.force_parts if self.pulls else stress_kernels.normal_force
        return sample(x, y, z, self.poisson)


def _spread_forces(symbols: Symbols, pixel: Pixel, period: Shape) -> Symbols:
    """Return the symbols of forces spread over pixels, exact in the wave vector."""
    wave_y, wave_x = (
        edge * np.sinc(np.arange(highest + 1) / length)
        for edge, highest, length in zip(pixel, symbols.highest, period, strict=True)
    )

    def block(columns: slice) -> NDArray[Any]:
        result = symbols.block(columns)
        result *= np.outer(wave_y, wave_x[columns]).astype(result.dtype)
        return result

    return Symbols(symbols.highest, block)


def steps(shape: Shape, pixel: Pixel, depth: float) -> tuple[int, int]:
    """Return the steps between samples of the kernels along y and x, in pixels."""
    y, x = (
        min(depth / (_SAMPLES * edge), _BLEND_SAMPLES * (_BLEND - 1) * n, _COARSEST)
        for n, edge in zip(shape, pixel, strict=True)
    )
    return (1, 1) if min(y, x) < 1 else (2 ** int(math.log2(y)), 2 ** int(math.log2(x)))


def _blending_period(shape: Shape) -> tuple[int, int]:
    """Return a period long enough to blend kernels, and a multiple of all steps."""
    y, x = (math.ceil(_BLEND * n / _COARSEST) for n in shape)
    period = free_period((y, x))
    return _COARSEST * period[0], _COARSEST * period[1]


class _Image(NamedTuple):
    """Offsets and weights of a kernel or its image, for some samples."""

    sample: slice
    offsets: Offsets
    weight: Array
    mirrored: bool


def _images(offsets: Offsets, points: int, period: int) -> list[_Image]:
    """Return the parts of a periodic kernel with a smooth transition to its periodic image.

    Halfway between the last offset on the map and its image, the kernel and its image have equal
    weight. The weight is an error function, the smoothest step for its width.
    """

    def weight(distance: Offsets) -> Array:
        reach = (2 * distance - period) / (period - 2 * points)
        return np.array([0.5 * math.erfc(_STEEPNESS * value) for value in reach])

    images = [_Image(slice(None), offsets, weight(offsets), False)]
    late = int(np.searchsorted(offsets, points, side="right"))
    if late < offsets.size:
        beyond = period - offsets[late:]
        images.append(_Image(slice(late, None), beyond, weight(beyond), True))
    return images


def blend(
    kernels: Callable[[Offsets, Offsets], Iterator[Array]],
    terms: list[Term],
    shape: Shape,
    period: Shape,
    rows: Offsets,
    columns: Offsets,
) -> list[Array]:
    """Return kernels that blend smoothly into their images beyond the offsets of the map."""
    result = [np.zeros((columns.size, rows.size)) for _ in terms]
    for y in _images(rows, shape[0], period[0]):
        for x in _images(columns, shape[1], period[1]):
            weight = np.outer(x.weight, y.weight)
            parts = kernels(y.offsets, x.offsets)
            for term, total, kernel in zip(terms, result, parts, strict=True):
                kernel *= weight
                if (term.odd[0] and y.mirrored) != (term.odd[1] and x.mirrored):
                    np.negative(kernel, out=kernel)
                total[x.sample, y.sample] += kernel
    return result


def _waves(loads: UnitLoads, terms: list[Term], shape: Shape, z: float, damped: float) -> Symbols:
    """Return the stress of waves of pressure and traction, up to q z = ``damped``."""
    (ny, nx), (dy, dx) = shape, loads.pixel
    highest = ny // 2, nx // 2
    if z > 0:
        reach = damped / (2 * math.pi * z)
        highest = (
            math.ceil(min(highest[0], reach * ny * dy)),
            math.ceil(min(highest[1], reach * nx * dx)),
        )
    qy = 2 * math.pi / (ny * dy) * np.arange(highest[0] + 1, dtype=np.float64)[:, None]

    def block(columns: slice) -> Array:
        qx: Array = 2 * math.pi / (nx * dx) * np.arange(columns.start, columns.stop)
        symbols = np.stack(loads.waves(qy, qx, z))
        # The wave at Nyquist has no sine. Along x the transform of a real map drops it.
        if 2 * highest[0] == ny:
            for term, symbol in zip(terms, symbols, strict=True):
                symbol[-1] *= not term.odd[0]
        return symbols

    return Symbols(highest, block)


# Depths per octave of the default list; its first depth in pixels, its last in contact radii.
_PER_OCTAVE = 3
_MIN_DEPTH_PIXELS = 0.5
_MAX_DEPTH_RADII = 3.0


def graded_depths(pressure: NDArray[Any], pixel: Pixel, *, boundary: str = "free") -> Array:
    """Return depths that follow the stress from a single pixel to the whole contact.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    boundary : {"free", "periodic"}
        Whether the map is isolated, or one period.

    Returns
    -------
    ndarray, shape (nz,)
        0, then a geometric series with three depths per octave, from half the shorter pixel edge,
        below which the stress only reflects the constant pressure on a pixel, to three contact
        radii [m].

    Raises
    ------
    InputError
        If the pixel is not positive, or there is no pressure.

    Notes
    -----
    The stress under a spot of radius r peaks at about r/2 (0.48 r under a Hertz contact) and
    changes little within a third of an octave. Spots may have any size from a pixel up, so the
    series is geometric. The contact radius is √5 times the larger standard deviation of the
    distribution of pressure over x and y: equal to a under a Hertz contact, and about the size of
    the loaded region otherwise. On a periodic map the list ends at a depth of one side, where the
    longest wave is damped to e^(-2π).
    """
    require_pixel(pixel)
    total = float(pressure.sum())
    if not total > 0:
        raise InputError("is zero everywhere: there is no stress", argument="pressure")
    if pressure.shape[0] == 1:
        # The width of a profile has no effect.
        pixel = (pixel[1], pixel[1])
    reach = 0.0
    for axis, edge in enumerate(pixel):
        weights = pressure.sum(axis=1 - axis) / total
        position = np.arange(weights.size) * edge
        position -= np.einsum("i,i->", weights, position)
        spread = float(np.einsum("i,i->", weights, position**2))
        reach = max(reach, _MAX_DEPTH_RADII * math.sqrt(5 * spread))
    if not Boundary(boundary).free_axes:
        reach = min(reach, max(n * edge for n, edge in zip(pressure.shape, pixel, strict=True)))
    first = _MIN_DEPTH_PIXELS * min(pixel)
    # A single loaded pixel has no spread; its stress decays within a few pixels.
    reach = max(reach, _MAX_DEPTH_RADII * max(pixel))
    count = math.ceil(_PER_OCTAVE * math.log2(reach / first)) + 1
    return np.concatenate([[0.0], np.geomspace(first, reach, count)])


@dataclass(frozen=True, eq=False)
class Slice:
    """Stress at one depth.

    Parameters
    ----------
    depth : float
        z [m].
    stress : ndarray, shape (6, ny, nx)
        Tensors xx, yy, zz, yz, xz, xy at the pixel centers [Pa].
    """

    depth: float
    stress: NDArray[Any]


def slices(
    pressure: ArrayLike,
    pixel: Pixel,
    depths: ArrayLike,
    poisson: float,
    *,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    traction: ArrayLike | None = None,
    precision: str = "single",
    workers: int | None = None,
) -> Iterator[Slice]:
    """Return an iterator over the stress at each depth.

    Parameters
    ----------
    pressure : array_like, shape (ny, nx)
        Pressure on the surface [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    depths : array_like, shape (nz,)
        Depths z ≥ 0 [m], in any order.
    poisson : float
        Poisson's ratio ν of the body; its other constants do not matter.
    boundary : {"free", "periodic"}
        Whether the map is isolated, or one period.
    friction : float
        Coefficient μ of the traction μ p on this body; the other body carries the opposite
        traction.
    direction : float
        Angle of the traction from x towards y [rad].
    traction : array_like, shape (2, ny, nx), optional
        Traction on this body [Pa], components (y, x), instead of friction.
    precision : {"double", "single"}
        Arithmetic of the transforms. Single is accurate to about 1e-6 of the largest pressure.
    workers : int, optional
        Threads; by default one for each core that the process may use.

    Returns
    -------
    iterator of Slice
        One slice for each depth, computed during iteration; the caller may modify it.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    Free: pressure is constant on each pixel, and the stress at the pixel centers is exact
    (`stress_kernels.uniform_pressure`). In single precision, kernels that are smooth at their
    depth are sampled at fewer points, which keeps the stress within 1e-6 of the largest pressure.

    Periodic: pressure is the trigonometric polynomial through the pixel centers, and each of its
    waves has its exact stress (`stress_kernels.waves`). The mean pressure acts on a body that
    cannot expand sideways: σ_xx = σ_yy = -ν/(1-ν) p̄.
    """
    workspace = Workspace(workers)
    field = field_of(
        pressure, pixel, poisson, boundary, friction, direction, precision, workspace, traction
    )
    return (_slice(field, depth) for depth in depth_list(depths).tolist())


def _slice(field: Field, depth: float) -> Slice:
    stress: NDArray[Any] = np.empty((6, *field.shape), field.real)

    def scale_rows(rows: slice, block: NDArray[Any]) -> None:
        np.multiply(block, field.unit, out=stress[:, rows], casting="same_kind")

    field.stream(depth, scale_rows)
    return Slice(depth, stress)


class CrossSection:
    """Stress at one depth along the row and the column through a pixel.

    Parameters
    ----------
    field : Field
        The stress.
    point : (int, int)
        Row and column of the pixel.
    """

    def __init__(self, field: Field, point: tuple[int, int]) -> None:
        (ny, nx), self.point = field.shape, point
        self.along_x: NDArray[Any] = np.empty((6, nx), field.real)
        self.along_y: NDArray[Any] = np.empty((6, ny), field.real)

    def store_block(self, rows: slice, stress: NDArray[Any]) -> None:
        """Store the stress of a row block; a callback of `Responses.stream`."""
        row, column = self.point
        self.along_y[:, rows] = stress[:, :, column]
        if rows.start <= row < rows.stop:
            self.along_x[...] = stress[:, row - rows.start]


def cross_section(field: Field, depth: float, point: tuple[int, int]) -> CrossSection:
    """Return the stress at one depth along the row and the column through a pixel."""
    cross = CrossSection(field, point)
    field.stream(depth, cross.store_block)
    return cross


def planes(field: Field, crosses: list[CrossSection]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the results of `sections` from the cross sections at all depths."""
    along_x = np.stack([cross.along_x for cross in crosses], axis=1)
    along_y = np.stack([cross.along_y for cross in crosses], axis=1)
    return along_x * field.unit, along_y * field.unit


def depth_list(depths: ArrayLike) -> Array:
    """Return depths as an array; raise `InputError` unless they are finite and ≥ 0."""
    listed = np.asarray(depths, dtype=np.float64)
    if listed.ndim != 1 or not listed.size or not (listed >= 0).all() or np.isinf(listed).any():
        raise input_error("depths", depths, "must be a list of finite depths ≥ 0 [m]")
    return listed
