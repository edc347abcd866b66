"""The Python script that repeats a result, written from what the result says of itself."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.result import ContactResult
from roughcontact.material.material import RIGID, Material
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from roughcontact.volume.result import ElastoplasticResult

_NUMBER = r"([\d.eE+-]+)"

# Each sentence of a provenance -> the call that wrote it.
_STEPS: tuple[tuple[str, Callable[..., str]], ...] = (
    (r"leveled: least-squares plane subtracted", lambda: "leveled()"),
    (r"leveled: least-squares (\w+) subtracted", lambda form: f'leveled("{form}")'),
    (r"leveled: robust plane .*", lambda: 'leveled("robust")'),
    (
        r"leveled: plane through the points ([\d, ()-]+) subtracted",
        lambda points: f'leveled("three-point", [{points}])',
    ),
    (
        r"form removed: least-squares polynomial of degree (\d+), .*",
        lambda degree: f'without_form("polynomial", {degree})',
    ),
    (
        r"form removed: least-squares (?:convex|concave) (sphere|cylinder) of .*",
        lambda shape: f'without_form("{shape}")',
    ),
    (
        rf"outliers removed: \d+ points further than {_NUMBER} .* median of (\d+) × \d+ points",
        lambda limit, window: f"without_outliers({limit}, {window})",
    ),
    (r"filled: .*", lambda: "filled()"),
    (r"masked: .*", lambda: "masked()"),
    (r"cropped to the largest rectangle .*", lambda: "largest_rectangle()"),
    (
        r"cropped: rows (\d+):(\d+), columns (\d+):(\d+)",
        lambda *ends: "cropped(({}, {}), ({}, {}))".format(*ends),
    ),
    (r"rotated: (\d+) degrees .*", lambda angle: f"rotated({int(angle) // 90})"),
    (
        r"resampled: band-limited, .* to (\d+) × (\d+) points, .*",
        lambda ny, nx: f"resampled(({ny}, {nx}))",
    ),
    (
        r"resampled: by a cubic spline, .* to (\d+) × (\d+) points, .*",
        lambda ny, nx: f'resampled(({ny}, {nx}), method="spline")',
    ),
    (
        rf"filtered: Gaussian S-filter at {_NUMBER} m and L-filter at {_NUMBER} m .*",
        lambda s, l: f"filtered(s={s}, l={l})",  # noqa: E741
    ),
    (
        rf"filtered: Gaussian ([SL])-filter at {_NUMBER} m .*",
        lambda name, cut: f"filtered({name.lower()}={cut})",
    ),
)


def repeating(result: ContactResult) -> str:
    """Return a script that solves the same problem again.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    str
        Lines of Python; empty if the result does not tell enough: if a map does not come from
        an instrument's file, if a step of its preparation is not one of `Surface`'s methods, or
        if the ceiling differs from point to point. Files are named as in the result, without
        their folders; filters have the six digits that the provenance keeps.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(32)
    >>> about = rc.Provenance("ground.opd", "Wyko", steps=("filled: 2 missing points by …",))
    >>> surface = rc.Surface(heights, pixel, about)
    >>> result = rc.solve(surface, load=0.1, material=rc.Material(210e9, 0.3))
    >>> print(repeating(result))
    import roughcontact as rc
    <BLANKLINE>
    surface = rc.read_surface("ground.opd").filled()
    result = rc.solve(
        surface,
        load=0.1,
        material=rc.Material(young=2.1e+11, poisson=0.3),
        ceiling=None,
    )
    """
    if isinstance(result.ceiling, np.ndarray):
        return ""
    lines = ["import roughcontact as rc", ""]
    maps = _maps(result)
    if not maps:
        return ""
    lines += maps
    value = result.load if result.control == "load" else result.approach
    single = result.precision == "single"
    lines += [
        "result = rc.solve(",
        "    surface,",
        f"    {result.control}={_number(value)},",
        f"    material={_material(_without_law(result.material))},",
    ]
    if result.moments is not None:
        about_y, about_x = result.moments
        lines.append(f"    moments=({_number(about_y)}, {_number(about_x)}),")
    if result.counter_material != RIGID:
        lines.append(f"    counter_material={_material(_without_law(result.counter_material))},")
    if result.counter_surface is not None:
        lines.append("    counter_surface=counter_surface,")
    lines.append(f"    ceiling={None if result.ceiling is None else _number(result.ceiling)},")
    if result.boundary.periodic_axes:
        lines.append(f'    boundary="{result.boundary}",')
    if single:
        lines.append('    precision="single",')
    if result.tolerance != (1e-4 if single else 1e-6):
        lines.append(f"    tolerance={_number(result.tolerance)},")
    return "\n".join([*lines, ")"])


def repeating_volume(result: ElastoplasticResult) -> str:
    """Return a script that follows the same path of loads again.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    str
        Lines of Python; empty where `repeating` would give none, and where no load was reached.
        Loads are those of all increments, layers those that the volume had in the end.
    """
    contact = result.contact
    maps = _maps(contact)
    if not maps or not result.increments:
        return ""
    materials = _materials(contact)
    laws = sorted({type(m.hardening).__name__ for m in materials.values() if m.hardening})
    lines = ["import roughcontact as rc"]
    if laws:
        lines.append(f"from roughcontact.material.hardening import {', '.join(laws)}")
    thickness = (_number(float(f"{value:.6g}")) for value in result.bodies[0].thickness)
    lines += ["", *maps, "layers = [  # from the surface down [m]"]
    lines += textwrap.wrap(", ".join(thickness) + ",", 90, initial_indent="    ",
                           subsequent_indent="    ")  # fmt: skip
    loads = ", ".join(_number(step.load) for step in result.increments)
    lines += ["]", "result = rc.solve_elastoplastic(", "    surface,"]
    lines += textwrap.wrap(f"loads=[{loads}],", 90, initial_indent="    ",
                           subsequent_indent="        ")  # fmt: skip
    lines += [f"    {name}={_material(body)}," for name, body in materials.items()]
    if contact.counter_surface is not None:
        lines.append("    counter_surface=counter_surface,")
    if contact.boundary.periodic_axes:
        lines.append(f'    boundary="{contact.boundary}",')
    lines += ["    layers=layers,", f"    tolerance={_number(result.tolerance)},"]
    if result.precision != "single":
        lines.append(f'    precision="{result.precision}",')
    return "\n".join([*lines, ")"])


def _maps(result: ContactResult) -> list[str]:
    """Return the lines that read the maps; none if one of them cannot be read again."""
    lines = []
    for name, surface in (
        ("surface", result.surface), ("counter_surface", result.counter_surface)
    ):  # fmt: skip
        if surface is None:
            continue
        read = _reading(surface)
        if not read:
            return []
        lines.append(f"{name} = {read}")
    return lines


def _materials(result: ContactResult) -> dict[str, Material]:
    materials = {"material": result.material, "counter_material": result.counter_material}
    return {name: body for name, body in materials.items() if body != RIGID}


def _reading(surface: Surface) -> str:
    about = surface.provenance
    # Matrices have no unit of their own, and what was said of it is not kept.
    from_file = bool(about.instrument) and not about.instrument.startswith("matrix")
    if not from_file or not Path(about.source).suffix or not about.source.isprintable():
        return ""
    channel = f", channel={_quoted(about.channel)}" if about.channel else ""
    calls = [f"rc.read_surface({_quoted(about.source)}{channel})"]
    for step in about.steps:
        call = _call(step)
        if not call:
            return ""
        calls.append(call)
    return ".".join(calls)


def _call(step: str) -> str:
    for pattern, write in _STEPS:
        match = re.fullmatch(pattern, step)
        if match:
            return write(*match.groups())
    return ""


def _material(body: Material) -> str:
    young = 'float("inf")' if body.young == RIGID.young else _number(body.young)
    words = [f"young={young}", f"poisson={_number(body.poisson)}"]
    if body.hardening is not None:
        words.append(f"hardening={body.hardening!r}")
    elif body.yield_strength is not None:
        words.append(f"yield_strength={_number(body.yield_strength)}")
    if body.hardness is not None:
        words.append(f"hardness={_number(body.hardness)}")
    if body.name:
        words.append(f"name={_quoted(body.name)}")
    return f"rc.Material({', '.join(words)})"


def _without_law(body: Material) -> Material:
    # The ceiling has no use for it, and its name would have to be imported.
    return replace(body, hardening=None)


def _number(value: float) -> str:
    short = f"{value:g}"
    return short if float(short) == value else repr(float(value))


def _quoted(text: str) -> str:
    plain = text.isprintable() and '"' not in text and "\\" not in text
    return f'"{text}"' if plain else repr(text)
