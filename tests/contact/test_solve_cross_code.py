"""The stored answers of other programs, to the last digit that their own residual allows."""

import indentation
import numpy as np
import passage
import problems
import pytest
import tangential_with_tamaas as pushed

import broken
import cross_code
import roughcontact as rc
from roughcontact.halfspace import convolution

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def rows():
    return cross_code.compare()


def row_keys(rows):
    return [(row.peer, row.settings, row.problem) for row in rows]


def test_all_solvable_problems_of_each_program_are_stored(rows):
    tight = {(row.peer, row.problem) for row in rows if row.settings == "tight"}
    elastic = {name for name in problems.NAMES if "ceiling" not in name and "x" not in name}
    assert tight == {
        *(("contactmechanics", name) for name in problems.NAMES),
        *(("tamaas", name) for name in problems.NAMES),
        *(("aspher", name) for name in elastic),
    }


def test_programs_agree_as_far_as_their_certificates_reach(rows):
    # Measured: 0.4 to 2.5 times what the three numbers add up to. Peers reach 1e-10 elastic, and
    # 1e-8 under a ceiling.
    tight = [row for row in rows if row.settings == "tight"]
    assert row_keys(
        row for row in tight if row.certificate > 2e-8 or row.load_error > 2e-8
    ) == row_keys([])
    assert row_keys(row for row in tight if row.own > 1.1e-10) == row_keys([])
    far = [
        row
        for row in tight
        if max(row.difference, row.peak) > 4 * (row.certificate + row.own + row.load_error)
    ]
    assert row_keys(far) == row_keys([])
    # Pixel by pixel the same contact; another machine's rounding may move one at its rim.
    assert row_keys(row for row in tight if row.contact > 1 or row.saturated > 1) == row_keys([])


def test_certificate_matches_error_at_other_settings(rows):
    other = {(row.peer, row.problem): row for row in rows if row.settings != "tight"}
    # Loose, but right to what the certificate says.
    for key in (
        ("contactmechanics", "rough-128"),
        ("contactmechanics", "rough-128-periodic"),
        ("aspher", "rough-256"),
    ):
        row = other[key]
        assert 1e-6 < row.certificate < 1e-3
        assert 0.3 < row.difference / row.certificate < 3
    # Wrong: the mean pressure everywhere.
    wrong = other["tamaas", "rough-64-ceiling"]
    assert wrong.certificate > 1
    assert wrong.difference > 0.9
    assert wrong.contact > 10 * wrong.touching
    assert other["tamaas", "rough-64"].certificate < 1e-9


def test_the_comparison_would_see_a_wrong_kernel(monkeypatch):
    true = convolution.free
    broken.replace_free(
        monkeypatch,
        lambda shape, pixel, modulus, **o: true(shape, pixel, modulus * (1 + 1e-6), **o),
    )
    stored = problems.load("aspher")[1]["tight", "rough-64"]
    row = cross_code.row_of("aspher", "tight", "rough-64", stored, cross_code.solve("rough-64"))
    assert row.difference > 100 * (row.certificate + row.load_error)


def test_page_contains_the_groups_of_rows(rows):
    text = cross_code.PAGE.read_text(encoding="utf-8")
    for name, group in cross_code.group_rows(rows).items():
        assert f"| {' | '.join(name)} | {len(group)} |" in text
    for grid in indentation.GRIDS:
        assert f"| tamaas | {grid} | {len(indentation.LOADS)} |" in text
    assert f"| tamaas | {len(passage.PLACES)} |" in text


def test_finite_elements_of_rough_block_approach_the_half_space() -> None:
    rows = {(row.program, row.points): row for row in cross_code.compare_block()}
    finest = rows["roughcontact", 64]
    for program in ("contactmechanics", "tamaas"):
        other = rows[program, 64]
        np.testing.assert_allclose(other.pressure, finest.pressure, rtol=0, atol=1e-7 * 26e9)
        assert other.mean_gap == pytest.approx(finest.mean_gap, rel=1e-7)
        assert other.stiffness == pytest.approx(finest.stiffness, rel=1e-5)
    # Elements of the first order: their error decreases with the grid.
    apart = [
        abs(rows["calculix", points].mean_gap / rows["roughcontact", points].mean_gap - 1)
        for points in (32, 64)
    ]
    assert apart[1] < 0.6 * apart[0] < 0.006
    assert rows["calculix", 64].stiffness == pytest.approx(finest.stiffness, rel=0.02)
    assert rows["calculix", 64].share == pytest.approx(finest.share, rel=0.05)


@pytest.mark.slow
def test_indentation_of_a_hardening_half_space() -> None:
    rows = cross_code.compare_indentations(("sphere-64",))
    assert [row.load for row in rows] == list(indentation.LOADS)
    for row in rows:
        # Tolerance of two discretizations at 5 to 9 points in a contact radius; measured 0.4
        # to 0.8 % and, in order, 0.62, 0.20, 0.01, 0.07, 0.12 %.
        assert row.pressure < 0.015
        assert row.strain < 0.01
        assert row.peak < 0.01
        assert row.contact == 0
        assert row.residual <= cross_code.STRAIN_TOLERANCE
    # Fields are compared at a node and over a layer: most where the zone is two layers thick.
    assert rows[0].field < 0.05
    assert max(row.field for row in rows[1:]) < 0.02
    assert max(row.profile for row in rows) < 0.025


@pytest.mark.slow
def test_passage_over_a_hardening_half_space() -> None:
    rows, field = cross_code.compare_passage()
    assert [row.place for row in rows] == list(passage.PLACES)
    for row in rows:
        assert row.pressure < 0.015
        assert row.strain < 0.01
        assert row.contact == 0
        assert row.residual <= cross_code.STRAIN_TOLERANCE
    # Of a value at a node and the average over the layer around it.
    assert field < 0.03


def test_tamaas_finds_the_same_partial_slip() -> None:
    problem = problems.PROBLEMS[pushed.PROBLEM]
    body = rc.Material(young=problems.MODULUS * (1 - pushed.POISSON**2), poisson=pushed.POISSON)
    contact = rc.solve(
        rc.Surface(problem.heights, problem.pixel),
        material=body,
        ceiling=None,
        load=problem.load,
        boundary="periodic",
        tolerance=1e-10,
    )
    force = pushed.PART * pushed.FRICTION * problem.load
    # Their first axis runs along the rows downwards.
    found = rc.tangential(
        contact, friction=pushed.FRICTION, force=force, direction=-90.0, tolerance=1e-10
    )
    with np.load(pushed.STORED) as stored:
        index, (along_y, along_x, pressure), shift = (
            stored[name] for name in ("index", "traction", "shift")
        )
    np.testing.assert_array_equal(np.flatnonzero(contact.pressure), index)
    np.testing.assert_allclose(contact.pressure.flat[index], pressure, atol=1e-9 * pressure.max())
    theirs, ours = np.stack([along_y, along_x]), found.traction.reshape(2, -1)[:, index]
    stick = np.hypot(*theirs) < pushed.FRICTION * pressure * (1 - 1e-6)
    np.testing.assert_array_equal(found.stick.flat[index], stick)
    assert found.last.shift == pytest.approx(shift[0], rel=1e-5)
    # K_xy of the shortest waves along y or x is odd there: 0 here, not in Tamaas.
    assert np.linalg.norm(ours - theirs) / np.linalg.norm(theirs) < 4e-3
