"""Python script that repeats a result, generated from the data stored in the result."""

from __future__ import annotations

import inspect
import math
import textwrap
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools.text import replace_unprintable
from roughcontact.contact.result import CALIBRATED, ContactResult
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Kinematic
from roughcontact.material.material import RIGID, Layer, Material
from roughcontact.surface.generation import generate
from roughcontact.surface.provenance import NOTE, Operation, Provenance
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from roughcontact.elastoplastic.volume_result import ElastoplasticResult

# Longer chains are split into one call per line.
_WIDTH = 96

# File name that a script assumes; a result does not record its file.
_RESULT = "result.nc"


def script_of_result(result: ContactResult) -> str:
    """Return a script that repeats the solve of a contact."""
    script = _Script()
    script.add_maps(result)
    ceiling = script.ceiling(result)
    bodies = _materials(result)
    if result.calibration is None:
        # No other ceiling depends on the hardening law, which would need an import.
        bodies = {name: replace(body, hardening=None) for name, body in bodies.items()}
    script.add_laws(bodies)
    script.lines += [
        "result = rc.solve(",
        *(f"    {specified}," for specified in _solve_arguments(result, bodies, ceiling)),
        ")",
    ]
    return script.text()


def script_of_map(surface: Surface) -> str:
    """Return a script that recreates a map."""
    script = _Script()
    script.add_map("surface", surface)
    return script.text()


def repeating_volume(result: ElastoplasticResult) -> str:
    """Return a script that repeats the load path of an elastoplastic contact."""
    contact = result.solution
    if not result.increments:
        return ""
    script = _Script(".solution")
    script.add_maps(contact)
    materials = _materials(contact)
    script.add_laws(materials)
    thickness = (_number(value) for value in result.bodies[0].thickness)
    lines = script.lines
    lines.append("layers = [  # from the surface down [m]")
    lines += textwrap.wrap(
        ", ".join(thickness) + ",", 90, initial_indent="    ", subsequent_indent="    "
    )
    lines += ["]", "result = rc.solve_elastoplastic(", "    surface,"]
    if result.has_moved:
        lines += ["    path=[", *_points(result), "    ],"]
    else:
        loads = ", ".join(_number(step.load) for step in result.increments)
        lines += textwrap.wrap(
            f"loads=[{loads}],", 90, initial_indent="    ", subsequent_indent="        "
        )
    lines += [f"    {name}={_material(body)}," for name, body in materials.items()]
    if contact.counter_surface is not None:
        lines.append("    counter_surface=counter_surface,")
    if contact.boundary is not Boundary.FREE:
        lines.append(f'    boundary="{contact.boundary}",')
    lines += [
        "    increments=1,",
        "    layers=layers,",
        f"    tolerance={_number(result.tolerance)},",
    ]
    if result.precision != "single":
        lines.append(f'    precision="{result.precision}",')
    lines.append(")")
    return script.text()


