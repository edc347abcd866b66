"""Anderson's acceleration of fixed points that are known."""

from __future__ import annotations

import numpy as np

from roughcontact.elastoplastic import increments
from roughcontact.elastoplastic.increments import Mixer
from roughcontact.halfspace.fft import Workspace


def error_history(rates: np.ndarray, steps: int) -> list[tuple[float, bool]]:
    """Return the error after each step to a known point, and whether the step was a plain one.

    Two parts of five components each, whose error shrinks by ``rates`` in a plain step.
    """
    rng = np.random.default_rng(0)
    target = [rng.standard_normal(rates.shape) for _ in range(2)]
    mixer, at = Mixer([1.0, 0.5], Workspace(1)), [np.zeros(rates.shape) for _ in range(2)]
    messages = []
    for _ in range(steps):
        mapped = [t + rates * (y - t) for t, y in zip(target, at, strict=True)]
        defect = [x - y for x, y in zip(mapped, at, strict=True)]
        at = mixer.mix([x.copy() for x in mapped], defect)
        plain = all(np.array_equal(x, y) for x, y in zip(at, mapped, strict=True))
        messages.append((max(np.abs(y - t).max() for t, y in zip(target, at, strict=True)), plain))
    return messages


def test_as_many_rates_as_it_remembers_are_solved_at_once() -> None:
    # Linear, of three rates: three differences hold all that is left.
    result = error_history(np.resize([0.3, 0.7, 0.95], (5, 6)), 6)
    # Normal equations lose half the digits.
    assert result[3][0] < 1e-7 < result[2][0]
    assert result[0][1]


def test_while_the_defect_falls_no_step_is_plain() -> None:
    # Many slow rates keep it busy for longer than its patience.
    steps = 3 * increments._MAX_FRUITLESS_STEPS
    result = error_history(np.linspace(0.5, 0.999, 5 * 40).reshape(5, 40), steps)
    assert not any(plain for _, plain in result[1:])
    # Plain steps alone would leave nearly all of the slowest.
    assert result[-1][0] < 0.6 * 0.999**steps
