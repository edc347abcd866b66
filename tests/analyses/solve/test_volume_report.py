"""The report on the volume model says what the result says."""

import dataclasses
import datetime
import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cautions import Caution, CautionTag, Severity
from roughcontact.drawing import elastoplastic as volume_plots
from roughcontact.errors import InputError
from roughcontact.material.hardening import Kinematic, Linear, Perfect, Tabulated
from roughcontact.report import assumptions, phrases
from roughcontact.report.page import Edition
from roughcontact.report.presentation import presentation_of
from roughcontact.units import format_engineering, format_percent

DAY = datetime.date(2024, 2, 29)


def words(text: str) -> str:
    """Return the text of a page without its tags."""
    body = text[text.index("<body>") :]
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", body)).split())


def with_material(result: Any, **changes: Any) -> Any:
    """Return a result whose body is said to be of another material."""
    body = result.bodies[0]
    material = dataclasses.replace(body.material, hardening=None, **changes)
    pair = dataclasses.replace(result.contact.pair, material=material)
    contact = dataclasses.replace(result.contact, pair=pair)
    bodies = (dataclasses.replace(body, material=material),)
    return dataclasses.replace(result, solution=contact, bodies=bodies)


def report_text(result: Any) -> str:
    """Return the text of a report."""
    return words(presentation_of(result).render(Edition(date=DAY)))


@pytest.mark.usefixtures("quick")
def test_question_first_then_sections_in_the_order_of_the_other_report(loaded) -> None:
    text = presentation_of(loaded).render(Edition(date=DAY))
    page = words(text)
    assert page.startswith("How deep does ball.nc yield under 350 mN?")
    contact = loaded.contact
    front = page[: page.index("Warnings and cautions")]
    for value in (
        format_engineering(contact.max_pressure, "Pa", 3),
        phrases.format_share(contact.contact_fraction),
        format_percent(loaded.max_plastic_strain),
        format_engineering(loaded.plastic_depth, "m", 3),
        format_engineering(contact.approach, "m", 3),
    ):
        assert value in front
    assert phrases.volume_regime(loaded) in front
    assert loaded.regime in page
    titles = re.findall(r'<h2 id="chapter-\d+">\d+ ([^<]+)</h2>', text)
    assert titles == [
        "Input",
        "Results",
        "Assumptions",
        "Method and certificate",
        "How to repeat",
        "References",
    ]
    assert "Swift hardening, 1.24 GPa (30 + 1e6 e)^0.085" in page
    assert "0 N → 350 mN" in page
    assert "ceiling" not in page
    for step in loaded.increments:
        assert format_engineering(step.approach, "m") in page
        assert f"{step.residual:.1e}" in page
    assert f"{loaded.contact.certificate:.1e}" in page
    for row in assumptions.assumption_rows(presentation_of(loaded).case()):
        assert " ".join(row) in page
    assert "Checked: convergence, stress against" in page
    assert "Hardening Swift hardening, 1.24 GPa (30 + 1e6 e)^0.085 rigid" in page


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_the_area_keeps_the_perimeter_that_has_yielded(loaded) -> None:
    corrected, all_elastic = (
        loaded.perimeter_corrected_area,
        loaded.contact.perimeter_corrected_area,
    )
    assert corrected > 1.001 * all_elastic
    page = report_text(loaded)
    assert f"Perimeter-corrected area {format_engineering(corrected, 'm²')}" in page


@pytest.mark.usefixtures("quick")
def test_unloaded_report_shows_residual_indentation(released) -> None:
    page = report_text(released)
    assert page.startswith("Which indentation does a load of 350 mN leave on ball.nc?")
    dent = format_engineering(float(released.residual_displacement.max()), "m", 3)
    assert f"an indentation remains of up to {dent}" in page
    assert "0 N → 350 mN → 0 N" in page
    stress = float(released.bodies[0].residual_von_mises.max())
    assert stress > 0
    assert "Residual displacement" in page
    assert "Largest von Mises stress under load" not in page
    assert "Contact spots" not in page
    assert "This was the largest load; the body is now unloaded" in page


