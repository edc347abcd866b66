"""Random contact problems at the ends of what can be asked, and what has to come of each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from random_cases import Case
from random_maps import KINDS, Array, drawn_holes, drawn_shape, rms_slope

TRAITS = (
    "two rows",
    "pixels beyond 1:100",
    "heights below 1e-15 m",
    "heights beyond 1 m",
    "99.9 % masked",
    "ceiling with zeros",
    "ceiling with infinities",
    "99.9 % of capacity and more",
    "tilt",
    "approach",
    "periodic along one axis",
)


def extreme(seed: int, largest: int) -> Case:
    """Return the extreme problem of a seed."""
    rng = np.random.default_rng([13, seed])
    kind = str(rng.choice(["self-affine", *KINDS, "self-affine"]))
    shape = drawn_shape(rng, largest)
    if rng.random() < 0.25:
        shape = (2, int(math.exp(rng.uniform(math.log(2), math.log(4 * largest)))))
        shape = shape if rng.random() < 0.5 else shape[::-1]
    edge = 10 ** rng.uniform(-9, -3)
    aspect = 10 ** rng.uniform(-3, 3) if rng.random() < 0.5 else 1.0
    pixel = (edge * math.sqrt(aspect), edge / math.sqrt(aspect))
    words = {"points": f"{shape[0]} × {shape[1]}", "pixel dy/dx": f"{aspect:.3g}"}
    surface, counter = _bodies(rng, kind, shape, pixel, words)
    together = surface.heights + (0.0 if counter is None else counter.heights)
    valid = np.isfinite(together)
    area = pixel[0] * pixel[1]

    poisson = rng.uniform(-0.99, 0.5, 2)
    material = rc.Material(10 ** rng.uniform(6, 12), poisson[0])
    against = rc.Material(10 ** rng.uniform(6, 12), poisson[1]) if rng.random() < 0.4 else rc.RIGID
    modulus = 1 / sum((1 - body.poisson**2) / body.young for body in (material, against))
    boundary = str(rng.choice(["free", "periodic", "periodic-x", "periodic-y"]))
    # Mean pressure: from a few pixels in touch to full contact, for any heights.
    strain = 10 ** rng.choice([rng.uniform(-1.5, 0.5), rng.uniform(-9, 1)])
    if rng.random() < 0.8:
        strain *= rms_slope(together, pixel) or 1.0
    mean = float(modulus * strain)
    ceiling, limit, expected = _ceiling(rng, mean, valid, words)
    if isinstance(ceiling, str):
        material = rc.Material(material.young, material.poisson, yield_strength=limit[0, 0] / 3)
    options: dict[str, Any] = {
        "material": material,
        "counter_material": against,
        "counter_surface": counter,
        "ceiling": ceiling,
        "boundary": boundary,
    }
    load = mean * int(np.count_nonzero(valid)) * area
    capacity = math.fsum(limit[valid]) * area
    if not valid.any():
        expected = expected or rc.CapacityError
    if rng.random() < 0.25:
        options["approach"], beyond = _approach(rng, together, boundary, limit)
        words["control"] = f"approach {options['approach']:.2g} m"
        expected = expected or beyond
    else:
        options["load"] = load or mean * area
        if load > capacity * (1 + 1e-9):
            expected = expected or rc.CapacityError
        elif rng.random() < 0.3 and valid.any():
            shares = limit[valid] * (area / load)
            options["boundary"] = boundary = "free"
            options["moments"], beyond = _moments(rng, load, shares, valid, pixel, words)
            expected = expected or beyond
    words["boundary"] = boundary
    _solver_options(rng, mean, shape, options, words)
    if "moments" in options and options.get("precision") == "single":
        expected = rc.InputError
    return Case(
        seed,
        surface,
        options,
        kind,
        words,
        expected,
        _traits(surface, options, load / capacity if capacity else 0.0),
    )


def _bodies(
    rng: np.random.Generator,
    kind: str,
    shape: tuple[int, int],
    pixel: tuple[float, float],
    words: dict[str, str],
) -> tuple[rc.Surface, rc.Surface | None]:
    """Return the map and, now and then, a second one."""
    heights = _heights(rng, kind, shape, pixel)
    draw = rng.random()
    if draw < 0.15:
        holes = rng.random(shape) < 0.999
        keep = np.argwhere(np.isfinite(heights))
        holes[tuple(keep[rng.integers(len(keep))])] = False
        heights, words["holes"] = np.where(holes, np.nan, heights), "99.9 %"
    elif draw < 0.25:
        heights, words["holes"] = drawn_holes(rng, heights)
    words["heights"] = f"{np.nanmax(heights) - np.nanmin(heights):.1g} m"
    if rng.random() < 0.1:
        # Measured from somewhere else: most or all digits are lost.
        heights = heights + np.nanstd(heights) * 10 ** rng.uniform(0, 18)
    counter = None
    if rng.random() < 0.1:
        counter = rc.Surface(_heights(rng, "self-affine", shape, pixel), pixel).masked()
        words["bodies"] = "two maps"
    return rc.Surface(heights, pixel).masked(), counter


def _heights(
    rng: np.random.Generator, kind: str, shape: tuple[int, int], pixel: tuple[float, float]
) -> Array:
    """Return a map [m]: of any height, or of slopes that a surface may have."""
    edge = math.sqrt(pixel[0] * pixel[1])
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * pixel[0] / edge
    x = (np.arange(shape[1]) - (shape[1] - 1) / 2) * pixel[1] / edge
    heights = KINDS[kind](rng, *np.meshgrid(y, x, indexing="ij"))
    depth = float(np.nanmax(heights) - np.nanmin(heights))
    if rng.random() < 0.5:
        scale = 10 ** rng.uniform(-30, 10) / (depth or 1.0)
    else:
        scale = 10 ** rng.uniform(-5, 0.5) / (rms_slope(heights * edge, pixel) or 1.0) * edge
    return np.asarray(heights * scale)


def _ceiling(
    rng: np.random.Generator, mean: float, valid: NDArray[np.bool_], words: dict[str, str]
) -> tuple[str | float | Array | None, Array, type[Exception] | None]:
    """Return a ceiling as `solve` takes it, the same on every pixel [Pa], and the error due."""
    # Part of the capacity that the load takes up; two of them refuse it.
    filling = float(
        rng.choice([0.03, 0.5, 0.9, 0.99, 0.999, 0.9999, 1 - 1e-8, 1 - 1e-13, 1.0001, 3.0])
    )
    value, shape = float(mean / filling), valid.shape
    words["ceiling"] = f"filled to {filling:.8g}"
    draw = rng.random()
    if draw < 0.3:
        words["ceiling"] = "none"
        return None, np.full(shape, math.inf), None
    if draw < 0.5:
        return ("auto" if draw < 0.4 else value), np.full(shape, value), None
    field = np.exp(rng.choice([0.3, 3.0, 10.0]) * rng.standard_normal(shape))
    if draw < 0.65:
        # A soft part in a hard one, down to one that carries next to nothing.
        soft = 10 ** rng.choice([rng.uniform(-6, 0), rng.uniform(-300, -20)])
        field = np.where(rng.random() > np.linspace(0, 1, shape[1]), soft, 1.0) * np.ones(shape)
    words["ceiling"] = "by pixel, " + words["ceiling"]
    sound = field[valid] if valid.any() else field
    field = np.maximum(field * (value / sound.mean()), 1e-300)
    if rng.random() < 0.4:
        field[rng.random(shape) < rng.choice([0.001, 0.2, 0.999])] = math.inf
        words["ceiling"] += ", some infinite"
    if rng.random() < 0.15:
        field[rng.random(shape) < rng.choice([0.01, 0.5])] = 0.0
        field[tuple(rng.integers(0, shape))] = 0.0
        words["ceiling"] += ", some zero"
        return field, field, rc.InputError
    return field, field, None


def _approach(
    rng: np.random.Generator, together: Array, boundary: str, limit: Array
) -> tuple[float, type[Exception] | None]:
    """Return an approach [m], and the error due."""
    valid = np.isfinite(together)
    if not valid.any():
        return 1e-6, None
    depth = float(together[valid].max() - together[valid].min())
    gap = float((together[valid].max() - together[valid]).mean())
    draw = rng.random()
    if draw < 0.2:
        approach = 10 ** rng.uniform(-30, 10)
    elif draw < 0.4:
        # Where a periodic map just closes.
        approach = gap * rng.choice([0.9, 0.999, 1 - 1e-6, 1.001])
    else:
        approach = depth * 10 ** rng.uniform(-4, 1)
    approach = float(approach) or 1e-6
    closes = boundary == "periodic" and valid.all() and np.isinf(limit).all()
    return approach, rc.CapacityError if closes and approach >= gap else None


def _moments(
    rng: np.random.Generator,
    load: float,
    share: Array,
    valid: NDArray[np.bool_],
    pixel: tuple[float, float],
    words: dict[str, str],
) -> tuple[tuple[float, float], type[Exception] | None]:
    """Return moments [N m] that some pressure has, or that none has, and the error due.

    ``share`` is the largest part of the load that each valid pixel can carry.
    """
    places = [
        (index - (points - 1) / 2) * edge
        for index, points, edge in zip(np.nonzero(valid), valid.shape, pixel, strict=True)
    ]
    at = np.array(places)
    inside = at @ _shared(rng.random(share.size) ** rng.choice([1, 10, 100]), share)
    angle = rng.uniform(0, 2 * math.pi)
    side = max(points * edge for points, edge in zip(valid.shape, pixel, strict=True))
    away = np.array([math.sin(angle), math.cos(angle)])
    order = np.argsort(-(away @ at))
    part = np.diff(np.minimum(np.cumsum(share[order]), 1.0), prepend=0.0)
    outermost = at[:, order] @ part
    draw = rng.random()
    due: type[Exception] | None = None
    if draw < 0.6:
        point, words["tilt"] = inside, "load within"
    elif draw < 0.85:
        way = float(rng.choice([0.5, 0.9, 0.99, 0.999]))
        point, words["tilt"] = inside + way * (outermost - inside), f"load {way:.3g} of the way out"
    else:
        point, words["tilt"] = outermost + 0.01 * side * away, "load beyond"
        due = rc.CapacityError
    return (float(point[0] * load), float(point[1] * load)), due


def _shared(weights: Array, share: Array) -> Array:
    """Return parts that sum to one, in the ratio of some weights but for those that are full."""
    weights, low, high = np.maximum(weights, 1e-250), -800.0, 800.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        full = np.minimum(weights * math.exp(min(middle, 700.0)), share).sum() >= 1
        low, high = (low, middle) if full else (middle, high)
    parts = np.minimum(weights * math.exp(min(high, 700.0)), share)
    return np.asarray(parts / parts.sum())


def _solver_options(
    rng: np.random.Generator,
    mean: float,
    shape: tuple[int, int],
    options: dict[str, Any],
    words: dict[str, str],
) -> None:
    """Add arithmetic, tolerance and start."""
    if rng.random() < 0.1:
        options["precision"] = words["precision"] = "single"
    elif rng.random() < 0.1:
        options["tolerance"] = float(rng.choice([1e-3, 1e-8, 1e-10]))
        words["tolerance"] = f"{options['tolerance']:.0e}"
    if rng.random() < 0.1:
        # The wrong start must cost time only.
        scale = mean * 10 ** rng.choice([0.0, rng.uniform(-30, 30)])
        options["initial_guess"] = scale * rng.random(shape) * (rng.random(shape) < rng.random())
        words["start"] = "random"


def _traits(surface: rc.Surface, options: dict[str, Any], filling: float) -> frozenset[str]:
    """Return the extreme traits of a problem."""
    depth = float(np.nanmax(surface.heights) - np.nanmin(surface.heights))
    ceiling = options["ceiling"]
    by_pixel = isinstance(ceiling, np.ndarray)
    found = (
        min(surface.shape) == 2,
        max(surface.pixel) > 100 * min(surface.pixel),
        depth < 1e-15,
        depth > 1,
        surface.missing > 0.995 * surface.heights.size,
        by_pixel and bool((ceiling == 0).any()),
        by_pixel and bool(np.isinf(ceiling).any()),
        "load" in options and 0.999 - 1e-9 <= filling <= 1,
        "moments" in options,
        "approach" in options,
        options["boundary"] in ("periodic-x", "periodic-y"),
    )
    return frozenset(trait for trait, holds in zip(TRAITS, found, strict=True) if holds)
