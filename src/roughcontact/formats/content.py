"""What a file is by its first bytes: the suffix is a hint, the content decides.

Only what nothing else begins with counts; many formats of instruments look alike.
"""

from __future__ import annotations

import codecs
from pathlib import Path
from typing import TextIO

from roughcontact import hdf5

_START = 4096
# Bytes by which a text shows its encoding: of more than one line in a head.
_TEXT_START = 2**15

# First bytes -> name of the format.
_SIGNATURES = (
    (b"\x93NUMPY", "npy"),
    (b"CDF\x01", "netcdf"),
    (b"CDF\x02", "netcdf"),
    (b"CDF\x05", "netcdf"),
)
_HDF5 = b"\x89HDF\r\n\x1a\n"

TEXT, HDF5 = "text", "hdf5"
"""Names of the formats of text and of arrays in HDF5."""

# Formats of this table and of texts, which a suffix may name by mistake.
_PLAIN = ("netcdf", "npy", "npz", "text", "hdf5")

# Formats of instruments whose suffix other programs give to texts; theirs are binary.
_SHARED = ("metropro",)


def format_of(path: Path, hinted: str | None) -> str | None:
    """Return the name of the format that a file is, as far as its content decides.

    Parameters
    ----------
    path : Path
        The file.
    hinted : str or None
        Name of the format by its suffix, None where that is not known.

    Returns
    -------
    str or None
        As ``hinted`` where the content decides nothing.
    """
    with path.open("rb") as stream:
        start = stream.read(_START)
    for signature, name in _SIGNATURES:
        if start.startswith(signature):
            return name
    if start.startswith(_HDF5) and (hinted is None or hinted in _PLAIN):
        return hinted if hinted == "netcdf" else _in_hdf5(path, hinted)
    if (hinted is None or hinted in _SHARED) and encoding_of(path):
        return TEXT
    return hinted


def _in_hdf5(path: Path, hinted: str | None) -> str:
    """Return the name of the format that an HDF5 file has by what is in its root.

    What writes its own scale is not to be read as bare arrays in a unit that somebody names.
    """
    try:
        hdf5.check(path)
        import h5py

        with h5py.File(path, "r") as file:
            # A table there; others call a group so.
            if "Data" in file and isinstance(file.get("MetaData"), h5py.Dataset):
                return "datx"
            # Who calls it by the suffix of bare arrays means these.
            return "netcdf" if "_NCProperties" in file.attrs and hinted != HDF5 else HDF5
    # Whoever reads it tells what is wrong.
    except Exception:
        return HDF5


def encoding_of(path: Path) -> str | None:
    """Return the encoding of a text as its beginning shows it; None of what is no text.

    UTF-8, UTF-16 with its mark or of plain letters, and Windows-1252 of whatever is neither.

    Parameters
    ----------
    path : Path
        The file.
    """
    with path.open("rb") as stream:
        start = stream.read(_TEXT_START)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings: tuple[str, ...] = ("utf-16",)
    elif len(start) > 1 and not (any(start[1::2]) and any(start[::2])):
        encodings = ("utf-16-be",) if any(start[1::2]) else ("utf-16-le",)
    else:
        encodings = ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = codecs.getincrementaldecoder(encoding)().decode(start)
        except UnicodeDecodeError:
            continue
        if text and all(c.isprintable() or c in "\t\r\n\f\xa0" for c in text):
            return encoding
    return None


def opened(path: Path, errors: str = "strict") -> TextIO:
    """Return a text, opened in its own encoding; ``errors`` as for `open`."""
    return path.open(encoding=encoding_of(path) or "utf-8-sig", errors=errors)