@pytest.mark.slow
def test_unloaded_the_pressure_is_that_of_the_largest_load(loaded, released, tmp_path) -> None:
    np.testing.assert_array_equal(released.largest_pressure, loaded.solution.pressure)
    assert loaded.largest_pressure is None
    path = tmp_path / "released.nc"
    released.save(path)
    for result in (released, rc.read_result(path)):
        drawings = presentation_of(result).drawings()
        (axes,) = (axes for axes in drawings["pressure"]().axes if axes.images)
        assert "at 350 mN, largest" in axes.get_title()
        drawn = axes.images[0].get_array()
        assert drawn.max() == pytest.approx(loaded.solution.max_pressure / 1e9)
        assert drawings["histogram"]().axes[0].patches[0].get_data().values.max() > 0
    # In one run, too, and the end is the same.
    surface, material = loaded.solution.surface, loaded.solution.material
    loads = [0.1, 0.2, 0.35]
    end = rc.solve_elastoplastic(surface, material=material, increments=1, loads=[*loads, 0.0])
    np.testing.assert_array_equal(end.largest_pressure, loaded.solution.pressure)
    np.testing.assert_array_equal(end.residual_displacement, released.residual_displacement)


@pytest.mark.long
def test_report_is_self_contained(loaded, tmp_path: Path) -> None:
    path = tmp_path / "out.html"
    loaded.report(path, "roughcontact solve <b>")
    text = path.read_text(encoding="utf-8")
    assert "roughcontact solve &lt;b&gt;" in text
    sources = re.findall(r'src="([^"]{0,30})', text)
    assert len(sources) > 4
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "<script" not in text
    for name in ("out.txt", "nowhere/out.html"):
        with pytest.raises(InputError):
            loaded.report(tmp_path / name)


@pytest.mark.usefixtures("quick")
def test_failure_is_on_top(loaded) -> None:
    stopped = dataclasses.replace(loaded, status="stopped before 9 N: <why>")
    front = report_text(stopped).split("Key numbers")[0]
    assert "Not converged: stopped before 9 N: <why>. Do not use these numbers." in front


@pytest.mark.usefixtures("quick")
def test_unreached_first_load_gives_warning(unmoved) -> None:
    assert unmoved.increments == ()
    page = report_text(unmoved)
    assert page.startswith("How deep does ball.nc yield?")
    assert "Do not use these numbers" in page
    # There is no path of loads, and none to repeat.
    assert "solve_elastoplastic(" not in page


@pytest.mark.usefixtures("quick")
def test_strains_above_one_are_printed_in_percent(loaded) -> None:
    body = dataclasses.replace(loaded.bodies[0], accumulated=100 * loaded.bodies[0].accumulated)
    stretched = dataclasses.replace(loaded, bodies=(body,))
    strain = f"{100 * stretched.max_plastic_strain:.0f} %"
    assert stretched.max_plastic_strain > 1.005
    assert report_text(stretched).count(strain) >= 4
    assert strain in volume_plots.section(stretched).get_suptitle()


def cautions(result: Any) -> dict[str, Caution]:
    return {caution.kind: caution for caution in result.cautions}


