"""Chapters of a report that its result does not hold by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact import units

if TYPE_CHECKING:
    from roughcontact.contact.history import LoadHistory
    from roughcontact.contact.stress import StressResult
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.report.page import Section


def sections(study: ResolutionStudy | None, notes: tuple[str, ...]) -> list[Section]:
    """Return the chapters of a report that the result itself does not hold."""
    from roughcontact.report.page import Section

    chapters = []
    if notes:
        chapters.append(
            Section("What the measurement resolves", tuple(_sentence(n) for n in notes))
        )
    if study is not None:
        head = ("case", "contact", "saturated", "largest pressure", "mean pressure")
        rows = [
            (
                name,
                units.percent(case.contact_fraction),
                units.percent(case.saturated_fraction),
                units.engineering(case.max_pressure, "Pa"),
                units.engineering(case.mean_pressure, "Pa"),
            )
            for name, case in study.named()
        ]
        chapters.append(Section("Can it be trusted", study.sentences, (head, *rows)))
    return chapters


def stress_section(stress: StressResult) -> Section:
    """Return the chapter of a report on the stress below the surface."""
    from roughcontact.plots import stress as stress_plots
    from roughcontact.report.page import Section

    told = stress.summary()
    depth, y, x = stress.place
    rows = [
        ("quantity", "value"),
        ("Largest von Mises stress", units.engineering(stress.max_von_mises, "Pa")),
        ("Its depth", units.engineering(depth, "m")),
        ("Its place (y, x)", f"{units.engineering(y, 'm')}, {units.engineering(x, 'm')}"),
        ("Largest Tresca stress", units.engineering(told["max_tresca"], "Pa")),
        (
            "Orthogonal shear amplitude, pass along y",
            units.engineering(told["max_orthogonal_shear_along_y"], "Pa"),
        ),
        (
            "Orthogonal shear amplitude, pass along x",
            units.engineering(told["max_orthogonal_shear_along_x"], "Pa"),
        ),
    ]
    if stress.yield_factor is not None:
        rows.append(("Yield strength over largest stress", f"{stress.yield_factor:.4g}"))
    if stress.yielded_volume is not None:
        rows.append(("Volume above the yield strength", f"{1e18 * stress.yielded_volume:.4g} µm³"))
    text = (
        f"Elastic stress in the {stress.body} body under the pressure found"
        + (f", with a friction coefficient of {stress.friction:g}" if stress.friction else "")
        + ". Tension is positive.",
        *(_sentence(note) for note in stress.warnings if note not in stress.contact.warnings),
    )
    figures = (
        ("Largest equivalent stresses at each depth.", stress_plots.stress_depth(stress)),
        ("Von Mises stress on planes through its maximum.", stress_plots.stress_section(stress)),
        ("Largest von Mises stress over all depths.", stress_plots.stress_map(stress)),
    )
    return Section("Stress below the surface", text, tuple(rows), figures)


def history_section(history: LoadHistory) -> Section:
    """Return the chapter of a report on a load history."""
    from roughcontact.plots import curves
    from roughcontact.report.page import Section

    head = ("step", "load", "approach", "contact", "saturated", "newly indented", "dissipated")
    nominal = history.last.pressure.size * history.last.pixel_area
    rows = [
        (
            str(number),
            units.engineering(step.load, "N"),
            units.engineering(step.approach, "m"),
            units.percent(step.contact_area / nominal),
            units.percent(step.saturated_area / nominal),
            f"{1e18 * step.indentation_volume:.3g} µm³",
            units.engineering(step.dissipated_energy, "J", 3),
        )
        for number, step in enumerate(history.steps, start=1)
    ]
    told = history.summary()
    body = "first body" if history.indented_body == "surface" else "counter-body"
    text = (
        f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
        f"indentation, {units.engineering(told['max_indentation'], 'm')} at most; unloading is "
        "elastic. The rest of this report is on the last step.",
        "Shaken down: the last pass adds no indentation."
        if history.shaken_down
        else "Not shaken down: the last pass still adds indentation.",
        str(told["volume_account"]),
    )
    figures = (("Load against approach, and what each step costs.", curves.hysteresis(history)),)
    return Section("Load history", text, (head, *rows), figures)


def _sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:]}."
