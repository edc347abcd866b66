"""Repeated passes on disk: the last state, and what each pass did."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from roughcontact import netcdf
from roughcontact.contact import archive as contact_archive
from roughcontact.errors import InputError
from roughcontact.volume import archive
from roughcontact.volume.passes import Pass
from roughcontact.volume.rolling import Rolling

_NUMBERS = {
    "flow": ("1", "largest plastic strain that the pass added, there and back counted"),
    "gain": ("1", "largest plastic strain that is left of it"),
    "max_pressure": ("Pa", "largest contact pressure on the way"),
    "max_plastic_strain": ("1", "largest accumulated plastic strain after the pass"),
    "max_residual_stress": ("Pa", "largest von Mises stress by the plastic strain alone"),
    "max_residual_displacement": ("m", "deepest residual displacement"),
    "steps": ("1", "increments"),
    "contact_area": ("m2", "largest contact area on the way"),
    "approach": ("m", "largest approach on the way"),
    "Sq": ("m", "root-mean-square height of the rough body after the pass"),
    "Spk": ("m", "reduced peak height of the rough body after the pass"),
}
_PROFILES = {
    "shear": ("1", "shear strain along the first pass that the pass added"),
    "residual_along": ("Pa", "normal stress by the plastic strain alone, along the pass"),
    "residual_across": ("Pa", "normal stress by the plastic strain alone, across the pass"),
}


def save_rolling(rolling: Rolling, path: str | os.PathLike[str]) -> None:
    """Write passes and their last state to a NetCDF file; `load_rolling` reads it.

    Parameters
    ----------
    rolling : Rolling
        The passes.
    path : str or path
        File to write; an old one is replaced when the new one is complete. What reads results of
        the volume model reads the last state from it.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written; an old file survives.
    """
    dataset, packed = archive.to_dataset(rolling.result)
    for name, (unit, text) in _NUMBERS.items():
        values = np.array([getattr(one, name) for one in rolling.passes])
        dataset[f"pass_{name}"] = ("pass", values, {"units": unit, "long_name": text})
    layers = rolling.result.bodies[0].thickness.size
    for name, (unit, text) in _PROFILES.items():
        # The volume may have become deeper on the way.
        profiles = np.zeros((len(rolling.passes), len(rolling.result.bodies), layers))
        for number, one in enumerate(rolling.passes):
            values = getattr(one, name)
            profiles[number, :, : values.shape[1]] = values
        about = {"units": unit, "long_name": f"{text}, layer by layer"}
        dataset[f"pass_{name}"] = (("pass", "yielding_body", "layer"), profiles, about)
    dataset.attrs |= {
        "rolling_direction": rolling.direction,
        "rolling_to_and_fro": int(rolling.to_and_fro),
        "rolling_step": rolling.step,
        "rolling_requested": rolling.requested,
    }
    if rolling.axis is not None:
        dataset.attrs["rolling_axis"] = rolling.axis
    netcdf.write(dataset, path, packed)


def load_rolling(path: str | os.PathLike[str]) -> Rolling:
    """Read passes that `Rolling.save` wrote.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    Rolling
        The same; every number keeps its bits.

    Raises
    ------
    FormatError
        If the file is missing, damaged, changed or holds no passes.
    """
    dataset = contact_archive.opened(path)
    with contact_archive.refused(Path(path), "Rolling"):
        columns = {
            name: np.array(dataset[f"pass_{name}"].values) for name in (*_NUMBERS, *_PROFILES)
        }
        steps = columns["steps"].tolist()
        rows = zip(*(columns[name].tolist() for name in _NUMBERS), strict=True)
        passes = tuple(
            replace(
                Pass(**dict(zip(_NUMBERS, row, strict=True))),
                **{name: columns[name][number] for name in _PROFILES},
            )
            for number, row in enumerate(rows)
        )
        result, axis = archive.from_dataset(dataset), dataset.attrs.get("rolling_axis")
        # Those of a run that went on from another one come first.
        if not 0 < sum(steps) <= len(result.increments):
            raise InputError("must be those of the increments", argument="steps")
        return Rolling(
            result=result,
            passes=passes,
            direction=float(dataset.attrs["rolling_direction"]),
            to_and_fro=bool(dataset.attrs["rolling_to_and_fro"]),
            # Earlier files tell none of them.
            requested=int(dataset.attrs.get("rolling_requested", 0)),
            step=float(dataset.attrs.get("rolling_step", 0.0)),
            axis=None if axis is None else float(axis),
        )
