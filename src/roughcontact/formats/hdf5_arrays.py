"""Matrices of plain numbers in HDF5: every array of two dimensions is a channel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from roughcontact import hdf5, limits
from roughcontact.errors import FormatError, RoughcontactError
from roughcontact.formats.matrices import chosen, scaled
from roughcontact.formats.scale import is_length
from roughcontact.formats.source import Asked, Channel, one_line
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

# Bytes that reading takes a point.
_EACH = 20
_UNIT_NAMES = ("unit", "units", "Unit", "Units")


def read(path: Path, name: str, asked: Asked) -> Surface:
    """Return one of the matrices in an HDF5 file: rows run along y."""
    found = channels(path, name)
    listed = [entry.name for entry in found]
    index = listed.index(chosen(path, listed, asked.channel))
    shape, unit = found[index].shape, found[index].unit
    limits.require_points(path.name, shape, _EACH)
    asked.expect(shape)
    values = _values(path, listed[index])
    about = Provenance(path.name, "matrix (hdf5)", listed[index] if len(listed) > 1 else "")
    return scaled(path, values, about, unit, asked)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the matrices of real numbers in an HDF5 file."""
    try:
        stored = hdf5.check(path)
        import h5py

        with h5py.File(path, "r") as file:
            listed = tuple(
                Channel(array, _unit(file[array]), True, said.shape)
                for array, said in stored.items()
                if len(said.shape) == 2 and min(said.shape) > 1 and said.kind in tuple("fiu")
            )
    except RoughcontactError:
        raise
    # h5py fails on damaged files with OSError, KeyError, RuntimeError and more.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as HDF5 ({one_line(error)}); check that the file is "
            "complete"
        ) from None
    if not listed:
        raise FormatError(f"{path.name} holds no matrix of at least 2 × 2 real numbers")
    return listed


def _values(path: Path, array: str) -> Any:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return np.asarray(file[array][()])
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as HDF5 ({one_line(error)}); check that the file is "
            "complete"
        ) from None


def _unit(array: Any) -> str:
    """Return the unit of length that an array states; empty if it states none."""
    for name in _UNIT_NAMES:
        said = array.attrs.get(name)
        text = said.decode("utf-8", "replace") if isinstance(said, bytes) else said
        if isinstance(text, str) and is_length(Path(), text):
            return text
    return ""
