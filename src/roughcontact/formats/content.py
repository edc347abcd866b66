"""What a file is by its first bytes: the suffix is a hint, the content decides.

Only what nothing else begins with counts; many formats of instruments look alike.
"""

from __future__ import annotations

import codecs
from pathlib import Path

from roughcontact import hdf5

_START = 4096

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
    if (hinted is None or hinted in _SHARED) and _is_text(start):
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


def _is_text(start: bytes) -> bool:
    """Return whether bytes are text, cut off anywhere."""
    try:
        text = codecs.getincrementaldecoder("utf-8-sig")().decode(start)
    except UnicodeDecodeError:
        return False
    return bool(text) and all(c.isprintable() or c in "\t\r\n\f" for c in text)
