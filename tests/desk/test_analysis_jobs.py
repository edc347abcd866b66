"""Jobs of the page: analyses with their figures, and the comparison of two contacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc

pytest.importorskip("panel")

from roughcontact.analyses.solve.fields import CONTACT
from roughcontact.analyses.tasks import from_text
from roughcontact.desk import analysis_jobs
from roughcontact.report.kind import quantity_of

GIVEN = {"material": "100Cr6", "boundary": "periodic"}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    heights = np.random.default_rng(1).normal(0, 40e-9, (16, 24))
    path = tmp_path_factory.mktemp("maps") / "map.npz"
    rc.Surface(heights, (2e-6, 1e-6)).save(path)
    return path


def ignore(_: object) -> None:
    """Ignore a progress message."""


@pytest.mark.long
@pytest.mark.parametrize("over_pressure", [False, True])
def test_load_curve_is_drawn_over_the_chosen_quantity(
    path: Path, over_pressure: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = []

    def read_axis(figure: object) -> bytes:
        axes.append(figure.axes[0])
        return b""

    monkeypatch.setattr(analysis_jobs.export, "png", read_axis)
    request = from_text("sweep", path, {**GIVEN, "from": "1 MPa", "to": "10 MPa", "steps": "2"})
    outcome = analysis_jobs.run_analysis(ignore, request, over_pressure)
    assert outcome.figures == (b"",)
    name, unit = ("nominal pressure", "MPa") if over_pressure else ("load", "mN")
    assert axes[0].get_xlabel() == f"{name} [{unit}]"
    (contact,) = (line for line in axes[0].lines if line.get_label() == "contact")
    largest = 10.0 if over_pressure else 10e6 * 32e-6 * 24e-6 * 1e3
    assert contact.get_xdata().max() == pytest.approx(largest, rel=1e-3)


@pytest.mark.long
def test_comparison_has_differences_and_a_figure(path: Path) -> None:
    requests = [from_text("solve", path, {**GIVEN, "load": load}) for load in ("10 MPa", "20 MPa")]
    found = analysis_jobs.compare_contacts(ignore, *requests, ("A", "B"))
    assert found.figure.startswith(b"\x89PNG")
    assert "−50.0 %" in [row[3] for row in found.rows]
    assert len(found.cautions) == 2


def test_change_of_a_text_is_empty(path: Path) -> None:
    surface = rc.read_surface(path)
    first, second = (
        rc.solve(surface, load=load, material=rc.Material(210e9, 0.3)) for load in (1.0, 2.0)
    )
    changes = {
        key: analysis_jobs._quantity_change(quantity_of(CONTACT, key), first, second)
        for key in ("load", "status")
    }
    assert changes == {"load": "−50.0 %", "status": ""}
