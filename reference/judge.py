"""Compare answers with the reference set; needs NumPy alone.

    python judge.py answers.json

The file holds {"problem": {"quantity": number, nested lists, or "file.npy" in its folder}} in the
SI units of problems.json; any of them may be left out. The exit status is 1 if one does not agree.
"""

import json
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent


def difference(answer, expected):
    """Return the norm of the difference over that of the reference."""
    answer, expected = np.asarray(answer, dtype=float), np.asarray(expected, dtype=float)
    if answer.shape != expected.shape:
        return np.inf
    return float(np.linalg.norm(answer - expected) / np.linalg.norm(expected))


def judge(answers, folder):
    """Yield problem, quantity, relative difference, and the reference of each answer."""
    problems = json.loads((HERE / "problems.json").read_text(encoding="utf-8"))
    for name, quantities in answers.items():
        for quantity, value in quantities.items():
            reference = problems[name]["answers"][quantity]
            expected = reference["value"]
            if expected is None:
                with np.load(HERE / f"{name}.npz", allow_pickle=False) as arrays:
                    expected = arrays[quantity]
            if isinstance(value, str):
                value = np.load(folder / value, allow_pickle=False)
            yield name, quantity, difference(value, expected), reference


def main(path):
    """Print a line for each answer, and return the number of those that do not agree."""
    answers = json.loads(path.read_text(encoding="utf-8"))
    wrong = 0
    for name, quantity, found, reference in judge(answers, path.parent):
        agrees = found <= reference["accept"]
        wrong += not agrees
        verdict = "agrees" if agrees else "DIFFERS"
        bounds = f"accepted {reference['accept']:.0e}, reference error {reference['error']:.0e}"
        print(f"{name:12} {quantity:20} {verdict:8} by {found:.1e}, {bounds}")
    return wrong


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1])) > 0)
