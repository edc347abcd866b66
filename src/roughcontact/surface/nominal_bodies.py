"""Nominal bodies (sphere, cylinder, punch, …) as surfaces, and their parsing from text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, overload

import numpy as np

from roughcontact import units
from roughcontact._tools.arrays import Array, Shape
from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.surface import shapes
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, to_si


class NominalBody(partial[Surface]):
    """Nominal body without a grid; called with ``shape`` and ``pixel`` it gives a surface."""

    def sample_body(self, surface: Surface) -> Surface:
        """Return the body on the grid of a map; on the grid of a profile, its cross-section."""
        values = self.keywords
        if surface.is_profile and self.func is not flat:
            if self.func not in (cylinder, wedge) or values["angle"] not in (0.0, 90.0):
                raise InputError(
                    "a profile takes 'flat', a cylinder such as 'cylinder 5 mm' or a wedge such as "
                    "'wedge 0.01', which continue unchanged across it"
                )
            values = {**values, "angle": 90.0}
        return self.func(shape=surface.shape, pixel=surface.pixel, **values)


def flat(*, shape: Shape, pixel: Quantities, center: tuple[float, float] | None = None) -> Surface:
    """Return a flat body."""
    edges = to_si(pixel, "length", "pixel")
    origin = Operation("nominal.flat", {"shape": shape, "pixel": edges})
    return Surface(shapes.flat(shape, edges), edges, Provenance("nominal flat", origin=origin))


def _length(value: float) -> str:
    return units.format_engineering(value, "m", 6)


def _round(word: str, radius: float) -> str:
    return f"{'concave ' if radius < 0 else ''}{word} of radius {_length(abs(radius))}"


def _edge(edge_radius: float) -> str:
    return f" with an edge radius of {_length(edge_radius)}" if edge_radius else ""


# Arguments without a unit.
_PLAIN = ("slope", "angle")
_OPTIONS = {
    "": "",
    "angle": "; ``angle`` [degrees], counter-clockwise from x, 0 by default",
    "edge_radius": "; ``edge_radius`` [m], 0 by default",
}

_CONTRACT = """Return a nominal {word}, on a grid or for the grid of a rough map.

Parameters
----------
size : float, str, quantity of pint or a pair of them
    {size_text}, also by the name ``{size}``.
shape : (int, int), optional
    Grid points ``(ny, nx)``.
pixel : (float, float), optional
    Pixel edges ``(dy, dx)`` [m]; given with ``shape``.
center : (float, float), optional
    Position of the axis ``(row, column)``; the center of the grid by default.
**sizes
    ``{size}`` without ``size``{option}.

Returns
-------
Surface or NominalBody
    Heights on the grid; without ``shape`` and ``pixel`` a body for ``counter_surface``.

Raises
------
InputError
    If an argument cannot be used.
