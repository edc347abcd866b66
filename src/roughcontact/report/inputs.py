"""What went in, worded once: maps, their roughness, and materials."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from roughcontact.material.material import Material
from roughcontact.report import wording
from roughcontact.report.quantities import ABSENT, Quantity, Table, quantity_of, within, written
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering, percent, plain


def _pair(values: Sequence[float]) -> str:
    return " × ".join(engineering(value, "m") for value in values)


def _range(surface: Surface) -> str:
    low, high = (float(end(surface.heights)) for end in (np.nanmin, np.nanmax))
    return (
        f"{engineering(low, 'm')} to {engineering(high, 'm')}, range {engineering(high - low, 'm')}"
    )


def _missing(surface: Surface) -> str:
    share = surface.missing / surface.heights.size
    return f"{surface.missing} ({percent(share)})" if surface.missing else "none"


SURFACE: Table = (
    Quantity("source", "source", of=lambda s: s.provenance.source, form=lambda v: v or "not named"),
    Quantity(
        "instrument", "instrument", of=lambda s: s.provenance.instrument, brief=False,
        form=lambda v: v or "not named",
    ),
    Quantity(
        "channel", "channel", of=lambda s: s.provenance.channel,
        when=lambda s: bool(s.provenance.channel),
    ),
    Quantity(
        "shape", "grid (y × x)", of=lambda s: list(s.shape),
        form=lambda v: f"{v[0]} × {v[1]} points",
    ),
    Quantity("pixel", "pixel (y × x)", unit="m", of=lambda s: list(s.pixel), form=_pair),
    Quantity("size", "size (y × x)", unit="m", of=lambda s: list(s.size), form=_pair),
    Quantity(
        "height_min", "heights", unit="m", of=lambda s: float(np.nanmin(s.heights)), brief=False,
        text=_range,
    ),
    Quantity("height_max", unit="m", of=lambda s: float(np.nanmax(s.heights))),
    Quantity(
        "missing", "missing points", of=lambda s: s.missing, brief=False,
        text=_missing,
    ),
)  # fmt: skip
"""Of a `Surface`."""


def _strength(name: str) -> Callable[[Material], str]:
    def text(body: Material) -> str:
        value: float | None = getattr(body, name)
        if value is None:
            return ABSENT if wording.is_rigid(body) else "not given"
        return engineering(value, "Pa")

    return text


BODY: Table = (
    Quantity("rigid", of=wording.is_rigid),
    Quantity(
        "name", "material", of=lambda b: b.name, form=lambda v: v or "not named", stored=False,
    ),
    Quantity(
        "young", "Young's modulus", symbol="E", unit="Pa",
        form=lambda v: "rigid" if math.isinf(v) else engineering(v, "Pa"),
    ),
    Quantity(
        "poisson", "Poisson's ratio", symbol="ν",
        text=lambda b: ABSENT if wording.is_rigid(b) else f"{b.poisson:g}",
    ),
    Quantity(
        "yield_strength", "yield strength", symbol="σ_Y", unit="Pa",
        text=_strength("yield_strength"),
    ),
    Quantity("hardening", "hardening", of=wording.hardening, stored=False),
    Quantity("hardness", "hardness", unit="Pa", text=_strength("hardness")),
    Quantity(
        "first_yield_pressure", "peak pressure at first yield of a sphere", unit="Pa",
        text=_strength("first_yield_pressure"), stored=False, brief=False,
    ),
)  # fmt: skip
"""Of a `Material`."""


def bodies(model: str) -> Table:
    """Return what of a material counts: with the volume model the law, not the hardness."""
    if model == "volume":
        return tuple(quantity for quantity in BODY if quantity.key != "hardness")
    law = quantity_of(BODY, "hardening")
    hardens = replace(law, when=lambda body: body.hardening is not None)
    return tuple(hardens if quantity is law else quantity for quantity in BODY)


class Measured(NamedTuple):
    """A map as it is in a file, and leveled."""

    surface: Surface
    leveled: Surface


def _both(name: str, unit: str) -> Quantity:
    def text(found: Measured) -> str:
        first, second = (
            written(getattr(surface, name), unit) for surface in (found.surface, found.leveled)
        )
        return f"{first}, after plane {second}"

    return Quantity(name, name, unit=unit, of=f"surface.{name}", text=text)


FILE: Table = (
    *(within("surface", quantity) for quantity in SURFACE if quantity.key != "missing"),
    _both("Sq", "m"),
    Quantity("Sq_leveled", unit="m", of="leveled.Sq"),
    _both("Sdq", "1"),
    Quantity("Sdq_leveled", of="leveled.Sdq"),
    within("surface", quantity_of(SURFACE, "missing")),
    Quantity("missing_fraction", of=lambda f: f.surface.missing / f.surface.heights.size),
    Quantity("roughness_leveled", of=lambda found: found.leveled.roughness()),
)
"""Of a map in a file, `Measured`."""


def measured(surface: Surface) -> Measured:
    """Return a map as it is in a file, and leveled."""
    return Measured(surface, surface.leveled())


ROUGHNESS = {
    "Sq": ("m", "root-mean-square height"),
    "Sa": ("m", "mean absolute height"),
    "Sp": ("m", "highest peak above the mean"),
    "Sv": ("m", "deepest dale below the mean"),
    "Sz": ("m", "height from deepest dale to highest peak"),
    "Ssk": ("", "skewness: negative if dales reach further than peaks"),
    "Sku": ("", "kurtosis: 3 for a Gaussian distribution of heights"),
    "Sdq": ("", "root-mean-square slope"),
    "Sdr": ("%", "excess of the developed over the projected area"),
    "Sal": ("m", "autocorrelation length: distance at which heights cease to be alike"),
    "Str": ("", "texture: near 1 the same in all directions, near 0 directional"),
    "Sk": ("m", "height of the core"),
    "Spk": ("m", "reduced height of the peaks above the core"),
    "Svk": ("m", "reduced depth of the dales below the core"),
    "Smr1": ("%", "share of the map that the peaks take"),
    "Smr2": ("%", "share of the map that peaks and core take"),
    "Vmp": ("ml/m²", "material volume of the peaks"),
    "Vmc": ("ml/m²", "material volume of the core"),
    "Vvc": ("ml/m²", "void volume of the core"),
    "Vvv": ("ml/m²", "void volume of the dales"),
}
"""Unit and meaning of the parameters of `Surface.roughness`."""


def parameter(name: str, values: Mapping[str, float]) -> str:
    """Return one of the parameters of `Surface.roughness` as text, in its unit of `ROUGHNESS`."""
    unit, _ = ROUGHNESS[name]
    value = values.get(name, math.nan)
    if math.isnan(value):
        largest = values.get(f"{name}_max", math.nan)
        if math.isnan(largest):
            return "not defined on this map"
        return f"not determined, at most {engineering(largest, unit, 2)}"
    if unit == "%":
        return f"{plain(100 * value)} %"
    if unit == "ml/m²":
        return f"{plain(1e6 * value)} ml/m²"
    return engineering(value, unit)
