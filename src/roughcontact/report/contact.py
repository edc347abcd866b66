"""A report on a result: one HTML file that needs nothing else and prints to A4.

Everything in it comes from the results that are handed over; nothing is solved here.
"""

from __future__ import annotations

import datetime
import math
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.curve import LOW_LOAD, LoadCurve
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import LOAD_TOLERANCE, MOMENT_TOLERANCE
from roughcontact.contact.spots import Spots
from roughcontact.errors import ConvergenceError, InputError, InsufficientMemoryError
from roughcontact.plots import curves, maps, profiles
from roughcontact.report import assumptions, chapters, page, regimes, script, wording
from roughcontact.report.page import Chapter, Row, Section, Table
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Close-ups show this many times the root of the area of the spot at the peak, or the longer side
# of the most loaded spot, but no fewer pixels; and only where this is a small part of the map.
_AROUND_SPOT = 4
_AROUND_LOADED = 1.5
_SMALL_PART = 0.5
_CLOSE_PIXELS = 40


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
        Further found.
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
            f"has {elastic.pressure.shape} pixels and the result {result.pressure.shape}; "
            "give the solution of the same problem, result.elastic()",
            argument="elastic",
        )
    spots = result.spots()
    stated = assumptions.statements(result, spots)
    found = [
        *chapters.prepared(result),
        _problem(result),
        chapters.assumed(stated),
        _results(result, spots),
        _profiles(result, spots),
        chapters.contact_spots(result, spots),
    ]
    if result.saturated_fraction > 0:
        found.append(_comparison(result, elastic))
    if curve is not None:
        found.append(_load_curve(curve))
    found += [chapters.added(section) for section in sections]
    lines = script.repeating(result)
    found += [_certificate(result), chapters.repetition(result.version, command, lines)]
    return page.render(
        found,
        title=_title(result),
        subtitle=chapters.subtitle(result),
        date=date,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=regimes.regime(result),
        certificate=_certificate_in_short(result),
        warnings=result.warnings,
        cautions=[item.caution for item in stated if item.caution],
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
    page.check_path(path)
    text = render(
        result, elastic=elastic, curve=curve, sections=sections, command=command, date=date
    )
    page.write(text, path)


def save_compared(
    result: ContactResult, path: str | os.PathLike[str], command: str, sections: Sequence[Section]
) -> None:
    """Write a report of a result; one with saturated pixels is solved without a ceiling beside it.

    Parameters
    ----------
    result, path, command, sections
        As for `save`.
    """
    page.check_path(path)
    elastic = None
    if result.saturated_fraction > 0:
        try:
            elastic = result.elastic()
        except ConvergenceError as error:
            # The chapter shows it as what it is.
            elastic = error.result if isinstance(error.result, ContactResult) else None
        except InsufficientMemoryError:
            # The chapter says that there is none; the report stays worth having.
            pass
    save(result, path, elastic=elastic, command=command, sections=sections)


def _title(result: ContactResult) -> str:
    name = result.surface.provenance.source or "an unnamed surface"
    if result.control == "load":
        return f"Contact of {name} under {engineering(result.load, 'N')}"
    return f"Contact of {name} at an approach of {engineering(result.approach, 'm')}"


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


def _problem(result: ContactResult) -> Chapter:
    given = {
        "load": ("Load W (given)", engineering(result.load, "N")),
        "approach": ("Approach ω (given)", engineering(result.approach, "m")),
    }[result.control]
    moments: list[Row] = []
    if result.moments is not None:
        about_y, about_x = (engineering(moment, "N m") for moment in result.moments)
        moments = [("Moments W·y, W·x (given)", f"{about_y}, {about_x}")]
    ceiling = ("Pressure ceiling", wording.ceiling(result))
    return chapters.problem(result, [given, *moments], [ceiling])


def _results(result: ContactResult, spots: Spots) -> Chapter:
    chapter = Chapter("Results")
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
    chapter.add("table", Table(rows, ("quantity", "value", "meaning")))
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


def _result_pictures(result: ContactResult, spots: Spots) -> list[page.Picture]:
    largest = engineering(result.max_pressure, "Pa", 3)
    touching = percent(result.contact_fraction)
    saturated = percent(result.saturated_fraction)
    classes = "Blue touches elastically"
    if result.ceiling is not None:
        classes += ", dark red is at the pressure ceiling"
    missing = " Grey points were not measured." if np.isnan(result.gap).any() else ""
    drawn: list[tuple[Callable[[], Figure], str, str]] = [
        (
            lambda: maps.pressure(result),
            f"Map of the contact pressure, largest {largest}.",
            "Contact pressure. The lightest ground does not touch; the darker, the higher. "
            "Black, where it occurs, is beyond the scale.",
        ),
        (
            lambda: maps.contact(result),
            f"Map of the contact: {touching} of the map touches, {saturated} is saturated.",
            f"Where the bodies touch. {classes}.{missing} The shares are counted on all points.",
        ),
        (
            lambda: maps.gap(result),
            f"Map of the open gap, mean {engineering(result.mean_gap, 'm', 3)}.",
            "Gap that is left between the bodies. Orange is closed; the darker the blue, the "
            f"wider the gap: this is the room left for a fluid or for wear debris.{missing}",
        ),
        (
            lambda: profiles.pressure_histogram(result),
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
                lambda: maps.close_up(result, point, width),
                f"Pressure and contact in a part of {about} around the most loaded spot.",
                f"A part of the last two figures, {about} wide, around the spot that carries most. "
                "It shows whether the pixels of the map resolve the contact.",
            ),
        )
    return [page.picture(draw(), alt, caption) for draw, alt, caption in drawn]


def _profiles(result: ContactResult, spots: Spots) -> Chapter:
    chapter = Chapter("Sections through the highest peak")
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
    chapter.add("figure", page.picture(profiles.section(result), f"{alt}; whole length.", caption))
    width = _close_up(result, spots)
    if width is not None:
        chapter.add(
            "figure",
            page.picture(
                profiles.section(result, width),
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


def _comparison(result: ContactResult, elastic: ContactResult | None) -> Chapter:
    chapter = Chapter("Elastic beside ceiling")
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
    chapter.add("table", Table(rows, ("", "elastic", label)))
    if touching:
        chapter.add(
            "text",
            f"{percent(inside / touching)} of the elastic contact also touches with the ceiling.",
        )
    chapter.add(
        "figure",
        page.picture(
            maps.comparison(pair, ["elastic", label]),
            "Maps of pressure and contact, elastic on the left and with the ceiling on the right.",
            "Pressure above, contact below; elastic on the left, with the ceiling on the right. "
            "Both pressures have the same colours; where the elastic pressure exceeds what the "
            "ceiling allows it is black.",
        ),
    )
    wide = elastic.max_pressure > _WIDE_RANGE * result.max_pressure
    chapter.add(
        "figure",
        page.picture(
            profiles.pressure_histogram(
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


def _load_curve(curve: LoadCurve) -> Chapter:
    chapter = Chapter("Load curve")
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
        page.picture(
            curves.load_curve(curve),
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
    chapter.add("table", Table(rows, head))
    return chapter


def _certificate(result: ContactResult) -> Chapter:
    chapter = Chapter("How exactly it is solved")
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
        Table(
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
