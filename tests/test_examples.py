"""Every example of the documentation runs, and its main number is what its page says."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

GALLERY = Path(__file__).parents[1] / "docs" / "gallery"

# Example, points per side here, main number, its value and how near it has to be. Grids are small,
# so that numbers differ from those of the pages; each tolerance is what a pixel makes of it.
NUMBERS: dict[str, tuple[int, str, float, float]] = {
    # W = 1 N under 3 GPa needs 3.33 % of the map.
    "01_first_contact": (64, "area_under_ceiling", 1 / 30, 1e-9),
    # Hertz away from the rim, of the peak pressure.
    "02_hertz": (64, "pressure_error", 0.0, 0.005),
    # Westergaard: to a pixel at either rim.
    "03_wavy": (64, "width_error", 0.0, 2 / 64),
    # All elastic spots lie inside the contact with the ceiling.
    "04_source_paper": (256, "inside", 1.0, 0.01),
    # κ of boundary elements, 1.8 to 2.3 (Hyun et al. 2004), and the scatter of one small map.
    "05_load_curve": (128, "kappa", 2.1, 0.5),
    "06_trust": (128, "steady", 0.0, 0.0),
    # The radius of a rough ball that was measured badly.
    "07_preparation": (128, "radius_error", 0.0, 0.02),
    # Crossed cylinders are a ball to Hertz: half a pixel of the radius.
    "08_two_bodies": (128, "radius_error", 0.0, 0.04),
    # At an index of 100 nearly all of the contact is saturated.
    "09_ceiling": (64, "steep", 1.0, 0.15),
    # Johnson 1985, sec. 4.2: largest von Mises stress below a ball over the peak pressure, ν = 0.3.
    "10_stress": (64, "ratio", 0.62, 0.01),
    # Rolling along runs in.
    "11_history": (64, "last_share", 0.3, 0.25),
    # Kogut and Etsion 2002; the area of a contact of five pixels in radius is rough.
    "12_volume": (20, "plateau", 2.2, 0.25),
    # Line Hertz: 32 pixels across the contact, of second order.
    "13_roller": (64, "peak_error", 0.0, 1e-3),
    # The peaks that stood out go on the first pass; a third to a half of Spk is left.
    "14_running_in": (64, "spk_left", 0.4, 0.15),
    # Mindlin and Deresiewicz 1953; the stick zone is 20 pixels in radius.
    # All six at full size; on a grid this coarse one may miss.
    "17_instruments": (256, "held_share", 1.0, 0.2),
    # By quadrature of axisymmetric waves, 0.496; 0.62 of bare steel.
    "16_coating": (64, "one", 0.496, 0.01),
    "15_fretting": (64, "energy_error", 0.0, 2e-3),
}


def run(name: str, points: int, monkeypatch: pytest.MonkeyPatch, folder: Path) -> dict[str, Any]:
    """Run an example on a small grid, without a screen."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    monkeypatch.chdir(folder)
    script = GALLERY / f"plot_{name}.py"
    text, count = re.subn(
        r"^POINTS = \d+$", f"POINTS = {points}", script.read_text("utf-8"), flags=re.MULTILINE
    )
    assert count == 1, "an example says its number of points once"
    small = folder / script.name
    small.write_text(text, encoding="utf-8")
    backend = mpl.get_backend()
    plt.switch_backend("Agg")
    try:
        return runpy.run_path(str(small))
    finally:
        plt.close("all")
        plt.switch_backend(backend)


# Many contacts with plasticity of the volume, whatever the grid; many maps.
MARKS = {
    **dict.fromkeys(("12_volume", "14_running_in", "17_instruments"), pytest.mark.slow),
    **dict.fromkeys(("04_source_paper", "09_ceiling", "11_history"), pytest.mark.long),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[MARKS[name]] if name in MARKS else []) for name in NUMBERS],
)
def test_main_number(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    points, what, value, tolerance = NUMBERS[name]
    found = run(name, points, monkeypatch, tmp_path)[what]
    if name == "06_trust":
        # The elastic area of a surface that is rough down to the pixel depends on the pixel.
        assert list(found.values()) == [True, False, True]
    else:
        assert found == pytest.approx(value, abs=tolerance)


def test_every_example_is_checked() -> None:
    assert {path.stem.removeprefix("plot_") for path in GALLERY.glob("*.py")} == set(NUMBERS)
