"""Figures of the page show what those of the report show: the same numbers, names and colors."""

from __future__ import annotations

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from bokeh.document import Document

from roughcontact import plots
from roughcontact.desk.figures import Drawing, read_figure, show_drawing
from roughcontact.drawing import style
from roughcontact.report import kinds

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


@pytest.fixture(scope="module")
def surface():
    return rc.Surface(np.random.default_rng(1).normal(0, 40e-9, (32, 48)), (2e-6, 1e-6))


def pages_of(result) -> dict[str, Drawing]:
    """Return the figures of a result, each of which a document takes."""
    drawings = {name: read_figure(draw()) for name, draw in kinds.drawings(result).items()}
    document = Document()
    for drawing in drawings.values():
        document.add_root(show_drawing(drawing))
    assert document.to_json()
    return drawings


def marks_of(drawing, glyph):
    return [mark for frame in drawing.frames for mark in frame.marks if mark.glyph == glyph]


@pytest.mark.long
def test_a_load_history_has_its_energies_and_its_loop(surface):
    history = rc.history(surface, [0.3, 1.0, 0.1], material=STEEL)
    (drawing,) = pages_of(history).values()
    loop, energy, volume = drawing.frames
    assert "dissipated" in energy.title
    assert energy.labels[0] == volume.labels[0] == "step"
    assert "indented volume" in volume.labels[1]
    bars = [
        float(np.ptp(part))
        for mark in energy.marks
        if mark.glyph == "patches"
        for part in mark.columns["ys"]
    ]
    np.testing.assert_allclose(
        np.array(bars) / max(bars),
        history.column("dissipated_energy") / history.column("dissipated_energy").max(),
    )
    assert {mark.name for mark in loop.marks} >= {"elastic", "new indentation"}
    assert [mark.columns["text"] for mark in marks_of(drawing, "text")] == [["start "], [" end"]]


@pytest.mark.long
def test_the_joint_and_the_slip_are_those_of_the_report(surface):
    contacts = [rc.solve(surface, load=load, material=STEEL) for load in (0.1, 0.3)]
    copper = rc.Conductor(17e-9, 390)
    conductance = rc.conductance(contacts, copper, copper)
    drawing = read_figure(plots.conductance(conductance))
    show_drawing(drawing)
    assert [frame.title for frame in drawing.frames] == [
        "Electrical resistance",
        "Thermal resistance",
    ]
    assert drawing.frames[0].scales == ("log", "log")
    line = next(mark for mark in drawing.frames[0].marks if mark.name == "computed")
    np.testing.assert_allclose(line.columns["y"], conductance.resistance("electrical"))
    assert line.look["line_color"] == style.SERIES[0]


@pytest.mark.long
def test_a_leak_has_its_gap_and_its_flow_in_decades(surface):
    contacts = [rc.solve(surface, load=load, material=STEEL) for load in (0.05, 0.1)]
    leak = rc.leakage(contacts)
    for drawing in pages_of(leak).values():
        assert drawing.frames
    drawing = read_figure(plots.leak(leak))
    gap, *flows = drawing.frames
    assert gap.is_map
    assert gap.ends[1][0] > gap.ends[1][1], "row 0 is above"
    assert all(frame.colors.is_log for frame in flows)
    assert flows
    (image,) = [mark for mark in flows[0].marks if mark.glyph == "image"]
    assert image.columns["image"][0].shape == (32, 48)
    assert image.columns["dh"][0] > 0


@pytest.mark.long
def test_every_result_with_figures_of_its_own_is_shown(surface):
    from roughcontact.analyses.tangential.model import tangential

    contact = rc.solve(surface, load=0.3, material=STEEL)
    drawings = pages_of(tangential(contact, friction=0.15, force=0.01))
    traction, stick, curve = next(iter(drawings.values())).frames
    assert traction.colors.label.startswith("traction [")
    assert [name for _, name in stick.patches] == ["stick", "slip", "no contact"]
    assert "solved" in {mark.name for mark in curve.marks}
    contacts = [
        rc.solve(surface, load=load, material=STEEL, boundary="periodic") for load in (0.1, 0.3)
    ]
    separation, *others = next(iter(pages_of(rc.interface_law(contacts)).values())).frames
    assert separation.title == "Pressure and separation"
    assert len(others) == 3


def test_lines_spans_and_areas_keep_their_style():
    figure, axes = style.panels(4, 3)
    axes.axhline(2.0, color="#123456", linestyle="-.", label="level")
    axes.axvspan(1, 2, color="#654321", alpha=0.5)
    axes.plot([0, 1], [1, 2], "s--", color="#0072b2", label="both")
    axes.fill_between([0, 1], [0, 0], [1, 2], color="#d55e00", alpha=0.2, label="band")
    axes.stairs([1, 2], [0, 1, 2], label="steps")
    (frame,) = read_figure(figure).frames
    kinds_of = [mark.glyph for mark in frame.marks]
    assert kinds_of == ["patches", "band", "multi_line", "span", "line", "scatter"]
    area, band, _, span, line, points = frame.marks
    assert band.columns == {"left": 1.0, "right": 2.0}
    assert band.look["fill_alpha"] == 0.5
    assert (span.columns, span.look["line_dash"]) == (
        {"dimension": "width", "location": 2.0},
        "dashdot",
    )
    assert (line.look["line_dash"], points.look["marker"]) == ("dashed", "square")
    assert area.look["fill_alpha"] == pytest.approx(0.2)
