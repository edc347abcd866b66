"""Damage to files of results: what bad disks, cut transfers and careless hands leave behind."""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

# What a hand may write into the attributes of a result; none of it can be the result of a solve.
EDITS: tuple[tuple[str, Any], ...] = (
    ("load", -1.0), ("load", 0.0), ("load", math.nan), ("load", math.inf), ("load", 1e300),
    ("load", 0.7), ("certificate", -1.0), ("certificate", math.nan), ("certificate", 1.0),
    ("load_error", -1.0), ("load_error", math.nan), ("load_error", 0.5),
    ("boundary", "garbage"), ("ceiling", -1.0), ("ceiling", 0.0), ("ceiling", math.nan),
    ("ceiling", 1.0), ("tolerance", -1.0), ("tolerance", math.inf), ("tolerance", 1e-30),
    ("pixel_x", -1e-6), ("pixel_x", 1e-30), ("pixel_y", 1e12), ("pixel_y", 1e-6),
    ("convolutions", -5), ("iterations", -1), ("status", "garbage"), ("status", ""),
    ("precision", "triple"), ("control", "magic"), ("approach", math.inf), ("approach", math.nan),
    ("tilt_y", math.inf), ("contact_modulus", -1.0), ("contact_modulus", 1.0),
    ("material_young", -1.0), ("material_young", 1e300), ("material_poisson", 0.7),
    ("material_yield_strength", -1.0), ("seconds", -1.0), ("seconds", math.nan),
)  # fmt: skip
KINDS = ("flipped", "flipped", "cut", "zeroed", "edited")


def damaged(content: bytes, kind: str, rng: np.random.Generator) -> bytes:
    """Return bytes with one bit turned, the end cut off, or a run of zeros."""
    changed = bytearray(content)
    place = int(rng.integers(len(content)))
    if kind == "flipped":
        changed[place] ^= 1 << int(rng.integers(8))
    elif kind == "cut":
        del changed[place:]
    else:
        end = min(place + int(rng.choice([1, 8, 64, 512, 4096])), len(content))
        changed[place:end] = bytes(end - place)
    return bytes(changed)


def edit(path: Path, name: str, value: Any) -> None:
    """Give a file another attribute, as a hand does that knows HDF5 and nothing of results."""
    with h5py.File(path, "a") as file:
        file.attrs[name] = value


def held(thing: Any) -> Any:
    """Return all that a result holds, to the bit."""
    if is_dataclass(thing):
        return {field.name: held(getattr(thing, field.name)) for field in fields(thing)}
    if isinstance(thing, np.ndarray):
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, (tuple, list)):
        return [held(part) for part in thing]
    return repr(thing)


def copies(content: bytes, path: Path, count: int, seed: int = 0) -> Any:
    """Write a file again and again, damaged each time, and yield in which way."""
    for number in range(count):
        rng = np.random.default_rng([13, seed, number])
        kind = KINDS[number % len(KINDS)]
        if kind == "edited":
            path.write_bytes(content)
            name, value = EDITS[number // len(KINDS) % len(EDITS)]
            edit(path, name, value)
            yield f"{name} = {value!r}"
            continue
        changed = damaged(content, kind, rng)
        if changed != content:
            path.write_bytes(changed)
            yield f"{kind}, {number}"