class _Script:
    """Lines of a Python script and the required imports."""

    def __init__(self, held: str = "") -> None:
        self.held = held
        self.imports = {"import roughcontact as rc"}
        self.lines: list[str] = []
        self.names: set[str] = set()

    def text(self) -> str:
        """Return the script."""
        order = sorted(self.imports, key=lambda line: (line.startswith("from"), line))
        return "\n".join([*order, "", *self.lines])

    def comment(self, text: str) -> None:
        """Add a comment from a name in a file, on one line."""
        self.lines.append(f"# {replace_unprintable(text)}")

    def add_laws(self, bodies: Mapping[str, Material]) -> None:
        """Add the imports of the hardening laws of bodies."""
        laws = {m.hardening for m in bodies.values() if m.hardening}
        laws |= {law.isotropic for law in laws if isinstance(law, Kinematic)}
        if laws:
            names = sorted({type(law).__name__ for law in laws})
            self.imports.add(f"from roughcontact.material.hardening import {', '.join(names)}")

    def add_maps(self, result: ContactResult) -> None:
        """Add the lines that create the surfaces of a result."""
        self.add_map("surface", result.surface)
        if result.counter_surface is not None:
            self.add_map("counter_surface", result.counter_surface)

    def add_map(self, name: str, surface: Surface) -> None:
        """Add the lines that create a surface of a result."""
        lost = _unrepeatable_steps(surface.provenance)
        if lost:
            self.comment(f"No script can repeat these steps: {'; '.join(lost)}")
            self.comment("The prepared map is in the file of the result.")
            self.lines.append(f'{name} = rc.read_result("{_RESULT}"){self.held}.{name}')
        else:
            self.add(name, surface.traced())

    def ceiling(self, result: ContactResult) -> str:
        """Return the code of the ceiling of a result; add the lines that it needs."""
        if result.ceiling is None:
            return "None"
        if result.calibration is not None:
            return _quote(CALIBRATED)
        if not isinstance(result.ceiling, np.ndarray):
            return _number(result.ceiling)
        self.comment("One ceiling per point, from the file of the result.")
        self.lines.append(f'ceiling = rc.read_result("{_RESULT}").ceiling')
        return "ceiling"

    def add(self, name: str, about: Provenance) -> str:
        """Add the lines that create one map, and return its variable name."""
        number = 2
        wanted = name
        while name in self.names:
            name, number = f"{wanted}_{number}", number + 1
        self.names.add(name)
        calls = [self.origin(name, about)]
        for step in about.operations:
            method = getattr(Surface, step.method, None)
            if method is not None:
                calls.append(f"{step.method}({self.arguments(method, step.arguments)})")
        line = f"{name} = {'.'.join(calls)}"
        if len(line) > _WIDTH and len(calls) > 1:
            self.lines += [f"{name} = (", f"    {calls[0]}"]
            self.lines += [*(f"    .{call}" for call in calls[1:]), ")"]
        else:
            self.lines.append(line)
        return name

    def origin(self, name: str, about: Provenance) -> str:
        """Return the call that originally created a map."""
        created = about.origin
        assert created is not None
        specified = dict(created.arguments)
        if created.method == "read_surface":
            path = specified.pop("path")
            words = [
                _literal(path),
                *_keyword_arguments({k: v for k, v in specified.items() if v is not None}),
            ]
            return f"rc.read_surface({', '.join(words)})"
        if created.method == "generate":
            specified["rng"] = specified.pop("seed")
            return f"rc.generate({self.arguments(generate, specified)})"
        if created.method == "reference_map":
            return f"rc.Surface(*rc.reference_map({', '.join(_keyword_arguments(specified))}))"
        if created.method == "Surface":
            return self.array(name, about, created)
        self.imports.add("from roughcontact.surface import nominal_bodies")
        specified = {k: v for k, v in specified.items() if v is not None}
        method = created.method.replace("nominal.", "nominal_bodies.")
        return f"{method}({', '.join(_keyword_arguments(specified))})"

    def array(self, name: str, about: Provenance, created: Operation) -> str:
        """Return the call that creates a map from an array supplied by the user."""
        self.imports.add("import numpy as np")
        ny, nx = created.found["shape"]
        digest = created.found.get("sha256")
        self.comment(
            f"An array in memory: supply it as {name}.npy, {ny} × {nx} heights in meters"
            + (f", SHA-256 of its bytes {digest[:16]}…" if digest else "")
        )
        words = [f'np.load("{name}.npy")', f"pixel={_literal(created.arguments['pixel'])}"]
        pieces = [about.source, about.instrument, about.channel]
        notes = [step.arguments["text"] for step in about.operations if step.method == NOTE]
        while pieces and not pieces[-1]:
            pieces.pop()
        if pieces or notes:
            parts = [
                *map(_literal, pieces),
                *([f"steps={_literal(tuple(notes))}"] if notes else []),
            ]
            words.append(f"provenance=rc.Provenance({', '.join(parts)})")
        if created.arguments["holes_masked"]:
            words.append("holes_masked=True")
        return f"rc.Surface({', '.join(words)})"

    def arguments(self, method: Any, specified: Mapping[str, Any]) -> str:
        """Return the arguments of a call that differ from the defaults."""
        words, named = [], inspect.Parameter.KEYWORD_ONLY
        for name, parameter in inspect.signature(method).parameters.items():
            if name not in specified or specified[name] == parameter.default:
                continue
            value = specified[name]
            text = self.add(name, value) if isinstance(value, Provenance) else _literal(value)
            placed = parameter.default is parameter.empty and parameter.kind is not named
            words.append(text if placed else f"{name}={text}")
        return ", ".join(words)


