"""The cases of the atlas: which maps, pressed how, and one case computed.

`atlas.py` runs them. A number names a map: the same parameters and the same heights wherever it is
made. Maps are periodic, with the shortest wave at eight pixels; where the texture has a lay the
pixels are as much longer along it as the waves are. All loads and strengths are made
dimensionless by E* and the RMS gradient.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact.material.hardening import Hardening, Linear, Perfect
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.theory import height_distribution
from roughcontact.theory.persson import persson_fractions

Array = NDArray[np.float64]
Row = dict[str, float | str]

YOUNG, POISSON, GRADIENT = 210e9, 0.3, 0.1
MODULUS = YOUNG / (1 - POISSON**2)
SIDE = 1e-4
# Pixels of the shortest wave.
SHORTEST = 8
CEILING_FACTOR = 3.0

MAPS, CASES, POINTS = {"fit": 54, "held": 32}, 12, 512
BROAD = {"fit": 32, "held": 10}
TAILS = {"fit": 44, "held": 16}
VOLUMES, LOADS, RATIO, VOLUME_POINTS = {"fit": 48, "held": 16}, 6, 2.0, 64
# Each of these many maps has twice the points, and room for broader spectra.
LARGE, VOLUME_LARGE = 4, 8

CONTACT = (0.005, 0.8)
"""Range of the contact fraction that the theory gives, from which loads are drawn."""
INDEX = (0.5, 300.0)
"""Range of E* h'/σ_Y with a ceiling."""
ELASTIC = 0.15
"""Share of the cases without one."""


@dataclass(frozen=True)
class Map:
    """Parameters that a map is drawn with.

    Parameters
    ----------
    name : str
        ``fit-012``, ``held-003``.
    points : int
        Points a side.
    hurst, rolloff, breadth, Str, Ssk : float
        Hurst exponent, waves a side at the roll-off, roll-off over cut-off, texture, skewness.
    draws : ndarray
        Numbers from 0 to 1 for what it is pressed with.
    Sku : float or None
        Kurtosis; None for the usual one, 3 + 1.5 Ssk².
    """

    name: str
    points: int
    hurst: float
    rolloff: float
    breadth: float
    Str: float
    Ssk: float
    draws: Array
    Sku: float | None = None

    @property
    def seed(self) -> int:
        """Of its phases."""
        *model, kind, number = self.name.split("-")
        turn = 1000 * (("broad" in model) + 2 * ("tails" in model))
        return int(number) + (10_000 if kind == "held" else 0) + turn


def maps() -> list[Map]:
    """Return the maps of the ceiling model."""
    return [
        _random_map(
            f"{role}-{number:03d}", draw, POINTS * (1 if number % LARGE else 2), (6.0, 14.0)
        )
        for role, count in MAPS.items()
        for number, draw in enumerate(_draws(role, count, 5 + 2 * CASES))
    ]


def broad_maps() -> list[Map]:
    """Return further maps of the ceiling model: broader spectra, stronger lays, more skewness."""
    return [
        _random_map(
            f"broad-{role}-{number:03d}", draw, POINTS, (3.0, 6.0), span=3.4, skewed=(-1.5, 1.5)
        )
        for role, count in BROAD.items()
        for number, draw in enumerate(_draws(role, count, 6 + 2 * CASES))
    ]


def tailed_maps() -> list[Map]:
    """Return further maps of the ceiling model: any kurtosis from 2 to 10."""
    return [
        _map_with_kurtosis(
            _random_map(
                f"tails-{role}-{number:03d}", draw[1:], POINTS, (4.0, 12.0), 3.4, (-1.5, 1.5)
            ),
            draw[0],
        )
        for role, count in TAILS.items()
        for number, draw in enumerate(_draws(role, count, 7 + 2 * CASES))
    ]


def _map_with_kurtosis(drawn: Map, share: float) -> Map:
    """Return a map with a given kurtosis, from nearly the least possible to 10."""
    least = max(1.9, height_distribution.least_kurtosis(drawn.Ssk) + 1.5 * height_distribution.STEP)
    return replace(drawn, Sku=float(least * (10 / least) ** share))


def ceiling_maps() -> list[Map]:
    """Return all maps of the ceiling model."""
    return [*tailed_maps(), *broad_maps(), *maps()]


def volume_maps() -> list[Map]:
    """Return the maps of the volume model."""
    return [
        _random_map(
            f"volume-{role}-{number:03d}",
            draw,
            VOLUME_POINTS * (1 if number % VOLUME_LARGE else 2),
            (2.5, 3.5),
        )
        for role, count in VOLUMES.items()
        for number, draw in enumerate(_draws(role, count, 8))
    ]


