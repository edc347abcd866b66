"""Export of interface laws to other programs: decks, tables, JSON, arrays."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact._tools.files import atomic_write, to_json, write_atomically
from roughcontact._tools.text import replace_unprintable
from roughcontact._version import __version__
from roughcontact.analyses.law.curve import ERROR, refine_geometrically, thin_points
from roughcontact.analyses.law.model import UNLOADING, InterfaceLaw, LawTable
from roughcontact.units import format_engineering

MAX_ROWS = 200
"""Maximum number of table rows in CalculiX; versions before about 2.16 had 20."""

# Maximum length of a comment line.
_WIDTH = 76

# CalculiX silently moves apart rows that are closer than this [mm].
_MIN_SPACING = 2e-10

# Units of decks: mm, N, s, tonne, K; hence MPa, mW = N mm/s, and mA for currents.
_LENGTH, _PRESSURE, _CONDUCTANCE = 1e3, 1e-6, 1e-3
_SLOPE = _PRESSURE / _LENGTH
_UNITS = "Units: mm, N, s, t, K; pressure in MPa, conductance in mW/(mm^2 K) and mA/(mm^2 V)"


def csv(law: InterfaceLaw) -> str:
    """Return the thinned tables of all branches as text, SI units in the head."""
    head = "branch,pressure [Pa],overclosure [m],separation [m],mean_gap [m],contact_fraction [1]"
    names = ["pressure", "overclosure", "separation", "mean_gap", "contact_fraction"]
    if law.bodies is not None:
        head += ",thermal_conductance [W/(m² K)]"
        names.append("thermal_conductance")
    rows = []
    for table in map(law.table, law.branches):
        columns = [getattr(table, name).tolist() for name in names]
        rows += [",".join([table.branch, *map(repr, row)]) for row in zip(*columns, strict=True)]
    return "\n".join([head, *rows]) + "\n"


def abaqus(law: InterfaceLaw) -> str:
    """Return the surface interactions for an Abaqus deck."""
    text = (
        "The faces represent the mean planes of the rough surfaces. Overclosure 0: the mean planes "
        "meet. Negative overclosure: the faces are apart.",
    )

    def rows(branch: str) -> list[str]:
        keywords = ("*GAP CONDUCTANCE, PRESSURE", "*GAP ELECTRICAL CONDUCTANCE, PRESSURE")
        tables = _conductances(law, branch)
        return [
            line
            for name, (pressure, values) in zip(keywords, tables, strict=False)
            for line in (name, *_rows(values, pressure))
        ]

    def friction(branch: str) -> list[str]:
        assert law.friction is not None
        slip, strength = law.elastic_slip(branch)[-1] * _LENGTH, _shear_strength(law)
        limit = "" if strength is None else f", TAUMAX={strength:.9e}"
        return [
            *_comments(
                "While it sticks, the shear stress is friction p/(elastic slip) times the shift. "
                "The elastic slip is that of the largest pressure."
            ),
            f"*FRICTION, ELASTIC SLIP={slip:.9e}{limit}",
            f"{law.friction.sliding:.9g}",
        ]

    return _make_deck(law, text, lambda table: table.overclosure, rows, friction)


def calculix(law: InterfaceLaw) -> str:
    """Return the surface interactions for a CalculiX deck."""
    text = (
        "The faces represent planes at the highest summits of the rough surfaces. Overclosure 0: "
        "first touch. It is the approach of the mean planes since then.",
        "Use TYPE=NODE TO SURFACE: face-to-face contact of CalculiX 2.20 ignores pressure tables. "
        "Beyond the last row the pressure is constant.",
    )

    def rows(branch: str) -> list[str]:
        return [
            *_comments(
                "Conductance over pressure. In node-to-surface contact with a table of overclosure "
                "CalculiX 2.20 uses the first row at all pressures: give *GAP CONDUCTANCE with the "
                "row of your pressure."
            ),
            *(f"** {row}" for row in _rows(*_conductances(law, branch)[0][::-1])),
        ]

    def friction(branch: str) -> list[str]:
        assert law.friction is not None
        pressure, slopes = _stick_slopes(law, branch)
        return [
            *_comments(
                "Stick slope over pressure. The last row is used: give the row of your pressure."
            ),
            *(f"** {row}" for row in _rows(slopes, pressure)),
            "*FRICTION",
            f"{law.friction.sliding:.9g}, {slopes[-1]:.9e}",
        ]

    return _make_deck(law, text, _overclosure, rows, friction)


def ansys(law: InterfaceLaw) -> str:
    """Return real constants of contact elements for Ansys Mechanical APDL."""
    lines = [
        *_comment_head(law, "!"),
        f"! {_UNITS}",
        *_comments(
            "The faces represent planes at the highest summits. Model them just touching. Before "
            "reading this file, set CID to the real constants of the contact elements (CONTA172 "
            "or CONTA174, pure penalty KEYOPT(2)=1, KEYOPT(10)=2) and MID to their material. "
            "FKN is the pressure over the penetration. Negative values are absolute, not factors.",
            "!",
        ),
    ]
    for table in (_thin_table(law, branch) for branch in law.branches):
        lines.append(f"! {_words(table)}")
        name = f"ROUGH_{table.branch.upper()}"
        across, pressure = _overclosure(table)[1:] * _LENGTH, table.pressure[1:] * _PRESSURE
        constants = {"FKN": (3, "GAP", across, -pressure / across)}
        if law.friction is not None:
            own, slopes = _stick_slopes(law, table.branch)
            constants["FKT"] = (12, "PRESSURE", own, -slopes)
        for (number, key), item in zip(
            ((14, "TCC"), (19, "ECC")), _conductances(law, table.branch), strict=False
        ):
            constants[key] = (number, "PRESSURE", *item)
        # Real constants describe one branch.
        mark = "! " if table.branch == UNLOADING else ""
        for key, (number, variable, first, second) in constants.items():
            lines += [
                f"*DIM,{name}_{key},TABLE,{first.size},1,1,{variable}",
                *(
                    f"{name}_{key}({row},0)={x:.9e} $ {name}_{key}({row},1)={y:.9e}"
                    for row, (x, y) in enumerate(
                        zip(first.tolist(), second.tolist(), strict=True), start=1
                    )
                ),
                f"{mark}RMODIF,CID,{number},%{name}_{key}%",
            ]
    if law.friction is not None:
        strength = _shear_strength(law)
        lines += [] if strength is None else [f"RMODIF,CID,9,{strength:.9e}"]
        lines.append(f"MP,MU,MID,{law.friction.sliding:.9g}")
    return "\n".join(lines) + "\n"


def moose(law: InterfaceLaw) -> str:
    """Return functions for an input file of MOOSE, in SI units."""
    lines = [
        *_comment_head(law, "#"),
        *_comments(
            "Units: m, Pa, W/(m^2 K), S/m^2. The faces represent planes at the highest summits. "
            "Pressure is over the approach of the mean planes since first touch, conductance over "
            "pressure. For c_normal use the slope given with a branch.",
            "#",
        ),
        "[Functions]",
    ]
    for table in (_thin_table(law, branch) for branch in law.branches):
        slope = float(np.diff(table.pressure)[-1] / np.diff(_overclosure(table))[-1])
        lines.append(f"  # {_words(table)}; c_normal = {slope:.4e} Pa/m at the largest pressure")
        tables = {"pressure": (_overclosure(table), table.pressure)}
        if law.friction is not None:
            own, slopes = _stick_slopes(law, table.branch)
            tables["stick_slope"] = (own / _PRESSURE, slopes / _SLOPE)
        for key, (pressure, values) in zip(
            ("thermal_conductance", "electrical_conductance"),
            _conductances(law, table.branch),
            strict=False,
        ):
            tables[key] = (pressure / _PRESSURE, values / _CONDUCTANCE)
        for key, columns in tables.items():
            x, y = (" ".join(f"{value:.9e}" for value in column.tolist()) for column in columns)
            lines += [
                f"  [rough_{table.branch}_{key}]",
                "    type = PiecewiseLinear",
                f"    x = '{x}'",
                f"    y = '{y}'",
                "  []",
            ]
    return "\n".join([*lines, "[]"]) + "\n"


def lubrication(law: InterfaceLaw) -> str:
    """Return asperity pressure over separation and Greenwood-Tripp parameters as text."""
    result, table = law.asperities, law.table()
    sigma = result.deviation
    lines = [
        *_comment_head(law, "#"),
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
    """Return the columns of each branch over the pressure."""
    return {
        f"{branch}_{name}": np.asarray(values)
        for branch, columns in law.summary()["branches"].items()
        for name, values in columns.items()
    }


def _numbers(law: InterfaceLaw) -> str:
    return to_json(law.summary()) + "\n"


_TEXTS: dict[str, Callable[[InterfaceLaw], str]] = {
    ".csv": csv,
    ".json": _numbers,
    ".inp": abaqus,
    ".ccx": calculix,
    ".txt": lubrication,
    ".mac": ansys,
    ".i": moose,
}


def save(law: InterfaceLaw, path: str | os.PathLike[str]) -> None:
    """Write a law in the format of the file suffix; see `formats.export`."""
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        with atomic_write(path) as stream:
            np.savez(stream, **arrays(law))
        return
    write_atomically(path, _TEXTS[suffix](law))


def _comment_head(law: InterfaceLaw, mark: str) -> list[str]:
    names = ", ".join(item.name for item in law.maps)
    result = law.resolved
    low, high = (format_engineering(end, "Pa", 4) for end in (result.low, result.high))
    return [
        f"{mark} Interface law of {_ascii(names)}",
        f"{mark} roughcontact {__version__}; mean of {len(law.maps)} map(s)",
        f"{mark} resolved from {_ascii(low)} to {_ascii(high)}",
    ]


def _ascii(text: str) -> str:
    return replace_unprintable(text).replace("µ", "u").encode("ascii", "replace").decode()


def _make_deck(
    law: InterfaceLaw,
    notes: tuple[str, ...],
    overclosure: Callable[[LawTable], Array],
    conductance: Callable[[str], list[str]],
    friction: Callable[[str], list[str]],
) -> str:
    """Return a surface interaction for each branch, with friction and conductance if known."""
    lines = [
        *_comment_head(law, "**"),
        f"** {_UNITS}",
        *(line for text in notes for line in _comments(text)),
    ]
    for table in (_thin_table(law, branch) for branch in law.branches):
        across = overclosure(table) * _LENGTH
        selected = [0]
        for number in range(1, across.size):
            if across[number] - across[selected[-1]] >= _MIN_SPACING:
                selected.append(number)
        lines += [
            f"** {_words(table)}",
            f"*SURFACE INTERACTION, NAME=ROUGH_{table.branch.upper()}",
            "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
            *_rows(table.pressure[selected] * _PRESSURE, across[selected]),
            *(friction(table.branch) if law.friction is not None else ()),
            *(conductance(table.branch) if law.bodies is not None else ()),
        ]
    return "\n".join(lines) + "\n"


def _words(table: LawTable) -> str:
    words = "unloading and loading again" if table.branch == UNLOADING else "first loading"
    return f"{words}; linear interpolation is accurate to {100 * table.error:.3g} %"


def _overclosure(table: LawTable) -> Array:
    """Return the approach of the mean planes since first touch [m]."""
    return table.separation[0] - table.separation


def _comments(text: str, mark: str = "**") -> list[str]:
    return [f"{mark} {line}" for line in textwrap.wrap(text, _WIDTH)]


def _thin_table(law: InterfaceLaw, branch: str) -> LawTable:
    """Return a table within the row limit of CalculiX, if necessary with a larger error."""
    table = law.table(branch)
    while table.pressure.size > MAX_ROWS:
        table = law.table(branch, 1.5 * table.error)
    return table


def _stick_slopes(law: InterfaceLaw, branch: str) -> tuple[Array, Array]:
    """Return pressures and tangential stiffness per area of a branch, in deck units."""
    steps = law.branch_steps(branch)
    slopes = np.array([step.tangential_stiffness for step in steps])
    return np.array([step.pressure for step in steps]) * _PRESSURE, slopes * _SLOPE


def _shear_strength(law: InterfaceLaw) -> float | None:
    """Return the shear strength of the softer body in deck units, or None."""
    strength = math.inf if law.friction is None else law.friction.shear_strength
    return strength * _PRESSURE if math.isfinite(strength) else None


def _conductances(law: InterfaceLaw, branch: str) -> list[tuple[Array, Array]]:
    """Return pressure with thermal, then electrical conductance, as far as known."""
    pressure, tables = law.pressures(branch), []
    for values in (law.thermal_conductance(branch), law.electrical_conductance(branch)):
        there = np.isfinite(values)
        if not there.any():
            break
        fine = refine_geometrically(pressure[there])
        result = np.exp(np.interp(np.log(fine), np.log(pressure[there]), np.log(values[there])))
        rows = thin_points(fine, result, ERROR)
        tables.append(
            (
                np.concatenate([[0.0], fine[rows] * _PRESSURE]),
                np.concatenate([[0.0], result[rows] * _CONDUCTANCE]),
            )
        )
    return tables


def _rows(first: Array, second: Array) -> list[str]:
    return [f"{a:.9e}, {b:.9e}" for a, b in zip(first.tolist(), second.tolist(), strict=True)]
