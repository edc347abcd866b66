"""Commands of how-to pages that this suite runs; `docs/commands.py` runs all of them."""

from __future__ import annotations

import re
import runpy
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.halfspace import convolution

HOWTO = ROOT / "docs" / "howto"


def commands(page: str) -> list[list[str]]:
    """Return the commands whose output a page shows."""
    text = (HOWTO / page).read_text(encoding="utf-8")
    found = re.findall(r"^\$ roughcontact ((?:.*\\\n)*.*)$", text, re.MULTILINE)
    return [shlex.split(line.replace("\\\n", " ")) for line in found]


@pytest.fixture
def raceway(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Write the map of the page as the documentation does, with fewer points."""
    monkeypatch.chdir(tmp_path)
    maps: dict[str, Any] = runpy.run_path(str(HOWTO / "maps.py"))
    maps["save"](Path("raceway.sdf"), maps["raceway"]((128, 80), 4e-6), 4e-6)


@pytest.mark.long
@pytest.mark.usefixtures("raceway")
def test_the_recipe_of_the_roller_runs(capsys: pytest.CaptureFixture[str]) -> None:
    solve, sweep = commands("roller.md")
    assert app.main([*solve, "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "Hertz's peak pressure: 1.5 GPa of the smooth bodies (line), under 78.41 N" in shown
    assert "half-width 104 µm" in shown.lower()
    result = rc.read_result("raceway.nc")
    # π R p²/E* on 0.32 mm, R = 4 mm of both cylinders.
    assert result.load == pytest.approx(78.41, abs=0.01)
    assert result.max_pressure > 1.5e9
    assert app.main([*sweep, "--verbose"]) == app.SOLVED
    assert "Hertz's peak pressure 500 MPa (8.71" in " ".join(capsys.readouterr().out.split())


def test_pages_writing_into_maps_name_script_of_folder() -> None:
    pages = [HOWTO.parent / "tutorial.md", HOWTO.parent / "others.md", *HOWTO.glob("*.md")]
    writing = [text for page in pages if " maps/" in (text := page.read_text(encoding="utf-8"))]
    assert len(writing) >= 6
    for text in writing:
        before = text.partition(" maps/")[0]
        assert "python docs/howto/maps.py" in before
        assert "folder `maps`" in before


@pytest.mark.long
def test_the_example_of_another_program_runs_here() -> None:
    text = (HOWTO.parent / "others.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, Any] = {}
    exec(script, names)
    result = names["result"]
    # The table's displacement is that of the half-space under the pressure.
    (displacement,) = re.findall(r"not kept: `(.*?)`", text)
    names["heights"] = result.surface.heights
    applied = convolution.periodic((256, 256), (1 / 256, 1 / 256), 1.0)(result.pressure)
    assert eval(displacement, names) == pytest.approx(applied, abs=1e-9 * np.ptp(applied))
    # Hyun et al. 2004: 1.8 to 2.3 times the pressure over E* h', of pixels a little more.
    assert 0.18 < result.contact_fraction < 0.23
    assert result.pressure.mean() == pytest.approx(0.1)
    assert CautionTag.UNITS in {caution.kind for caution in result.cautions}
