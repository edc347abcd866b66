"""Virtual instruments: the effect of a measurement on a map.

`Instrument.measure` applies in this order: contact of a tip, lateral transfer, average over a
pixel, sampling, noise, missing points.

Tip: the image under a paraboloid of radius R is ``max over u of z(r + u) - |u|²/(2R)``. As ``|u|²``
is a sum over both axes, two passes along them are exact. A sphere of radius r becomes one of radius
r + R.

Villarrubia 1997, doi:10.6028/jres.102.030

Transfer of an optical instrument, for heights that are small against the wavelength of light: that
of a round pupil in incoherent light, ``T(ν) = (2/π)(acos ν - ν √(1 - ν²))`` with
``ν = q λ/(2 NA)``, which is one half at the wavelength λ50 = 1.2377 λ/NA. It holds for interference
microscopes whose light fills the pupil (CSI, PSI), and for confocal microscopes, whose pupils of
illumination and detection have the same autocorrelation. In coherent light (laser Fizeau, PSI with
a laser) T is one up to the wave number NA/λ. Focus variation averages over a window:
``T(q) = 2^-(q λ50)²``. Each is multiplied by ``sinc`` of a pixel along each axis.

Goodman 2005, Introduction to Fourier Optics, sections 6.2 and 6.3; de Groot 2021,
doi:10.1088/2515-7647/abe3da; Wilson & Sheppard 1984, Theory and Practice of Scanning Optical
Microscopy, ch. 3; ISO 25178-606:2015

Shape: between pupil and Gaussian of one λ50, ``T = T_pupil^(1 - s) T_Gauss^s``. Aberrations pass
less than the pupil, and light that does not fill the pupil passes more: s of an instrument of
known aperture is 0.1 ± 0.2, of one of which only λ50 is known 0.2 ± 0.35.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arguments import set_fields, validate_public_methods
from roughcontact._tools.arrays import Pixel
from roughcontact._tools.text import replace_unprintable
from roughcontact.errors import InputError, input_error, require_choice
from roughcontact.halfspace import fft
from roughcontact.surface import resolution as resolutions
from roughcontact.surface.form import level
from roughcontact.surface.random_surfaces import generator_of
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, to_si

Array = NDArray[np.float64]

_LENGTHS = dict.fromkeys(("optical", "coherent", "gaussian", "measured"), "resolution")
_LENGTHS["tip"] = "tip_radius"

# ν of a round pupil at T = 1/2, and wavelength of white light [m].
_HALF, _WAVELENGTH = 0.4039727532995173, 550e-9

# Shape of the transfer and its standard uncertainty: of optical instruments of known aperture, and
# of known resolution alone.
_SHAPE_OF_APERTURE, _SHAPE_OF_RESOLUTION = (0.1, 0.2), (0.2, 0.35)

STORED = Path(__file__).with_name("instruments.toml")


@dataclass(frozen=True)
@validate_public_methods
class Instrument:
    """A virtual instrument: how a map differs from its surface.

    Parameters
    ----------
    kind : {"optical", "coherent", "gaussian", "measured", "tip"}
        Principle of the measurement: a microscope in incoherent light (CSI, confocal), or in
        coherent light; an average over a window (focus variation); a transfer function that was
        measured, see `from_transfer`; a stylus or AFM.
    resolution : float, optional
        Wavelength λ50 [m] of which half the amplitude is measured; 0 for a perfect transfer. All
        kinds but a tip need it, or the aperture.
    numerical_aperture : float, optional
        Numerical aperture NA of the objective, from which the resolution follows.
    wavelength : float
        Wavelength λ of the light [m].
    tip_radius : float, optional
        Radius [m] of the tip; an instrument with a tip needs it.
    noise : float
        Root-mean-square noise of one point [m], independent from point to point.
    u_resolution, u_tip_radius, u_noise : float
        Relative standard uncertainties of resolution, tip radius and noise.
    shape, u_shape : float, optional
        Shape of an optical transfer, from 0 for a round pupil to 1 for a Gaussian, and its
        standard uncertainty.
    curve : tuple of (float, float)
        Measured transfer function: ``q λ50`` and transfer; see `from_transfer`.
    name : str
        Name in reports.

    Raises
    ------
    InputError
        If a length is negative, or the length that the kind needs is missing.

    Examples
    --------
    >>> Instrument("optical", resolution="1.2 um", noise="1 nm").resolution
    1.2e-06
    >>> round(Instrument("optical", numerical_aperture=0.55).resolution, 9)
    1.238e-06
    """

    kind: str = "optical"
    resolution: float = 0.0
    tip_radius: float = 0.0
    noise: float = 0.0
    u_resolution: float = 0.15
    u_tip_radius: float = 0.2
    u_noise: float = 0.2
    shape: float = 1.0
    u_shape: float = 0.0
    curve: tuple[tuple[float, float], ...] = ()
    name: str = ""

    def __init__(
        self,
        kind: str = "optical",
        *,
        resolution: Quantity | None = None,
        numerical_aperture: float | None = None,
        wavelength: Quantity = _WAVELENGTH,
        tip_radius: Quantity | None = None,
        noise: Quantity = 0.0,
        u_resolution: float = 0.15,
        u_tip_radius: float = 0.2,
        u_noise: float = 0.2,
        shape: float | None = None,
        u_shape: float | None = None,
        curve: Sequence[tuple[float, float]] = (),
        name: str = "",
    ) -> None:
        require_choice(tuple(_LENGTHS), kind=kind)
        known = _SHAPE_OF_RESOLUTION
        if numerical_aperture is not None:
            if not 0 < numerical_aperture < math.inf:
                raise input_error("numerical_aperture", numerical_aperture, "must be positive")
            cutoff = to_si(wavelength, "length", "wavelength") / numerical_aperture
            resolution = cutoff if kind == "coherent" else cutoff / (2 * _HALF)
            known = _SHAPE_OF_APERTURE
        if {"resolution": resolution, "tip_radius": tip_radius}[_LENGTHS[kind]] is None:
            raise InputError(f"is needed for kind {kind!r}", argument=_LENGTHS[kind])
        if kind == "measured" and len(curve) < 2:
            raise InputError("is needed for kind 'measured'; use from_transfer", argument="curve")
        if kind != "optical" or not resolution:
            known = (1.0, 0.0)
        numbers = {
            "u_resolution": u_resolution,
            "u_tip_radius": u_tip_radius,
            "u_noise": u_noise,
            "u_shape": known[1] if u_shape is None else u_shape,
        }
        lengths = {"resolution": resolution, "tip_radius": tip_radius, "noise": noise}
        numbers |= {key: to_si(value or 0.0, "length", key) for key, value in lengths.items()}
        for key, value in numbers.items():
            if not 0 <= value < math.inf:
                raise input_error(key, value, "must not be negative")
            set_fields(self, **{key: float(value)})
        pairs = tuple((float(x), float(t)) for x, t in curve)
        form = min(known[0] if shape is None else float(shape), 1.0)
        set_fields(self, kind=kind, shape=form, curve=pairs, name=replace_unprintable(name))

    @classmethod
    def from_name(cls, name: str, noise: Quantity = 0.0) -> Instrument:
        """Return an instrument of the catalog with typical values, or of a given kind.

        Parameters
        ----------
        name : str
            Name, such as ``"CSI 50x"``, or kind with resolution, aperture, tip radius or file of a
            transfer function, such as ``"optical 1.2 um"``, ``"optical NA 0.55"``,
            ``"tip 50 nm"`` or ``"measured itf.csv"``.
        noise : float
            Root-mean-square noise of one point [m]. The catalog has none: data sheets state
            the noise on a flat, and noise on a rough surface is higher.

        Returns
        -------
        Instrument
            Its resolution or tip radius with standard uncertainties.

        Raises
        ------
        InputError
            If the catalog does not contain the name.
        """
        rows = tomllib.loads(STORED.read_text(encoding="utf-8"))["instrument"]
        known = {row["name"].casefold(): row for row in rows}
        kind, _, given = name.partition(" ")
        if kind in _LENGTHS and name.casefold() not in known:
            if kind == "measured":
                return cls.from_transfer(*_read_transfer(Path(given)), noise=noise, name=name)
            if match := re.fullmatch(r"NA (\d*\.?\d+)(?: (.+))?", given):
                return cls(
                    kind,
                    numerical_aperture=float(match[1]),
                    wavelength=match[2] or _WAVELENGTH,
                    noise=noise,
                    name=name,
                )
            size = to_si(given, "length", "instrument")
            return cls(kind, **{_LENGTHS[kind]: size}, noise=noise, name=name)
        if name.casefold() not in known:
            listed = ", ".join(row["name"] for row in rows)
            raise InputError(
                f"{name!r} is not in the catalog, which holds {listed}; or give a text such as "
                "'optical 1.2 um', 'optical NA 0.55', 'tip 50 nm' or 'measured itf.csv'",
                argument="instrument",
                value=name,
            )
        row = {key: value for key, value in known[name.casefold()].items() if key != "source"}
        return cls(**row, noise=noise)

    @classmethod
    def from_transfer(cls, waves: ArrayLike, transfer: ArrayLike, **more: Any) -> Instrument:
        """Return an instrument with a measured transfer function.

        Parameters
        ----------
        waves : array_like, shape (n,)
            Wave numbers [1/m], not negative and increasing.
        transfer : array_like, shape (n,)
            Measured amplitude over true amplitude of each; 0 beyond the last.
        **more
            The other arguments of `Instrument`.

        Returns
        -------
        Instrument
            Its resolution is the wavelength at which the transfer falls to one half, or that of
            the last wave number, with a standard uncertainty of 5 %.
        """
        q, t = np.asarray(waves, dtype=float), np.asarray(transfer, dtype=float)
        is_curve = q.ndim == 1 and q.shape == t.shape and q.size > 1
        if not is_curve or q[0] < 0 or not (np.diff(q) > 0).all():
            raise InputError("must be at least two increasing wave numbers", argument="waves")
        if not ((t >= 0) & (t <= 1.2)).all() or not t[0] > 0.5:
            raise InputError("must fall from about 1 to 0", argument="transfer")
        low = np.flatnonzero(t < 0.5)
        half = q[-1]
        if low.size:
            last = low[0]
            half = np.interp(0.5, t[last - 1 : last + 1][::-1], q[last - 1 : last + 1][::-1])
        curve = list(zip(q / half, t, strict=True))
        known = {"u_resolution": 0.05, **more, "resolution": 1 / half, "curve": curve}
        return cls("measured", **known)

    @classmethod
    def from_repeats(cls, first: Surface, second: Surface, **more: Any) -> Instrument:
        """Return an instrument with the noise estimated from two maps of the same place.

        Parameters
        ----------
        first, second : Surface
            Two consecutive maps of the same place.
        **more
            The other arguments of `Instrument`.

        Returns
        -------
        Instrument
            Its noise is Sq of the leveled difference over √2.
        """
        if first.shape != second.shape:
            raise InputError(
                f"must have {first.shape} points as the first, got {second.shape}",
                argument="second",
            )
        difference = Surface(first.heights - second.heights, first.pixel).leveled()
        noise = difference.Sq / math.sqrt(2)
        return cls(**{"u_noise": 0.1, **more, "noise": noise})

    @classmethod
    def from_map(cls, surface: Surface) -> Instrument:
        """Return an optical instrument with noise and resolution estimated from a spectrum.

        Parameters
        ----------
        surface : Surface
            A measured map.

        Returns
        -------
        Instrument
            Its noise is the plateau of the spectrum, 0 without one: a lower bound, since the
            instrument smooths part of the noise. Its resolution is the wavelength below which
            the spectrum falls faster than that of a rough surface, at least two pixels.
        """
        heights, pixel = level(surface.heights), surface.pixel
        cutoff = resolutions.smoothing_cutoff(heights, pixel) or 0.0
        return cls(
            resolution=max(cutoff, 2 * max(pixel)),
            noise=resolutions.noise_height(heights, pixel),
            u_resolution=0.3,
            u_noise=0.5,
            name="estimated from the map",
        )

    def measure(
        self,
        surface: Surface,
        *,
        points: tuple[int, int] | None = None,
        missing: ArrayLike | None = None,
        periodic: bool = False,
        rng: int | np.random.Generator | None,
    ) -> Surface:
        """Return the map of a surface that this instrument measures.

        Parameters
        ----------
        surface : Surface
            Heights without holes.
        points : (int, int), optional
            Grid points of the map; those of the surface are an integer multiple along each axis,
            and the default.
        missing : array_like of bool, optional
            Points without a height on the map.
        periodic : bool
            Whether the surface continues periodically; else it is mirrored at its edges.
        rng : int, numpy.random.Generator or None
            Seed or source of the noise; None gives different noise in every call.

        Returns
        -------
        Surface
            The map, neither filled nor leveled.
        """
        surface.require_map("an instrument")
        if surface.missing:
            raise InputError("has missing points; fill them first", argument="surface")
        shape = points or surface.shape
        steps = [fine // coarse for fine, coarse in zip(surface.shape, shape, strict=True)]
        if tuple(n * step for n, step in zip(shape, steps, strict=True)) != surface.shape:
            raise input_error("points", points, f"must divide {surface.shape}")
        heights = surface.heights
        if not periodic:
            heights = np.pad(heights, [(0, n) for n in heights.shape], "symmetric")
        whole = tuple(n // step for n, step in zip(heights.shape, steps, strict=True))
        image = self.image(heights, surface.pixel, whole)[: shape[0], : shape[1]]
        image = image + self.noise * generator_of(rng).standard_normal(image.shape)
        if missing is not None:
            image[np.asarray(missing, dtype=bool)] = np.nan
        pixel = surface.pixel[0] * steps[0], surface.pixel[1] * steps[1]
        return Surface(image, pixel)

    def image(self, heights: Array, pixel: tuple[float, float], points: tuple[int, int]) -> Array:
        """Return the noiseless image of periodic heights on a coarser grid."""
        if self.tip_radius:
            heights = dilate(heights, pixel, self.tip_radius)
        steps = [fine // coarse for fine, coarse in zip(heights.shape, points, strict=True)]
        edges = pixel[0] * steps[0], pixel[1] * steps[1]
        spectrum = fft.rfft2(heights) * self.transfer(heights.shape, pixel, edges)
        # The center of a pixel of the image is between points of the surface.
        for axis, step in enumerate(steps):
            n = heights.shape[axis]
            waves = fft.half_frequencies(n) if axis else fft.frequencies(n)[:, None]
            spectrum *= np.exp(1j * math.pi * (step - 1) * waves)
        return fft.irfft2(spectrum, heights.shape)[:: steps[0], :: steps[1]]

    def transfer(
        self, shape: tuple[int, ...], pixel: tuple[float, float], edges: tuple[float, float]
    ) -> Array:
        """Return the transfer function at every wave of a grid, for maps of another pixel."""
        qy = fft.frequencies(shape[0], pixel[0])[:, None]
        qx = fft.half_frequencies(shape[1], pixel[1])
        result = self.lateral_transfer(np.hypot(qy, qx))
        return result * np.sinc(qy * edges[0]) * np.sinc(qx * edges[1])

    def lateral_transfer(self, q: Array) -> Array:
        """Return the transfer function at wave numbers [1/m], without pixels."""
        x = q * self.resolution
        if self.kind == "measured":
            places, transfer = np.array(self.curve).T
            return np.asarray(np.interp(x, places, transfer, right=0.0))
        if self.kind == "coherent":
            return (x <= 1).astype(float)
        pupil = round_pupil(_HALF * x) if self.shape < 1 else np.ones_like(x)
        return np.asarray(pupil ** (1 - self.shape) * np.exp2(-self.shape * x**2))

    def vary(self, shape: float = 0.0, **factors: float) -> Instrument:
        """Return the instrument with some lengths multiplied by factors, and another shape."""
        lengths = {key: getattr(self, key) * by for key, by in factors.items()}
        return replace(self, **lengths, shape=self.shape + shape)


def round_pupil(x: Array) -> Array:
    """Return the incoherent transfer of a round pupil, at wave numbers over its largest one."""
    x = np.minimum(x, 1.0)
    return np.asarray(2 / math.pi * (np.arccos(x) - x * np.sqrt(1 - x**2)))


def _read_transfer(path: Path) -> tuple[Array, Array]:
    """Return wave numbers [1/m] and transfer of a file of two columns, the first in 1/mm."""
    try:
        text = path.read_text(encoding="utf-8-sig").replace(",", " ").replace(";", " ")
        table = np.loadtxt(text.splitlines(), ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path} is not a transfer function: {error}", argument="instrument"
        ) from None
    if table.shape[1] != 2:
        raise InputError(
            f"{path} has {table.shape[1]} columns; a transfer function has two, the spatial "
            "frequency [1/mm] and the transfer",
            argument="instrument",
        )
    return 1e3 * table[:, 0], table[:, 1]


def dilate(heights: Array, pixel: Pixel, tip_radius: float) -> Array:
    """Return the image of periodic heights under a paraboloid of a radius.

    The axes are separable. The tip may touch between points: around each point, up to half a pixel
    away, the heights are continued with their slope and curvature.
    """
    for axis, edge in enumerate(pixel):
        image = np.empty_like(np.moveaxis(heights, axis, 0))
        # Blocks of columns stay in the cache of a processor.
        width = max(_BLOCK // len(image), 1)
        for first in range(0, image.shape[1], width):
            columns = slice(first, first + width)
            along = np.ascontiguousarray(np.moveaxis(heights, axis, 0)[:, columns])
            image[:, columns] = _dilate_columns(along, edge**2 / tip_radius)
        heights = np.moveaxis(image, 0, axis)
    return heights


# Number of heights that are dilated at once.
_BLOCK = 1 << 14


def _dilate_columns(heights: Array, curvature: float) -> Array:
    """Return the image of periodic columns under a parabola of a curvature, in points."""
    before, after = np.roll(heights, 1, 0), np.roll(heights, -1, 0)
    slope = (after - before) / 2
    # A valley that is sharper than the tip is touched at its ends.
    blunter = np.maximum(curvature - (after - 2 * heights + before), 1e-9 * curvature)
    # Further away the surface is nowhere steep enough for the tip.
    steepest = float(np.abs(after - heights).max(initial=0.0))
    reach = min(math.ceil(steepest / curvature) + 1, (len(heights) - 1) // 2)
    image = heights.copy()
    for steps in range(-reach, reach + 1):
        rise = slope - curvature * steps
        place = np.clip(rise / blunter, -0.5, 0.5)
        apex = heights - curvature * steps**2 / 2 + place * (rise - blunter * place / 2)
        np.maximum(image, np.roll(apex, -steps, 0), out=image)
    return image
