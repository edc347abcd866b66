"""Contacts of a project: their digests and complete results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4

from roughcontact._tools import checkpoints
from roughcontact._tools.files import to_json
from roughcontact._version import __version__
from roughcontact.analyses.compare import task as comparison
from roughcontact.errors import ArgumentRef
from roughcontact.request.options import GROUP
from roughcontact.request.request import Request
from roughcontact.request.task import Command

RUN_KEYS = frozenset({"run", "sha256", "seal"})
"""Keys of the summary of a contact in addition to its quantities."""

SOLVED, KEPT, FAILED = "solved", "solved before", "failed"


@dataclass(frozen=True)
class Entry:
    """One contact of a project."""

    name: str  # Name in reports; file names derive from it
    request: Request  # Options and input files
    summary: Path  # JSON file, written last
    contact: int  # Number of the contact: its entries share maps and load


@dataclass(frozen=True)
class ContactReport:
    """Outcome of one contact of a project."""

    name: str  # Name of the contact
    state: str  # `SOLVED`, `KEPT` or `FAILED`
    summary: Mapping[str, Any]  # Content of its JSON file
    reason: str = ""  # Reason of the failure, one sentence

    @property
    def last(self) -> Mapping[str, Any]:
        """Main quantities: of the last or largest of several loads, else of the contact."""
        return dict(self.summary.get("last", self.summary))

    def record(self) -> dict[str, Any]:
        """Return the report as values for JSON."""
        return {name: getattr(self, name) for name in ("name", "state", "summary", "reason")}


def spell_key(mention: ArgumentRef, task: Command) -> str:
    """Return an argument, and its value if any, as spelled in project files."""
    option = task.option_of_argument(mention.name)
    if option is None:
        return str(mention)
    if mention.value is None:
        return option.name
    if isinstance(mention.value, bool):
        return f"{option.name} = {str(mention.value).lower()}"
    return f"{option.name} = {json.dumps(option.text(mention.value), ensure_ascii=False)}"


def find_complete(entry: Entry, digest: str) -> dict[str, Any] | None:
    """Return the summary of an identical earlier run with unchanged files, or None."""
    try:
        text = json.loads(entry.summary.read_text(encoding="utf-8"))
        if not isinstance(text, dict) or text.get("run") != digest:
            return None
        if text.pop("seal", None) != checkpoints.checksum_json(text):
            return None
        # A profile has fewer figures than a map.
        paths = [path for _, path in entry.request.places if path.name in text["sha256"]]
        if text["sha256"] != _file_checksums(paths):
            return None
    except (OSError, ValueError, TypeError, LookupError, RecursionError):
        return None
    return {**text, "written": [str(path) for path in paths]}


def seal_summary(text: Mapping[str, Any], digest: str, written: Iterable[Path]) -> dict[str, Any]:
    """Return the content of the JSON file of a contact, sealed for `find_complete`."""
    if taken := RUN_KEYS & text.keys():
        raise ValueError(f"the file itself keeps {', '.join(sorted(taken))}")
    whole = json.loads(to_json({**text, "run": digest, "sha256": _file_checksums(written)}))
    return {**whole, "seal": checkpoints.checksum_json(whole)}


def checksum_if_readable(path: Path) -> str | None:
    """Return the checksum of a regular file; None for other or unreadable files."""
    try:
        # A device or a pipe has no end, or can be read only once.
        return checkpoints.checksum_file(path) if path.is_file() else None
    except OSError:
        return None


def request_digest(
    entry: Entry, content: Callable[[Path], str | None] = checksum_if_readable
) -> str:
    """Return the digest of the version, the options and the input files of a contact."""
    request = entry.request
    # Groups by name and size, their files by content.
    specified = {
        name: _strip_folders(value) if request.task.by_name[name].is_place else value
        for name, value in request.specified.items()
        if name != GROUP.name
    }
    sizes = map(len, comparison.groups(request).values())
    groups = [list(group) for group in zip(comparison.labels(request), sizes, strict=True)]
    return checkpoints.checksum_json(
        {
            "version": __version__,
            "task": request.task.name,
            "options": specified,
            # The suffix gives the format; a file without a checksum may change.
            "inputs": [
                [path.suffix.lower(), content(path) or uuid4().hex] for path in request.read_files
            ],
            **({"groups": groups} if groups else {}),
        }
    )


def _strip_folders(value: str | bool | list[str]) -> str | bool | list[str]:
    """Return paths without their folders."""
    if isinstance(value, list):
        return [Path(text).name for text in value]
    return Path(value).name if isinstance(value, str) else value


def _file_checksums(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: checkpoints.checksum_file(path) for path in paths}
