"""Output formats of maps, contacts and volumes: one table each.

All formats keep missing points, and row 0 is the row of smallest y. A file appears under its name
only when it is complete. ``roughcontact.plots`` draws figures.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError, input_error

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.surface.surface import Surface

Target = str | os.PathLike[str]
Writer = Callable[[Any, Target], None]

TABLES = (".csv", ".xlsx", ".json")
"""Suffixes of files with the table of a result."""


@dataclass(frozen=True)
class Content:
    """Content of a file of a format, and its writer."""

    words: str  # Text for help and web page
    write: Writer  # `write(source, path)`


@dataclass(frozen=True)
class FormatTable:
    """Output formats of objects of a class."""

    noun: str  # Name of the class in messages
    contents: Mapping[str, Content]  # Formats by suffix

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Suffixes of the file names."""
        return tuple(self.contents)

    def write(self, source: Any, path: Target) -> None:
        """Write an object in the format of the suffix; raise `InputError` for other suffixes."""
        suffix = Path(path).suffix.lower()
        if suffix not in self.contents:
            raise InputError(
                f"must end in one of {', '.join(self.contents)} for {self.noun}, "
                f"got {str(path)!r}; figures are written by roughcontact.plots",
                argument="path",
                value=str(path),
            )
        self.contents[suffix].write(source, path)


def lazy_writer(place: str) -> Writer:
    """Return a writer imported on first use, as help and messages need only the table."""
    return lambda source, path: resolve_name(f"roughcontact.{place}")(source, path)


VTR, VTI = lazy_writer("formats.vtk:save_vtr"), lazy_writer("formats.vtk:save_vtk")
_CSV = Content("pressure", lazy_writer("formats.tables:save_csv"))
_JSON = Content("numbers", lazy_writer("formats.tables:save_json"))
_MAPS = Content("maps for ParaView", VTI)

SURFACE = FormatTable(
    "a surface",
    {
        ".nc": Content("heights and provenance, every bit", lazy_writer("formats.netcdf:save")),
        ".npz": Content("heights and pixel, every bit", lazy_writer("formats.tables:save_npz")),
        ".x3p": Content(
            "heights and pixel, every bit; ISO 25178-72", lazy_writer("formats.metrology:save_x3p")
        ),
        ".sur": Content(
            "heights to 32 bits; Digital Surf", lazy_writer("formats.metrology:save_sur")
        ),
        ".vti": Content("heights for ParaView", VTI),
        ".csv": Content("heights as text, every bit", _CSV.write),
    },
)
CONTACT = FormatTable(
    "a result",
    {
        ".nc": Content("everything", lazy_writer("contact.archive:save_result")),
        ".vti": _MAPS,
        ".csv": _CSV,
        ".json": _JSON,
    },
)
VOLUME = FormatTable(
    "a result with its volume",
    {
        ".nc": Content("everything", lazy_writer("elastoplastic.archive:save_elastoplastic")),
        ".vtr": Content("strain and stress of the volume model", VTR),
        ".vti": _MAPS,
        ".csv": _CSV,
        ".json": _JSON,
    },
)


# Formats that cannot store profiles.
_OF_MAPS = (".x3p", ".sur", ".vti", ".vtr")


def list_formats(*tables: FormatTable) -> str:
    """Return a text that lists suffixes and content of tables."""
    words = []
    for suffix in dict.fromkeys(suffix for table in tables for suffix in table.contents):
        held = [table.contents[suffix].words for table in tables if suffix in table.contents]
        words += [f"{suffix} {text}" for text in dict.fromkeys(held)]
    return ", ".join(words)


def save_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map in the format given by the suffix of the file."""
    _require_kept(surface, path)
    SURFACE.write(surface, path)


def save_contact(result: ContactResult, path: Target) -> None:
    """Write a contact in the format given by the suffix of the file; see `save_surface`."""
    if Path(path).suffix.lower() != ".nc":
        _require_kept(result.surface, path)
    CONTACT.write(result, path)


def _require_kept(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Raise `InputError` for a profile in a format of maps."""
    if surface.is_profile and Path(path).suffix.lower() in _OF_MAPS:
        raise input_error(
            "path",
            str(path),
            "needs a name that ends in .nc, .npz (heights), .csv or .json (results) for a profile",
        )
