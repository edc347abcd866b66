"""The ceiling of a contact: as it was asked for, and as plasticity of the volume recommends it.

A ceiling has one free number, its height over the yield strength. Three is right for metals in
full plasticity; before that the plateau of the pressure is lower, and where the metal hardens it
rises. What it is depends on how far a contact is beyond first yield, and that can be read from
the solution with any ceiling: see `recommended_ceiling`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError, Mention, require_choice, require_positive
from roughcontact.material.material import CEILING_FACTOR, softer

# Plateau of a perfectly plastic sphere over its yield strength, a line in log₁₀(load/first yield)
# through solutions with plasticity of the volume; benchmarks/ceiling_error.py fits it again.
_PLATEAU, _PER_DECADE = 1.44, 0.48

# Strain whose flow stress counts, over the slope a/R: between 0.1 for Swift's law, which is steep
# at small strains, and 0.2 for a linear one, which is Tabor's for full indentation.
_STRAIN = 0.15

# Error of a height difference over the largest height, at most.
_ROUNDING = 16 * float(np.finfo(np.float64).eps)


def resolved_ceiling(
    ceiling: str | float | ArrayLike | None, pair: Pair
) -> float | NDArray[np.float64] | None:
    """Return the ceiling as `solve` uses it.

    Parameters
    ----------
    ceiling : "auto", float, array_like or None
        As for `solve`.
    pair : Pair
        The bodies.

    Returns
    -------
    float, ndarray of shape (ny, nx), or None
        Largest pressure [Pa]; ``None`` without a ceiling.

    Raises
    ------
    InputError
        If it is neither of these, not positive, or does not fit the grid.
    """
    if isinstance(ceiling, str):
        require_choice(("auto",), ceiling=ceiling)
        body = pair.softer
        return None if body is None else body.ceiling
    if ceiling is None:
        return None
    try:
        given = np.asarray(ceiling)
    except ValueError:
        raise InputError(
            "must be a number or a map, got rows of unequal length", argument="ceiling"
        ) from None
    if given.dtype.kind not in "fiu" or isinstance(ceiling, np.ma.MaskedArray):
        raise InputError(
            f"must be real numbers [Pa], got {type(ceiling).__name__}", argument="ceiling"
        )
    values = given.astype(np.float64)
    if values.ndim == 0:
        require_positive(ceiling=float(values))
        return float(values)
    if values.shape != pair.shape:
        raise InputError(f"has shape {values.shape}, the surface {pair.shape}", argument="ceiling")
    if not (values > 0).all():
        smallest = float(values.min())
        raise InputError(
            f"must be positive everywhere [Pa], its smallest is {smallest!r}", argument="ceiling"
        )
    if np.isinf(values).all():
        return None
    values.flags.writeable = False
    return values


def combined_ceiling(
    ceiling: float | ArrayLike | None, counter_ceiling: float | ArrayLike | None
) -> float | NDArray[np.float64] | None:
    """Return the pressure ceiling of two bodies: the smaller one on every pixel.

    Parameters
    ----------
    ceiling, counter_ceiling : float, array_like of shape (ny, nx), or None
        Ceiling of each body [Pa], one for all or one per pixel: of a coating, of inclusions;
        ``None``, or ``inf`` on a pixel, where the body never yields. Maps lie on the common grid.

    Returns
    -------
    float, ndarray of shape (ny, nx), or None
        What `solve` takes as ``ceiling``: the softer of two points that touch yields.

    Raises
    ------
    InputError
        If a ceiling is not positive everywhere, or the maps differ in shape.

    Examples
    --------
    >>> combined_ceiling(3e9, [[2e9, 5e9]])
    array([[2.e+09, 3.e+09]])
    """
    known = [
        _checked_ceiling(name, value)
        for name, value in (("ceiling", ceiling), ("counter_ceiling", counter_ceiling))
        if value is not None
    ]
    if not known:
        return None
    maps = {ceiling.shape for ceiling in known if ceiling.ndim}
    if len(maps) > 1:
        raise InputError(
            "and ",
            Mention("counter_ceiling"),
            f" must lie on one grid, got the shapes {known[0].shape} and {known[1].shape}",
            argument="ceiling",
        )
    smaller = np.minimum(known[0], known[-1])
    return smaller if smaller.ndim else float(smaller)


def _checked_ceiling(name: str, ceiling: float | ArrayLike) -> NDArray[np.float64]:
    try:
        values = np.asarray(ceiling)
    except ValueError:
        raise InputError(
            "must be a number or a map, got rows of unequal length", argument=name
        ) from None
    if values.dtype.kind not in "fiu" or values.ndim not in (0, 2) or not values.size:
        raise InputError(
            f"must be a number or a map [y, x] in Pa, got dtype {values.dtype} and "
            f"shape {values.shape}",
            argument=name,
        )
    if not (values > 0).all():
        raise InputError(
            f"must be positive everywhere [Pa], its smallest is {values.min()}",
            argument=name,
        )
    return values.astype(np.float64)


@dataclass(frozen=True)
class RecommendedCeiling:
    """The ceiling that gives the contact area of plasticity in the volume.

    Parameters
    ----------
    load_ratio : float
        How far beyond first yield the contact spots are: load over the load of first yield of
        the sphere with the same slope and mean pressure in contact, its yield strength the flow
        stress.
    slope : float
        Contact radius over radius of that sphere, a/R.
    flow_stress : float
        Yield strength at the strain 0.15 a/R [Pa]; σ_Y if the material does not harden.
    ceiling : float
        The recommended ceiling [Pa].
    factor : float
        The same over the yield strength before any plastic strain.
    """

    load_ratio: float
    slope: float
    flow_stress: float
    ceiling: float
    factor: float


def ceiling_factor(load_ratio: float, first_yield: float = 1.615) -> float:
    """Return the ceiling of a perfectly plastic sphere over its yield strength.

    Parameters
    ----------
    load_ratio : float
        Load P over the load P_c of first yield.
    first_yield : float
        Hertz peak pressure at first yield over the yield strength; 1.615 at ν = 0.3.

    Returns
    -------
    float
        1.44 + 0.48 log₁₀(P/P_c), not below ``first_yield`` and not above 3.

    Raises
    ------
    InputError
        If the ratio is not positive.

    Notes
    -----
    Fitted to solutions with plasticity of the volume, ν = 0.3 and P/P_c from 6 to 700, such that
    the contact area agrees: it does to 1 %, the approach to 6 %. The form is that of cavity models
    (Johnson 1985, section 6.3): in the transition the plateau grows with the logarithm of the
    size of the plastic zone. On a half-space with small strains nothing else enters: E*, R and σ_Y
    only set the scale of the load.

    Examples
    --------
    >>> [round(ceiling_factor(ratio), 2) for ratio in (1, 12, 40, 300, 3000)]
    [1.61, 1.96, 2.21, 2.63, 3.0]
    """
    require_positive(load_ratio=load_ratio, first_yield=first_yield)
    plateau = _PLATEAU + _PER_DECADE * math.log10(load_ratio)
    return min(max(plateau, first_yield), CEILING_FACTOR)


def recommended_ceiling(result: ContactResult) -> RecommendedCeiling | None:
    """Return the ceiling that a contact should be solved with, judged from one solution.

    Parameters
    ----------
    result : ContactResult
        A solution with any ceiling, three yield strengths for instance.

    Returns
    -------
    RecommendedCeiling or None
        ``None`` if no yield strength is known, or if the spots have no slope but their tilt:
        pixels on their own, and flats without a step at their rim.

    Notes
    -----
    The spots are taken for one sphere. On a disc of radius a the slope of a paraboloid of radius R
    has the root mean square g = a/(√2 R), so that a/R = √2 g of any contact, g the slope of the
    initial gap over the contact spots, less the mean of each spot. With the mean pressure p̄ the
    load P = π a² p̄ is, over that of first yield P_c = π³ R² p_y³/(6 E*²),

        P/P_c = 6 (E* a/R)² p̄/(π² p_y³),

    p_y the Hertz peak pressure at first yield: whatever the ceiling of the solution, a lower one
    gives more area and so more slope. A material that hardens is taken at the strain 0.15 a/R.
    Tabor (1951) has 0.2 for full indentation; 0.15 does better before, where much of the plastic
    zone has strained less. On spheres and rough maps with two laws the area then agrees to 8 %.

    Examples
    --------
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-24:24, -24:24] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 1e-3), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = recommended_ceiling(solve(ball, material=steel, load=2.5))
    >>> round(found.load_ratio), round(found.factor, 1)
    (6, 1.8)
    """
    body = softer(result.material, result.counter_material)
    if body is None or body.yield_strength is None or body.first_yield_pressure is None:
        return None
    slope = math.sqrt(2) * _contact_slope(result)
    if slope == 0:
        return None
    flow = body.yield_strength
    if body.hardening is not None:
        flow = float(body.hardening.strength(np.array(_STRAIN * slope)))
    first_yield = body.first_yield_pressure / body.yield_strength
    mean = result.load / result.corrected_contact_area
    index = result.contact_modulus * slope / (math.pi * first_yield * flow)
    ratio = 6 * index**2 * mean / (first_yield * flow)
    ceiling = flow * ceiling_factor(ratio, first_yield)
    return RecommendedCeiling(ratio, slope, flow, ceiling, ceiling / body.yield_strength)


def _contact_slope(result: ContactResult) -> float:
    """Return the root-mean-square slope within the contact spots, each less its mean."""
    label = result.spots().label
    places = np.nonzero(label)
    bodies = [body for body in (result.surface, result.counter_surface) if body is not None]
    pixel = result.surface.pixel
    # What a flat has that is tilted, by the rounding of its heights.
    rounding = _ROUNDING * sum(float(np.nanmax(np.abs(b.heights))) for b in bodies) / min(pixel)
    gap, spot = result.initial_gap, label[places]
    if not spot.size:
        return 0.0
    count = np.bincount(spot)
    square = np.zeros(spot.size)
    for axis, edge in enumerate(pixel):
        before, after = list(places), list(places)
        before[axis] = np.maximum(places[axis] - 1, 0)
        after[axis] = np.minimum(places[axis] + 1, gap.shape[axis] - 1)
        apart = np.maximum(after[axis] - before[axis], 1) * edge
        slope = (gap[tuple(after)] - gap[tuple(before)]) / apart
        # Missing points never touch; at their rim the slope counts as that of the spot.
        known = ~np.isnan(slope)
        total = np.bincount(spot[known], slope[known], count.size)
        mean = total / np.maximum(np.bincount(spot[known], minlength=count.size), 1)
        square += np.where(known, slope - mean[spot], 0.0) ** 2
    slope = math.sqrt(float(square.mean()))
    return slope if slope > rounding else 0.0
