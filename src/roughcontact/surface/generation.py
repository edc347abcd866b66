"""Random surfaces with requested parameters of ISO 25178, and turned surfaces.

`turned_heights`: Shaw, Metal Cutting Principles (2005), the ideal roughness f²/(8R) of turning.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arguments import as_pair, validate_arguments
from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import ArgumentRef, InputError, input_error, require_positive
from roughcontact.halfspace import fft
from roughcontact.surface import grid, random_surfaces
from roughcontact.surface.alignment import cosine_sine
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.random_surfaces import Spectrum, with_gradient
from roughcontact.surface.roughness import rms_height
from roughcontact.surface.shapes import require_grid
from roughcontact.surface.spectrum import texture
from roughcontact.surface.surface import Surface, summary
from roughcontact.theory import height_distribution
from roughcontact.units import Quantities, Quantity, format_engineering, to_si


def turned_heights(
    shape: Shape, pixel: Pixel, feed: float, nose_radius: float, lay: float = 0.0
) -> Array:
    """Return the heights of an ideally turned surface: parabolic grooves, feed apart."""
    (ny, nx), (dy, dx) = shape, pixel
    cosine, sine = cosine_sine(lay)
    sides = ny * dy, nx * dx
    if not 4 * max(pixel) <= feed <= max(sides):
        raise InputError(
            f"has a feed of {feed:.4g} m, which must be between four pixels, {4 * max(pixel):.4g} "
            f"m, and a side of the map, {max(sides):.4g} m",
            argument="turning",
        )
    if not feed <= 2 * nose_radius < math.inf:
        raise InputError(
            f"has a nose radius of {nose_radius:.4g} m, less than half the feed {feed:.4g} m",
            argument="turning",
        )
    if 0.0 in (cosine, sine):
        across = sides[0] if sine == 0 else sides[1]
        feed = across / max(round(across / feed), 1)
    # Centers of the pixels; rows count downwards as the map is drawn.
    up, right = -(np.arange(ny)[:, None] + 0.5) * dy, (np.arange(nx) + 0.5) * dx
    phase = (up * cosine - right * sine) / feed
    offset = (phase - np.floor(phase) - 0.5) * feed
    grooves: Array = offset * offset / (2 * nose_radius)
    grooves -= grooves.mean()
    return grooves


def combine_with_grooves(grooves: Array, roughness: Array, height: float) -> Array:
    """Return grooves plus scaled roughness with the given root-mean-square height."""
    own = float(np.mean(grooves * grooves))
    if own > height**2:
        raise InputError(
            f"must be at least {math.sqrt(own):.4g} m, the Sq of the grooves alone, got "
            f"{height:.4g} m; give a smaller feed or a larger nose radius",
            argument="Sq",
            value=height,
        )
    common = float(np.mean(grooves * roughness))
    square = float(np.mean(roughness * roughness))
    # The positive root of |grooves + scale · roughness|² = height².
    scale = (math.sqrt(common**2 + square * (height**2 - own)) - common) / square
    return grooves + scale * roughness


Waves = NDArray[np.complex128]

PARAMETER_TOLERANCE = 0.02
"""Relative tolerance of the requested parameters of a generated map."""

# Default of the shortest wave, in pixels.
_CUTOFF = 8
# Default Str of the two groove families of a honed surface.
_HONED = 0.1
# Approximate ratio of Sal to the wavelength of the roll-off: start of the search.
_SAL = 0.33
# Maximum number of corrections of roll-off and ratio, of translations in each, and the tolerance of
# both, well below `PARAMETER_TOLERANCE`.
_ROUNDS, _TRANSLATIONS, _CLOSE = 8, 40, 0.005
# Damping of the correction of Str: on a map with two lays it changes up to 50 % more than the
# stretch of the spectrum.
_MOMENT_DAMPING = 0.8
# Fraction of the error by which the next target is corrected, and the bounds of its kurtosis: close
# to two heights, and far into the tails.
_GAIN, _LEAST, _MOST = 0.5, 0.5, 4 * height_distribution.MAX_KURTOSIS
# Ratio of roll-off to cut-off wavelength that is needed to determine a Hurst exponent.
_SPAN = 1.5


@dataclass(frozen=True)
class _Request:
    """Arguments of `generate`, lengths in meters; None if derived from the others."""

    Sq: float
    Sal: float | None
    Sdq: float | None
    hurst: float
    rolloff_wavelength: float | None
    cutoff_wavelength: float | None
    Str: float | None
    lay: float
    Ssk: float
    Sku: float | None
    honing: float | None
    turning: Sequence[float] | None
    seed: int

    def __post_init__(self) -> None:
        """Convert lengths to meters."""
        for name in ("Sq", "Sal", "rolloff_wavelength", "cutoff_wavelength", "turning"):
            object.__setattr__(self, name, to_si(getattr(self, name), "length", name))

    @property
    def rolloff(self) -> float | None:
        """Roll-off wavelength, of a turned surface by default its feed."""
        return self.rolloff_wavelength or (None if self.turning is None else self.turning[0])

    @property
    def ratio(self) -> float | None:
        """Str, of a honed surface with a default."""
        return _HONED if self.Str is None and self.honing is not None else self.Str

    @property
    def moments(self) -> tuple[float, float]:
        """Skewness and kurtosis."""
        usual = height_distribution.usual_kurtosis(self.Ssk)
        return self.Ssk, usual if self.Sku is None else self.Sku

    def cutoff(self, pixel: Pixel) -> float:
        """Return the cut-off wavelength on a grid."""
        return self.cutoff_wavelength or _CUTOFF * max(pixel)


@dataclass(frozen=True)
class _State:
    """State of the search for a map: phases of its parts, and their target moments."""

    phases: list[Waves]
    aim: tuple[float, float]


@validate_arguments
def generate(
    shape: tuple[int, int] | int,
    pixel: Quantities | Quantity,
    *,
    Sq: Quantity,
    Sal: Quantity | None = None,
    Sdq: float | None = None,
    hurst: float = 0.8,
    rolloff_wavelength: Quantity | None = None,
    cutoff_wavelength: Quantity | None = None,
    Str: float | None = None,
    lay: float = 0.0,
    Ssk: float = 0.0,
    Sku: float | None = None,
    honing: float | None = None,
    turning: Quantities | None = None,
    rng: int | np.random.Generator | None = 0,
) -> Surface:
    """Return a random rough surface with given parameters.

    Parameters
    ----------
    shape : (int, int) or int
        Grid points ``(ny, nx)``, or of each side.
    pixel : (float, float) or float
        Pixel edges ``(dy, dx)`` [m], or of a square one.
    Sq : float
        Root-mean-square height [m].
    Sal : float, optional
        Autocorrelation length [m]. This, ``rolloff_wavelength`` or Sdq sets the long waves.
    Sdq : float, optional
        Root-mean-square gradient. It sets the roll-off, or with Sal or a roll-off the cut-off.
    hurst : float
        Hurst exponent H, in [0, 1].
    rolloff_wavelength : float, optional
        Wavelength [m] above which the spectrum is flat.
    cutoff_wavelength : float, optional
        Shortest wavelength [m], at least two pixels; by default eight.
    Str : float, optional
        Texture aspect ratio, in (0, 1]; by default 1, the same in all directions.
    lay : float
        Direction of the lay [degrees], counter-clockwise from x as the map is drawn, row 0 on
        top.
    Ssk, Sku : float
        Skewness and kurtosis; by default those of a Gaussian surface, with Ssk alone the
        kurtosis of a gamma distribution, 3 + 1.5 Ssk².
    honing : float, optional
        Angle [degrees] between the two groove families of a honed surface, symmetric to the
        lay.
    turning : (float, float), optional
        Feed and radius of the nose of the tool [m] of a turned surface, with grooves along the
        lay; see `turned_heights`. Random roughness supplies the rest of Sq.
    rng : int, numpy.random.Generator or None
        Seed of ``numpy.random.default_rng``, 0 or more. A seed gives the same surface, to rounding,
        on every machine. A generator draws a seed, None a different one in every call; the surface
        records the seed.

    Returns
    -------
    Surface
        With requested and measured parameters in its provenance; see
        `compare_parameters`. It is periodic, except for grooves of turning across a corner.
        Equal seeds give the same waves on every grid over the same sides.

    Raises
    ------
    InputError
        If no such surface is possible, or the map too small or too coarse for it.

    Notes
    -----
    Every wave has the power that the spectrum demands (`random_surfaces.Spectrum`), not a random
    one, and a random phase. The heights are translated to a distribution of Johnson's system
    (``theory.height_distribution``), rank by rank; then the waves get their power back and keep
    their phases. Both steps alternate, with the targets corrected by the error, until spectrum and
    distribution agree with the request. Sal and Str are measured on the map, and roll-off and
    stretch of the spectrum corrected accordingly.

    References
    ----------
    Schreiber & Schmitz 1996, doi:10.1103/PhysRevLett.77.635 (alternating amplitudes and spectrum);
    Grigoriu 1984, doi:10.1061/(ASCE)0733-9399(1984)110:4(610) (translation); Johnson 1949,
    doi:10.1093/biomet/36.1-2.149; Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8
    (spectra)

    Examples
    --------
    >>> made = generate((256, 256), (1e-6, 1e-6), Sq="0.4 um", Sal="8 um", Ssk=-0.8, rng=3)
    >>> found = made.roughness()
    >>> [float(f"{found[name]:.2g}") for name in ("Sq", "Sal", "Ssk")]
    [4e-07, 8e-06, -0.8]
    """
    shape, edges = as_pair(shape, "shape"), as_pair(to_si(pixel, "length", "pixel"), "pixel")
    require_grid(shape, edges, grid.TRANSLATED_ARRAYS)
    seed = random_surfaces.seed_of(rng)
    sizes: dict[str, Any] = {"Sq": Sq, "Sal": Sal, "turning": turning}
    sizes |= {"rolloff_wavelength": rolloff_wavelength, "cutoff_wavelength": cutoff_wavelength}
    requested = _Request(
        Sdq=Sdq, hurst=hurst, Str=Str, lay=lay, Ssk=Ssk, Sku=Sku, honing=honing, seed=seed, **sizes
    )
    _check(requested, edges)
    if requested.turning is None:
        heights, spectrum = _generate_map(shape, edges, requested)
        heights *= requested.Sq / rms_height(heights)
    else:
        grooves = turned_heights(shape, edges, requested.turning[0], requested.turning[1], lay)
        heights, spectrum = _generate_map(shape, edges, requested)
        heights = combine_with_grooves(grooves, heights, requested.Sq)
    return _surface(heights, edges, requested, spectrum)


def _surface(heights: Array, pixel: Pixel, requested: _Request, spectrum: Spectrum) -> Surface:
    """Return the map with requested and actual parameters in its provenance."""
    measured = summary(heights, pixel)
    result = {name: value for name, value in measured.items() if math.isfinite(value)}
    result["rolloff_wavelength"], result["cutoff_wavelength"] = spectrum.rolloff, spectrum.cutoff
    if requested.turning is None and requested.honing is None:
        result |= _hurst(heights, spectrum)
    specified = {"shape": heights.shape, "pixel": pixel, **asdict(requested)}
    created = Operation("generate", specified, result)
    heights.flags.writeable = False
    source = f"generated rough surface, seed {requested.seed}"
    return Surface(heights, pixel, Provenance(source, origin=created))


def _hurst(heights: Array, spectrum: Spectrum) -> dict[str, float]:
    """Return the Hurst exponent from the spectrum of a map; NaN if its range is too short."""
    if spectrum.rolloff < _SPAN * spectrum.cutoff:
        return {}
    rising = spectrum.distances
    sloped = (rising > 1 / spectrum.rolloff) & (rising <= 1 / spectrum.cutoff)
    power = np.square(np.abs(fft.rfft2(heights)[sloped]))
    # Least-squares line without BLAS, whose last digits depend on the number of threads.
    along, power = np.log(rising[sloped]), np.log(power)
    along -= along.mean()
    slope = np.sum(along * power) / np.sum(along * along)
    return {"hurst": float(-1 - slope / 2)}


def _check_turning(requested: _Request) -> None:
    """Raise `InputError` for grooves that are impossible, or combined with other textures."""
    turning = requested.turning
    if not isinstance(turning, Sequence) or len(turning) != 2:
        raise input_error("turning", turning, "must be a pair (feed, nose radius) in meters")
    for name in ("Sal", "Sdq", "Str", "Sku", "honing", "Ssk"):
        value = getattr(requested, name)
        if value is not None and (value or name != "Ssk"):
            raise InputError(
                f"cannot be combined with {ArgumentRef('turning')}, whose grooves decide it; leave "
                "one out",
                argument=name,
            )
    if not all(0 < length < math.inf for length in turning):
        raise input_error("turning", turning, "must be two positive lengths, feed and nose radius")


def _check(requested: _Request, pixel: Pixel) -> None:
    """Raise `InputError` for impossible, redundant or missing parameters."""
    if requested.turning is not None:
        _check_turning(requested)
    require_positive(Sq=requested.Sq)
    for name in ("Sal", "Sdq", "rolloff_wavelength", "cutoff_wavelength"):
        value = getattr(requested, name)
        if value is not None:
            require_positive(**{name: value})
    if requested.Str is not None and not 0 < requested.Str <= 1:
        raise input_error("Str", requested.Str, "must be in (0, 1]")
    if requested.honing is not None and not 0 < requested.honing < 180:
        raise input_error("honing", requested.honing, "must be an angle between 0 and 180 degrees")
    cosine_sine(requested.lay)
    if requested.Sal is not None and requested.rolloff is not None:
        raise InputError(
            f"and {ArgumentRef('rolloff_wavelength')} set the same; give one of them",
            argument="Sal",
        )
    if requested.Sal is None and requested.Sdq is None and requested.rolloff is None:
        raise InputError(
            f"or {ArgumentRef('Sdq')} or {ArgumentRef('rolloff_wavelength')} must be given, for "
            "the length of the waves",
            argument="Sal",
        )
    cutoff = requested.cutoff(pixel)
    random_surfaces.check_waves(pixel, requested.rolloff or cutoff, cutoff, requested.hurst)
    height_distribution.require(*requested.moments, 1 if requested.honing is None else 2)


def _generate_map(shape: Shape, pixel: Pixel, requested: _Request) -> tuple[Array, Spectrum]:
    """Return a map of zero mean with the requested spectrum, moments and texture."""
    cutoff = requested.cutoff(pixel)
    start = requested.rolloff or (requested.Sal / _SAL if requested.Sal else 2 * cutoff)
    spectrum = Spectrum(
        shape,
        pixel,
        max(start, cutoff),
        cutoff,
        requested.hurst,
        requested.ratio or 1.0,
        requested.lay,
    )
    spectrum = _with_gradient(spectrum, requested)
    # Two independent generators; the first one gives the same draws with and without honing.
    sources = np.random.default_rng(requested.seed).spawn(1 if requested.honing is None else 2)
    drawn = [_phases(random_surfaces.random_amplitudes(shape, pixel, rng)) for rng in sources]
    state = _State(drawn, _part_moments(requested.moments, len(drawn)))
    for _ in range(_ROUNDS):
        amplitudes = _families(spectrum, requested.honing)
        heights, state = _impose_moments(shape, amplitudes, state, requested.moments)
        corrected = _correct_spectrum(spectrum, requested, heights)
        if corrected == spectrum:
            break
        spectrum = corrected
    return heights, spectrum


def _families(spectrum: Spectrum, honing: float | None) -> list[Array]:
    """Return the amplitudes of the waves of each independent part of a map."""
    turns = (0.0,) if honing is None else (-honing / 2, honing / 2)
    return [np.sqrt(replace(spectrum, lay=spectrum.lay + turn).power) for turn in turns]


def _with_gradient(spectrum: Spectrum, requested: _Request) -> Spectrum:
    """Return a spectrum with the requested gradient, if any."""
    if requested.Sdq is None:
        return spectrum
    sought = "rolloff" if requested.Sal is None and requested.rolloff is None else "cutoff"
    return with_gradient(spectrum, sought, requested.Sdq, requested.Sq)


def _correct_spectrum(spectrum: Spectrum, requested: _Request, heights: Array) -> Spectrum:
    """Return a spectrum corrected for measured Sal and Str, or the same if they are close."""
    if requested.Sal is None and requested.ratio is None:
        return spectrum
    Sal, Str, _ = texture(heights, spectrum.pixel)
    rolloff, ratio = spectrum.rolloff, spectrum.ratio
    if requested.Sal is not None and not abs(Sal / requested.Sal - 1) < _CLOSE:
        rolloff = _longer_rolloff(spectrum, requested, Sal)
    if (
        requested.ratio is not None
        and not math.isnan(Str)
        and not abs(Str / requested.ratio - 1) < _CLOSE
    ):
        ratio = min(ratio * (requested.ratio / Str) ** _MOMENT_DAMPING, 1.0)
    if (rolloff, ratio) == (spectrum.rolloff, spectrum.ratio):
        return spectrum
    return _with_gradient(replace(spectrum, rolloff=rolloff, ratio=ratio), requested)


def _longer_rolloff(spectrum: Spectrum, requested: _Request, Sal: float) -> float:
    """Return a roll-off corrected for Sal; raise if the map is too small for it."""
    assert requested.Sal is not None
    side = min(n * edge for n, edge in zip(spectrum.shape, spectrum.pixel, strict=True))
    if requested.Sal > side / 4:
        raise InputError(
            f"must be at most a quarter of the shorter side, {side / 4:.4g} m, for the map to show "
            f"it, got {requested.Sal:.4g} m",
            argument="Sal",
            value=requested.Sal,
        )
    wanted = 4 * side if math.isnan(Sal) else spectrum.rolloff * requested.Sal / Sal
    rolloff = min(max(wanted, spectrum.cutoff), 4 * side)
    if rolloff == spectrum.rolloff:
        kind, other = (
            ("at least", "shorter than the cut-off of the waves; give more points, or a shorter ")
            if rolloff == spectrum.cutoff
            else ("at most", "longer than the map holds; give longer sides or another ")
        )
        raise InputError(
            f"must be {kind} {format_engineering(Sal, 'm')} on this map, got "
            f"{format_engineering(requested.Sal, 'm')}: its waves would be {other}"
            f"{ArgumentRef('cutoff_wavelength')}",
            argument="Sal",
            value=requested.Sal,
        )
    return rolloff


def _impose_moments(
    shape: Shape, amplitudes: list[Array], state: _State, wanted: tuple[float, float]
) -> tuple[Array, _State]:
    """Return a map with these amplitudes and moments, and the final state of the search."""
    scores = _normal_scores(math.prod(shape))
    for _ in range(_TRANSLATIONS):
        parts = [
            _normalize_heights(fft.irfft2(amplitude * phases, shape))
            for amplitude, phases in zip(amplitudes, state.phases, strict=True)
        ]
        heights = parts[0] if len(parts) == 1 else _normalize_heights(np.sum(parts, axis=0))
        missed = [
            want - got
            for want, got in zip(wanted, height_distribution.moments(heights), strict=True)
        ]
        if all(
            abs(by) < _CLOSE * max(abs(want), 1) for by, want in zip(missed, wanted, strict=True)
        ):
            break
        aim = _next_moments(state.aim, missed, len(parts))
        try:
            ranks = _normalize_heights(height_distribution.fit_johnson(*aim).heights(scores))
        except ValueError:
            # The target moments are outside of all distributions.
            raise InputError(
                f"{wanted[0]:.3g} with Sku {wanted[1]:.3g} is not reachable, too few waves fit; "
                "use a shorter ",
                ArgumentRef("cutoff_wavelength"),
                " or a larger map",
                argument="Ssk",
            ) from None
        state = _State([_phases(fft.rfft2(_rank_transform(part, ranks))) for part in parts], aim)
    return heights, state


def _next_moments(
    aim: tuple[float, float], missed: Sequence[float], parts: int
) -> tuple[float, float]:
    """Return the next target moments of each part of a map."""
    by = _part_moments((missed[0], 3 + missed[1]), parts)
    skewness, kurtosis = aim[0] + _GAIN * by[0], aim[1] + _GAIN * (by[1] - 3)
    minimum = height_distribution.least_kurtosis(skewness) + _LEAST * height_distribution.STEP
    return skewness, min(max(kurtosis, minimum), _MOST)


def _part_moments(moments: tuple[float, float], parts: int) -> tuple[float, float]:
    """Return skewness and kurtosis of independent maps from those of their sum."""
    return math.sqrt(parts) * moments[0], 3 + parts * (moments[1] - 3)


def _normal_scores(points: int) -> Array:
    """Return the normal quantile of every rank, in rising order."""
    from scipy.special import ndtri

    return ndtri((np.arange(points) + 0.5) / points)


def _rank_transform(heights: Array, ranks: Array) -> Array:
    """Return the map with the given heights in the rank order of its heights."""
    created = np.empty_like(heights)
    created.reshape(-1)[np.argsort(heights, axis=None)] = ranks
    return created


def _phases(waves: Waves) -> Waves:
    """Return waves of unit amplitude with the same phases; 0 where there are none."""
    size = np.abs(waves)
    return np.divide(waves, size, out=np.zeros_like(waves), where=size > 0)


def _normalize_heights(heights: Array) -> Array:
    """Return heights with zero mean and unit root mean square."""
    deviation: Array = heights - heights.mean()
    deviation /= math.sqrt(float(np.mean(deviation * deviation)))
    return deviation


@dataclass(frozen=True)
class Parameter:
    """A parameter of a generated map."""

    name: str  # Symbol of the standard, or `"hurst"`
    requested: float  # Requested value, SI units
    measured: float  # Measured parameters of the map

    @property
    def missed(self) -> float:
        """Relative error, absolute for a skewness below 1; NaN if the map does not show it."""
        scale = max(abs(self.requested), 1.0) if self.name == "Ssk" else abs(self.requested)
        by = self.measured - self.requested
        return by if scale == 0 else by / scale

    @property
    def met(self) -> bool:
        """Whether the error is within `PARAMETER_TOLERANCE`."""
        return abs(self.missed) <= PARAMETER_TOLERANCE


def compare_parameters(surface: Surface) -> tuple[Parameter, ...]:
    """Return the requested and the actual parameters of a generated map."""
    created = surface.provenance.origin
    if created is None or created.method != "generate" or surface.provenance.operations:
        raise InputError("is not an unchanged generated map", argument="surface")
    specified, result = dict(created.arguments), created.found
    del specified["shape"], specified["pixel"]
    request = _Request(**specified)
    requested = {name: specified[name] for name in ("Sq", "Sal", "Sdq", "Str")}
    if request.turning is None:
        Ssk, Sku = request.moments
        requested |= {"Ssk": Ssk, "Sku": Sku, "hurst": request.hurst}
    return tuple(
        Parameter(name, value, result.get(name, math.nan))
        for name, value in requested.items()
        if value is not None and (name != "hurst" or name in result)
    )
