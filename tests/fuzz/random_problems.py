"""Randomised contact problems, each certified or refused by a judge that shares no code with them.

`robustness.py` runs them. A seed names a problem. What has to come of it, a solution or which
error, is reasoned from its numbers before it is solved; what came is judged by ``tests/judge.py``:
plain NumPy and SciPy.
"""

from __future__ import annotations

import math
import platform
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
if str(ROOT / "tests") not in sys.path:
    sys.path.append(str(ROOT / "tests"))

import judge  # noqa: E402 - found next to the tests
import roughcontact as rc  # noqa: E402
from extreme_cases import TRAITS, extreme  # noqa: E402
from random_cases import Case, ordinary  # noqa: E402
from random_maps import KINDS  # noqa: E402
from roughcontact.contact.load_case import LoadCase  # noqa: E402
from roughcontact.contact.pair import Pair  # noqa: E402
from roughcontact.contact.validation import build_problem  # noqa: E402
from roughcontact.halfspace.boundary import Boundary  # noqa: E402

# Possible outcomes. A ConvergenceError is right where the digits of the arithmetic do not hold the
# tolerance, and honest where the convolutions allowed did not suffice.
CERTIFIED = "certified"
REFUSED = "refused with the right error"
ROUNDED = "below the rounding, said so"
GAVE_UP = "gave up, said so"
WRONG = "wrong"
VERDICTS = (CERTIFIED, REFUSED, ROUNDED, GAVE_UP, WRONG)

# Of every thousand seeds the first half are ordinary problems, the second half extreme ones.
THOUSAND = 1000
# Points along the longer side.
MAX_POINTS = 1024


@dataclass(frozen=True)
class Outcome:
    """Outcome of a problem.

    Parameters
    ----------
    case : Case
        The problem.
    verdict : str
        One of ``VERDICTS``.
    words : str
        Error, or reason of the rejection.
    certificate : float
        ε by the independent judge; NaN without a solution.
    convolutions : int
        On the full grid.
    seconds : float
        Wall time of the solve.
    """

    case: Case
    verdict: str
    words: str = ""
    certificate: float = math.nan
    convolutions: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        """Return everything in one line."""
        problem = ", ".join(f"{name} {value}" for name, value in self.case.words.items())
        return (
            f"{self.case.seed}: {self.case.kind}, {problem}: {self.verdict}"
            f"{': ' if self.words else ''}{self.words} "
            f"(certificate {self.certificate:.1e}, {self.convolutions} convolutions, "
            f"{self.seconds:.2f} s)"
        )


