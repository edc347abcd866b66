"""A report on a result: one HTML file that needs nothing else and prints to A4.

Everything in it comes from the results that are handed over; nothing is solved here.
"""

from __future__ import annotations

import base64
import datetime
import io
import math
import os
import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from importlib import metadata, resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact import assumptions, plots, script
from roughcontact._version import __version__
from roughcontact.archive import replacing
from roughcontact.contact import LOAD_TOLERANCE, MOMENT_TOLERANCE
from roughcontact.errors import InputError
from roughcontact.loading import LOW_LOAD, LoadCurve
from roughcontact.material import Material
from roughcontact.result import ContactResult
from roughcontact.spots import Spots
from roughcontact.surface import Surface
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATE = "report.html.j2"
_LIBRARIES = ("numpy", "scipy", "ducc0", "matplotlib")

# Spots whose share of the load is told, and spots that make a distribution worth drawing.
_LARGEST = 10
_ENOUGH_SPOTS = 3

# Close-ups show this many times the root of the area of the spot at the peak, or the longer side
# of the most loaded spot, but no fewer pixels; and only where this is a small part of the map.
_AROUND_SPOT = 4
_AROUND_LOADED = 1.5
_SMALL_PART = 0.5
_CLOSE_PIXELS = 40

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
    "Sal": ("m", "distance over which heights lose their likeness"),
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

_FEW_COLUMNS, _FEW_ROWS = 5, 24

# Dots from which a figure has several panels, and needs the whole width of a page.
_WIDE = 8 * plots.DPI

Row = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Section:
    """A chapter that other results add to a report.

    Parameters
    ----------
    title : str
        Its heading.
    text : tuple of str
        Paragraphs, plain text.
    table : tuple of tuple of str
        Rows of a table, the first of them its head; empty for none.
    figures : tuple of (str, Figure)
        Captions with their figures.
    """

    title: str
    text: tuple[str, ...] = ()
    table: tuple[Row, ...] = ()
    figures: tuple[tuple[str, Figure], ...] = ()


