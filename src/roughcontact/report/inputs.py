"""Input data as text: maps, their roughness, and materials."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from roughcontact.contact.plausibility import spike_statistics
from roughcontact.errors import InputError, Sentence, message_parts
from roughcontact.formats.no_data import AUTO, format_code
from roughcontact.material import catalog
from roughcontact.material.material import Material
from roughcontact.report import phrases
from roughcontact.report.kind import (
    ABSENT,
    Cells,
    Headline,
    Quantity,
    Table,
    always,
    capitalize_first,
    delegate_quantity,
    format_value,
    quantity_of,
)
from roughcontact.surface import roughness
from roughcontact.surface.cleaning import fill_mode
from roughcontact.surface.surface import Surface
from roughcontact.units import (
    count_noun,
    format_engineering,
    format_lengths,
    format_percent,
    group_digits,
    plain_decimal,
)


def _pair(values: Sequence[float]) -> str:
    return " × ".join(format_engineering(value, "m") for value in values)


def _range(surface: Surface) -> str:
    low, high = (float(end(surface.heights)) for end in (np.nanmin, np.nanmax))
    first, last, depth = (
        group_digits(format_engineering(value, "m")) for value in (low, high, high - low)
    )
    return f"{first} to {last}, range {depth}"


def _missing_text(surface: Surface) -> str:
    points, left = math.prod(surface.shape), "none"
    if surface.missing:
        left = f"{surface.missing} ({format_percent(surface.missing / points)})"
    filled = round(surface.provenance.filled_share(points) * points)
    return f"{left} left; {filled} filled" if filled else left


SURFACE = (
    Quantity("source", "source", of="provenance.source", form=lambda v: v or "not named"),
    Quantity(
        "instrument",
        "instrument",
        of="provenance.instrument",
        brief=False,
        form=lambda v: v or "not named",
    ),
    Quantity(
        "channel", "channel", of="provenance.channel", when=lambda s: bool(s.provenance.channel)
    ),
    Quantity("shape", "grid (y × x)", form=lambda v: f"{v[0]} × {v[1]} points"),
    Quantity("pixel", "pixel (y × x) [m]", form=_pair),
    Quantity("size", "size (y × x) [m]", form=_pair),
    Quantity(
        "height_min",
        "heights [m]",
        of=lambda s: float(np.nanmin(s.heights)),
        brief=False,
        text=_range,
    ),
    Quantity("height_max", "[m]", of=lambda s: float(np.nanmax(s.heights))),
    Quantity("missing", "missing points", of=lambda s: s.missing, brief=False, text=_missing_text),
)
"""Quantities of a `Surface`."""


_OF_A_MAP = ("shape", "pixel", "size")

TRACE = (
    *(quantity for quantity in SURFACE[:3]),
    Quantity(
        "points", "points", of=lambda s: s.shape[1], text=lambda s: f"{s.shape[1]} of a profile"
    ),
    Quantity("spacing", "distance of the points [m]", of=lambda s: s.pixel[1]),
    Quantity("length", "length [m]", of=lambda s: s.size[1]),
    *(quantity for quantity in SURFACE[3:] if quantity.key not in _OF_A_MAP),
)
"""Quantities of a `Surface` that is a profile."""


def table_of(surface: Surface) -> Table:
    """Return the quantities of a map or of a profile."""
    return TRACE if surface.is_profile else SURFACE


def _strength(body: Material, name: str) -> str:
    value: float | None = getattr(body, name)
    if value is None:
        return ABSENT if phrases.is_rigid(body) else "not given"
    return format_engineering(value, "Pa")


BODY = (
    Quantity("rigid", of=phrases.is_rigid),
    Quantity(
        "name", "material", of=lambda b: b.name, form=lambda v: v or "not named", stored=False
    ),
    Quantity(
        "young",
        "Young's modulus $E$ [Pa]",
        form=lambda v: "rigid" if math.isinf(v) else format_engineering(v, "Pa"),
    ),
    Quantity(
        "poisson",
        "Poisson's ratio $ν$",
        text=lambda b: ABSENT if phrases.is_rigid(b) else f"{b.poisson:g}",
    ),
    Quantity(
        "yield_strength",
        "yield strength $σ_Y$ [Pa]",
        text=partial(_strength, name="yield_strength"),
        when=always,
    ),
    Quantity("coating", "coating, outermost first", text=phrases.coating),
    Quantity("hardening", "hardening", of=phrases.hardening, stored=False),
    Quantity("hardness", "hardness [Pa]", text=partial(_strength, name="hardness"), when=always),
)
"""Quantities of a `Material`."""


def bodies(model: str) -> Table:
    """Return the relevant quantities of a material; the volume model has no hardness."""
    if model == "volume":
        return tuple(quantity for quantity in BODY if quantity.key != "hardness")
    law = quantity_of(BODY, "hardening")
    hardens = replace(law, when=lambda body: body.hardens)
    return tuple(hardens if quantity is law else quantity for quantity in BODY)


def sources(bodies: Sequence[Material]) -> list[str]:
    """Return the sources of the catalog values of two bodies; none for other values."""
    names: dict[str, dict[str, str]] = {}
    for body in bodies:
        try:
            entry = catalog.entry(body.name)
        except InputError:
            continue
        for key, symbol in _SYMBOLS.items():
            value = getattr(entry, key)
            if value and getattr(entry.material, key) == getattr(body, key):
                names.setdefault(value.source, {})[symbol] = body.name
    return [
        f"{', '.join(symbols)} of {' and '.join(dict.fromkeys(symbols.values()))}: {source}"
        for source, symbols in names.items()
    ]


_SYMBOLS = {"young": "E", "poisson": "ν", "yield_strength": "σ_Y", "hardness": "hardness"}


class Measured(NamedTuple):
    """Map as stored in a file, and leveled."""

    surface: Surface
    leveled: Surface


def _both(result: Measured, name: str, unit: str) -> str:
    both = (result.surface, result.leveled)
    first, second = (format_value(getattr(surface, name), unit) for surface in both)
    return f"{first}, after plane {second}"


# Str below which a texture is directional, and from which it is isotropic; skewness and excess
# kurtosis below which heights are Gaussian.
_DIRECTED, _ISOTROPIC, _SKEWED, _PEAKED = 0.3, 0.5, 0.5, 1.0


def _character(values: Mapping[str, float]) -> str:
    """Return the texture direction and height distribution of a map as text."""
    gaussian = abs(values["Ssk"]) < _SKEWED and abs(values["Sku"] - 3) < _PEAKED
    heights = "Gaussian" if gaussian else "not Gaussian"
    # If the lay extends beyond the map, Str is not determined but bounded.
    known = not math.isnan(values["Str"])
    if (values["Str"] if known else values["Str_max"]) < _DIRECTED:
        return f"Directional, {heights}"
    if not known:
        return capitalize_first(heights)
    return f"{'Weakly directional' if values['Str'] < _ISOTROPIC else 'Isotropic'}, {heights}"


def _codes(surface: Surface) -> dict[float, int]:
    """Return the values of missing points in the file of a map, and how often they occur."""
    origin = surface.provenance.origin
    return {} if origin is None else dict(origin.found.get("no_data", ()))


def _action(result: Measured) -> str:
    """Return the options that `solve` needs for a map to be accepted without a warning."""
    *words, fill = _options(result) or [""]
    if words:
        return f"solve it with {' '.join([*words, fill])}"
    return f"choose {fill}, mask or crop" if fill else "ready to solve"


def _options(result: Measured) -> list[str]:
    """Return the options that `solve` needs, the treatment of missing points last."""
    codes, words = _codes(result.surface), []
    if codes:
        words.append(f"--no-data {format_code(*codes) if len(codes) == 1 else AUTO}")
    if spike_statistics(result.leveled) is not None:
        words.append("--outliers 6")
    if words or result.surface.missing:
        words.append(f"--missing {fill_mode(result.surface.missing / result.surface.heights.size)}")
    return words


def _brief_parameters(surface: Surface) -> list[Cells]:
    """Return the main parameters of a leveled profile: of the roughness below λc, and of all."""
    wave, rows = roughness.profile_cutoff(surface.size[1]), []
    if wave is not None:
        head = f"λc {format_engineering(wave, 'm')}"
        rows.append((head, ("Rq", "Ra", "Rz", "Rt"), filtered_parameters(surface)))
    rows.append(("all waves", ("Pq", "Pa", "Pz", "Pt"), surface.roughness()))
    return [
        (head, *(f"{name} {_parameter(values[name], 'm')}" for name in names))
        for head, names, values in rows
    ]


def headline(result: Measured, name: str) -> Headline:
    """Return the headline of a file: grid, type of map, and roughness."""
    surface, leveled = result.surface, result.leveled
    about = surface.provenance.instrument or "height map"
    missing = surface.missing
    state = (
        "complete" if not missing else f"{format_percent(missing / surface.heights.size)} missing"
    )
    codes = [f"{count_noun(n, 'point')} at {format_code(c)}" for c, n in _codes(surface).items()]
    if codes:
        state += f" ({', '.join(codes)})"
    action = _action(result)
    if surface.is_profile:
        grid = f"{surface.shape[1]} points, {format_lengths((surface.size[1],))}"
        answer = f"{capitalize_first(state)}; {action}."
        brief = _brief_parameters(leveled)
        return Headline(f"{name}: {about}, {grid}", answer, (), brief, ())
    values = leveled.roughness()
    ny, nx = surface.shape
    grid = (
        f"{ny} × {nx} points, {format_lengths(surface.size)}, pixel {format_lengths(surface.pixel)}"
    )
    notes = leveled.resolution_notes()
    rows = [
        ("   ".join(f"{key} {parameter(key, values)}" for key in keys),)
        for keys in (("Sq", "Sa", "Sz", "Ssk", "Sku"), ("Sdq", "Sal", "Spk", "Svk"), ("Str",))
    ]
    remarks = tuple(Sentence("Resolution: ", *message_parts(note)) for note in notes[:1])
    return Headline(
        f"{name}: {about}, {grid}", f"{_character(values)}, {state}; {action}.", (), rows, remarks
    )


FILE_HEADS = ("file", "points", "pixel", "missing", "Sq (Pq)", "Sz (Pt)", "options to solve it")
"""Names of the columns of `file_row`."""


def file_row(result: Measured | None, name: str) -> Cells:
    """Return the row of a file in a table of files; of a file that cannot be read without result.

    Heights are those after leveling.
    """
    if result is None:
        return (name, *("",) * (len(FILE_HEADS) - 2), "cannot be read")
    surface, first = result.surface, int(result.surface.is_profile)
    values = result.leveled.roughness()
    heights = [values["Pq"], values["Pt"]] if first else [values["Sq"], values["Sz"]]
    edges = surface.pixel[first:] if len(set(surface.pixel)) > 1 else surface.pixel[:1]
    cells = (
        "×".join(map(str, surface.shape[first:])),
        format_lengths(edges).replace(" × ", "×"),
        format_percent(surface.missing / surface.heights.size) if surface.missing else "none",
        *(format_engineering(value, "m", 3) for value in heights),
    )
    narrow = (cell.replace(" ", "\N{NO-BREAK SPACE}") for cell in cells)
    return (name, *narrow, " ".join(_options(result)) or "none")


def files_verdict(results: Sequence[Measured | None]) -> str:
    """Return how many of several files can be solved as they are, as a sentence."""
    read = [item for item in results if item is not None]
    ready = sum(not _options(item) for item in read)
    text = f"{ready} of {count_noun(len(results), 'file')} ready to solve"
    if len(read) > ready:
        text += f", {len(read) - ready} with the options in the last column"
    if len(read) < len(results):
        text += f", {len(results) - len(read)} unreadable"
    return f"{text}."


_MISSING_PART = (
    Quantity("missing_fraction", of=lambda f: f.surface.missing / f.surface.heights.size),
    Quantity(
        "no_data",
        "value of missing points",
        of=lambda f: list(_codes(f.surface)),
        form=lambda codes: ", ".join(map(format_code, codes)),
    ),
)

FILE = (
    *(delegate_quantity("surface", quantity) for quantity in SURFACE if quantity.key != "missing"),
    Quantity("Sq", "Sq [m]", of="surface.Sq", text=partial(_both, name="Sq", unit="m")),
    Quantity("Sq_leveled", "[m]", of="leveled.Sq"),
    Quantity("Sdq", "Sdq", of="surface.Sdq", text=partial(_both, name="Sdq", unit="1")),
    Quantity("Sdq_leveled", of="leveled.Sdq"),
    delegate_quantity("surface", quantity_of(SURFACE, "missing")),
    *_MISSING_PART,
    Quantity("roughness_leveled", of=lambda result: result.leveled.roughness()),
)
"""Quantities of a map in a file, `Measured`."""

FILE_OF_PROFILE = (
    *(delegate_quantity("surface", quantity) for quantity in TRACE),
    *_MISSING_PART,
    Quantity(
        "cutoff",
        "roughness without waves beyond λc [m]",
        of=lambda result: roughness.profile_cutoff(result.surface.size[1]),
        when=always,
        form=lambda v: (
            "λc not determined: five of 0.08 mm do not fit into the profile"
            if v is None
            else f"{format_engineering(v, 'm')}, the largest λc of which five fit"
        ),
    ),
    Quantity("primary", of=lambda result: result.leveled.roughness()),
    Quantity("roughness", of=lambda result: filtered_parameters(result.leveled)),
)
"""Quantities of a profile in a file, `Measured`."""


def file_table(result: Measured) -> Table:
    """Return the quantities of a map or of a profile in a file."""
    return FILE_OF_PROFILE if result.surface.is_profile else FILE


def filtered_parameters(surface: Surface) -> dict[str, float]:
    """Return the parameters of a leveled profile without waves longer than λc, by symbol."""
    wave = roughness.profile_cutoff(surface.size[1])
    if wave is None:
        return {}
    heights, spacing = surface.filtered(l=wave).heights[0], surface.pixel[1]
    rest = round((surface.size[1] - roughness.SECTIONS * wave) / spacing)
    end = min(round(0.5 * wave / spacing), rest // 2)
    # The margin absorbs the rounding of positions.
    sections = int((heights.size - 2 * end) * spacing / wave + 0.01)
    points = min(round(sections * wave / spacing), heights.size)
    first = (heights.size - points) // 2
    return roughness.profile_parameters(heights[first : first + points], spacing, sections)


def measured_map(surface: Surface) -> Measured:
    """Return a map as stored in a file, and leveled."""
    return Measured(surface, surface.leveled())


PROFILE_ROUGHNESS = {
    "q": ("m", "root-mean-square height"),
    "a": ("m", "mean absolute height"),
    "z": ("m", "height from deepest dale to highest peak, R: mean of the sections λc"),
    "t": ("m", "the same of the whole profile"),
    "p": ("m", "highest peak above the mean, R: mean of the sections λc"),
    "v": ("m", "deepest dale below the mean, R: mean of the sections λc"),
    "sk": ("", "skewness: negative if dales reach further than peaks"),
    "ku": ("", "kurtosis: 3 for a Gaussian distribution of heights"),
    "sm": ("m", "mean width of the elements, a peak and a dale each"),
    "dq": ("", "root-mean-square slope"),
    "da": ("", "mean absolute slope; with σ = Pq or Rq for contact conductance"),
}
"""Unit and meaning of profile parameters, by the part of the symbol after P or R."""


def profile_parameters(surface: Surface) -> list[tuple[str, str, str, str]]:
    """Return rows of name, value of the primary and roughness profile, and meaning."""
    whole, rough = surface.roughness(), filtered_parameters(surface)
    return [
        (
            f"P{name}, R{name}",
            _parameter(whole[f"P{name}"], unit),
            _parameter(rough[f"R{name}"], unit) if rough else ABSENT,
            meaning,
        )
        for name, (unit, meaning) in PROFILE_ROUGHNESS.items()
    ]


def _parameter(value: float, unit: str) -> str:
    return "not defined" if math.isnan(value) else format_engineering(value, unit)


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
    "Sal": ("m", "autocorrelation length: distance over which heights are correlated"),
    "Str": ("", "texture: near 1 the same in all directions, near 0 directional"),
    "Std": ("°", "direction of the lay, counter-clockwise from x, row 0 on top"),
    "Sk": ("m", "height of the core"),
    "Spk": ("m", "reduced height of the peaks above the core"),
    "Svk": ("m", "reduced depth of the dales below the core"),
    "Smr1": ("%", "share of the map that the peaks take"),
    "Smr2": ("%", "share of the map that peaks and core take"),
    "Sxp": ("m", "height of the peaks, from material ratio 2.5 % to 50 %"),
    "Sdc": ("m", "height from material ratio 10 % to 80 %"),
    "m": ("", "mean absolute slope along a profile; with σ = Sq for contact conductance"),
    "Vmp": ("ml/m²", "material volume of the peaks"),
    "Vmc": ("ml/m²", "material volume of the core"),
    "Vvc": ("ml/m²", "void volume of the core"),
    "Vvv": ("ml/m²", "void volume of the dales"),
}
"""Unit and meaning of the parameters of `Surface.roughness`."""


def parameter(name: str, values: Mapping[str, float]) -> str:
    """Return a parameter of `Surface.roughness` as text, with its unit in `ROUGHNESS`."""
    unit, _ = ROUGHNESS[name]
    value = values.get(name, math.nan)
    if math.isnan(value):
        largest = values.get(f"{name}_max", math.nan)
        if math.isnan(largest):
            return "not defined on this map"
        return f"not determined, at most {format_engineering(largest, unit, 2)}"
    if unit == "%":
        return f"{plain_decimal(100 * value)} %"
    if unit == "°":
        return f"{value:.1f}°"
    if unit == "ml/m²":
        return f"{plain_decimal(1e6 * value)} ml/m²"
    return group_digits(format_engineering(value, unit))
