"""Format by content: the suffix is a hint, the first bytes decide."""

from __future__ import annotations

import codecs
import re
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TextIO

from roughcontact._tools import netcdf
from roughcontact.errors import FormatError
from roughcontact.formats.source import damage_as_error

_START = 4096
# Number of bytes by which the encoding of a text is determined: several lines of a header.
_TEXT_START = 2**15

# First bytes -> name of the format.
_SIGNATURES = (
    (b"\x93NUMPY", "npy"),
    ((b"CDF\x01", b"CDF\x02", b"CDF\x05"), "netcdf"),
    (b"Gwyddion Simple Field ", "gsf"),
    ((b"ply\n", b"ply\r"), "ply"),
    (b"SigmaSurf_Data", "smd"),
    ((b"DIGITAL SURF", b"DSCOMPRESSED"), "sur"),
    (b"GWYP", "gwy"),
    (b"AliconaImaging", "al3d"),
    ((b"VK3_", b"VK4_", b"VK6", b"VK7"), "vk"),
    (b"\\*File list", "di"),
)
# First bytes -> contents that are no map under any suffix.
_NO_MAPS = (
    (b"%PDF", "a PDF document"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    ((b"<!DOCTYPE", b"<html"), "a web page, not the file itself"),
    (b"version https://git-lfs", "a pointer of Git LFS, not the file itself"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"# .PCD", "a point cloud of PCL, no map"),
    (b"Rar!", "a RAR archive"),
    (b"7z\xbc\xaf", "a 7-Zip archive"),
)
UNREAD = {
    ".pcd": "a profile in Mahr's Perthometer Concept format; let the instrument save profiles as "
    ".TXT, or export it from MarWin as text",
    ".zag": "a project of Keyence's VR software; save the measurement as .zon or as CSV",
}
"""Suffix -> family of files that are not read, and the remedy."""

# First bytes -> containers of many formats, for errors.
_TIFF = (b"II*\0", b"MM\0*")
_CONTAINERS = (
    (_TIFF, "a TIFF image"),
    (b"PK\3\4", "a ZIP archive"),
    (b"\xd0\xcf\x11\xe0", "a document of Office before 2007 or another OLE container"),
    (b"\x89HDF", "an HDF5 file"),
)
_STL = re.compile(rb"solid\b[^\n]*\n\s*facet\b")
# Axes in the records of a profile.
_RECORDS = re.compile(rb"^C[XZ]\0?[ \t]+[A-Z]\0?[ \t]+[\d.]", re.MULTILINE)
_HDF5 = b"\x89HDF\r\n\x1a\n"

TEXT, HDF5 = "text", "hdf5"
"""Names of the formats of text and of arrays in HDF5."""

# Formats that a suffix may name by mistake: those of this table, and texts.
_PLAIN = ("netcdf", "npy", "npz", "text", "hdf5")

# Binary formats of instruments whose suffix other programs use for texts.
_SHARED = ("metropro",)

# Beginnings of texts that are no tables of numbers: PDF, PostScript, RTF, HTML and XML.
_DOCUMENTS = (b"%PDF", b"%!PS", b"{\\rtf", b"<")


def format_of(path: Path, hinted: str | None) -> str | None:
    """Return the name of the format of a file, as far as its content determines it."""
    with path.open("rb") as stream:
        start = stream.read(_START)
    for signature, name in _SIGNATURES:
        if start.startswith(signature):
            return name
    for signature, what in _NO_MAPS:
        if start.startswith(signature):
            raise FormatError(
                f"{path.name} is {what}; export the heights as .x3p, .sur, 32-bit TIFF or text"
            )
    if hinted in (None, TEXT, "qep") and _RECORDS.search(start):
        return "smd"
    if hinted in (None, TEXT) and _STL.match(start):
        return "stl"
    if hinted is None and start.startswith(_TIFF):
        return "tiff"
    if start.startswith(_HDF5) and (hinted is None or hinted in _PLAIN):
        return hinted if hinted == "netcdf" else _in_hdf5(path, hinted)
    if hinted is None and start.lstrip().startswith(_DOCUMENTS):
        return None
    if (hinted is None or hinted in _SHARED) and encoding_of(path):
        return TEXT
    return hinted


def _in_hdf5(path: Path, hinted: str | None) -> str:
    """Return the name of the format of an HDF5 file by the content of its root."""
    with hdf5_errors(path):
        netcdf.check_hdf5(path)
        import h5py

        with h5py.File(path, "r") as file:
            # In this format it is a table; other programs have a group of this name.
            if "Data" in file and isinstance(file.get("MetaData"), h5py.Dataset):
                return "datx"
            if "position-pattern.grid.ilength" in file.get("Measurement_000", file).attrs:
                return "jpk-hdf5"
            # The suffix of bare arrays selects the arrays.
            return "netcdf" if "_NCProperties" in file.attrs and hinted != HDF5 else HDF5


def hdf5_errors(path: Path) -> AbstractContextManager[None]:
    """Convert any error of HDF5 into a `FormatError`."""
    return damage_as_error(path, "HDF5", "check that the file is complete")


def describe_content(path: Path) -> str:
    """Return the kind of a file by its first bytes, as the end of "FILE is …"."""
    with path.open("rb") as stream:
        start = stream.read(_START)
    what = next((what for mark, what in _CONTAINERS if start.startswith(mark)), "")
    if what or encoding_of(path) is None:
        return what or "of an unknown binary format"
    first = start.strip().split(b"\n")[0].strip()[:40].decode("latin-1")
    return f"a text that starts with {first!r}"


def encoding_of(path: Path) -> str | None:
    """Return the encoding of a text by its beginning; None for other content."""
    with path.open("rb") as stream:
        start = stream.read(_TEXT_START)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings: tuple[str, ...] = ("utf-16",)
    elif len(start) > 1 and not (any(start[1::2]) and any(start[::2])):
        encodings = ("utf-16-be",) if any(start[1::2]) else ("utf-16-le",)
    else:
        encodings = ("utf-8-sig", "cp1252", "shift_jis", "gb18030")
    for encoding in encodings:
        try:
            text = codecs.getincrementaldecoder(encoding)().decode(start)
        except UnicodeDecodeError:
            continue
        if text and all(c.isprintable() or c in "\t\r\n\f\xa0\u202f" for c in text):
            return encoding
    return None


def open_text(path: Path, errors: str = "strict") -> TextIO:
    """Open a text in its encoding; ``errors`` as in ``open``."""
    return path.open(encoding=encoding_of(path) or "utf-8-sig", errors=errors)
