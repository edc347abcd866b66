"""A kind of result is one row: all that shows results asks it, and nothing else is touched."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.solve import report as surface, task as solve
from roughcontact.analyses.tasks import PRESENTATIONS
from roughcontact.cautions import Caution, CautionTag as CautionKind, as_caution
from roughcontact.cli import console
from roughcontact.cli.terminal import DisplayOptions
from roughcontact.references import make_use
from roughcontact.report.figures import Illustration
from roughcontact.report.kind import PROBLEM, CellTable, Column, Quantity, Use
from roughcontact.report.presentation import Presentation, presentation_of
from roughcontact.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Capture = pytest.CaptureFixture[str]


@dataclass(frozen=True, repr=False, eq=False)
class Squeak:
    """Step of a result."""

    pitch: float


@dataclass(frozen=True, repr=False, eq=False)
class Squeaking(Result):
    """How a contact squeaks."""

    largest: rc.ContactResult
    steps: tuple[Squeak, ...]

    @property
    def cautions(self) -> tuple[Caution, ...]:
        return (as_caution(CautionKind.EDGE, "It squeaks at the edge.", share=0.5),)


def pitches(found: Squeaking, colour: str = "k") -> Figure:
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().plot([step.pitch for step in found.steps], color=colour)
    return figure


class SqueakingPresentation(Presentation):
    table = (
        Quantity("grease", "grease", of=lambda _: "none", part=PROBLEM),
        Quantity("loudest", "loudest pitch [Hz]", of=lambda found: found.steps[-1].pitch),
    )
    columns = (Column("pitch", "pitch [Hz]"),)
    is_listed = True
    figures = (Illustration("pitches", pitches, "Pitch over the step."),)
    plots = (pitches,)
    contact_name = "largest"

    def question(self) -> str:
        return "How does it squeak?"

    def answer(self) -> str:
        return f"It squeaks at {self.result.steps[-1].pitch:g} Hz."

    def numbers(self) -> CellTable:
        return (), [("loudest pitch", f"{self.result.steps[-1].pitch:g} Hz")]

    def sentences(self) -> tuple[str, ...]:
        return ("A sentence about squeaks.",)

    def works(self) -> tuple[Use, ...]:
        return (make_use("squeaks", "Johnson1985"),)


@pytest.fixture
def squeaking(monkeypatch: pytest.MonkeyPatch) -> Squeaking:
    monkeypatch.setattr(surface, "Squeaking", SqueakingPresentation, raising=False)
    monkeypatch.setitem(PRESENTATIONS, "Squeaking", "analyses.solve.report:Squeaking")
    heights, pixel = rc.reference_map(32)
    steel = rc.Material(210e9, 0.3, 1e9)
    result = rc.solve(rc.Surface(heights, pixel), material=steel, load=0.1)
    return Squeaking(result, (Squeak(440.0), Squeak(880.0)))


def test_a_session_shows_a_new_kind(squeaking: Squeaking) -> None:
    text = repr(squeaking)
    assert text.splitlines()[1].strip() == "It squeaks at 880 Hz."
    assert "loudest pitch  880 Hz" in text
    assert "CAUTION edge: It squeaks" in text
    assert "data:image/png" in squeaking._repr_html_()
    assert squeaking.warnings == ("It squeaks at the edge.",)


def test_the_console_shows_it(squeaking: Squeaking, capsys: Capture) -> None:
    outcome: Any = SimpleNamespace(
        result=squeaking,
        request=SimpleNamespace(task=solve.TASK),
        written=(Path("a.json"),),
        extra_results={},
    )
    console.print_outcome(outcome, DisplayOptions.VERBOSE)
    shown = " ".join(capsys.readouterr().out.split())
    for item in ("loudest pitch 880 Hz", "440 Hz", "A sentence about squeaks.", "a.json"):
        assert item in shown
    assert "CAUTION edge: It squeaks" in shown


def test_quantities_of_new_kind_are_saved(squeaking: Squeaking, tmp_path: Path) -> None:
    summary = squeaking.summary()
    assert (summary["loudest"], summary["pitch"]) == (880.0, [440.0, 880.0])
    for name in ("out.json", "out.csv"):
        squeaking.save(tmp_path / name)
    assert json.loads((tmp_path / "out.json").read_text(encoding="utf-8")) == summary
    assert (tmp_path / "out.csv").read_text(encoding="utf-8") == "pitch [Hz]\n440.0\n880.0\n"
    with pytest.raises(rc.InputError, match="csv"):
        squeaking.save(tmp_path / "out.nc")
    frame = squeaking.to_pandas()
    assert (frame.to_dict("list"), frame.attrs) == (
        {"pitch": [440.0, 880.0]},
        {"units": {"pitch": "Hz"}},
    )
    with pytest.raises(rc.InputError, match=r"Squeaking has no NetCDF form: use to_pandas\(\)"):
        squeaking.to_xarray()
    frame = squeaking.largest.to_pandas()
    assert frame.shape[0] == 1
    assert frame["load"][0] == squeaking.largest.load
    assert frame.attrs["units"]["load"] == "N"


@pytest.mark.long
def test_new_kind_is_drawn_cited_and_reported(squeaking: Squeaking, tmp_path: Path) -> None:
    assert dir(squeaking.plot) == ["pitches"]
    assert squeaking.plot.pitches(colour="r").axes
    assert list(presentation_of(squeaking).drawings()) == ["pitches"]
    cites = dict(squeaking.references().uses)
    assert "squeaks" in cites
    assert "solver" in cites
    squeaking.report(tmp_path / "out.html")
    text = (tmp_path / "out.html").read_text(encoding="utf-8")
    for item in (
        "How does it squeak?",
        "Pitch over the step.",
        "880 Hz",
        "A sentence about squeaks.",
    ):
        assert item in text


def test_a_kind_without_a_question_has_no_report(
    squeaking: Squeaking, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(SqueakingPresentation, "question", lambda _: "")
    with pytest.raises(rc.InputError, match="no report on a Squeaking alone"):
        squeaking.report(tmp_path / "out.html")


@pytest.mark.long
def test_dataset_matches_netcdf_file(tmp_path: Path) -> None:
    import xarray

    steel = rc.Material(210e9, 0.3, hardening=rc.hardening.Linear("1 GPa", "20 GPa"))
    flat = rc.Surface(np.zeros((8, 24)), (8e-6, 8e-6))
    roller = rc.cylinder("1.5 mm", angle=90)
    rolled = rc.roll(
        flat,
        counter_surface=roller,
        material=steel,
        load=5.0,
        passes=1,
        steps=3,
        boundary="periodic",
    )
    assert rolled.axis == 90.0
    contact = rolled.result.solution
    for result in (contact, rolled.result, rolled, rc.subsurface_stress(contact)):
        result.save(tmp_path / "out.nc")
        with xarray.open_dataset(tmp_path / "out.nc") as saved:
            dataset = result.to_xarray()
            assert dataset.equals(saved), type(result).__name__
            assert dataset.attrs.keys() == saved.attrs.keys() - {"checksum_sha256"}
    frame = rolled.to_pandas()
    assert len(frame) == 1
    assert frame.attrs["units"].keys() == set(frame)
