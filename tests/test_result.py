"""The display of an object in a session: some ten lines, a picture, its figures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import plots

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)


def surface() -> rc.Surface:
    heights = rc.self_affine(
        (24, 36), 1e-6, rms_height=1e-7, rolloff_wavelength=12e-6, cutoff_wavelength=3e-6, rng=2
    )
    return rc.Surface(heights, (1e-6, 1e-6), rc.Provenance("<ground>.opd"))


@pytest.fixture(scope="module")
def objects() -> dict[str, Any]:
    rough = surface()
    result = rc.solve(rough, material=STEEL, load=1e-2)
    return {
        "Surface": rough,
        "ContactResult": result,
        "LoadCurve": rc.sweep(rough, material=STEEL, loads=np.geomspace(1e-4, 1e-2, 12)),
        "LoadHistory": rc.history(rough, ["10 mN", "0 N"], material=STEEL),
        "StressResult": rc.subsurface_stress(result),
        "LoadSearch": rc.find_load(rough, material=STEEL, contact_fraction=[0.05]),
    }


KINDS = ("Surface", "ContactResult", "LoadCurve", "LoadHistory", "StressResult", "LoadSearch")


@pytest.mark.parametrize("kind", KINDS)
def test_repr_is_short(kind: str, objects: dict[str, Any]) -> None:
    lines = repr(objects[kind]).splitlines()
    assert lines[0].partition(":")[0] == kind
    assert 2 <= len(lines) <= 20
    assert max(map(len, lines)) < 120
    assert "array" not in repr(objects[kind])


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_html_repr_matches_repr_with_figure(kind: str, objects: dict[str, Any]) -> None:
    shown = objects[kind]._repr_html_()
    lines = [line.strip() for line in repr(objects[kind]).splitlines()[1:]]
    for line in lines:
        for cell in line.split("  "):
            assert cell.strip().replace("<", "&lt;").replace(">", "&gt;") in shown
    assert ("data:image/png;base64," in shown) == (kind != "LoadSearch")
    # The name of a file is no markup.
    assert "<ground>" not in shown


def test_a_leak_rate_names_the_arguments_that_scale_it(objects: dict[str, Any]) -> None:
    leak = rc.leakage(objects["ContactResult"], viscosity="1 mPa s", pressure_difference="1 bar")
    assert "of the land: seal_width, seal_length" in repr(leak)
    assert "--" not in repr(leak)


def test_shares_have_no_exponent() -> None:
    rough = [rc.Surface(*rc.reference_map(32, seed)) for seed in range(3)]
    rougher = [rc.Surface(4.5 * one.heights, one.pixel) for one in rough]
    groups = {"a": rough, "b": rougher}
    shown = repr(rc.compare(groups, material=STEEL, pressure="50 MPa", steps=1))
    assert "+350 % (" in shown
    assert "e+0" not in shown


def test_repr_shows_warnings() -> None:
    # As if micrometres were metres.
    far_off = rc.Surface(1e6 * surface().heights, surface().pixel)
    result = rc.solve(far_off, material=rc.Material(210e9, 0.3), load=1.0)
    for shown in (repr(result), result._repr_html_()):
        assert "WARNING units: RMS slope" in shown


def test_unconverged_result_is_marked(objects: dict[str, Any]) -> None:
    stopped = rc.solve(surface(), material=STEEL, load=1e-2, max_iterations=1, on_failure="return")
    assert repr(stopped).startswith("ContactResult, not converged:")
    assert "<b>ContactResult, not converged</b>" in stopped._repr_html_()


def test_the_figures_of_an_object_are_its_methods(objects: dict[str, Any]) -> None:
    result = objects["ContactResult"]
    assert set(dir(result.plot)) >= {"pressure", "contact", "gap", "section", "spots", "overview"}
    assert result.plot.pressure.__doc__ == plots.pressure.__doc__
    title = result.plot.pressure(limit=1e9).axes[0].get_title()
    assert title == plots.pressure(result, limit=1e9).axes[0].get_title()
    assert len(result.plot().axes) == len(plots.overview(result).axes)
    assert dir(objects["Surface"].plot) == ["bearing_curve", "surface"]
    assert "plot.stress_depth()" in repr(objects["StressResult"].plot)
    with pytest.raises(AttributeError, match="no figure 'colour', only surface"):
        objects["Surface"].plot.colour()
    with pytest.raises(AttributeError, match="LoadSearch has no figures"):
        _ = objects["LoadSearch"].plot


@pytest.mark.long
def test_profile_is_shown_as_profile() -> None:
    trace = rc.Surface(1e-7 * np.sin(np.arange(200) / 9), 2e-6)
    result = rc.solve(trace, material=STEEL, load="10 N/m")
    assert "200 of a profile" in repr(trace)
    assert "Real contact length" in repr(result)
    assert dir(trace.plot) == ["heights"]
    assert dir(rc.subsurface_stress(result).plot) == ["stress_depth", "stress_section"]
    for shown in (trace, result):
        assert "data:image/png" in shown._repr_html_()


def test_public_modules_are_lazy_and_listed() -> None:
    code = (
        "import sys, roughcontact as rc; listed = dir(rc); "
        "assert {'catalog', 'hardness', 'theory', 'plots'} <= set(listed), listed; "
        "assert 'roughcontact.theory.hertz' not in sys.modules; "
        "assert {'hertz', 'persson'} <= set(dir(rc.theory)); "
        "rc.theory.hertz.contact_radius, rc.catalog.entries, rc.hardness"
    )
    about = {"PYTHONPATH": str(Path(rc.__file__).parents[1])}
    subprocess.run([sys.executable, "-c", code], check=True, env=about)
