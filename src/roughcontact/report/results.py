"""What is told of any result, from the table of its kind."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from roughcontact._version import __version__
from roughcontact.contact.compared import Comparison
from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.found import FoundLoads
from roughcontact.contact.history import LoadHistory
from roughcontact.contact.result import ContactResult
from roughcontact.contact.sampling import SamplingStudy
from roughcontact.contact.stress import StressResult
from roughcontact.contact.study import ResolutionStudy
from roughcontact.files import require_suffix, to_json, write
from roughcontact.formats import export
from roughcontact.joint.conductance import Conductance
from roughcontact.joint.estimate import Estimate
from roughcontact.joint.interface import InterfaceLaw
from roughcontact.report import (
    compared,
    conducted,
    estimated,
    found,
    kinds,
    lawful,
    profile,
    rolled,
    studied,
    tables,
)
from roughcontact.report.quantities import (
    ANSWER,
    Cells,
    Columns,
    Row,
    Table,
    csv_text,
    listing_of,
    quantity_of,
    rows_of,
    stored,
    stored_columns,
)
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.rolling import Rolling


def table_of(result: Any) -> Table:
    """Return the quantities of a kind of result."""
    kind = kinds.of(result)
    if kind is not None:
        return kind.table
    match result:
        case ContactResult():
            whole = profile.CONTACT if result.pair.is_profile else tables.CONTACT
            return tables.SHARED if result.pair.is_shared else whole
        case ElastoplasticResult():
            return tables.VOLUME
        case Rolling():
            return rolled.ROLLING
        case StressResult():
            return profile.STRESS if result.solution.pair.is_profile else tables.STRESS
        case LoadCurve():
            return profile.CURVE if result.is_profile else tables.CURVE
        case LoadHistory():
            return tables.HISTORY
        case FoundLoads():
            return found.FOUND
        case Conductance():
            return conducted.CONDUCTANCE
        case InterfaceLaw():
            return lawful.LAW
        case Estimate():
            return estimated.ESTIMATE
        case Comparison():
            return compared.COMPARISON
        case SamplingStudy():
            return compared.SAMPLING
        case ResolutionStudy():
            return studied.STUDY
    raise TypeError(f"there is no table for a {type(result).__name__}")


def columns_of(result: Any) -> Columns:
    """Return what is told of each step of a kind of result; nothing where it has no steps."""
    kind = kinds.of(result)
    if kind is not None:
        return kind.columns
    match result:
        case ElastoplasticResult():
            return tables.INCREMENTS
        case Rolling():
            return rolled.PASSES
        case LoadCurve():
            return profile.CURVE_COLUMNS if result.is_profile else tables.CURVE_COLUMNS
        case LoadHistory():
            return tables.HISTORY_COLUMNS
        case FoundLoads():
            return found.FOUND_COLUMNS
        case Conductance():
            return conducted.CONDUCTANCE_COLUMNS
        case InterfaceLaw():
            return lawful.LAW_COLUMNS
        case Comparison():
            return compared.COMPARISON_COLUMNS
        case SamplingStudy():
            return compared.SAMPLING_COLUMNS
        case ResolutionStudy():
            return studied.STUDY_COLUMNS
    return ()


def summary(result: Any) -> dict[str, Any]:
    """Return a result by name, in SI units, ready for JSON."""
    told = stored(table_of(result), result)
    if isinstance(result, LoadCurve | Conductance) or kinds.of(result) is not None:
        return {**told, **stored_columns(columns_of(result), result), "version": __version__}
    return told


def sentences(result: Any) -> tuple[str, ...]:
    """Return what a reader of a kind of result has to know before its numbers."""
    match result:
        case Conductance():
            return conducted.sentences(result)
        case InterfaceLaw():
            return lawful.sentences(result)
    kind = kinds.of(result)
    return () if kind is None else kind.sentences(result)


def title(result: Any) -> str:
    """Return the title of the chapter on what a joint does."""
    kind = kinds.of(result)
    if kind is not None:
        return kind.title
    return lawful.TITLE if isinstance(result, InterfaceLaw) else conducted.TITLE


def csv(result: Any) -> str:
    """Return the steps of a result as a table in text, units in the head."""
    return csv_text(columns_of(result), result)


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a result of many loads as a table, or as JSON; see `LoadCurve.save`."""
    require_suffix(path, ".csv", ".json")
    table = Path(path).suffix.lower() == ".csv"
    text = csv(result) if table else to_json(summary(result)) + "\n"
    write(path, text)


def save_rolling(rolling: Rolling, path: str | os.PathLike[str]) -> None:
    """Write passes as a table or as JSON, or what `formats.export` makes of them."""
    if Path(path).suffix.lower() in (".csv", ".json"):
        save(rolling, path)
    else:
        export.save(rolling, path)


def save_summary(result: Estimate, path: str | os.PathLike[str]) -> None:
    """Write a result without steps as JSON."""
    require_suffix(path, ".json")
    write(path, to_json(summary(result)) + "\n")


def rows(result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return what is told of a result; see `quantities.rows_of`."""
    return rows_of(table_of(result), result, part, brief)


_CALIBRATED = (
    "contact_area", "contact_fraction", "saturated_fraction", "mean_pressure", "mean_gap",
    "approach",
)  # fmt: skip


def under_calibrated(result: Any) -> dict[str, str]:
    """Return what is told under the calibrated ceiling, by key; nothing where it is the same."""
    other = getattr(result, "calibrated", None)
    if other is None or not other.differs:
        return {}
    return {key: quantity_of(tables.CONTACT, key).row(other).text for key in _CALIBRATED}


def _ceilings(result: ContactResult) -> tuple[str, str]:
    """Return the heads of two columns: the ceiling of a result, and the calibrated one."""
    assert result.calibrated is not None
    factors = (result.calibrated.factor * float(result.ceiling or 0) / result.calibrated.ceiling,
               result.calibrated.factor)  # fmt: skip
    own, other = (f"{factor:.3g} σ_Y" for factor in factors)
    return f"ceiling {own}", f"calibrated, {other}"


def beside_calibrated(result: Any, brief: bool = False) -> tuple[Cells, list[tuple[Row, Cells]]]:
    """Return heads and rows of an answer, with a second column where another ceiling changes it."""
    found, told = rows(result, brief=brief), under_calibrated(result)
    if not told:
        return (), [(row, (row.text,)) for row in found]
    return _ceilings(result), [(row, (row.text, told.get(row.key, ""))) for row in found]


def first_yield(onset: StressResult, brief: bool = False) -> list[Row]:
    """Return what is told of the contact at the load of first yield."""
    of_profile = onset.solution.pair.is_profile
    return rows_of(profile.FIRST_YIELD if of_profile else tables.FIRST_YIELD, onset, brief=brief)


def row(result: Any, key: str) -> Row:
    """Return one quantity of a result."""
    return quantity_of(table_of(result), key).row(result)


def listing(result: Any, brief: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the steps of a result; see `quantities.listing_of`."""
    return listing_of(columns_of(result), result, brief)
