"""Virtual instruments: the effect of a measurement on a map.

`Instrument.measure` applies in this order: contact of a tip, lateral transfer, average over a
pixel, sampling, noise, missing points.

Tip: the image under a paraboloid of radius R is ``max over u of z(r + u) - |u|²/(2R)``. As ``|u|²``
is a sum over both axes, two passes along them are exact. A sphere of radius r becomes one of radius
r + R.

Villarrubia 1997, doi:10.6028/jres.102.030

Transfer: ``T(q) = 2^-(q λ50)²``, one half at the wavelength λ50, times ``sinc`` of a pixel along
each axis. The transfer of a round pupil in incoherent light is one half at 0.404 of 2 NA/λ, hence
λ50 = 1.24 λ/NA.

de Groot et al. 2024, doi:10.1364/AO.521868; ISO 25178-600:2019
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arguments import validate_public_methods
from roughcontact._tools.text import replace_unprintable
from roughcontact.errors import InputError, input_error, require_choice
from roughcontact.halfspace import fft
from roughcontact.surface import resolution as resolutions
from roughcontact.surface.form import level
from roughcontact.surface.random_surfaces import generator_of
from roughcontact.surface.roughness import rms_height
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity, to_si

Array = NDArray[np.float64]

_LENGTHS = {"optical": "resolution", "tip": "tip_radius"}
STORED = Path(__file__).with_name("instruments.toml")


@dataclass(frozen=True)
@validate_public_methods
class Instrument:
    """A virtual instrument: how a map differs from its surface.

    Parameters
    ----------
    kind : {"optical", "tip"}
        Principle of the measurement.
    resolution : float, optional
        Wavelength λ50 [m] of which half the amplitude is measured; 0 for a perfect transfer. An
        optical instrument needs it.
    tip_radius : float, optional
        Radius [m] of the tip; an instrument with a tip needs it.
    noise : float
        Root-mean-square noise of one point [m], independent from point to point.
    u_resolution, u_tip_radius, u_noise : float
        Relative standard uncertainties of resolution, tip radius and noise.
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
    """

    kind: str = "optical"
    resolution: float = 0.0
    tip_radius: float = 0.0
    noise: float = 0.0
    u_resolution: float = 0.15
    u_tip_radius: float = 0.2
    u_noise: float = 0.2
    name: str = ""

    def __init__(
        self,
        kind: str = "optical",
        *,
        resolution: Quantity | None = None,
        tip_radius: Quantity | None = None,
        noise: Quantity = 0.0,
        u_resolution: float = 0.15,
        u_tip_radius: float = 0.2,
        u_noise: float = 0.2,
        name: str = "",
    ) -> None:
        require_choice(tuple(_LENGTHS), kind=kind)
        if {"optical": resolution, "tip": tip_radius}[kind] is None:
            raise InputError(f"is needed for kind {kind!r}", argument=_LENGTHS[kind])
        numbers = {"u_resolution": u_resolution, "u_tip_radius": u_tip_radius, "u_noise": u_noise}
        for key, value in (
            ("resolution", resolution),
            ("tip_radius", tip_radius),
            ("noise", noise),
        ):
            numbers[key] = to_si(value or 0.0, "length", key)
        for key, value in numbers.items():
            if not 0 <= value < math.inf:
                raise input_error(key, value, "must not be negative")
            object.__setattr__(self, key, float(value))
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "name", replace_unprintable(name))

    @classmethod
    def named(cls, name: str, noise: Quantity = 0.0) -> Instrument:
        """Return an instrument of the catalog with typical values, or of a given kind.

        Parameters
        ----------
        name : str
            Name, such as ``"CSI 50x"``, or kind with resolution or tip radius, such as
            ``"optical 1.2 um"`` or ``"tip 50 nm"``.
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
        kind, _, length = name.partition(" ")
        if kind in _LENGTHS and name.casefold() not in known:
            size = to_si(length, "length", "instrument")
            return cls(kind, **{_LENGTHS[kind]: size}, noise=noise, name=name)
        if name.casefold() not in known:
            listed = ", ".join(row["name"] for row in rows)
            raise InputError(
                f"{name!r} is not in the catalog, which holds {listed}; or give a text such as "
                "'optical 1.2 um' or 'tip 50 nm'",
                argument="instrument",
                value=name,
            )
        row = {key: value for key, value in known[name.casefold()].items() if key != "source"}
        return cls(**row, noise=noise)

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
        noise = rms_height(level(first.heights - second.heights)) / math.sqrt(2)
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
            heights = dilated(heights, pixel, self.tip_radius)
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
        result: Array = np.exp2(-(self.resolution**2) * (qy**2 + qx**2))
        return result * np.sinc(qy * edges[0]) * np.sinc(qx * edges[1])

    def changed(self, **factors: float) -> Instrument:
        """Return the instrument with some lengths multiplied by factors."""
        return replace(self, **{key: getattr(self, key) * by for key, by in factors.items()})


def dilated(heights: Array, pixel: tuple[float, float], tip_radius: float) -> Array:
    """Return the image of periodic heights under a paraboloid of a radius."""
    from scipy import ndimage

    for axis, edge in enumerate(pixel):
        # Further away even the highest point is below a tip that touches the lowest one.
        reach = math.sqrt(2 * tip_radius * float(np.ptp(heights))) / edge
        reach = min(int(reach), (heights.shape[axis] - 1) // 2)
        shape = [1, 1]
        shape[axis] = 2 * reach + 1
        tip = (np.arange(-reach, reach + 1) * edge) ** 2 / (2 * tip_radius)
        heights = ndimage.grey_dilation(heights, structure=-tip.reshape(shape), mode="wrap")  # type: ignore[call-overload]
    return heights
