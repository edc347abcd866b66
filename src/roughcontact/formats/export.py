"""Every format that maps and results are written in: one table.

A missing point is a missing point in each of them, and row 0 is the row of smallest y. What is
written appears under its name only once it is complete. ``roughcontact.plots`` draws figures.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.elastoplastic.result import ElastoplasticResult
    from roughcontact.surface.surface import Surface

Target = str | os.PathLike[str]
Writer = Callable[[Any, Target], None]


class ContentType(Enum):
    """What can be written, and how a message calls it."""

    SURFACE = "a surface"
    CONTACT = "a result"
    VOLUME = "a result with its volume"
    LAW = "the law of an interface"
    ROLLING = "repeated passes"


@dataclass(frozen=True)
class Content:
    """What a file holds of one kind of source."""

    words: str  # What it keeps, as help and web page say it
    write: Writer  # `write(source, path)`


@dataclass(frozen=True)
class OutputFormat:
    """A format that maps and results are written in."""

    suffix: str  # How its files end
    contents: dict[ContentType, Content]  # What it holds of each `ContentType` that it can hold


def _lazy_writer(place: str) -> Writer:
    """Return a writer that is loaded when it writes: help and messages need the table alone."""
    return lambda source, path: resolve_name(f"roughcontact.{place}")(source, path)


def _last_state_writer(write: Writer) -> Writer:
    """Return what writes the state after the last pass."""
    return lambda rolling, path: write(rolling.result, path)


_X3P, _SUR = _lazy_writer("formats.metrology:save_x3p"), _lazy_writer("formats.metrology:save_sur")
_VTR, _VTI = _lazy_writer("formats.vtk:save_vtr"), _lazy_writer("formats.vtk:save_vtk")
_CSV, _LAW = _lazy_writer("formats.tables:save_csv"), _lazy_writer("analyses.law.decks:save")


def _result_contents(content: Content) -> dict[ContentType, Content]:
    return {ContentType.CONTACT: content, ContentType.VOLUME: content}


FORMATS = (
    OutputFormat(
        ".nc",
        {
            ContentType.SURFACE: Content(
                "heights and provenance, every bit", _lazy_writer("formats.netcdf:save")
            ),
            ContentType.CONTACT: Content("everything", _lazy_writer("contact.archive:save_result")),
            ContentType.VOLUME: Content(
                "everything", _lazy_writer("elastoplastic.archive:write_result")
            ),
            ContentType.ROLLING: Content(
                "everything", _lazy_writer("analyses.roll.model:save_rolling")
            ),
        },
    ),
    OutputFormat(
        ".npz",
        {
            ContentType.SURFACE: Content(
                "heights and pixel, every bit", _lazy_writer("formats.tables:save_npz")
            ),
            ContentType.LAW: Content("arrays", _LAW),
        },
    ),
    OutputFormat(
        ".x3p", {ContentType.SURFACE: Content("heights and pixel, every bit; ISO 25178-72", _X3P)}
    ),
    OutputFormat(".sur", {ContentType.SURFACE: Content("heights to 32 bits; Digital Surf", _SUR)}),
    OutputFormat(
        ".vtr",
        {
            ContentType.VOLUME: Content("strain and stress of the volume model", _VTR),
            ContentType.ROLLING: Content("final strain and stress", _last_state_writer(_VTR)),
        },
    ),
    OutputFormat(
        ".vti",
        {
            ContentType.SURFACE: Content("heights for ParaView", _VTI),
            **_result_contents(Content("maps for ParaView", _VTI)),
            ContentType.ROLLING: Content("final maps", _last_state_writer(_VTI)),
        },
    ),
    OutputFormat(
        ".pvd",
        {
            ContentType.ROLLING: Content(
                "all steps of --folder for ParaView", _lazy_writer("analyses.roll.files:save_pvd")
            )
        },
    ),
    OutputFormat(
        ".csv",
        {
            ContentType.SURFACE: Content("heights as text, every bit", _CSV),
            **_result_contents(Content("pressure", _CSV)),
            ContentType.LAW: Content("thinned tables", _LAW),
        },
    ),
    OutputFormat(
        ".json",
        {
            **_result_contents(Content("numbers", _lazy_writer("formats.tables:save_json"))),
            ContentType.LAW: Content("numbers", _LAW),
        },
    ),
    OutputFormat(".inp", {ContentType.LAW: Content("a deck for Abaqus", _LAW)}),
    OutputFormat(".ccx", {ContentType.LAW: Content("a deck for CalculiX", _LAW)}),
    OutputFormat(".mac", {ContentType.LAW: Content("real constants for Ansys APDL", _LAW)}),
    OutputFormat(".i", {ContentType.LAW: Content("functions for MOOSE", _LAW)}),
    OutputFormat(".fcmacro", {ContentType.LAW: Content("a macro for FreeCAD", _LAW)}),
    OutputFormat(".txt", {ContentType.LAW: Content("a table for mixed lubrication", _LAW)}),
)
"""Every format; help, messages, project file and documentation read them from here."""


# What is written there has two sides.
_OF_MAPS = (".x3p", ".sur", ".vti", ".vtr")


def suffixes(*kinds: ContentType) -> tuple[str, ...]:
    """Return how files may end that hold one of some kinds."""
    return tuple(known.suffix for known in FORMATS if known.contents.keys() & set(kinds))


def format_list_text(*kinds: ContentType) -> str:
    """Return a text that lists the content of the formats of some kinds."""
    words = []
    for known in FORMATS:
        held = [known.contents[kind].words for kind in kinds if kind in known.contents]
        words += [f"{known.suffix} {text}" for text in dict.fromkeys(held)]
    return ", ".join(words)


def save_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map in the format that the suffix of the file names."""
    _require_kept(surface, path)
    writer_of(ContentType.SURFACE, path)(surface, path)


def save_contact(result: ContactResult, path: Target) -> None:
    """Write a contact in the format that the suffix of the file names; see `save_surface`."""
    if Path(path).suffix.lower() != ".nc":
        result.require_whole("a file other than .nc")
        _require_kept(result.surface, path)
    writer_of(ContentType.CONTACT, path)(result, path)


def save_volume(result: ElastoplasticResult, path: Target) -> None:
    """Write a contact with its volume in the format that the suffix of the file names."""
    writer_of(ContentType.VOLUME, path)(result, path)


def _require_kept(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Raise `InputError` where a format has no profiles."""
    if surface.is_profile and Path(path).suffix.lower() in _OF_MAPS:
        raise InputError(
            "needs a name that ends in .nc, .npz (heights), .csv or .json (results) for a profile, "
            f"got {str(path)!r}",
            argument="path",
            value=str(path),
        )


def writer_of(kind: ContentType, path: str | os.PathLike[str]) -> Writer:
    """Return what writes a kind in the format that the suffix names; `InputError` if none does."""
    suffix = Path(path).suffix.lower()
    for known in FORMATS:
        if suffix == known.suffix and kind in known.contents:
            return known.contents[kind].write
    raise InputError(
        f"must end in one of {', '.join(suffixes(kind))} for {kind.value}, got {str(path)!r}; "
        "figures are written by roughcontact.plots",
        argument="path",
        value=str(path),
    )
