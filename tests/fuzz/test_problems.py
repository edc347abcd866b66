"""A small part of `tests/fuzz/random_problems.py`, and that it sees what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

import random_problems
import robustness
import roughcontact as rc
from broken import replace_free
from roughcontact.halfspace import convolution

BLOCK = 20


@pytest.mark.parametrize("first", range(0, 200, BLOCK))
def test_random_problems_are_certified_or_rejected(first):
    outcomes = [
        random_problems.attempt(random_problems.draw(seed, 48))
        for seed in range(first, first + BLOCK)
    ]
    good = (random_problems.CERTIFIED, random_problems.REFUSED, random_problems.ROUNDED)
    assert [str(outcome) for outcome in outcomes if outcome.verdict not in good] == []


# Seed and size of problems that were not solved once, or not rightly, and what was the matter.
FOUND = {
    "very narrow pixels near full contact: hardly anything resists what differs between two": [
        (375, 1024),
        (645, 300),
        (970, 300),
        (2641, 150),
        (3775, 150),
        (4638, 150),
    ],
    "a ceiling so low that the square of the pressure is no number": [(661, 300)],
    "a moment that is a staircase over the tilt": [(843, 300), (1913, 150), (1932, 150)],
    "a tilt too steep for its own digits": [(983, 300)],
    "a tilt so steep that judge and program round the gap differently": [(2878, 150)],
    "moments nearly at the capacity: a pixel deep in contact below its ceiling": [(950, 1024)],
    "a start on pixels that never touch": [(2687, 1024)],
}


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "largest"), [case for cases in FOUND.values() for case in cases])
def test_problems_that_once_failed(seed, largest):
    outcome = random_problems.attempt(random_problems.draw(seed, largest))
    assert outcome.verdict == random_problems.CERTIFIED, str(outcome)


# Of a tilt: the displacement was lost in the rounding of the gap, and divided by; or the last digit
# of the tilt was more than the displacement.
@pytest.mark.slow
@pytest.mark.parametrize(("seed", "largest"), [(1595, 150), (1544, 1024), (3675, 1024)])
def test_unreachable_digits_are_classified_as_rounding(seed, largest):
    outcome = random_problems.attempt(random_problems.draw(seed, largest))
    assert outcome.verdict == random_problems.ROUNDED, str(outcome)


def test_the_problems_are_of_all_kinds():
    cases = [random_problems.draw(seed, 48) for seed in range(160)]
    assert {case.kind for case in cases} == set(random_problems.KINDS)
    words = [case.words for case in cases]
    assert {word["boundary"] for word in words} == {"free", "periodic"}
    assert {word["control"] for word in words} == {"load", "approach"}
    for name in ("holes", "bodies", "precision", "tolerance", "start"):
        assert any(name in word for word in words)
    assert {case.expected for case in cases} == {None, rc.InputError, rc.CapacityError}
    ceilings = [case.options["ceiling"] for case in cases]
    assert {type(ceiling) for ceiling in ceilings} == {type(None), str, float, np.ndarray}
    assert any(np.isinf(c).any() for c in ceilings if isinstance(c, np.ndarray))
    aspects = [case.surface.pixel[0] / case.surface.pixel[1] for case in cases]
    assert min(aspects) == pytest.approx(1 / 20)
    assert max(aspects) == pytest.approx(20)
    # The same seed is the same problem.
    np.testing.assert_array_equal(
        cases[5].surface.heights, random_problems.draw(5, 48).surface.heights
    )


def solved_case():
    """A problem that is solved under a given load."""
    for seed in range(200):
        case = random_problems.draw(seed, 48)
        plain = case.words["boundary"] == "free" and case.options["ceiling"] is None
        large = case.kind == "self-affine" and case.surface.heights.size > 500
        if case.expected is None and plain and large and "load" in case.options:
            return case
    raise AssertionError("no such problem among the first 200")


def test_a_wrong_answer_is_seen(monkeypatch):
    solve = rc.solve

    def more(surface, *, load, **options):
        return replace(solve(surface, load=1.01 * load, **options), load=load)

    case = solved_case()
    assert random_problems.attempt(case).verdict == random_problems.CERTIFIED
    true = convolution.free
    with monkeypatch.context() as patch:
        # A modulus that is 1 % off, which the program itself cannot see.
        replace_free(
            patch,
            lambda shape, pixel, modulus, **options: true(shape, pixel, modulus / 1.01, **options),
        )
        outcome = random_problems.attempt(case)
    assert outcome.verdict == random_problems.WRONG
    assert "certificate" in outcome.words
    # Another load than requested; an unexpected error; a missing error.
    with monkeypatch.context() as patch:
        patch.setattr(rc, "solve", more)
        outcome = random_problems.attempt(case)
    assert outcome.verdict == random_problems.WRONG
    assert "load error" in outcome.words
    small = replace(case, options={**case.options, "ceiling": 1e-9})
    assert random_problems.attempt(small).words.startswith("CapacityError")
    assert random_problems.attempt(small).verdict == random_problems.WRONG
    due = replace(case, expected=rc.CapacityError)
    assert "was due" in random_problems.attempt(due).words
    # A crash is no answer.
    broken = replace(case, options={**case.options, "boundary": None, "material": None})
    assert random_problems.attempt(broken).verdict == random_problems.WRONG


def test_iteration_limit_is_distinguished_from_rounding():
    case = solved_case()
    few = replace(case, options={**case.options, "max_iterations": 2})
    assert random_problems.attempt(few).verdict == random_problems.GAVE_UP
    fine = replace(case, options={**case.options, "tolerance": 1e-17})
    assert random_problems.attempt(fine).verdict == random_problems.ROUNDED


def test_the_table_counts_every_problem():
    outcomes = [random_problems.attempt(random_problems.draw(seed, 16)) for seed in range(12)]
    total = random_problems.table(outcomes).splitlines()[-1].split("|")
    counts = [int(cell) for cell in total[3:-3]]
    assert int(total[2]) == sum(counts) == 12
    assert counts[random_problems.VERDICTS.index(random_problems.WRONG)] == 0


def test_the_documentation_holds_the_last_whole_run():
    text = robustness.PAGE.read_text(encoding="utf-8")
    for part in robustness.PARTS:
        start, end = robustness.marks(part.name)
        table = text.split(start)[1].split(end)[0].splitlines()
        (head,) = [
            line.split("|") for line in table if "| wrong |" in line and "extreme" not in line
        ]
        (total,) = [line.split("|") for line in table if line.startswith("| all |")]
        assert total[[cell.strip() for cell in head].index("wrong")].strip() == "0"
        (lines,) = [line for line in table if " s, roughcontact " in line]
        assert int(lines.split()[1]) >= 0.99 * part.count