"""


@dataclass(frozen=True, eq=False, repr=False)
class NominalForm:
    """Kind of nominal body; called with size, ``shape`` and ``pixel`` it gives a surface."""

    name: str  # Name in this module and of its heights in `shapes`
    size: str  # Argument for the size
    size_text: str  # Size as messages call it
    description: Callable[..., str]  # Function that formats size and option
    examples: tuple[str, ...] = ()  # Texts that `parse` accepts
    option: str = ""  # Another argument, 0 by default
    count: int = 1  # Number of values of the size, along y first
    curvatures: Callable[[Any], tuple[float, float]] | None = None  # Curvatures along y and x [1/m]

    def __post_init__(self) -> None:
        """Set the docstring of the call."""
        about = _CONTRACT.format(
            word=self.word,
            size=self.size,
            size_text=self.size_text.capitalize(),
            option=_OPTIONS[self.option],
        )
        object.__setattr__(self, "__doc__", about)

    def __repr__(self) -> str:
        """Return the name, by which other processes unpickle the object."""
        return self.name

    __reduce__ = __repr__

    @property
    def word(self) -> str:
        """Name in texts; both punches share one."""
        return self.name.rpartition("_")[2]

    @overload
    def __call__(
        self,
        size: Any = None,
        /,
        *,
        shape: Shape,
        pixel: Quantities,
        center: tuple[float, float] | None = None,
        **sizes: Any,
    ) -> Surface: ...

    @overload
    def __call__(
        self, size: Any = None, /, *, center: tuple[float, float] | None = None, **sizes: Any
    ) -> NominalBody: ...

    def __call__(
        self,
        size: Any = None,
        /,
        *,
        shape: Shape | None = None,
        pixel: Quantities | None = None,
        center: tuple[float, float] | None = None,
        **sizes: Any,
    ) -> Surface | NominalBody:
        """Return the body on a grid, or without one."""
        specified = [*([] if size is None else [(self.size, size)]), *sizes.items()]
        sizes = self._check_options(specified)
        if shape is None and pixel is None:
            return NominalBody(self, center=center, **sizes)
        if shape is None or pixel is None:
            missing = "shape" if shape is None else "pixel"
            raise InputError("is needed for a grid; leave out both for none", argument=missing)
        edges = to_si(pixel, "length", "pixel")
        heights: Array = getattr(shapes, self.name)(shape, edges, center=center, **sizes)
        sizes = {name: sizes[name] for name in (self.size, self.option) if name}
        beyond = int(np.count_nonzero(np.isnan(heights)))
        origin = Operation(
            f"nominal.{self.name}",
            {**sizes, "shape": shape, "pixel": edges, "center": center},
            {"outside": beyond},
        )
        about = Provenance(f"nominal {self.description(**sizes)}", origin=origin)
        return Surface(heights, edges, about, holes_masked=beyond > 0)

    def _check_options(self, specified: list[tuple[str, Any]]) -> dict[str, Any]:
        """Return size and option in SI units; raise on other names, a missing or a double size."""
        names, options = [name for name, _ in specified], [self.option] if self.option else []
        if names.count(self.size) != 1 or not {*names} <= {self.size, *options}:
            raise InputError(
                f"a nominal {self.word} takes {' and '.join([self.size, *options])}, "
                f"got {', '.join(names) or 'nothing'}"
            )
        return dict.fromkeys(options, 0.0) | {
            name: value if name in _PLAIN else to_si(value, "length", name)
            for name, value in specified
        }


sphere = NominalForm(
    "sphere",
    "radius",
    "the radius",
    lambda radius: _round("sphere", radius),
    ("sphere 10 mm",),
    curvatures=lambda radius: (1 / radius, 1 / radius),
)
"""Sphere of a given radius: a nominal body, or a surface with ``shape`` and ``pixel``."""
ellipsoid = NominalForm(
    "ellipsoid",
    "radii",
    "each radius of curvature",
    lambda radii, angle: (
        f"ellipsoid of the radii of curvature {_length(radii[0])} along y and {_length(radii[1])} "
        f"along x{f', turned by {angle:g} degrees counter-clockwise' if angle else ''}"
    ),
    ("ellipsoid 10 mm 4 mm 30 deg",),
    "angle",
    2,
    lambda radii: (1 / radii[0], 1 / radii[1]),
)
cylinder = NominalForm(
    "cylinder",
    "radius",
    "the radius",
    lambda radius, angle: (
        f"{_round('cylinder', radius)}, axis at {angle:g} degrees counter-clockwise from x"
    ),
    ("cylinder 5 mm 90 deg", "cylinder -5.2 mm"),
    "angle",
    curvatures=lambda radius: (1 / radius, 0.0),
)
"""Cylinder of a given radius and angle of its axis, called like `sphere`."""
punch = NominalForm(
    "punch",
    "radius",
    "the radius",
    lambda radius, edge_radius: f"round punch of radius {_length(radius)}{_edge(edge_radius)}",
    ("punch 20 um", "punch 20 um 10 um", "punch 20 um edge 2 um"),
    "edge_radius",
)
rectangular_punch = NominalForm(
    "rectangular_punch",
    "sides",
    "each side",
    lambda sides, edge_radius: (
        f"rectangular punch of {_length(sides[0])} along y by {_length(sides[1])} along x"
        f"{_edge(edge_radius)}"
    ),
    option="edge_radius",
    count=2,
)
cone = NominalForm(
    "cone", "slope", "the slope", lambda slope: f"cone of slope {slope:g}", ("cone 0.01",)
)
wedge = NominalForm(
    "wedge",
    "slope",
    "the slope",
    lambda slope, angle: (
        f"wedge of slope {slope:g}, ridge at {angle:g} degrees counter-clockwise from x"
    ),
    ("wedge 0.01 90 deg",),
    "angle",
)

BODIES = {
    form.name: form for form in (sphere, ellipsoid, cylinder, punch, rectangular_punch, cone, wedge)
}
"""Nominal bodies other than the flat, by name."""

FORMS = ("flat", *(text for form in BODIES.values() for text in form.examples))
"""Example texts of all forms that `parse` accepts."""


def parse(text: str, name: str = "body") -> NominalBody:
    """Return the nominal body that a text describes."""
    examples = ", ".join(repr(form) for form in FORMS)
    wrong = input_error(name, text, f"must read like one of {examples}")
    if not isinstance(text, str) or not text.strip():
        raise wrong
    word, *rest = text.split()
    word, sizes = word.lower(), " ".join(rest)
    forms = [form for form in BODIES.values() if form.word == word]
    option = forms[0].option if forms else ""
    specified: dict[str, Any] = {option: 0.0} if option else {}
    if option == "angle" and (result := _ANGLE.search(sizes)):
        sizes, specified = sizes[: result.start()], {option: float(result[1])}
    elif option == "edge_radius" and (result := _EDGE.search(sizes)):
        edge = _parse_size(result[1], name, "the edge radius of the punch")
        sizes, specified = sizes[: result.start()], {option: edge}
    parts = _QUANTITY.findall(sizes)
    read_whole = "".join(parts).replace(" ", "") == sizes.replace(" ", "")
    if not read_whole or not all(map(math.isfinite, specified.values())):
        raise wrong
    if word == "flat" and not parts:
        return NominalBody(flat)
    for form in forms:
        if len(parts) == form.count:
            measured = _slope if form.size == "slope" else _parse_size
            measured = _parse_radius if form.curvatures else measured
            values = [measured(part, name, f"{form.size_text} of the {word}") for part in parts]
            size = values[0] if form.count == 1 else tuple(values)
            return form(size, **specified)
    raise wrong


def _parse_radius(text: str, name: str, what: str) -> float:
    radius = _parse_size(text, name, what, positive=False)
    if radius == 0:
        raise InputError(
            ArgumentRef(name), f": {what} must not be 0; negative is concave", value=text
        )
    return radius


def _parse_size(text: str, name: str, what: str, positive: bool = True) -> float:
    try:
        return units.parse(text, "length", what, positive)
    except InputError as error:
        own = () if error.argument is None else (ArgumentRef(error.argument), " ")
        raise InputError(ArgumentRef(name), ": ", *own, *error.parts, value=text) from None


_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"{_NUMBER}(?:\s*[A-Za-z\u00b5\u03bcÅ]+)?")
_ANGLE = re.compile(rf"\s+({_NUMBER})\s*(?:deg|degrees?|°)$")
_EDGE = re.compile(r"\s*\bedge\b\s*(.*)$")


def _slope(text: str, name: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(
            ArgumentRef(name), f": {what} must be a number without a unit, got {text!r}", value=text
        ) from None
    if not 0 < value < math.inf:
        raise InputError(
            ArgumentRef(name), f": {what} must be positive and finite, got {text!r}", value=text
        )
    return value
