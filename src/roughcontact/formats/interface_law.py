"""Laws of interfaces for other programs: decks for Abaqus and CalculiX, tables, JSON, arrays."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._version import __version__
from roughcontact.files import atomic_write, to_json, write
from roughcontact.joint.interface_law import UNLOADING, InterfaceLaw, LawTable
from roughcontact.joint.law_curve import ERROR, between, thinned
from roughcontact.units import engineering

Array = NDArray[np.float64]

MOST_ROWS = 200
"""Rows of a table that CalculiX keeps; versions before 2.16 or so kept 20."""

# Longest line of a comment.
_WIDTH = 76

# Rows closer than this CalculiX moves apart [mm]; it says so nowhere.
_CLOSEST = 2e-10

# The units of decks: mm, N, s, tonne, K; hence MPa, and mW = N mm/s.
_LENGTH, _PRESSURE, _CONDUCTANCE = 1e3, 1e-6, 1e-3


def csv(law: InterfaceLaw) -> str:
    """Return the thinned tables of all branches as text, SI units in the head."""
    head = "branch,pressure [Pa],overclosure [m],separation [m],mean_gap [m],contact_fraction [1]"
    names = ["pressure", "overclosure", "separation", "mean_gap", "contact_fraction"]
    if law.bodies is not None:
        head += ",thermal_conductance [W/(m² K)]"
        names.append("thermal_conductance")
    rows = []
    for table in _tables(law):
        columns = [getattr(table, name).tolist() for name in names]
        rows += [",".join([table.branch, *map(repr, row)]) for row in zip(*columns, strict=True)]
    return "\n".join([head, *rows]) + "\n"


def abaqus(law: InterfaceLaw) -> str:
    """Return the surface interactions of a deck for Abaqus."""
    text = (
        "The faces stand for the mean planes of the rough surfaces. Overclosure 0: the mean "
        "planes meet. Negative overclosure: the faces are apart.",
    )

    def rows(branch: str) -> list[str]:
        return ["*GAP CONDUCTANCE, PRESSURE", *_conductance(law, branch)]

    def friction(branch: str) -> list[str]:
        assert law.friction is not None
        slip, strength = law.elastic_slip(branch)[-1] * _LENGTH, law.friction.shear_strength
        limit = f", TAUMAX={strength * _PRESSURE:.9e}" if math.isfinite(strength) else ""
        return [
            *_comments(
                "While it sticks, the shear stress is friction p/(elastic slip) times the shift. "
                "The elastic slip is that of the largest pressure."
            ),
            f"*FRICTION, ELASTIC SLIP={slip:.9e}{limit}",
            f"{law.friction.sliding:.9g}",
        ]

    return _deck(law, text, lambda table: table.overclosure, rows, friction)


def calculix(law: InterfaceLaw) -> str:
    """Return the surface interactions of a deck for CalculiX."""
    text = (
        "The faces stand for planes at the highest summits of the rough surfaces. Overclosure 0: "
        "first touch. It is the distance by which the mean planes came closer since then.",
        "Use TYPE=NODE TO SURFACE: face-to-face contact of CalculiX 2.20 makes no pressure of a "
        "table. Beyond the last row the pressure stays as it is.",
    )

    def rows(branch: str) -> list[str]:
        return [
            *_comments(
                "Conductance over pressure. In node-to-surface contact with a table of overclosure "
                "CalculiX 2.20 takes the first row, whatever the pressure: give *GAP CONDUCTANCE "
                "with the row that fits."
            ),
            *(f"** {row}" for row in _conductance(law, branch)),
        ]

    def friction(branch: str) -> list[str]:
        assert law.friction is not None
        steps = law.of_branch(branch)
        slopes = [step.tangential_stiffness * _PRESSURE / _LENGTH for step in steps]
        return [
            *_comments("Stick slope over pressure. The last row is taken: give that which fits."),
            *(f"** {slope:.9e}, {step.pressure * _PRESSURE:.9e}"
              for slope, step in zip(slopes, steps, strict=True)),
            "*FRICTION",
            f"{law.friction.sliding:.9g}, {slopes[-1]:.9e}",
        ]  # fmt: skip

    return _deck(law, text, lambda table: table.separation[0] - table.separation, rows, friction)


def lubrication(law: InterfaceLaw) -> str:
    """Return asperity pressure over separation, and Greenwood and Tripp's parameters, as text."""
    result, table = law.asperities, law.table()
    sigma = result.deviation
    lines = [
        *_head(law, "#"),
        "# Units: m, Pa. Asperity pressure of the first loading over separation of the mean planes",
        "# over sigma.",
        f"# sigma = {sigma:.6e} m",
        f"# E* = {law.contact_modulus:.6e} Pa",
        "# Greenwood and Tripp from spectral moments of the gap:",
        f"# m0 = {result.m0:.6e} m2, m2 = {result.m2:.6e}, m4 = {result.m4:.6e} 1/m2",
        f"# bandwidth alpha = m0 m4/m2^2 = {result.bandwidth:.4g}",
        f"# summit density eta = {result.density:.6e} 1/m2",
        f"# summit radius R = {result.radius:.6e} m",
        f"# eta R sigma = {result.roughness_parameter:.4g}, sigma/R = {sigma / result.radius:.4e}",
        "# WARNING: m4, and with it eta, R and alpha, is set by the smallest waves, which the",
        "# pixel cuts: another pixel gives others. The pressures below do not use them.",
        "separation/sigma,asperity pressure [Pa]",
        *(
            f"{u / sigma!r},{p!r}"
            for u, p in zip(table.separation.tolist(), table.pressure.tolist(), strict=True)
        ),
    ]
    return "\n".join(lines) + "\n"