def draw(seed: int, largest: int = 192) -> Case:
    """Return the problem of a seed."""
    return (ordinary if seed % THOUSAND < THOUSAND // 2 else extreme)(seed, largest)


def attempt(case: Case) -> Outcome:
    """Solve a problem and judge what comes."""
    began = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = rc.solve(case.surface, **case.options)
    except rc.ConvergenceError as error:
        return _given_up(case, error, time.perf_counter() - began)
    except rc.InputError as error:
        seconds = time.perf_counter() - began
        # A CapacityError is an InputError, but either in place of the other is wrong.
        if type(error) is not case.expected:
            return Outcome(case, WRONG, f"{type(error).__name__}: {error}", seconds=seconds)
        if not _refuses(case):
            return Outcome(case, WRONG, "check lets it pass", seconds=seconds)
        return Outcome(case, REFUSED, str(error), seconds=seconds)
    except Exception as error:
        return Outcome(case, WRONG, f"failed with {type(error).__name__}: {error}")
    seconds = time.perf_counter() - began
    faults = judge.faults(result, case.options.get("load"), result.tolerance)
    if case.expected is not None:
        faults.append(f"solved, but {case.expected.__name__} was due")
    return Outcome(
        case,
        WRONG if faults else CERTIFIED,
        "; ".join(faults),
        judge.judge(result).certificate,
        result.convolutions,
        seconds,
    )


def _refuses(case: Case) -> bool:
    terms = dict(case.options)
    start = terms.pop("initial_guess", None)
    bodies = {
        name: terms.pop(name)
        for name in ("material", "counter_material", "counter_surface")
        if name in terms
    }
    try:
        boundary = Boundary(terms.pop("boundary", "free"))
        build_problem(Pair(case.surface, boundary=boundary, **bodies), LoadCase(**terms), start)
    except rc.InputError:
        return True
    return False


def _given_up(case: Case, error: rc.ConvergenceError, seconds: float) -> Outcome:
    result = error.result
    found = judge.judge(result)
    verdict = GAVE_UP
    if result.converged or case.expected is not None or not found.bounded:
        verdict = WRONG
    elif "rounding" in result.status:
        # Found too early only if the digits would have held a tenth of the tolerance: that of the
        # certificate, or of moments.
        held = result.tolerance if result.certificate > result.tolerance else 1e-8
        verdict = ROUNDED if found.doubt > 0.1 * held else WRONG
    return Outcome(case, verdict, str(error), found.certificate, result.convolutions, seconds)


# The table ----------------------------------------------------------------------------------------


def table(outcomes: list[Outcome]) -> str:
    """Return the outcomes of the problems, by the kind of map, as Markdown."""
    kinds = {kind: [o for o in outcomes if o.case.kind == kind] for kind in KINDS}
    return _rows("map", kinds | {"all": outcomes})


def trait_table(outcomes: list[Outcome]) -> str:
    """Return the outcomes of the extreme problems, by what is extreme about them, as Markdown."""
    return _rows("extreme", {t: [o for o in outcomes if t in o.case.traits] for t in TRAITS})


def _rows(what: str, rows: dict[str, list[Outcome]]) -> str:
    lines = [
        f"| {what} | problems | {' | '.join(VERDICTS)} | worst certificate / tolerance "
        "| most convolutions |",
        "|---|" + "---|" * (len(VERDICTS) + 3),
    ]
    for name, chosen in rows.items():
        solved = [o for o in chosen if o.verdict == CERTIFIED]
        counts = " | ".join(str(sum(o.verdict == v for o in chosen)) for v in VERDICTS)
        worst = max((o.certificate / tolerance_of(o.case) for o in solved), default=0.0)
        most = max((o.convolutions for o in solved), default=0)
        lines.append(f"| {name} | {len(chosen)} | {counts} | {worst:.2f} | {most} |")
    return "\n".join(lines)


def tolerance_of(case: Case) -> float:
    """Return the certificate that a problem is solved to."""
    usual = 1e-4 if case.options.get("precision") == "single" else 1e-6
    return float(case.options.get("tolerance", usual))


def page(outcomes: list[Outcome], seconds: float) -> str:
    """Return the part of the documentation that a run renews."""
    notes = [
        f"{len(outcomes)} problems in {seconds:.0f} s, roughcontact {rc.__version__}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}."
    ]
    solved = [o for o in outcomes if o.verdict == CERTIFIED]
    if solved:
        convolutions = [o.convolutions for o in solved]
        most = max(solved, key=lambda o: o.convolutions)
        worst = max(solved, key=lambda o: o.certificate / tolerance_of(o.case))
        notes += [
            f"Convolutions: median {np.median(convolutions):.0f}, "
            f"95 % up to {np.quantile(convolutions, 0.95):.0f}, most {most.convolutions}.",
            f"Worst certificate: {worst}.",
            f"Most convolutions: {most}.",
        ]
    notes += [str(o) for o in outcomes if o.verdict in (GAVE_UP, WRONG)]
    listed = "\n".join(f"- {note}" for note in notes)
    return f"{table(outcomes)}\n\n{trait_table(outcomes)}\n\n{listed}"


def run(seeds: Sequence[int], every: bool = False) -> list[Outcome]:
    """Attempt problems one after the other; print what was not as it should be, or all."""
    outcomes = []
    for number, seed in enumerate(seeds, start=1):
        outcomes.append(attempt(draw(seed, MAX_POINTS)))
        if every or outcomes[-1].verdict in (GAVE_UP, WRONG):
            print(outcomes[-1], flush=True)
        elif number % 100 == 0:
            print(f"{number} of {len(seeds)}", flush=True)
    return outcomes
