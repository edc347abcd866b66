"""The stored answers of other programs, to the last digit that their own residual allows."""

import problems
import pytest

import cross_code
import roughcontact as rc
from roughcontact import convolution


@pytest.fixture(scope="module")
def rows():
    return cross_code.compare()


def told(rows):
    return cross_code.table(rows)


def test_all_that_a_program_can_solve_is_there(rows):
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
    assert told(row for row in tight if row.certificate > 2e-8 or row.load_error > 2e-8) == told([])
    assert told(row for row in tight if row.own > 1.1e-10) == told([])
    far = [
        row
        for row in tight
        if max(row.difference, row.peak) > 4 * (row.certificate + row.own + row.load_error)
    ]
    assert told(far) == told([])
    # Pixel by pixel the same contact; another machine's rounding may move one at its rim.
    assert told(row for row in tight if row.contact > 1 or row.saturated > 1) == told([])


def test_the_certificate_tells_what_other_settings_leave(rows):
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
    monkeypatch.setitem(
        rc.contact._BOUNDARIES, "free",
        lambda shape, pixel, modulus, **o: true(shape, pixel, modulus * (1 + 1e-6), **o),
    )  # fmt: skip
    stored = problems.load("aspher")[1]["tight", "rough-64"]
    row = cross_code.row_of("aspher", "tight", "rough-64", stored, cross_code.solve("rough-64"))
    assert row.difference > 100 * (row.certificate + row.load_error)


def test_the_documentation_holds_every_row(rows):
    text = cross_code.PAGE.read_text(encoding="utf-8")
    for row in rows:
        assert f"| {row.peer} | {row.settings} | {row.problem} |" in text
