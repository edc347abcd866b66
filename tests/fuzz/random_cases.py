"""Random contact problems as engineers have them, and what has to come of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import roughcontact as rc
from random_maps import KINDS, Array, drawn_heights, drawn_holes, drawn_shape, rms_slope


@dataclass(frozen=True)
class Case:
    """One problem and what has to come of it.

    Parameters
    ----------
    seed : int
        Source of the draw.
    surface : Surface
        The map.
    options : dict
        Everything else that `solve` is given.
    kind : str
        Kind of the map.
    words : dict
        The problem as text, for the table.
    expected : type or None
        The error that has to come, or ``None`` for a solution.
    traits : frozenset of str
        Its extreme traits.
    """

    seed: int
    surface: rc.Surface
    options: dict[str, Any]
    kind: str
    words: dict[str, str]
    expected: type[Exception] | None
    traits: frozenset[str] = frozenset()


def ordinary(seed: int, largest: int) -> Case:
    """Return the ordinary problem of a seed."""
    rng = np.random.default_rng([6, seed])
    # A sixth of them what most measured maps are.
    kind = str(rng.choice(["self-affine", *KINDS, "self-affine"]))
    shape = drawn_shape(rng, largest)
    edge, aspect = 10 ** rng.uniform(-9, -3), 1.0
    if rng.random() < 0.4:
        aspect = float(rng.choice([1.5, 3, 20])) ** rng.choice([-1, 1])
    pixel = (edge * math.sqrt(aspect), edge / math.sqrt(aspect))
    heights = drawn_heights(rng, kind, shape, pixel)
    words = {"points": f"{shape[0]} × {shape[1]}", "pixel dy/dx": f"{aspect:.3g}"}
    expected: type[Exception] | None = None

    counter = None
    if rng.random() < 0.1:
        other = drawn_heights(rng, "self-affine", shape, pixel)
        if rng.random() < 0.3:
            other, _ = drawn_holes(rng, other)
        counter = rc.Surface(other, pixel)
        words["bodies"] = "two maps"
    holed = bool(np.isnan(heights).any())
    if rng.random() < 0.2:
        heights, words["holes"] = drawn_holes(rng, heights)
        holed = bool(np.isnan(heights).any())
    surface = rc.Surface(heights, pixel)
    if holed and rng.random() < 0.07:
        expected, words["holes"] = rc.InputError, "left unhandled"
    elif holed:
        surface = surface.masked()
    if counter is not None and counter.missing:
        counter = counter.masked()
    together = surface.heights + (0.0 if counter is None else counter.heights)
    valid = np.isfinite(together)

    material = rc.Material(10 ** rng.uniform(6, 12), rng.uniform(-0.5, 0.5))
    against = rc.RIGID
    if rng.random() < 0.4:
        against = rc.Material(10 ** rng.uniform(6, 12), rng.uniform(-0.5, 0.5))
    modulus = 1 / sum((1 - body.poisson**2) / body.young for body in (material, against))
    boundary = str(rng.choice(["free", "periodic"]))
    words["boundary"] = boundary

    # Mean pressure: from a few pixels in touch to full contact.
    area = surface.pixel[0] * surface.pixel[1]
    points = max(int(np.count_nonzero(valid)), 1)
    slope = max(rms_slope(together, pixel), 1e-6)
    decades = [rng.uniform(-1.5, 0.5), rng.uniform(-4, 1), rng.uniform(-9, -4)]
    mean = modulus * slope * 10 ** rng.choice(decades, p=[0.6, 0.3, 0.1])
    load = float(mean * points * area)
    ceiling, capacity, words["ceiling"] = _ceiling(rng, mean, shape, valid)
    if isinstance(ceiling, str):
        material = rc.Material(material.young, material.poisson, yield_strength=capacity / 3)
    by_pixel = np.broadcast_to(
        math.inf if ceiling is None else capacity if isinstance(ceiling, str) else ceiling, shape
    )
    carries = math.fsum(by_pixel[valid]) * area

    options: dict[str, Any] = {
        "material": material,
        "counter_material": against,
        "counter_surface": counter,
        "ceiling": ceiling,
        "boundary": boundary,
    }
    if rng.random() < 0.2:
        depth = float(np.nanmax(together) - np.nanmin(together)) if valid.any() else 0.0
        approach = depth * 10 ** rng.uniform(-3, 0.2) if depth else slope * edge
        if rng.random() < 0.2 and valid.any():
            # Where a periodic map just closes.
            gap = float(np.nanmax(together) - together[valid].mean())
            approach = gap * rng.choice([0.9, 0.999, 1.001]) or approach
        options["approach"] = float(approach)
        words["control"] = "approach"
        if boundary == "periodic" and valid.all() and np.isinf(by_pixel).all():
            gap = float((np.max(together) - together).mean())
            if approach >= gap:
                expected = expected or rc.CapacityError
    else:
        options["load"] = load
        words["control"] = "load"
        if load > carries * (1 + 1e-9):
            expected = expected or rc.CapacityError
    if not valid.any():
        expected = expected or rc.CapacityError
    if rng.random() < 0.1:
        options["precision"] = "single"
        words["precision"] = "single"
    elif rng.random() < 0.1:
        options["tolerance"] = 1e-8
        words["tolerance"] = "1e-8"
    if rng.random() < 0.1:
        # The wrong start must cost time only.
        options["initial_guess"] = mean * rng.random(shape) * (rng.random(shape) < rng.random())
        words["start"] = "random"
    return Case(seed, surface, options, kind, words, expected)


def _ceiling(
    rng: np.random.Generator, mean: float, shape: tuple[int, int], valid: NDArray[np.bool_]
) -> tuple[str | float | Array | None, float, str]:
    """Return a ceiling [Pa] as `solve` takes it, its scalar value, and its name."""
    # Part of the capacity that the load takes up; two of them refuse it.
    filling = float(
        rng.choice([1e-4, 0.03, 0.2, 0.5, 0.9, 0.99, 0.9999, 1 - 1e-8, 1 - 1e-13, 1.0001, 3.0])
    )
    value = float(mean / filling)
    name = f"filled to {filling:.8g}"
    draw = rng.random()
    if draw < 0.35:
        return None, math.inf, "none"
    if draw < 0.45:
        return "auto", value, name
    if draw < 0.7:
        return value, value, name
    spread = rng.choice([0.3, 3.0])
    field = np.exp(spread * rng.standard_normal(shape))
    if draw < 0.8:
        # A soft part in a hard one.
        field = np.where(rng.random() > np.linspace(0, 1, shape[1]), 1e-3, 1.0) * np.ones(shape)
        name = f"two halves, {name}"
    else:
        name = f"by pixel, {name}"
    sound = field[valid] if valid.any() else field
    field = field * value / sound.mean()
    if rng.random() < 0.3:
        field[rng.random(shape) < 0.2] = math.inf
        name += ", some infinite"
    return field, value, name