def test_small_deformations_are_checked(loaded) -> None:
    assert not cautions(loaded)
    # By hand: r/R at the edge of a spot is √2 times the root mean square over a disc.
    table = assumptions.assumption_rows(presentation_of(loaded).case())
    (small,) = (case for name, case, _ in table if name == "Small strains")
    slope = re.search(r"slope under the contact ([\d.]+)", small)
    assert slope is not None
    radius = np.sqrt(loaded.contact.contact_area / np.pi)
    assert np.sqrt(2) * float(slope[1]) == pytest.approx(radius / 105e-6, rel=0.05)
    surface = loaded.contact.surface
    steep = dataclasses.replace(surface, heights=3 * surface.heights)
    pair = dataclasses.replace(loaded.contact.pair, surface=steep)
    contact = dataclasses.replace(loaded.contact, pair=pair)
    steeper = cautions(dataclasses.replace(loaded, solution=contact))[CautionTag.SLOPES]
    assert 0.1 < steeper.numbers["slope"] < 0.2
    body = loaded.bodies[0]
    strained = dataclasses.replace(body, accumulated=body.accumulated * 10)
    larger = cautions(dataclasses.replace(loaded, bodies=(strained,)))[CautionTag.STRAIN]
    assert 0.1 < larger.numbers["max_plastic_strain"] < 0.2


def test_perfect_plasticity_and_short_tables_give_cautions(loaded, released) -> None:
    result = cautions(with_material(loaded, yield_strength=1656e6))
    assert result[CautionTag.PIXEL_SCATTER].severity is Severity.NOTE
    assert CautionTag.PIXEL_SCATTER not in cautions(with_material(released, yield_strength=1656e6))
    body = loaded.bodies[0]
    for last, short in ((0.005, True), (0.5, False)):
        law = Tabulated((0.0, last), (1.6e9, 3e9))
        material = dataclasses.replace(body.material, hardening=law, yield_strength=None)
        changed = dataclasses.replace(body, material=material)
        result = cautions(dataclasses.replace(loaded, bodies=(changed,)))
        assert (CautionTag.HARDENING_RANGE in result) is short


def test_yield_on_unloading_gives_caution(loaded, released) -> None:
    weak = dict(yield_strength=400e6)
    assert CautionTag.RESIDUAL_YIELD in cautions(with_material(loaded, **weak))
    assert CautionTag.RESIDUAL_YIELD not in cautions(with_material(released, **weak))


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_two_bodies_have_a_table_each() -> None:
    y, x = np.mgrid[:16, :18] - np.array([8, 9])[:, None, None]
    surface = rc.Surface(-(y**2 + x**2) * (0.6e-6) ** 2 / 2e-4, (0.6e-6, 0.6e-6))
    brass = rc.Material(110e9, 0.34, hardening=Linear(1.2e9, 2e9))
    result = rc.solve_elastoplastic(
        surface,
        material=rc.Material(210e9, 0.3, 1.6e9),
        counter_material=brass,
        increments=1,
        loads=[0.2],
    )
    page = report_text(result)
    assert "Plastic strain and stress of the body" in page
    assert "Plastic strain and stress of the counter-body" in page
    assert "linear hardening, modulus 2 GPa" in page
    # A warning of the result is in the box of warnings.
    for note in result.warnings:
        assert note in page


@pytest.mark.parametrize(
    ("material", "words"),
    [
        (rc.Material(1e9, 0.3), "elastic"),
        (rc.Material(1e9, 0.3, 1e6), "perfectly plastic"),
        (rc.Material(1e9, 0.3, hardening=Linear(1e6, 2e6)), "linear hardening, modulus 2 MPa"),
        (
            rc.Material(1e9, 0.3, hardening=Tabulated((0.0, 0.1), (1e6, 2e6))),
            "tabulated hardening, 2 MPa from a strain of 0.1 on",
        ),
        (
            rc.Material(1e9, 0.3, hardening=Kinematic(Perfect(1e6), 3e6)),
            "kinematic hardening, modulus 3 MPa",
        ),
        (
            rc.Material(1e9, 0.3, hardening=Kinematic(Linear(1e6, 2e6), 3e6)),
            "linear hardening, modulus 2 MPa, and kinematic hardening, modulus 3 MPa",
        ),
    ],
)
def test_hardening_law_is_formatted_as_text(material: rc.Material, words: str) -> None:
    assert phrases.hardening(material) == words