def _draws(role: str, count: int, width: int) -> Array:
    """Return numbers from 0 to 1, shape (count, width): even for the fit, random for the test."""
    if role == "held":
        return np.random.default_rng(20_000 + width).random((count, width))
    from scipy.stats import qmc

    evenly: Array = qmc.Sobol(width, seed=width).random(256)[:count]
    return evenly


def _random_map(
    name: str,
    draw: Array,
    points: int,
    rolloff: tuple[float, float],
    span: float = 2.0,
    skewed: tuple[float, float] = (-1.5, 0.6),
) -> Map:
    waves = rolloff[0] + (rolloff[1] - rolloff[0]) * draw[0]
    most = points / SHORTEST / waves
    return Map(
        name,
        points,
        hurst=0.3 + 0.7 * draw[1],
        rolloff=waves,
        breadth=1.5 * (most / 1.5) ** draw[2],
        # Half of them without a lay.
        Str=1.0 if draw[3] > 0.5 else 10 ** (span * (draw[3] - 0.5)),
        # A third of them Gaussian.
        Ssk=0.0 if draw[4] > 2 / 3 else skewed[0] + (skewed[1] - skewed[0]) * 1.5 * draw[4],
        draws=draw[5:],
    )


def generate_map(drawn: Map) -> Surface:
    """Return a map with the RMS gradient `GRADIENT`: one without a lay, stretched along x."""
    pixel = SIDE / drawn.points
    alike = rc.generate(
        (drawn.points, drawn.points),
        (pixel, pixel),
        Sq=1e-6,
        rolloff_wavelength=SIDE / drawn.rolloff,
        cutoff_wavelength=SIDE / drawn.rolloff / drawn.breadth,
        hurst=drawn.hurst,
        Ssk=drawn.Ssk,
        Sku=drawn.Sku,
        rng=drawn.seed,
    )
    stretched = (pixel, pixel / drawn.Str)
    slope = roughness.rms_gradient(alike.heights, stretched)
    return rc.Surface(alike.heights * (GRADIENT / slope), stretched)


def parameters_of(surface: Surface) -> Row:
    """Return the parameters of a map on which the formulas may depend."""
    values = surface.roughness()
    Sq = values["Sq"]
    second, fourth = moments(surface)
    return {
        "breadth": values["Sdq"] * values["Sal"] / Sq,
        "Str": values["Str"],
        "Ssk": values["Ssk"],
        "Sku": values["Sku"],
        "nayak": Sq**2 * fourth / second**2,
        "gradient": values["Sdq"],
        "height": Sq,
    }


