"""Files of results: whether they are as they were written, and hold the solutions they claim."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from roughcontact.contact.result import ContactResult
from roughcontact.contact.verification import Verification
from roughcontact.errors import FormatError, InsufficientMemoryError
from roughcontact.volume import archive


@dataclass(frozen=True)
class Checked:
    """What came of a file.

    Parameters
    ----------
    file : str
        Its path.
    sealed : bool
        Whether it has checksums, which agree.
    found : Verification or None
        What it states of its contact beside what was computed again; ``None`` if it was refused.
    reason : str
        Why it is no sound result, in a sentence; empty if it is one.
    """

    file: str
    sealed: bool
    found: Verification | None
    reason: str


def check_file(path: str | os.PathLike[str]) -> Checked:
    """Return what came of the result in a file.

    Parameters
    ----------
    path : str or path
        A file that `roughcontact.load_result` reads.
    """
    file = str(path)
    try:
        result = archive.load_result(path)
        found = archive.verified(result)
    except (FormatError, InsufficientMemoryError) as error:
        return Checked(file, False, None, str(error))
    pressed = result if isinstance(result, ContactResult) else result.solution
    try:
        found.require(Path(path).name)
    except FormatError as error:
        return Checked(file, not pressed.unsealed, found, str(error))
    return Checked(file, not pressed.unsealed, found, "")