def _solve_arguments(
    result: ContactResult, bodies: Mapping[str, Material], ceiling: str
) -> list[str]:
    """Return the arguments of `solve` that differ from the defaults."""
    value = result.load if result.control == "load" else result.approach
    specified = [
        "surface",
        f"{result.control}={_number(value)}",
        f"material={_material(bodies.get('material', result.material))}",
    ]
    if result.moments is not None:
        about_y, about_x = result.moments
        specified.append(f"moments=({_number(about_y)}, {_number(about_x)})")
    if "counter_material" in bodies:
        specified.append(f"counter_material={_material(bodies['counter_material'])}")
    if result.counter_surface is not None:
        specified.append("counter_surface=counter_surface")
    specified.append(f"ceiling={ceiling}")
    # The boundary of a free profile is stored as periodic along y.
    free = Boundary.PERIODIC_Y if result.pair.is_profile else Boundary.FREE
    if result.boundary is not free:
        specified.append(f'boundary="{result.boundary}"')
    single = result.precision == "single"
    if single:
        specified.append('precision="single"')
    if result.tolerance != (1e-4 if single else 1e-6):
        specified.append(f"tolerance={_number(result.tolerance)}")
    return specified


def _unrepeatable_steps(about: Provenance) -> list[str]:
    """Return the steps that a script cannot repeat, as text."""
    steps = list(about.operations)
    if about.origin is not None and about.origin.method == "Surface":
        # The script repeats these notes with the array.
        while steps and steps[0].method == NOTE:
            del steps[0]
    return [
        *(text for step in steps if step.method not in vars(Surface) for text in step.sentences),
        *(
            text
            for step in steps
            for value in step.arguments.values()
            if isinstance(value, Provenance)
            for text in _unrepeatable_steps(value)
        ),
    ]


def _points(result: ElastoplasticResult) -> list[str]:
    """Return the points of a path as code, relative to the final position."""
    last = result.increments[-1].offset
    lines = []
    for step in result.increments:
        y, x = (now - end for now, end in zip(step.offset, last, strict=True))
        words = [_number(step.load), f"({_number(y)}, {_number(x)})"]
        if step.friction:
            words += [_number(step.friction), _number(step.direction)]
        lines.append(f"        rc.PathPoint({', '.join(words)}),")
    return lines


def _materials(result: ContactResult) -> dict[str, Material]:
    materials = {"material": result.material, "counter_material": result.counter_material}
    return {name: body for name, body in materials.items() if body != RIGID}


def _creation_call(value: Material | Layer, *absent: str) -> str:
    """Return the call that creates a material or a layer, with all values but the defaults."""
    words = [
        f"{item.name}={_value(getattr(value, item.name))}"
        for item in fields(value)
        if getattr(value, item.name) != item.default and item.name not in absent
    ]
    return f"rc.{type(value).__name__}({', '.join(words)})"


def _material(body: Material) -> str:
    # A hardening law includes the yield strength.
    return _creation_call(body, *(["yield_strength"] if body.hardening is not None else []))


def _value(value: Any) -> str:
    if isinstance(value, float):
        return 'float("inf")' if math.isinf(value) else _number(value)
    if isinstance(value, tuple):
        return f"[{', '.join(map(_creation_call, value))}]"
    return _quote(value) if isinstance(value, str) else repr(value)


def _number(value: float) -> str:
    short = f"{value:g}"
    # An integer has the same value without a decimal point, except for the sign of zero.
    return short if value and float(short) == value else repr(float(value))


def _keyword_arguments(specified: Mapping[str, Any]) -> list[str]:
    return [f"{name}={_literal(value)}" for name, value in specified.items()]


def _literal(value: Any) -> str:
    if isinstance(value, str):
        return _quote(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(_literal, value))}{',' if len(value) == 1 else ''})"
    return repr(value)


def _quote(text: str) -> str:
    plain = text.isprintable() and '"' not in text and "\\" not in text
    return f'"{text}"' if plain else repr(text)
