"""Console, report and files show the same quantities of a result."""

from __future__ import annotations

import html
import json
import math
import re
from pathlib import Path
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from matplotlib.figure import Figure

import roughcontact as rc
from roughcontact.analyses.history import report as history_report
from roughcontact.analyses.solve import (
    fields as contact_fields,
    report as contact,
    task as solve,
    uncertainty_report as uncertainty,
    volume_report as elastoplastic,
)
from roughcontact.analyses.stress import report as subsurface_stress, task as stress_task
from roughcontact.analyses.sweep import report as curves
from roughcontact.cli import console
from roughcontact.cli.terminal import DisplayOptions
from roughcontact.contact.result import Regime
from roughcontact.formats import tables as files
from roughcontact.material.material import RIGID
from roughcontact.report import figures, inputs
from roughcontact.report.kind import (
    ABSENT,
    ANSWER,
    HEADLINE,
    PROBLEM,
    TRUST,
    Column,
    Quantity,
    csv_text,
    delegate_quantity,
    format_value,
    profile_table,
    quantity_of,
    read_attribute,
    rows_of,
    side_by_side,
    split_label,
    stored_steps,
    stored_values,
)
from roughcontact.report.presentation import Presentation, presentation_of

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
Capture = pytest.CaptureFixture[str]


class Place(NamedTuple):
    """Place of a point."""

    row: int
    column: int


pytestmark = pytest.mark.usefixtures("quick")


def ball(points: int = 24, radius: float = 1e-2, side: float = 4e-4) -> rc.Surface:
    x = (np.arange(points) - (points - 1) / 2) * side / points
    return rc.Surface(-(x[:, None] ** 2 + x**2) / (2 * radius), (side / points, side / points))


@pytest.fixture(scope="module")
def contact_result() -> rc.ContactResult:
    return rc.solve(ball(), material=STEEL, load=20.0)


@pytest.fixture(scope="module")
def volume_result() -> rc.ElastoplasticResult:
    return rc.solve_elastoplastic(ball(16), material=STEEL, load=80.0, increments=2, tolerance=1e-2)


@pytest.fixture(scope="module")
def stress_result(contact_result: rc.ContactResult) -> rc.results.StressResult:
    return rc.subsurface_stress(contact_result)


@pytest.fixture(scope="module")
def history() -> rc.results.LoadHistory:
    return rc.history(ball(), [60.0, 0.0], material=STEEL)


@pytest.fixture(scope="module")
def curve() -> rc.results.LoadCurve:
    return rc.sweep(ball(), material=STEEL, loads=[5.0, 20.0])


def text_of(markup: str) -> str:
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", markup)).split())


def write_outputs(
    kind: str, request: pytest.FixtureRequest, capsys: Capture
) -> tuple[str, str, Any]:
    """Return console output, report and JSON record of a kind of result."""
    result = request.getfixturevalue(kind)
    asked: Any = SimpleNamespace(task=solve.TASK)
    outcome: Any = SimpleNamespace(result=result, request=asked, written=(), extra_results={})
    console.print_outcome(outcome, DisplayOptions.VERBOSE)
    shown = " ".join(capsys.readouterr().out.split())
    kept = json.loads(json.dumps(result.summary(), default=str))
    return shown, text_of(presentation_of(result).render()), kept


TABLES: dict[str, type[Presentation]] = {
    "contact_result": contact.ContactPresentation,
    "volume_result": elastoplastic.VolumePresentation,
    "stress_result": subsurface_stress.StressPresentation,
    "history": history_report.HistoryPresentation,
    "curve": curves.CurvePresentation,
}


def change_kind(monkeypatch: pytest.MonkeyPatch, kind: str, **more: Any) -> None:
    """Add to what a kind tells; its row is the only place that changes."""
    for name, one in more.items():
        monkeypatch.setattr(TABLES[kind], name, (*getattr(TABLES[kind], name), one))