def moments(surface: Surface) -> tuple[float, float]:
    """Return the moments m₂ and m₄ of an average profile of a periodic map [1, 1/m²].

    From its waves: m₂ is half the mean squared gradient, m₄ three eighths of the mean squared
    Laplacian, which holds for maps without a lay (Longuet-Higgins 1957); others are averaged.
    """
    from roughcontact.halfspace import fft

    (ny, nx), (dy, dx) = surface.heights.shape, surface.pixel
    power = np.square(np.abs(fft.rfft2(surface.heights))) / surface.heights.size**2
    power[:, 1 : (nx + 1) // 2] *= 2
    squares = (2 * math.pi) ** 2 * (
        fft.frequencies(ny, dy)[:, None] ** 2 + fft.half_frequencies(nx, dx) ** 2
    )
    return float((power * squares).sum()) / 2, 3 / 8 * float((power * squares**2).sum())


# --- the ceiling model


def loads(drawn: Map) -> list[tuple[float, float]]:
    """Return the loads of a map: pairs of p̄/(E* h′) and E* h′/σ_Y, 0 without a ceiling."""
    pairs = []
    for first, second in drawn.draws[: 2 * CASES].reshape(-1, 2):
        index = 0.0
        if second > ELASTIC:
            index = INDEX[0] * (INDEX[1] / INDEX[0]) ** ((second - ELASTIC) / (1 - ELASTIC))
        wanted = CONTACT[0] * (CONTACT[1] / CONTACT[0]) ** first
        pairs.append((pressure_of(wanted, index), index))
    return pairs


def pressure_of(fraction: float, index: float) -> float:
    """Return p̄/(E* h′) at which Persson's theory has a contact fraction."""
    from scipy.optimize import brentq

    ceiling = CEILING_FACTOR / index if index else None

    def excess(logarithm: float) -> float:
        return persson_fractions(math.exp(logarithm), 1.0, 1.0, ceiling)[0] - fraction

    most = math.log(ceiling * (1 - 1e-9)) if ceiling and ceiling < 4 else math.log(4)
    return math.exp(brentq(excess, -20.0, most))


def solve_ceiling_case(surface: Surface, pressure: float, index: float) -> Row:
    """Return the results of the ceiling model, on all points and on every second one."""
    found: Row = {"pressure": pressure, "index": index}
    stress = MODULUS * roughness.rms_gradient(surface.heights, surface.pixel)
    coarse = rc.Surface(surface.heights[::2, ::2], (2 * surface.pixel[0], 2 * surface.pixel[1]))
    for suffix, one in (("", surface), ("_coarse", coarse)):
        result = rc.solve(
            one,
            material=rc.Material(young=YOUNG, poisson=POISSON),
            load=rc.NominalPressure(pressure * stress),
            ceiling=CEILING_FACTOR / index * stress if index else None,
            boundary="periodic",
            tolerance=1e-5,
        )
        corrected = result.perimeter_corrected_area / (result.pressure.size * result.pixel_area)
        found |= {
            f"contact{suffix}": corrected,
            f"pixels{suffix}": result.contact_fraction,
            f"saturated{suffix}": result.saturated_fraction,
            f"gap{suffix}": result.mean_gap,
        }
    found["separation"] = float(np.mean(result.gap))
    return found


def read_measured(place: Path) -> tuple[Surface, Row]:
    """Return a measured map, leveled, filled and without waves below eight pixels, and about it.

    It is continued by its mirror images, so that nothing jumps where it is taken as periodic.
    """
    surface = rc.read_surface(place).leveled()
    surface = surface.filled() if surface.missing else surface
    surface = surface.filtered(SHORTEST * max(surface.pixel), None)
    about = parameters_of(surface)
    if math.isnan(float(about["Str"])):
        about["Str"] = surface.roughness()["Str_max"]
    about["waves"] = min(surface.size) / surface.roughness()["Sal"]
    z = surface.heights
    z = np.concatenate([z, z[::-1]])
    return rc.Surface(np.concatenate([z, z[:, ::-1]], axis=1), surface.pixel), about


MEASURED_LOADS = [
    (fraction, index) for index in (0.0, 3.0, 20.0, 100.0) for fraction in (0.02, 0.08, 0.25, 0.5)
]
"""Contact fractions of the theory, and E* h′/σ_Y, under which measured maps are pressed."""


def ceilings(drawn: Map, done: set[int]) -> list[tuple[int, Row]]:
    """Return the cases of a map that are missing, by their numbers."""
    surface = generate_map(drawn)
    about = parameters_of(surface)
    return [
        (case, about | solve_ceiling_case(surface, *load))
        for case, load in enumerate(loads(drawn))
        if case not in done
    ]


# --- the volume model


def path(drawn: Map) -> tuple[list[float], float, float]:
    """Return the loads p̄/(E* h′), rising, E* h′/σ_Y, and the hardening modulus over E."""
    first, second, third = drawn.draws[:3]
    index = 2.0 * (150 / 2.0) ** first
    hardening = 0.0 if second < 1 / 3 else 10 ** (-3 + 2 * (second - 1 / 3) * 1.5)
    last = pressure_of(0.25 + 0.2 * third, index)
    return [last / RATIO**step for step in range(LOADS)][::-1], index, hardening


def solve_volume_cases(surface: Surface, drawn: Map) -> list[Row]:
    """Return the results of the volume model at every load of the path."""
    pressures, index, hardening = path(drawn)
    stress = MODULUS * roughness.rms_gradient(surface.heights, surface.pixel)
    area = math.prod(surface.size)
    strength = stress / index
    law: Hardening = Linear(strength, hardening * YOUNG) if hardening else Perfect(strength)
    result = rc.solve_elastoplastic(
        surface,
        material=rc.Material(young=YOUNG, poisson=POISSON, hardening=law),
        loads=[pressure * stress * area for pressure in pressures],
        boundary="periodic",
        increments=1,
    )
    pairs = [pressure * stress * area for pressure in pressures]
    rows: list[Row] = []
    for pressure, load in zip(pressures, pairs, strict=True):
        step = min(result.increments, key=lambda one: abs(one.load - load))
        rows.append(
            {
                "pressure": pressure,
                "index": index,
                "hardening": hardening,
                "volume": step.plastic_volume / area,
                "contact": step.contact_area / area,
                "strain": step.max_plastic_strain,
            }
        )
    return rows


def volumes(drawn: Map, done: set[int]) -> list[tuple[int, Row]]:
    """Return the loads of a map with plasticity of the volume that are missing: all of a path."""
    surface = generate_map(drawn)
    about = parameters_of(surface)
    rows = enumerate(solve_volume_cases(surface, drawn))
    return [(case, about | row) for case, row in rows if case not in done]


# --- on a worker


def solve_cases(
    threads: int, work: Callable[..., list[tuple[int, Row]]], drawn: Map, done: set[int]
) -> list[tuple[int, Row]]:
    """Return the missing cases of a map, by `ceilings` or `volumes`, solved on several cores."""
    from roughcontact.halfspace import fft

    with fft.limit_threads(threads):
        return work(drawn, done)