def render(
    result: ContactResult,
    *,
    elastic: ContactResult | None = None,
    curve: LoadCurve | None = None,
    sections: Sequence[Section] = (),
    command: str = "",
    date: datetime.date | None = None,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    result : ContactResult
        What the report is on.
    elastic : ContactResult, optional
        The same problem without a ceiling, to stand beside it; see `ContactResult.elastic`. It
        is left out where the ceiling is reached nowhere.
    curve : LoadCurve, optional
        The same contact under other loads, for a chapter of its own.
    sections : sequence of Section
        Further chapters.
    command : str
        What was typed to get the result. Without it a Python script is given, where the result
        tells enough for one.
    date : date, optional
        Date of the report; today by default.

    Returns
    -------
    str
        HTML with its figures inside: no other file, no network and no script is needed.

    Raises
    ------
    InputError
        If the elastic result has another grid.
    """
    if elastic is not None and elastic.pressure.shape != result.pressure.shape:
        raise InputError(
            f"elastic has {elastic.pressure.shape} pixels and the result {result.pressure.shape}; "
            "give the solution of the same problem, result.elastic()"
        )
    spots = result.spots()
    stated = assumptions.statements(result, spots)
    chapters = [
        *_input(result),
        _assumptions(stated),
        _results(result, spots),
        _profiles(result, spots),
        _spots(result, spots),
    ]
    if result.saturated_fraction > 0:
        chapters.append(_comparison(result, elastic))
    if curve is not None:
        chapters.append(_load_curve(curve))
    chapters += [_added(section) for section in sections]
    chapters += [_certificate(result), _repetition(result, command)]
    _number(chapters)
    return _filled(
        title=_title(result),
        subtitle=_subtitle(result),
        date=(date or datetime.date.today()).isoformat(),
        version=__version__,
        converged=result.converged,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=assumptions.regime(result),
        certificate=_certificate_in_short(result),
        warnings=[_sentence(note) for note in result.warnings],
        cautions=[_sentence(item.caution) for item in stated if item.caution],
        chapters=chapters,
    )


def save(
    result: ContactResult,
    path: str | os.PathLike[str],
    *,
    elastic: ContactResult | None = None,
    curve: LoadCurve | None = None,
    sections: Sequence[Section] = (),
    command: str = "",
    date: datetime.date | None = None,
) -> None:
    """Write a report to an HTML file.

    Parameters
    ----------
    result, elastic, curve, sections, command, date
        As for `render`.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.

    Raises
    ------
    InputError
        If the suffix is another one, the folder does not exist, or the elastic result has
        another grid.
    OSError
        If the file cannot be written.
    """
    check_path(path)
    text = render(
        result, elastic=elastic, curve=curve, sections=sections, command=command, date=date
    )
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def check_path(path: str | os.PathLike[str]) -> None:
    """Raise `InputError` unless a report can have this name, before anything is computed."""
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"path of a report must end in .html, got {str(target)!r}")
    if target.is_dir():
        raise InputError(f"path {str(target)!r} is a folder; give the name of a file")
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the report {str(target)!r} does not exist; create it first"
        )


# What the template is given


@dataclass(frozen=True)
class _Table:
    rows: Sequence[Row]
    head: Row = ()

    @property
    def style(self) -> str:
        """Many columns stand close; few rows stay on one page."""
        dense = "dense" if len(self.head) > _FEW_COLUMNS else ""
        return f"{dense} {'short' if len(self.rows) <= _FEW_ROWS else ''}".strip()


@dataclass
class _Picture:
    caption: str
    alt: str
    source: str
    width: int
    height: int
    number: int = 0

    @property
    def wide(self) -> bool:
        return self.width > _WIDE


@dataclass
class _Chapter:
    """Heading and blocks in their order; `anchor` and numbers come last."""

    title: str
    blocks: list[tuple[str, Any]] = field(default_factory=list)
    anchor: str = ""
    number: int = 0

    def add(self, kind: str, content: Any) -> None:
        self.blocks.append((kind, content))


def _filled(**values: Any) -> str:
    # Imported late: only reports need it.
    import jinja2

    environment = jinja2.Environment(
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_printable,
    )
    source = resources.files("roughcontact").joinpath("templates", _TEMPLATE)
    return environment.from_string(source.read_text(encoding="utf-8")).render(**values)


def _printable(value: Any) -> Any:
    # A file name can hold bytes that are no text, or control characters, which HTML forbids.
    if type(value) is not str or value.isprintable():
        return value
    return "".join(c if c.isprintable() or c in "\n\t" else "�" for c in value)


def _number(chapters: Sequence[_Chapter]) -> None:
    pictures = 0
    for number, chapter in enumerate(chapters, start=1):
        chapter.number = number
        chapter.anchor = f"chapter-{number}"
        for kind, content in chapter.blocks:
            if kind == "figure":
                pictures += 1
                content.number = pictures


def _picture(figure: Figure, alt: str, caption: str) -> _Picture:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=plots.DPI)
    data = stream.getvalue()
    # Width and height stand first in a PNG file's first chunk.
    width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
    return _Picture(caption, alt, base64.b64encode(data).decode("ascii"), width, height)


# The first page


def _title(result: ContactResult) -> str:
    name = result.surface.provenance.source or "an unnamed surface"
    if result.control == "load":
        return f"Contact of {name} under {engineering(result.load, 'N')}"
    return f"Contact of {name} at an approach of {engineering(result.approach, 'm')}"


def _subtitle(result: ContactResult) -> str:
    ny, nx = result.surface.shape
    height, width = (engineering(side, "m", 3) for side in result.surface.size)
    other = result.counter_surface
    against = "a flat counter-body"
    if other is not None:
        against = other.provenance.source or "a second measured surface"
    return (
        f"{_body(result.material)} against {against} ({_body(result.counter_material)}); "
        f"{height} × {width}, {ny} × {nx} points (y × x)"
    )


def _body(material: Material) -> str:
    if math.isinf(material.young):
        return "rigid"
    stiffness = f"E {engineering(material.young, 'Pa')}"
    return f"{material.name}, {stiffness}" if material.name else stiffness


def _key_numbers(result: ContactResult) -> list[Row]:
    area = engineering(result.contact_area, "m²", 3)
    if result.ceiling is None:
        saturated = ("–", "purely elastic: no ceiling")
    else:
        saturated = (percent(result.saturated_fraction), "of the map is at the pressure ceiling")
    last = ("Approach", engineering(result.approach, "m", 3), "of the bodies from the first touch")
    if result.control == "approach":
        last = ("Load", engineering(result.load, "N", 3), "at the approach that was given")
    return [
        ("Largest pressure", engineering(result.max_pressure, "Pa", 3), _hottest(result)),
        ("Real contact", percent(result.contact_fraction), f"of the map touches: {area}"),
        ("Saturated", *saturated),
        ("Mean gap", engineering(result.mean_gap, "m", 3), "left open between the bodies"),
        last,
    ]


def _hottest(result: ContactResult) -> str:
    if result.saturated_fraction > 0 and not isinstance(result.ceiling, np.ndarray):
        return "the ceiling"
    return "on any one pixel"


def _certificate_in_short(result: ContactResult) -> str:
    if result.converged:
        return (
            f"Certificate {result.certificate:.1e}, asked for {result.tolerance:.0e}: pressure and "
            "gap fulfil the conditions of contact to within this part of the pressure. It says how "
            "exactly the problem as stated is solved; whether the problem is the right one, the "
            "assumptions say."
        )
    return (
        f"Certificate {result.certificate:.1e}, asked for {result.tolerance:.0e}: the solver "
        "stopped before it had a solution. Do not use these numbers."
    )


def _sentence(note: str) -> str:
    if not note:
        return ""
    text = note[:1].upper() + note[1:]
    return text if text.endswith(".") else f"{text}."


# Chapters


def _input(result: ContactResult) -> list[_Chapter]:
    surfaces = [result.surface]
    names = ["map"]
    if result.counter_surface is not None:
        surfaces.append(result.counter_surface)
        names = ["first body", "counter-body"]
    chapter = _Chapter("Input and preparation")
    facts = [_facts(surface) for surface in surfaces]
    rows = [(label, *(fact[label] for fact in facts)) for label in facts[0]]
    chapter.add("table", _Table(rows, ("", *names) if len(names) > 1 else ()))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        if surface.provenance.steps:
            chapter.add("text", f"Preparation{of}, in this order:")
            chapter.add("steps", [_sentence(step) for step in surface.provenance.steps])
        else:
            chapter.add("text", f"Preparation{of}: none recorded; the heights are as given.")
        sq = engineering(surface.Sq, "m", 3)
        chapter.add(
            "figure",
            _picture(
                plots.surface(surface),
                f"Map of the heights{of}, root-mean-square height {sq}.",
                f"Heights{of} as they were pressed, after preparation. Light is high: contact "
                "begins there." + (" Grey points are missing." if surface.missing else ""),
            ),
        )
    roughness = _Chapter("Roughness of the prepared surface")
    roughness.add(
        "text",
        "Parameters of ISO 25178-2, of the heights as they were pressed; no filter is applied "
        "beyond the preparation above.",
    )
    roughness.add("table", _roughness_table(surfaces, names))
    for surface, name in zip(surfaces, names, strict=True):
        of = f" of the {name}" if len(names) > 1 else ""
        roughness.add(
            "figure",
            _picture(
                plots.bearing_curve(surface),
                f"Material ratio curve{of}.",
                f"Material ratio curve{of} (bearing curve): which share of the map lies above a "
                "height. Steep ends mean few high peaks or deep dales; contact begins at the left "
                "end.",
            ),
        )
    return [chapter, roughness, _problem(result)]


def _facts(surface: Surface) -> dict[str, str]:
    about = surface.provenance
    (ny, nx), (dy, dx), (height, width) = surface.shape, surface.pixel, surface.size
    low, high = float(np.nanmin(surface.heights)), float(np.nanmax(surface.heights))
    missing = "none after preparation" if about.steps else "none"
    if surface.missing:
        share = percent(surface.missing / surface.heights.size)
        missing = f"{surface.missing} ({share}), taken as never touching"
    return {
        "Source": about.source or "not named",
        "Instrument": about.instrument or "not named",
        "Channel": about.channel or "the only one",
        "Grid (y × x)": f"{ny} × {nx} points",
        "Pixel (y × x)": f"{engineering(dy, 'm')} × {engineering(dx, 'm')}",
        "Size (y × x)": f"{engineering(height, 'm')} × {engineering(width, 'm')}",
        "Heights": f"{engineering(low, 'm')} to {engineering(high, 'm')}",
        "Missing points": missing,
    }


def _roughness_table(surfaces: Sequence[Surface], names: Sequence[str]) -> _Table:
    columns = []
    for surface in surfaces:
        try:
            columns.append(surface.roughness())
        except InputError:
            # Holes that leave no point both of its neighbours.
            columns.append({})
    rows = [
        (
            name,
            *(
                (_texture(value) if name == "Str" else parameter(value, unit))
                for value in (values.get(name, math.nan) for values in columns)
            ),
            meaning,
        )
        for name, (unit, meaning) in ROUGHNESS.items()
    ]
    values = tuple(names) if len(names) > 1 else ("value",)
    return _Table(rows, ("parameter", *values, "meaning"))


def parameter(value: float, unit: str) -> str:
    """Return a roughness parameter as text, in its unit of `ROUGHNESS`."""
    if math.isnan(value):
        return "not defined on this map"
    if unit == "%":
        return f"{100 * value:.4g} %"
    if unit == "ml/m²":
        return f"{1e6 * value:.4g} ml/m²"
    return engineering(value, unit)


def _texture(value: float) -> str:
    # The summary has 0 where heights stay alike along one direction across all of the map.
    return "near 0" if value == 0 else parameter(value, "")


def _problem(result: ContactResult) -> _Chapter:
    chapter = _Chapter("Materials and load")
    bodies = (result.material, result.counter_material)
    rows: list[Row] = [
        ("Material", *(body.name or "not named" for body in bodies)),
        ("Young's modulus E", *(_modulus(body.young) for body in bodies)),
        ("Poisson's ratio ν", *(_ratio(body) for body in bodies)),
        ("Yield strength σ_Y", *(_strength(body.yield_strength) for body in bodies)),
        ("Hardness", *(_strength(body.hardness) for body in bodies)),
        (
            "Peak pressure of first yield, sphere",
            *(_strength(body.first_yield_pressure) for body in bodies),
        ),
    ]
    chapter.add("table", _Table(rows, ("", "body", "counter-body")))
    given = {
        "load": ("Load W (given)", engineering(result.load, "N")),
        "approach": ("Approach ω (given)", engineering(result.approach, "m")),
    }[result.control]
    boundary = {
        "free": "free: the map is all that touches",
        "periodic": "periodic: the map is one period of an endless surface",
    }[result.boundary]
    moments: list[Row] = []
    if result.moments is not None:
        about_y, about_x = (engineering(moment, "N m") for moment in result.moments)
        moments = [("Moments W·y, W·x (given)", f"{about_y}, {about_x}")]
    chapter.add(
        "table",
        _Table(
            [
                given,
                *moments,
                (
                    "Contact modulus E*",
                    f"{engineering(result.contact_modulus, 'Pa')}, from "
                    "1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂",
                ),
                ("Pressure ceiling", assumptions.ceiling_origin(result)),
                ("Boundary", boundary),
            ]
        ),
    )
    return chapter


def _modulus(young: float) -> str:
    return "rigid" if math.isinf(young) else engineering(young, "Pa")


def _ratio(body: Material) -> str:
    return "–" if math.isinf(body.young) else f"{body.poisson:g}"


def _strength(value: float | None) -> str:
    return "not given" if value is None else engineering(value, "Pa")


def _assumptions(stated: Iterable[assumptions.Statement]) -> _Chapter:
    chapter = _Chapter("What is assumed")
    chapter.add(
        "text",
        "The numbers of this report are those of a model. It takes the following for granted; "
        "where one of these does not hold for the part at hand, the numbers do not either.",
    )
    chapter.add("terms", [(item.topic, item.text, _sentence(item.caution)) for item in stated])
    return chapter


def _results(result: ContactResult, spots: Spots) -> _Chapter:
    chapter = _Chapter("Results")
    nominal = result.pressure.size * result.pixel_area
    rows: list[Row] = [
        ("Load W", engineering(result.load, "N"), "normal force that the pressure adds up to"),
        ("Approach ω", engineering(result.approach, "m"), "of the bodies from the first touch"),
        *_tilt_rows(result),
        ("Nominal area", engineering(nominal, "m²"), "of the whole map"),
        ("Nominal pressure", engineering(result.load / nominal, "Pa"), "load over nominal area"),
        (
            "Contact area",
            f"{engineering(result.contact_area, 'm²')} ({percent(result.contact_fraction)})",
            "pixels with pressure, and their share of the map",
        ),
        (
            "Contact area without rim excess",
            engineering(result.corrected_contact_area, "m²"),
            "less what whole pixels at the rim of spots add",
        ),
        ("Largest pressure", engineering(result.max_pressure, "Pa"), "on any pixel"),
    ]
    if result.contact_area > 0:
        mean = result.load / result.contact_area
        rows.append(("Mean pressure", engineering(mean, "Pa"), "load over contact area"))
    if result.ceiling is not None:
        rows.append(
            (
                "Saturated area",
                percent(result.saturated_fraction),
                "share of the map at the ceiling",
            )
        )
        if result.contact_fraction > 0:
            share = result.saturated_fraction / result.contact_fraction
            rows.append(
                ("Saturated share", percent(share), "of the contact area that is at the ceiling")
            )
        deepest = float(result.residual_indentation.max())
        rows.append(
            (
                "Residual indentation",
                f"up to {engineering(deepest, 'm')}" if deepest else "none",
                "depth that saturated points keep",
            )
        )
    rows += [
        ("Mean gap", engineering(result.mean_gap, "m"), "of the open gap; closed points count 0"),
        ("Regime", result.regime, "how far the softer body is from elastic"),
    ]
    chapter.add("table", _Table(rows, ("quantity", "value", "meaning")))
    for picture in _result_pictures(result, spots):
        chapter.add("figure", picture)
    return chapter


def _tilt_rows(result: ContactResult) -> list[Row]:
    if result.moments is None:
        return []
    slopes = ", ".join(f"{slope:.4g} rad" for slope in result.tilt)
    centre = ", ".join(engineering(place, "m") for place in result.centre_of_pressure)
    return [
        ("Tilt (y, x)", slopes, "by which the counter-body is turned away, about the middle"),
        ("Centre of pressure (y, x)", centre, "from the middle of the map"),
    ]


def _result_pictures(result: ContactResult, spots: Spots) -> list[_Picture]:
    largest = engineering(result.max_pressure, "Pa", 3)
    touching = percent(result.contact_fraction)
    saturated = percent(result.saturated_fraction)
    classes = "Blue touches elastically"
    if result.ceiling is not None:
        classes += ", dark red is at the pressure ceiling"
    missing = " Grey points were not measured." if np.isnan(result.gap).any() else ""
    drawn: list[tuple[Callable[[], Figure], str, str]] = [
        (
            lambda: plots.pressure(result),
            f"Map of the contact pressure, largest {largest}.",
            "Contact pressure. The lightest ground does not touch; the darker, the higher. "
            "Black, where it occurs, is beyond the scale.",
        ),
        (
            lambda: plots.contact(result),
            f"Map of the contact: {touching} of the map touches, {saturated} is saturated.",
            f"Where the bodies touch. {classes}.{missing} The shares are counted on all points.",
        ),
        (
            lambda: plots.gap(result),
            f"Map of the open gap, mean {engineering(result.mean_gap, 'm', 3)}.",
            "Gap that is left between the bodies. Orange is closed; the darker the blue, the "
            f"wider the gap: this is the room left for a fluid or for wear debris.{missing}",
        ),
        (
            lambda: plots.pressure_histogram(result),
            "Histogram of the contact pressure over the contact area.",
            "How the contact area is spread over the pressure. "
            + (
                "The share at the ceiling has no width on this axis and is stated instead of drawn."
                if result.saturated_fraction > 0
                else "The right end is the largest pressure of any pixel."
            ),
        ),
    ]
    point, width = _most_loaded(result, spots)
    if width < _SMALL_PART * min(result.surface.size):
        about = engineering(width, "m", 3)
        drawn.insert(
            2,
            (
                lambda: plots.close_up(result, point, width),
                f"Pressure and contact in a part of {about} around the most loaded spot.",
                f"A part of the last two figures, {about} wide, around the spot that carries most. "
                "It shows whether the pixels of the map resolve the contact.",
            ),
        )
    return [_picture(draw(), alt, caption) for draw, alt, caption in drawn]


def _profiles(result: ContactResult, spots: Spots) -> _Chapter:
    chapter = _Chapter("Sections through the highest peak")
    profile = "profile" if result.counter_surface is None else "sum of both profiles"
    caption = (
        f"Above: the {profile} before loading (grey), moved as a whole by the approach, and under "
        "load (blue), against the counter-body at zero height. What is grey above zero had to give "
        "way. Below: the pressure on the same line. Heights are exaggerated; the dotted line marks "
        "the highest peak."
    )
    if result.saturated_fraction > 0:
        caption += " Dark red is saturated: that much material has to flow away."
    alt = "Sections along x and y through the highest peak: heights before and under load, pressure"
    chapter.add("figure", _picture(plots.section(result), f"{alt}; whole length.", caption))
    width = _close_up(result, spots)
    if width is not None:
        chapter.add(
            "figure",
            _picture(
                plots.section(result, width),
                f"{alt}; {engineering(width, 'm', 3)} around the peak.",
                f"The same sections, {engineering(width, 'm', 3)} around the peak.",
            ),
        )
    return chapter


def _close_up(result: ContactResult, spots: Spots) -> float | None:
    """Return a width that shows the spot at the highest peak, or None if all of the map does."""
    peak = np.unravel_index(np.nanargmin(result.initial_gap), result.gap.shape)
    number = int(spots.label[peak])
    size = math.sqrt(float(spots.area[number - 1])) if number else 0.0
    width = max(_AROUND_SPOT * size, _CLOSE_PIXELS * max(result.surface.pixel))
    return width if width < _SMALL_PART * min(result.surface.size) else None


def _most_loaded(result: ContactResult, spots: Spots) -> tuple[tuple[int, int], float]:
    """Return the middle (y, x) of the spot that carries most, and a width that shows it."""
    smallest = _CLOSE_PIXELS * max(result.surface.pixel)
    if spots.count == 0:
        return (0, 0), math.inf
    places = np.nonzero(spots.label == 1 + int(spots.load.argmax()))
    ends = [(int(place.min()), int(place.max())) for place in places]
    sides = [
        (last - first + 1) * edge
        for (first, last), edge in zip(ends, result.surface.pixel, strict=True)
    ]
    middle = sum(ends[0]) // 2, sum(ends[1]) // 2
    return middle, max(_AROUND_LOADED * max(sides), smallest)


def _spots(result: ContactResult, spots: Spots) -> _Chapter:
    chapter = _Chapter("Contact spots")
    if spots.count == 0:
        chapter.add("text", "The bodies do not touch.")
        return chapter
    carried = float(spots.load.sum())
    largest = float(spots.area[0])
    chapter.add(
        "text",
        "A spot is a set of touching pixels joined by their edges. Its area decides how it "
        "carries heat and current, how far below it yielding begins, and whether the map resolves "
        "it.",
    )
    rows: list[Row] = [
        ("Number of spots", str(spots.count), ""),
        ("Mean area", engineering(float(spots.area.mean()), "m²"), ""),
        (
            "Largest area",
            engineering(largest, "m²"),
            f"{percent(largest / result.contact_area)} of the contact area",
        ),
        (
            "Load on the largest",
            engineering(float(spots.load[0]), "N"),
            f"{percent(min(float(spots.load[0]) / carried, 1.0))} of the load",
        ),
    ]
    if spots.count > _LARGEST:
        share = float(spots.load[:_LARGEST].sum()) / carried
        rows.append(
            (f"Load on the {_LARGEST} largest", percent(min(share, 1.0)), "of the load")
        )  # fmt: skip
    rows.append(
        (
            "Pixels of a spot that carries",
            str(assumptions.carrying_pixels(result, spots)),
            "spots of at least this size carry half of the load",
        )
    )
    chapter.add("table", _Table(rows, ("quantity", "value", "note")))
    if spots.count >= _ENOUGH_SPOTS:
        chapter.add(
            "figure",
            _picture(
                plots.spots(result),
                f"Number of contact spots of at least a given area; {spots.count} in all.",
                "How many spots have at least a given area, both axes logarithmic. On the shaded "
                "ground spots have so few pixels that the grid decides on their size.",
            ),
        )
    return chapter


def _comparison(result: ContactResult, elastic: ContactResult | None) -> _Chapter:
    chapter = _Chapter("Elastic beside ceiling")
    if elastic is None:
        chapter.add(
            "text",
            "No solution of the same problem without a ceiling was given to this report.",
        )
        return chapter
    label = "with ceiling"
    if not isinstance(result.ceiling, np.ndarray):
        label = f"ceiling {engineering(float(result.ceiling or 0), 'Pa', 3)}"
    chapter.add(
        "text",
        "The same surfaces under the same load, once without a ceiling, once with it. The ceiling "
        "takes load from the highest peaks and lays it on their surroundings: the contact grows, "
        "and the bodies come closer.",
    )
    if not elastic.converged:
        chapter.add(
            "warning",
            "The elastic solution did not converge: certificate "
            f"{elastic.certificate:.1e}, asked for {elastic.tolerance:.0e} ({elastic.status}). Its "
            "column and its maps show the best that was found, not a solution.",
        )
    inside = int(np.count_nonzero(elastic.contact & result.contact))
    touching = int(np.count_nonzero(elastic.contact))
    pair = (elastic, result)
    rows: list[Row] = [
        ("Largest pressure", *(engineering(r.max_pressure, "Pa") for r in pair)),
        ("Contact area", *(engineering(r.contact_area, "m²") for r in pair)),
        ("Contact", *(percent(r.contact_fraction) for r in pair)),
        ("Saturated", "–", percent(result.saturated_fraction)),
        ("Approach", *(engineering(r.approach, "m") for r in pair)),
        ("Mean gap", *(engineering(r.mean_gap, "m") for r in pair)),
        ("Certificate", *(f"{r.certificate:.1e}" for r in pair)),
        ("Status", *(r.status for r in pair)),
    ]
    chapter.add("table", _Table(rows, ("", "elastic", label)))
    if touching:
        chapter.add(
            "text",
            f"{percent(inside / touching)} of the elastic contact also touches with the ceiling.",
        )
    chapter.add(
        "figure",
        _picture(
            plots.comparison(pair, ["elastic", label]),
            "Maps of pressure and contact, elastic on the left and with the ceiling on the right.",
            "Pressure above, contact below; elastic on the left, with the ceiling on the right. "
            "Both pressures have the same colours; where the elastic pressure exceeds what the "
            "ceiling allows it is black.",
        ),
    )
    wide = elastic.max_pressure > _WIDE_RANGE * result.max_pressure
    chapter.add(
        "figure",
        _picture(
            plots.pressure_histogram(
                pair, ["elastic", label], scale="log" if wide else "linear"
            ),
            "Histograms of the contact pressure, elastic and with the ceiling.",
            "How the contact area is spread over the pressure, without and with the ceiling"
            + (", on a logarithmic pressure axis." if wide else "."),
        ),
    )  # fmt: skip
    return chapter


# Elastic over limited pressure from which a linear axis would squeeze one of them.
_WIDE_RANGE = 4.0


def _load_curve(curve: LoadCurve) -> _Chapter:
    chapter = _Chapter("Load curve")
    chapter.add(
        "text",
        f"The same contact under {len(curve.steps)} "
        f"{'loads' if curve.control == 'load' else 'approaches'}. Every one is solved as if it "
        "were the first: the model keeps no history, so that this is loading, not unloading.",
    )
    if math.isfinite(curve.low_load_slope):
        chapter.add(
            "text",
            f"At small loads (no more than {percent(LOW_LOAD)} in contact) the area grows as "
            f"A = κ W/(E* h′), with h′ = {curve.rms_gradient:.3g} the root-mean-square slope and "
            f"κ = {curve.low_load_slope:.3g}. For elastic contacts of many spots theory has 2.5 "
            "(Bush, Gibson and Thomas 1975) and 1.6 (Persson 2001), computations 1.8 to 2.3 (Hyun "
            "et al. 2004).",
        )
    chapter.add(
        "figure",
        _picture(
            plots.load_curve(curve),
            "Four diagrams over the load: areas, approach and gap, stiffness, number of spots.",
            "Contact and saturated area beside Persson's theory; approach and mean gap; stiffness; "
            "number of spots. Stiffness is what the next small load meets: saturated points carry "
            "no more of it.",
        ),
    )
    rows = [
        (
            engineering(step.load, "N"),
            engineering(step.approach, "m"),
            percent(step.contact_area / curve.nominal_area),
            percent(step.saturated_area / curve.nominal_area),
            engineering(step.max_pressure, "Pa"),
            engineering(step.mean_gap, "m"),
            f"{step.stiffness:.3g}",
            str(step.spots),
            f"{step.certificate:.1e}",
        )
        for step in curve.steps
    ]
    head = (
        "load", "approach", "contact", "saturated", "largest pressure", "mean gap",
        "stiffness [N/m]",         "spots", "certificate",
    )  # fmt: skip
    chapter.add("table", _Table(rows, head))
    return chapter


def _added(section: Section) -> _Chapter:
    chapter = _Chapter(section.title)
    for paragraph in section.text:
        chapter.add("text", paragraph)
    if section.table:
        head, *rows = section.table
        chapter.add("table", _Table(rows, head))
    for caption, figure in section.figures:
        chapter.add("figure", _picture(figure, caption, caption))
    return chapter


def _certificate(result: ContactResult) -> _Chapter:
    chapter = _Chapter("How exactly it is solved")
    chapter.add(
        "text",
        "Certificate: ε = ‖p − clip(p − g/K₀₀, 0, p_lim)‖ / ‖p‖, with p the pressure that is "
        "reported, p_lim its ceiling, K₀₀ the displacement of a pixel under unit pressure of its "
        "own, and g a gap that was computed afresh from p after the solver had ended. It is 0 if "
        "no point overlaps without pressure, no point that is pressed stands off, and only "
        "points at the ceiling sink in. It has no unit.",
    )
    load_error = f"{result.load_error:.1e}" if result.load_error else "0"
    if result.control == "load":
        load_error += f" (at most {LOAD_TOLERANCE:.0e})"
    else:
        load_error += " (the approach was given)"
    moments: list[Row] = []
    if result.moments is not None:
        moments = [("Moment error", f"{result.moment_error:.1e} (at most {MOMENT_TOLERANCE:.0e})")]
    status = "converged" if result.converged else f"NOT CONVERGED: {result.status}"
    chapter.add(
        "table",
        _Table(
            [
                ("Status", status),
                ("Certificate ε", f"{result.certificate:.1e}"),
                ("Tolerance asked for", f"{result.tolerance:.0e}"),
                ("Load error", load_error),
                *moments,
                ("Convolutions on the full grid", str(result.convolutions)),
                ("Iterations", str(result.iterations)),
                ("Time of the solve", f"{result.seconds:.2f} s"),
                ("Arithmetic of the transforms", f"{result.precision} precision"),
            ]
        ),
    )
    return chapter


def _repetition(result: ContactResult, command: str) -> _Chapter:
    chapter = _Chapter("How to repeat it")
    lines = command or script.repeating(result)
    if command:
        chapter.add("text", "The command that gave this result:")
    elif lines:
        chapter.add("text", "This script solves the same problem:")
    if lines:
        chapter.add("code", lines)
    else:
        chapter.add(
            "text",
            "The surface or its preparation was made in a program of its own, which has to be "
            "kept to repeat the result; all other input is in this report.",
        )
    rows: list[Row] = [
        ("roughcontact", f"{result.version or 'unknown'} (solved), {__version__} (this report)"),
        *((name, _installed(name)) for name in _LIBRARIES),
        ("Python", platform.python_version()),
        ("System", platform.platform()),
    ]
    chapter.add("text", "Versions where this report was written:")
    chapter.add("table", _Table(rows))
    return chapter


def _installed(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
