"""The report on any result."""

from __future__ import annotations

import os
from collections.abc import Sequence

from roughcontact.contact.compared import Comparison
from roughcontact.contact.result import ContactResult
from roughcontact.contact.sampling import SamplingStudy
from roughcontact.contact.study import ResolutionStudy
from roughcontact.errors import InputError
from roughcontact.report import comparison, contact, rolling, volume
from roughcontact.report.page import Addition
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.rolling import Rolling


def save(
    result: object,
    path: str | os.PathLike[str],
    command: str,
    additions: Sequence[Addition] = (),
    study: ResolutionStudy | None = None,
) -> None:
    """Write the report on a result."""
    match result:
        case ContactResult():
            contact.save_compared(result, path, command, additions, study)
        case ElastoplasticResult():
            volume.save(result, path, command=command, additions=additions)
        case Rolling():
            rolling.save(result, path, command=command)
        case Comparison() | SamplingStudy():
            comparison.save(result, path, command)
        case _:
            raise InputError(f"there is no report on a {type(result).__name__}")
