"""Sheets of Excel: input converted to text (matrix, points, two columns), and output tables."""

from __future__ import annotations

import contextlib
import math
import os
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughcontact._tools import memory
from roughcontact._tools.files import atomic_write
from roughcontact._tools.text import table_cell
from roughcontact.errors import FormatError
from roughcontact.formats import instruments, matrices, source
from roughcontact.formats.source import Channel, ReadOptions, damage_as_error
from roughcontact.surface.surface import Surface

# Reader of SurfaceTopography for the workbooks of this instrument.
_MITUTOYO = "mitutoyo"


def read_workbook(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in one of the sheets of a workbook."""
    sheets = _sheets(path)
    if _is_mitutoyo(sheets) and requested.channel is None:
        return instruments.read_instrument(path, _MITUTOYO, requested)
    sheet = matrices.choose_array(path, sheets, requested.channel)
    with _sheet_as_text(path, sheet) as text:
        surface = matrices.read_text(text, name, replace(requested, channel=None))
    if len(sheets) == 1:
        return surface
    return replace(surface, provenance=replace(surface.provenance, channel=sheet))


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the sheets of a workbook; sheets without numbers are not heights."""
    result = []
    sheets = _sheets(path)
    if _is_mitutoyo(sheets):
        return instruments.channels(path, _MITUTOYO)
    for sheet in sheets:
        try:
            with _sheet_as_text(path, sheet) as text:
                (inside,) = matrices.text_channels(text, name)
            result.append(replace(inside, name=sheet))
        except FormatError:
            result.append(Channel(sheet, "", False, ()))
    return tuple(result)


def _is_mitutoyo(sheets: list[str]) -> bool:
    """Return whether a workbook is a profile of a Mitutoyo SurfTest."""
    return {"DATA", "Certificate"} <= set(sheets)


def _sheets(path: Path) -> list[str]:
    with _open_workbook(path) as workbook:
        return [sheet.title for sheet in workbook.worksheets]


@contextlib.contextmanager
def _sheet_as_text(path: Path, sheet: str) -> Iterator[Path]:
    """Yield a text file of a sheet with the name of the workbook, tabs between cells."""
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        copy = Path(folder) / path.name
        with _open_workbook(path) as workbook, copy.open("x", encoding="utf-8") as stream:
            size, maximum = 0, memory.max_unpacked_bytes(path.stat().st_size)
            for row in _rows(path, workbook[sheet]):
                size += stream.write("\t".join(map(_cell, row)) + "\n")
                # A single cell may be thousands of empty ones away from the others.
                if size > maximum:
                    memory.require_size(path.name, size, packed=path.stat().st_size)
        if not copy.stat().st_size:
            raise FormatError(f"{path.name} holds no numbers in its sheet {sheet!r}")
        yield copy


def _rows(path: Path, sheet: Any) -> Iterator[tuple[Any, ...]]:
    """Return the rows of a sheet, of equal length unless it states more cells than exist."""
    stated = (sheet.max_row or 0) * (sheet.max_column or 0)
    if stated > source.check_sizes(path):
        sheet.reset_dimensions()
    return iter(sheet.iter_rows(values_only=True))


def _cell(value: Any) -> str:
    if value is None:
        return ""
    # A line break in a cell would split the row.
    return repr(value) if isinstance(value, float) else " ".join(str(value).split())


def write_workbook(rows: Iterable[Iterable[Any]], path: str | os.PathLike[str]) -> None:
    """Write the rows of a table as a workbook; numbers that are not finite become text."""
    workbook = source.import_optional(Path(path), "openpyxl").Workbook(write_only=True)
    sheet = workbook.create_sheet("roughcontact")
    for row in rows:
        sheet.append([_output_cell(value) for value in row])
    with atomic_write(path) as stream:
        workbook.save(stream)


def _output_cell(value: Any) -> Any:
    if isinstance(value, str):
        return table_cell(value)
    return value if math.isfinite(value) else repr(value)


@contextlib.contextmanager
def _open_workbook(path: Path) -> Iterator[Any]:
    """Open a workbook that is read row by row, with all errors as `FormatError`."""
    openpyxl = source.import_optional(path, "openpyxl")
    with damage_as_error(path, "an Excel workbook", "check that the file is complete"):
        source.check_sizes(path)
        with contextlib.closing(
            openpyxl.load_workbook(path, read_only=True, data_only=True)
        ) as workbook:
            yield workbook
