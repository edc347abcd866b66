"""Every example of the documentation runs on a small grid, and its own assertions hold."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from paths import ROOT

GALLERY = ROOT / "docs" / "gallery"

# Points per side here. Each example asserts its main number, to what a pixel makes of it.
POINTS = {
    "01_first_contact": 64,
    "02_hertz": 64,
    "03_wavy": 64,
    "04_source_paper": 256,
    "05_load_curve": 128,
    "06_trust": 64,
    "07_preparation": 128,
    "08_two_bodies": 128,
    "09_ceiling": 48,
    "10_stress": 48,
    "11_history": 48,
    "12_volume": 20,
    "13_roller": 64,
    "14_running_in": 64,
    "15_fretting": 64,
    "16_coating": 40,
    "17_instruments": 256,
    "18_wear": 64,
}

# Many contacts with plasticity of the volume, for any grid; many maps.
SLOW = ("12_volume", "14_running_in", "17_instruments")


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in POINTS]
)
def test_example_runs_without_display(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    script = GALLERY / f"plot_{name}.py"
    text, count = re.subn(
        r"^POINTS = \d+$", f"POINTS = {POINTS[name]}", script.read_text("utf-8"), flags=re.MULTILINE
    )
    assert count == 1, "an example says its number of points once"
    small = tmp_path / script.name
    small.write_text(text, encoding="utf-8")
    backend = mpl.get_backend()
    plt.switch_backend("Agg")
    try:
        runpy.run_path(str(small))
    finally:
        plt.close("all")
        plt.switch_backend(backend)


def test_every_example_is_run_and_asserts_its_number() -> None:
    scripts = {path.stem.removeprefix("plot_"): path for path in GALLERY.glob("*.py")}
    assert set(scripts) == set(POINTS)
    for name, path in scripts.items():
        assert re.search(r"^assert ", path.read_text("utf-8"), re.MULTILINE), name