def arrays(law: InterfaceLaw) -> dict[str, Any]:
    """Return all that is told of each branch over the pressure."""
    return {
        f"{branch}_{name}": np.asarray(values)
        for branch, columns in law.summary()["branches"].items()
        for name, values in columns.items()
    }


def _numbers(law: InterfaceLaw) -> str:
    return to_json(law.summary()) + "\n"


_TEXTS: dict[str, Callable[[InterfaceLaw], str]] = {
    ".csv": csv, ".json": _numbers, ".inp": abaqus, ".ccx": calculix, ".txt": lubrication,
}  # fmt: skip


def save(law: InterfaceLaw, path: str | os.PathLike[str]) -> None:
    """Write a law in the format that the suffix of the file names; see `formats.export`."""
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        with atomic_write(path) as stream:
            np.savez(stream, **arrays(law))
        return
    write(path, _TEXTS[suffix](law))


def _tables(law: InterfaceLaw) -> Iterator[LawTable]:
    for branch in law.branches:
        yield law.table(branch)


def _head(law: InterfaceLaw, mark: str) -> list[str]:
    names = ", ".join(item.name for item in law.maps)
    result = law.resolved
    low, high = (engineering(end, "Pa", 4) for end in (result.low, result.high))
    return [
        f"{mark} Interface law of {_ascii(names)}",
        f"{mark} roughcontact {__version__}; mean of {len(law.maps)} map(s)",
        f"{mark} resolved from {_ascii(low)} to {_ascii(high)}",
    ]


def _ascii(text: str) -> str:
    return text.replace("µ", "u").encode("ascii", "replace").decode()


def _deck(
    law: InterfaceLaw,
    notes: tuple[str, ...],
    overclosure: Callable[[LawTable], Array],
    conductance: Callable[[str], list[str]],
    friction: Callable[[str], list[str]],
) -> str:
    """Return a surface interaction for each branch, with what else is known of it."""
    lines = [
        *_head(law, "**"),
        "** Units: mm, N, s, t, K; pressure in MPa, conductance in mW/(mm^2 K)",
        *(line for text in notes for line in _comments(text)),
    ]
    for table in (_short(law, branch) for branch in law.branches):
        across = overclosure(table) * _LENGTH
        separately = [0]
        for number in range(1, across.size):
            if across[number] - across[separately[-1]] >= _CLOSEST:
                separately.append(number)
        words = "unloading and loading again" if table.branch == UNLOADING else "first loading"
        lines += [
            f"** {words}; straight lines between rows are right to {100 * table.error:.3g} %",
            f"*SURFACE INTERACTION, NAME=ROUGH_{table.branch.upper()}",
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
            *_rows(table.pressure[separately] * _PRESSURE, across[separately]),
            *(friction(table.branch) if law.friction is not None else ()),
            *(conductance(table.branch) if law.bodies is not None else ()),
        ]
    return "\n".join(lines) + "\n"


def _comments(text: str) -> list[str]:
    return [f"** {line}" for line in textwrap.wrap(text, _WIDTH)]


def _short(law: InterfaceLaw, branch: str) -> LawTable:
    """Return a table with no more rows than CalculiX keeps, at a greater error if need be."""
    table = law.table(branch)
    while table.pressure.size > MOST_ROWS:
        table = law.table(branch, 1.5 * table.error)
    return table


def _conductance(law: InterfaceLaw, branch: str) -> list[str]:
    pressure, values = law.pressures(branch), law.thermal_conductance(branch)
    there = np.isfinite(values)
    fine = between(pressure[there])
    result = np.exp(np.interp(np.log(fine), np.log(pressure[there]), np.log(values[there])))
    rows = thinned(fine, result, ERROR)
    return ["0., 0.", *_rows(result[rows] * _CONDUCTANCE, fine[rows] * _PRESSURE)]


def _rows(first: Array, second: Array) -> list[str]:
    return [f"{a:.9e}, {b:.9e}" for a, b in zip(first.tolist(), second.tolist(), strict=True)]