@pytest.mark.long
@pytest.mark.parametrize("kind", TABLES)
def test_new_quantity_appears_in_all_outputs(
    kind: str, request: pytest.FixtureRequest, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    added = Quantity("answer", "answer to all $Q$ [Pa]", of=lambda _: 42.123456e6)
    change_kind(monkeypatch, kind, table=added)
    shown, report, kept = write_outputs(kind, request, capsys)
    assert "Answer to all Q 42.12 MPa" in shown
    assert "Answer to all Q 42.12 MPa" in report
    assert kept["answer"] == 42.123456e6


def test_a_quantity_of_a_result_is_in_its_record(
    contact_result: rc.ContactResult,
    volume_result: rc.ElastoplasticResult,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    added = Quantity("answer", "answer", of=lambda _: 42)
    change_kind(monkeypatch, "contact_result", table=added)
    change_kind(monkeypatch, "volume_result", table=added)
    assert files.result_record(contact_result)["answer"] == 42
    assert files.result_record(volume_result)["volume"]["answer"] == 42


@pytest.mark.parametrize(
    ("kind", "name"), [("curve", "CURVE_COLUMNS"), ("history", "HISTORY_COLUMNS")]
)
def test_new_column_appears_in_all_outputs(
    kind: str,
    name: str,
    request: pytest.FixtureRequest,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    added = Column("root", "root [N]", of=lambda r: [s.load**0.5 for s in r.steps])
    change_kind(monkeypatch, kind, columns=added)
    # The table of a history shows its steps.
    fields = {"curve": curves, "history": history_report}[kind]
    monkeypatch.setattr(fields, name, (*getattr(fields, name), added))
    result = request.getfixturevalue(kind)
    shown, report, kept = write_outputs(kind, request, capsys)
    first = result.steps[0].load ** 0.5
    text = format_value(first, "N")
    assert text in shown
    assert text in report
    assert "root" in report
    values = kept["root"] if kind == "curve" else kept["steps"]["root"]
    assert values[0] == first
    result.save(tmp_path / "steps.csv")
    head, row, *_ = (tmp_path / "steps.csv").read_text(encoding="utf-8").splitlines()
    assert head.endswith(",root [N]")
    assert row.endswith(f",{first!r}")


@pytest.mark.parametrize("kind", TABLES)
def test_console_and_report_show_same_digits(
    kind: str, request: pytest.FixtureRequest, capsys: Capture
) -> None:
    result = request.getfixturevalue(kind)
    shown, report, _ = write_outputs(kind, request, capsys)
    brief = [
        row for part in (PROBLEM, ANSWER, TRUST) for row in presentation_of(result).rows(part, True)
    ]
    assert len(brief) > 2
    for row in brief:
        assert row.title.lower() in shown.lower()
        assert row.title in report
        assert row.text in shown
        assert row.text in report


@pytest.mark.parametrize("kind", TABLES)
def test_keys_are_unique_and_shown_quantities_have_names(
    kind: str, request: pytest.FixtureRequest
) -> None:
    table = presentation_of(request.getfixturevalue(kind)).table
    keys = [quantity.key for quantity in table]
    assert len(keys) == len(set(keys))
    assert all(quantity.stored or quantity.name for quantity in table)
    # A name stands within a line, or begins one.
    assert all(quantity.name[:1].islower() for quantity in table if quantity.name)
    assert {quantity.part for quantity in table} <= {PROBLEM, ANSWER, TRUST, HEADLINE}


def test_missing_quantity_of_one_result_is_marked(contact_result: rc.ContactResult) -> None:
    values = {
        row.key: texts
        for row, texts in side_by_side(
            contact_fields.CONTACT, [contact_result.elastic(), contact_result]
        )
    }
    assert values["saturated_fraction"][0] == ABSENT
    assert values["saturated_fraction"][1].endswith("%")
    assert values["load"] == ("20 N (given)", "20 N (given)")


def test_friction_is_shown_with_its_direction_or_omitted(
    contact_result: rc.ContactResult, stress_result: rc.results.StressResult
) -> None:
    rubbed = rc.subsurface_stress(contact_result, [1e-5], friction=0.2, direction=90.0)
    values = {row.key: row.text for row in presentation_of(rubbed).rows()}
    assert (values["friction"], values["direction"]) == ("0.2", "90°")
    assert {"friction", "direction"}.isdisjoint(
        row.key for row in presentation_of(stress_result).rows()
    )


def test_delegated_quantity_reads_part_of_result() -> None:
    inner = Quantity("real", "real part", of="real", text=lambda v: f"<{v.real}>")
    outer = delegate_quantity("number", inner, label="first part")
    (row,) = rows_of((outer,), type("Held", (), {"number": 3 + 4j}))
    assert (row.value, row.text, row.title) == (3.0, "<3.0>", "First part")


@pytest.mark.parametrize(
    ("label", "parts"),
    [
        ("", ("", "", "1", "")),
        ("[m²]", ("", "", "m²", "")),
        ("mean gap", ("mean gap", "", "1", "")),
        ("mean gap $ū$ [m]: of the open gap", ("mean gap", "ū", "m", "of the open gap")),
        ("tilt (y, x) [rad]: about the center", ("tilt (y, x)", "", "rad", "about the center")),
        ("contact: E* [Pa] and A", ("contact", "", "1", "E* [Pa] and A")),
    ],
)
def test_label_has_name_symbol_unit_and_meaning(label: str, parts: tuple[str, ...]) -> None:
    assert split_label(label) == parts


def test_attribute_on_a_path_is_read_of_each_item_and_none_where_it_ends() -> None:
    steps = (SimpleNamespace(load=1.0, at=Place(2, 3)), SimpleNamespace(load=4.0, at=Place(5, 6)))
    result = SimpleNamespace(steps=steps, base=None, at=Place(7, 8))
    assert read_attribute(result, "steps.load") == [1.0, 4.0]
    assert read_attribute(result, "steps.at.row") == [2, 5]
    assert read_attribute(result, "at.row") == 7
    assert read_attribute(result, "base.steps.load") is None
    assert Column("load").values(result) == [1.0, 4.0]
    assert not Column("load", of="base.steps.load").is_shown(result)
    assert not Quantity("base", "base").is_shown(result)


def test_stored_values_are_ready_for_json() -> None:
    result = SimpleNamespace(
        at=Place(1, 2), size=(1e-6, 2e-6), regime=Regime.SATURATED, areas=np.array([0.5, 1.0])
    )
    kept = stored_values([Quantity(key) for key in vars(result)], result)
    assert kept == {
        "at": {"row": 1, "column": 2},
        "size": [1e-6, 2e-6],
        "regime": str(Regime.SATURATED),
        "areas": [0.5, 1.0],
    }
    assert json.loads(json.dumps(kept)) == kept


def test_quantities_of_a_profile_are_those_of_a_map_per_meter_of_width() -> None:
    area = Quantity("contact_area", "contact area [m²]: pixels of the map with pressure")
    load, other = Quantity("load", "load $W$ [N]"), Quantity("tilt", "tilt")
    table = profile_table((area, load, other), "tilt", load={"label": "line load [N/m]"})
    assert [item.key for item in table] == ["contact_length", "load"]
    assert [item.label for item in table] == [
        "contact length [m]: points of the profile with pressure",
        "line load [N/m]",
    ]
    result = SimpleNamespace(contact_area=2e-6, load=3.0)
    assert [item.value(result) for item in table] == [2e-6, 3.0]


def test_csv_keeps_every_digit_and_the_type() -> None:
    steps = [type("Step", (), {"x": 0.1 + 0.2, "n": 3})]
    columns = (Column("x", "[m]"), Column("n"), Column("note", "note", stored=False))
    result = type("Steps", (), {"steps": steps})
    assert csv_text(stored_steps(columns, result)) == "x [m],n [1]\n0.30000000000000004,3\n"


def test_roughness_of_file_is_shown_with_and_without_plane() -> None:
    surface = rc.Surface(np.arange(12.0).reshape(3, 4) * 1e-9, (1e-6, 1e-6))
    row = quantity_of(inputs.FILE, "Sq").row(inputs.measured_map(surface))
    assert row.value == surface.Sq
    assert row.text.startswith(f"{format_value(surface.Sq, 'm')}, after plane ")


def test_figures_are_named_after_those_of_the_report(
    contact_result: rc.ContactResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = (
        solve.TASK.figures({solve.MODEL: None}),
        solve.TASK.figures({solve.MODEL: solve.VOLUME_MODEL}),
        stress_task.TASK.figures({}),
    )
    tables = (figures.CONTACT, elastoplastic.VolumePresentation.figures, subsurface_stress.FIGURES)
    assert tuple(resolve_name(f"roughcontact.{place}") for place in places) == tables
    drawn = []

    def sketch(scene: Any) -> Figure:
        drawn.append(scene.result)
        figure = Figure()
        figure.subplots()
        return figure

    added = figures.Illustration("sketch", sketch, "A sketch of it.")
    monkeypatch.setattr(contact.ContactPresentation, "figures", (*figures.CONTACT, added))
    assert "A sketch of it." in text_of(presentation_of(contact_result).render())
    presentation_of(contact_result).drawings()["sketch"]()
    assert drawn == [contact_result, contact_result]


def test_a_table_for_everything_that_has_a_summary() -> None:
    with pytest.raises(TypeError, match="no kind of results for a int"):
        presentation_of(3)


def test_undetermined_texture_shows_upper_bound() -> None:
    unknown = {"Sal": 1e-6, "Str": math.nan, "Str_max": 0.3123}
    assert inputs.parameter("Str", unknown) == "not determined, at most 0.31"
    assert inputs.parameter("Str", {**unknown, "Str": 0.25}) == "0.25"
    assert inputs.parameter("Str", {"Str": math.nan, "Str_max": math.nan}) == (
        "not defined on this map"
    )
    assert inputs.parameter("Sq", {}) == "not defined on this map"


def test_numbers_are_shown_without_powers_of_ten() -> None:
    values = {value: format_value(value, "m³") for value in (0.0, 3e-17, 1.87e-10, 7.2e-26)}
    assert list(values.values()) == ["0 µm³", "30 µm³", "0.187 mm³", "72 nm³"]
    assert inputs.parameter("Sdr", {"Sdr": 4.561e-7}) == "0.00004561 %"
    assert inputs.parameter("Vmp", {"Vmp": 1.196e-10}) == "0.0001196 ml/m²"


def test_a_rigid_body_has_no_strength_to_give() -> None:
    rigid = {row.key: row.text for row in rows_of(inputs.BODY, RIGID)}
    assert {rigid[key] for key in ("poisson", "yield_strength", "hardness")} == {"–"}


def test_every_cause_of_an_interval_is_named() -> None:
    # The rim takes 0.05 % from a nearly full contact: too little for whole per cent.
    heights = np.random.default_rng(2).normal(scale=1e-9, size=(48, 48))
    result = rc.solve(
        rc.Surface(heights, (1e-6, 1e-6)),
        load=2.0,
        material=rc.Material(210e9, 0.3),
        ceiling=None,
        boundary="periodic",
    )
    (row,) = (row for row in uncertainty.uncertainty_rows(result) if row[0] == "real contact")
    assert " to " in row[1]
    assert "spot perimeter below 0.1 %" in row[2]
