"""A report on a contact with plasticity of the volume, in the form of `report.contact`.

Everything in it comes from the result that is handed over; nothing is solved here.
"""

from __future__ import annotations

import datetime
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.solve import LOAD_TOLERANCE
from roughcontact.plots import maps, profiles, volume
from roughcontact.report import assumptions_volume, chapters, page, regimes, script
from roughcontact.report.page import Chapter, Row, Section, Table
from roughcontact.units import counted, engineering, percent
from roughcontact.volume import depth
from roughcontact.volume.result import ElastoplasticResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Drawn = tuple[Callable[[], "Figure"], str, str]

# Sections are drawn a second time around the largest plastic strain where the zone there is so
# small a part of the map, and then as wide as so many of its depths or pixels.
_SMALL_PART = 0.1
_AROUND_ZONE = 6.0
_CLOSE_PIXELS = 24

_STAYS = " It stays when the load is gone, unless the bodies flow again on unloading."


def render(
    result: ElastoplasticResult,
    *,
    sections: Sequence[Section] = (),
    command: str = "",
    date: datetime.date | None = None,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    result : ElastoplasticResult
        What the report is on.
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
    """
    contact = result.contact
    spots = contact.spots()
    stated = assumptions_volume.statements(result, spots)
    found = [
        *chapters.prepared(contact),
        _problem(result),
        chapters.assumed(stated),
        _results(result),
        *(_volume(result, body) for body in range(len(result.bodies))),
    ]
    if result.increments:
        found.append(_path(result))
    if spots.count:
        found.append(chapters.contact_spots(contact, spots))
    found += [chapters.added(section) for section in sections]
    lines = script.repeating_volume(result)
    found += [_certificate(result), chapters.repetition(result.version, command, lines)]
    return page.render(
        found,
        title=_title(result),
        subtitle=chapters.subtitle(contact),
        date=date,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=regimes.volume_regime(result),
        certificate=_certificate_in_short(result),
        warnings=[note for note in result.warnings if note != result.status],
        cautions=[item.caution for item in stated if item.caution],
    )


def save(
    result: ElastoplasticResult,
    path: str | os.PathLike[str],
    *,
    sections: Sequence[Section] = (),
    command: str = "",
    date: datetime.date | None = None,
) -> None:
    """Write a report to an HTML file.

    Parameters
    ----------
    result, sections, command, date
        As for `render`.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.

    Raises
    ------
    InputError
        If the suffix is another one, or the folder does not exist.
    OSError
        If the file cannot be written.
    """
    page.check_path(path)
    page.write(render(result, sections=sections, command=command, date=date), path)


def _title(result: ElastoplasticResult) -> str:
    name = result.contact.surface.provenance.source or "an unnamed surface"
    if result.contact.load:
        return f"Contact of {name} under {engineering(result.contact.load, 'N')}, with plastic flow"
    if not result.increments:
        return f"Contact of {name}, whose first load was not reached"
    return f"What a load of {_largest_load(result)} left on {name}"


def _largest_load(result: ElastoplasticResult) -> str:
    return engineering(max((step.load for step in result.increments), default=0.0), "N")


def _key_numbers(result: ElastoplasticResult) -> list[Row]:
    contact = result.contact
    strain = percent(result.max_plastic_strain)
    plastic: list[Row] = [
        ("Plastic strain", strain, "accumulated, at most"),
        ("Plastic depth", engineering(result.plastic_depth, "m", 3), "that it reaches"),
    ]  # fmt: skip
    if not contact.load:
        dent = engineering(float(result.residual_displacement.max()), "m", 3)
        stress = max(float(body.residual_von_mises.max()) for body in result.bodies)
        return [
            ("Dent", dent, "residual displacement, at most"),
            ("Residual stress", engineering(stress, "Pa", 3), "von Mises, at most"),
            *plastic,
            ("Largest load", _largest_load(result), "on the way; it is gone"),
        ]
    area = engineering(contact.contact_area, "m²", 3)
    return [
        ("Largest pressure", engineering(contact.max_pressure, "Pa", 3), "on any one pixel"),
        ("Real contact", percent(contact.contact_fraction), f"of the map touches: {area}"),
        *plastic,
        ("Approach", engineering(contact.approach, "m", 3), "of the bodies from the first touch"),
    ]


def _certificate_in_short(result: ElastoplasticResult) -> str:
    if not result.converged:
        return (
            "The numbers are those of the last load that was reached, "
            f"{engineering(result.contact.load, 'N')}."
        )
    text = (
        "In the last iteration of each increment the plastic strain changed by "
        f"{result.residual:.1e} of itself or less, asked for {result.tolerance:.0e}"
    )
    if result.contact.load:
        text += (
            f"; certificate of the contact {result.contact.certificate:.1e}. Both say how exactly "
            "the problem as stated is solved; whether the problem is the right one, the "
            "assumptions say."
        )
        return text
    return f"{text}. Whether the problem is the right one, the assumptions say."


def _problem(result: ElastoplasticResult) -> Chapter:
    loads = [step.load for step in result.increments]
    turns = [
        load
        for before, load, after in zip([0.0, *loads], loads, [*loads[1:], None], strict=False)
        if after is None or (load - before) * (after - load) < 0
    ]
    given = ("Loads W (given)", " → ".join(engineering(load, "N") for load in [0.0, *turns]))
    plasticity: list[Row] = [
        ("Increments", str(len(loads))),
        ("Plasticity", "of the volume: von Mises, isotropic hardening, radial return"),
    ]
    return chapters.problem(result.contact, [given], plasticity, laws=True)


def _results(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("Results")
    contact = result.contact
    nominal = contact.pressure.size * contact.pixel_area
    raised = max(-float(result.residual_displacement.min()), 0.0)
    dent = engineering(float(result.residual_displacement.max()), "m")
    rows: list[Row] = [
        ("Load W", engineering(contact.load, "N"), "normal force that the pressure adds up to"),
        ("Approach ω", engineering(contact.approach, "m"), "of the bodies from the first touch"),
        ("Nominal area", engineering(nominal, "m²"), "of the whole map"),
    ]
    if contact.load:
        mean = contact.load / contact.contact_area
        rows += [
            (
                "Contact area",
                f"{engineering(contact.contact_area, 'm²')} ({percent(contact.contact_fraction)})",
                "pixels with pressure, and their share of the map",
            ),
            (
                "Contact area without rim excess",
                engineering(result.corrected_contact_area, "m²"),
                "less what whole pixels at the elastic rim of spots add",
            ),
            ("Largest pressure", engineering(contact.max_pressure, "Pa"), "on any pixel"),
            ("Mean pressure", engineering(mean, "Pa"), "load over contact area"),
        ]
    rows += [
        ("Mean gap", engineering(contact.mean_gap, "m"), "of the open gap; closed points count 0"),
        ("Residual displacement", f"up to {dent}", "what plastic strain adds to the gap"),
        (
            "Raised surface",
            f"up to {engineering(raised, 'm')}" if raised else "none",
            "by which it takes from the gap (pile-up)",
        ),
        ("Regime", result.regime, "how far the bodies are from elastic"),
    ]
    chapter.add("table", Table(rows, ("quantity", "value", "meaning")))
    missing = " Grey points were not measured." if np.isnan(contact.gap).any() else ""
    drawn: list[Drawn] = [
        (
            lambda: volume.residual_displacement(result),
            f"Map of the residual displacement, up to {dent}.",
            "What plastic strain adds to the gap: red is pressed in, blue is raised."
            + (_STAYS + " The line is the edge of the contact." if contact.load else ""),
        ),
        (
            lambda: maps.gap(contact),
            f"Map of the open gap, mean {engineering(contact.mean_gap, 'm', 3)}.",
            f"Gap that is left between the bodies{'' if contact.load else ', which just touch'}. "
            "Orange is closed; the darker the blue, the wider the gap: this is the room left for "
            f"a fluid or for wear debris.{missing}",
        ),
    ]  # fmt: skip
    if contact.load:
        largest = engineering(contact.max_pressure, "Pa", 3)
        drawn.insert(
            0,
            (
                lambda: maps.pressure(contact),
                f"Map of the contact pressure, largest {largest}.",
                "Contact pressure. The lightest ground does not touch; the darker, the higher.",
            ),
        )
        drawn.append(
            (
                lambda: profiles.pressure_histogram(contact),
                "Histogram of the contact pressure over the contact area.",
                "How the contact area is spread over the pressure. The right end is the largest "
                "pressure of any pixel.",
            )
        )
    return _with(chapter, drawn)


def _volume(result: ElastoplasticResult, body: int) -> Chapter:
    where = "" if len(result.bodies) == 1 else f" of the {('first body', 'counter-body')[body]}"
    chapter = Chapter(f"Plastic strain and stress{where}")
    rows = _volume_rows(result, body)
    chapter.add("table", Table(rows, ("quantity", "value", "note")))
    kept = "each cell is one layer of one pixel" if result.contact.load else "each cell a layer"
    caption = (
        f"True to scale, {kept}; the plastic zone lies inside the grey line, the cross marks the "
        "largest plastic strain of the section."
    )
    if result.contact.load:
        caption += " Where the stress over the yield strength is 1 the material flows."
    width = _close_up(result, body)
    drawn: list[Drawn] = []
    for along in ("x", "y"):
        alt = f"Section along {along} through the largest plastic strain"
        lead = f"Section along {along} through the largest plastic strain{where}."
        drawn.append(
            (
                lambda along=along: volume.section(result, along, body=body, width=width),  # type: ignore[misc]
                f"{alt}: strain, stress under load, residual stress.",
                f"{lead} {caption}",
            )
        )
    drawn += [
        (
            lambda: volume.profile(result, body=body),
            "Profiles with depth below the largest plastic strain.",
            "Below the point of the largest plastic strain: the strain; the von Mises stress and "
            "the yield strength at this strain; the normal stresses by the plastic strain alone. "
            "Steps are layers.",
        ),
        (
            lambda: volume.layers(result, body),
            "Largest values of each layer over the depth.",
            "Layer by layer: how much of it has plastic strain, its largest strain, and its "
            "largest stresses, wherever they are.",
        ),
    ]
    return _with(chapter, drawn)


def _volume_rows(result: ElastoplasticResult, body: int) -> list[Row]:
    """Return where strain and stress of one body are largest, and its layers."""
    held = result.bodies[body]
    layer, row, column = depth.most_strained(result, body)
    dy, dx = result.contact.surface.pixel
    deep = float(held.depth[layer])
    told = depth.layers(result, body)
    deepest = int(told.max_residual_von_mises.argmax())
    place = f"{engineering((row + 0.5) * dy, 'm')}, {engineering((column + 0.5) * dx, 'm')}"
    rows: list[Row] = [
        (
            "Largest accumulated plastic strain" if held.plastic_volume else "Largest stress",
            percent(held.max_plastic_strain)
            if held.plastic_volume
            else engineering(float(held.von_mises.max()), "Pa"),
            f"{engineering(deep, 'm', 3)} deep, at y, x = {place}",
        ),
        (
            "Plastic depth",
            engineering(held.plastic_depth, "m"),
            "lower face of the lowest layer with plastic strain",
        ),
        ("Plastic volume", f"{1e18 * held.plastic_volume:.4g} µm³", "with any plastic strain"),
        (
            "Largest residual von Mises stress",
            engineering(float(told.max_residual_von_mises.max()), "Pa"),
            f"{engineering(float(held.depth[deepest]), 'm', 3)} deep",
        ),
    ]
    if result.contact.load:
        highest = int(told.max_von_mises.argmax())
        rows.append(
            (
                "Largest von Mises stress under load",
                engineering(float(told.max_von_mises.max()), "Pa"),
                f"{engineering(float(held.depth[highest]), 'm', 3)} deep",
            )
        )
    rows.append(
        (
            "Layers",
            str(held.thickness.size),
            f"{engineering(float(held.thickness.sum()), 'm', 3)} deep in all",
        )
    )
    return rows


def _close_up(result: ElastoplasticResult, body: int) -> float | None:
    """Return a width that shows the zone at the largest strain, or None if all of the map does."""
    zone = depth.profile(result, body=body)
    plastic = np.flatnonzero(zone.accumulated)
    if not plastic.size:
        return None
    deep = float(zone.faces[plastic[-1] + 1])
    edge, size = max(result.contact.surface.pixel), min(result.contact.surface.size)
    width = max(_AROUND_ZONE * deep, _CLOSE_PIXELS * edge)
    return width if deep < _SMALL_PART * size and width < size else None


def _path(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("Path of loads")
    chapter.add(
        "text",
        "Every increment starts from what the one before has left. Increments that did not settle "
        "were halved.",
    )
    chapter.add(
        "figure",
        page.picture(
            volume.path(result),
            "Four diagrams over the load: approach, contact area, pressure, plastic strain.",
            "Approach, contact area, largest pressure and largest plastic strain, from the first "
            "touch on. The ring is the state that this report is on.",
        ),
    )
    rows = [
        (
            str(number),
            engineering(step.load, "N"),
            engineering(step.approach, "m"),
            engineering(step.contact_area, "m²"),
            engineering(step.max_pressure, "Pa"),
            percent(step.max_plastic_strain),
            f"{1e18 * step.plastic_volume:.4g}",
            f"{step.residual:.1e}",
            str(step.iterations),
        )
        for number, step in enumerate(result.increments, start=1)
    ]
    head = (
        "", "load", "approach", "contact area", "largest pressure", "plastic strain",
        "plastic volume [µm³]", "residual", "iterations",
    )  # fmt: skip
    chapter.add("table", Table(rows, head))
    return chapter


def _certificate(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("How exactly it is solved")
    contact = result.contact
    chapter.add(
        "text",
        "Residual: the largest change of the plastic strain in the last iteration of an increment "
        "over the largest strain of that increment, or over the yield strain σ_Y/(2μ) if that is "
        "more. Yield excess: the largest von Mises stress over the yield strength at that place, "
        "less one, from stresses that were computed afresh from strain and pressure; it should be "
        "about 0 where something has yielded under load, and negative otherwise.",
    )
    chapter.add(
        "text",
        "Certificate of the contact: ε = ‖p − max(p − g/K₀₀, 0)‖ / ‖p‖, with p the pressure, K₀₀ "
        "the displacement of a pixel under unit pressure of its own, and g the gap, the residual "
        "displacement included, computed afresh from p after the solver had ended.",
    )
    status = "converged" if result.converged else f"NOT CONVERGED: {result.status}"
    rows: list[Row] = [
        ("Status", status),
        ("Residual of the plastic strain", f"{result.residual:.1e}, the worst of all increments"),
        ("Tolerance asked for", f"{result.tolerance:.0e}"),
        ("Yield excess", f"{result.yield_excess:+.1e}"),
    ]
    if contact.load:
        load_error = f"{contact.load_error:.1e}" if contact.load_error else "0"
        rows += [
            ("Certificate ε of the contact", f"{contact.certificate:.1e}"),
            ("Tolerance of the contact", f"{contact.tolerance:.0e}"),
            ("Load error", f"{load_error} (at most {LOAD_TOLERANCE:.0e})"),
        ]
    rows += [
        (
            "Iterations",
            f"{result.iterations} in {counted(len(result.increments), 'increment')}",
        ),
        (
            "Convolutions of the contact",
            str(sum(step.convolutions for step in result.increments)),
        ),
        ("Time of the solve", f"{result.seconds:.2f} s"),
        ("Arithmetic of the volume", f"{result.precision} precision"),
    ]
    chapter.add("table", Table(rows))
    drawn = (
        lambda: volume.convergence(result),
        "Residual of the plastic strain over the iterations",
        "How the plastic strain settled, increment by increment. Attempts that were given up for a "
        "smaller step or a larger volume are not shown.",
    )
    return _with(chapter, [drawn])


def _with(chapter: Chapter, drawn: Sequence[Drawn]) -> Chapter:
    for draw, alt, caption in drawn:
        chapter.add("figure", page.picture(draw(), alt, caption))
    return chapter
