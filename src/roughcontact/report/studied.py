"""What is told of a study of the resolution: can it be trusted."""

from __future__ import annotations

from collections.abc import Callable

from roughcontact.contact.study import QUANTITIES, ResolutionStudy
from roughcontact.report.kind import Kind
from roughcontact.report.quantities import Column, Columns, Quantity, Table
from roughcontact.units import percent

STUDY: Table = (
    Quantity("grids", of=lambda study: [vars(grid) for grid in study.grids]),
    Quantity("cutoffs", of=lambda study: [vars(cutoff) for cutoff in study.cutoffs]),
    Quantity("ceilings", of=lambda study: [vars(ceiling) for ceiling in study.ceilings]),
    Quantity("independent", of=lambda s: {name: s.independent(name) for name in QUANTITIES}),
    Quantity("at_ceiling"),
    Quantity("sentences", of=lambda study: list(study.sentences)),
)  # fmt: skip
"""Of a `ResolutionStudy`."""


def _cases(key: str) -> Callable[[ResolutionStudy], list[float]]:
    return lambda study: [getattr(case, key) for _, case in study.named()]


STUDY_COLUMNS: Columns = (
    Column("case", "case", of=lambda study: [name for name, _ in study.named()]),
    Column("contact_fraction", "contact", of=_cases("contact_fraction"), form=percent),
    Column(
        "corrected_fraction", "without rim", of=_cases("corrected_fraction"), form=percent
    ),
    Column("saturated_fraction", "saturated", of=_cases("saturated_fraction"), form=percent),
    Column("max_pressure", "largest pressure", unit="Pa", of=_cases("max_pressure")),
    Column("mean_pressure", "mean pressure", unit="Pa", of=_cases("mean_pressure")),
)  # fmt: skip
"""Of the solves of a `ResolutionStudy`."""


# Its papers are those of the contact that it is told with.
KIND = Kind(ResolutionStudy, STUDY, STUDY_COLUMNS)
