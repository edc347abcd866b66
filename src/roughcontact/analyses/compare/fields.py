"""References of a comparison."""

from __future__ import annotations

from roughcontact.analyses.compare.model import Comparison
from roughcontact.analyses.sweep.fields import curve_references
from roughcontact.references import make_use
from roughcontact.report.citations import Uses


def comparison_references(result: Comparison) -> Uses:
    """Yield the references of a comparison."""
    for sample in result.samples:
        yield from curve_references(sample.curve)
    yield make_use("intervals of the means", "Student1908")
    if len(result.groups) > 1 and not result.paired:
        wide = len(result.groups) > 2
        yield make_use("intervals of the differences", "Games1976" if wide else "Welch1947")
    if any(result.components(name) for name in result.names):
        yield make_use("scatter between groups and within", "Searle1992")
