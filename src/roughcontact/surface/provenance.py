"""Source and processing steps of a map, stored as data and formatted for display."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from roughcontact._tools.arguments import set_fields
from roughcontact._tools.text import replace_unprintable
from roughcontact.units import format_engineering

NOTE = "note"
"""Method of an `Operation` that is stored as a sentence only, and cannot be repeated."""

# Version of the JSON text of `to_text`.
_VERSION = 1


@dataclass(frozen=True)
class Operation:
    """One call that made or changed a map."""

    method: str  # Method of `Surface`
    arguments: Mapping[str, Any] = field(default_factory=dict, hash=False)
    found: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        """Convert values to Python's own numbers and tuples."""
        for name in ("arguments", "found"):
            values = {key: _plain(value) for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, values)

    @classmethod
    def note(cls, text: str) -> Operation:
        """Return a record that consists of a sentence only."""
        return cls(NOTE, {"text": replace_unprintable(text)})

    @property
    def sentences(self) -> tuple[str, ...]:
        """Text of the operation; empty if ``Provenance.source`` contains it."""
        words = _WORDS[self.method]
        if callable(words):
            return words(self.arguments, self.found)
        text = words.format_map({**self.arguments, **self.found})
        return (text,) if text else ()


@dataclass(frozen=True)
class Provenance:
    """Source of a map, and the steps of its preparation.

    Parameters
    ----------
    source : str
        File name or origin of the map; empty if unknown.
    instrument : str
        Instrument or file format as the file names it; empty if unknown.
    channel : str
        Height channel that was read; empty if there is only one.
    steps : iterable of str
        Earlier steps, each in one sentence; they cannot be repeated.
    origin : Operation, optional
        Operation that created the map.
    operations : tuple of Operation
        Steps of the preparation, in order, after ``steps``.
    """

    source: str
    instrument: str
    channel: str
    origin: Operation | None
    operations: tuple[Operation, ...]

    def __init__(
        self,
        source: str = "",
        instrument: str = "",
        channel: str = "",
        steps: Iterable[str] = (),
        *,
        origin: Operation | None = None,
        operations: Iterable[Operation] = (),
    ) -> None:
        # Names reach every written text: a line separator would end a comment of a script.
        names = {"source": source, "instrument": instrument, "channel": channel}
        set_fields(self, **{name: replace_unprintable(text) for name, text in names.items()})
        set_fields(self, origin=origin, operations=(*map(Operation.note, steps), *operations))

    @property
    def steps(self) -> tuple[str, ...]:
        """Preparation steps in order, one sentence each."""
        created = () if self.origin is None else (self.origin,)
        return tuple(text for step in (*created, *self.operations) for text in step.sentences)

    def filled_share(self, points: int) -> float:
        """Return the fraction of points that were filled, relative to the grid at that time.

        ``points`` is the present number of points, used for records of earlier versions.
        """
        share = 0.0
        for step in self.operations:
            if step.method == "filled":
                share += step.found.get("missing", 0) / step.found.get("points", points)
            elif "filled" in step.found:
                share = step.found["filled"] / step.found["points"]
        return min(share, 1.0)

    def with_name(self, name: str) -> Provenance:
        """Return the provenance with another name of the file that was read."""
        origin = self.origin
        if origin is not None and "path" in origin.arguments:
            origin = replace(origin, arguments={**origin.arguments, "path": name})
        return replace(self, source=name, origin=origin)

    def then(self, operation: Operation) -> Provenance:
        """Return the provenance with one more operation."""
        return replace(self, operations=(*self.operations, operation))

    def in_words(self) -> str:
        """Return the source and the preparation steps as text."""
        words = self.source or "another map"
        return f"{words} ({'; '.join(self.steps)})" if self.steps else words


def to_text(provenance: Provenance) -> str:
    """Return a provenance as JSON, for `from_text`."""
    # Operations are written by their fields, and so are provenances among their arguments.
    return json.dumps({"version": _VERSION, **vars(provenance)}, default=vars)


def from_text(text: str) -> Provenance:
    """Return the provenance in a text of `to_text`."""
    record = json.loads(text)
    try:
        if record.pop("version") != _VERSION:
            raise ValueError("the provenance was written by another version of this program")
        provenance = _provenance(record)
        # A step that cannot be formatted is damaged: raise here rather than in a report.
        _ = provenance.steps
    except (AttributeError, IndexError, KeyError, TypeError) as error:
        raise ValueError(f"no provenance: {type(error).__name__} {error}") from None
    return provenance


def _plain(value: Any) -> Any:
    """Return a value as Python's own numbers and tuples."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    return tuple(map(_plain, value)) if isinstance(value, (list, tuple)) else value


def _provenance(record: dict[str, Any]) -> Provenance:
    origin = record["origin"]
    return Provenance(
        record["source"],
        record["instrument"],
        record["channel"],
        origin=None if origin is None else _origin(origin),
        operations=[_operation(step) for step in record["operations"]],
    )


def _origin(record: dict[str, Any]) -> Operation:
    operation = _operation(record)
    if operation.method not in _ORIGINS:
        raise ValueError(f"{operation.method} makes no map")
    if operation.method == "Surface":
        ny, nx = map(int, operation.found["shape"])
        dy, dx = map(float, operation.arguments["pixel"])
        specified = {"pixel": (dy, dx), "holes_masked": bool(operation.arguments["holes_masked"])}
        return Operation("Surface", specified, {**operation.found, "shape": (ny, nx)})
    if operation.method == "read_surface":
        _ = operation.arguments["path"]
    return operation


def _operation(record: dict[str, Any]) -> Operation:
    if record["method"] not in _WORDS or not all(map(str.isidentifier, record["arguments"])):
        raise ValueError(f"no operation of this program: {record!r}")
    arguments = {
        name: _provenance(value) if isinstance(value, dict) else value
        for name, value in record["arguments"].items()
    }
    return Operation(record["method"], arguments, record["found"])


_Said = Mapping[str, Any]
# A format of the arguments and results, or a function of both.
_Words = str | Callable[[_Said, _Said], tuple[str, ...]]

# Number of digits of lengths, enough to distinguish different steps.
_DIGITS = 6


def _lengths(values: Sequence[float], between: str = " × ") -> str:
    return between.join(format_engineering(value, "m", _DIGITS) for value in values)


def _reading_notes(specified: _Said, result: _Said) -> tuple[str, ...]:
    notes: tuple[str, ...] = result.get("notes", ())
    if "stated_size" in result:
        stated, size = (
            " × ".join(format_engineering(side, "m") for side in result[name])
            for name in ("stated_size", "size")
        )
        notes += (f"read: sides of {stated}, as the file gives them, replaced by {size}",)
    return notes


def _body(specified: _Said, result: _Said) -> tuple[str, ...]:
    words = []
    center = specified.get("center")
    if center is not None:
        words.append(f"placed at the point ({center[0]:g}, {center[1]:g}) (y, x) in pixels")
    if result.get("outside"):
        words.append(f"{result['outside']} points outside the body never touch")
    return tuple(words)


def _describe_generated(specified: _Said, result: _Said) -> tuple[str, ...]:
    words = [f"Sq {format_engineering(specified['Sq'], 'm')}"]
    for name, text in (("Sal", "Sal"), ("rolloff_wavelength", "roll-off")):
        if specified[name] is not None:
            words.append(f"{text} {format_engineering(specified[name], 'm')}")
    for name, text in (("Sdq", "Sdq"), ("Str", "Str"), ("Sku", "Sku")):
        if specified[name] is not None:
            words.append(f"{text} {specified[name]:g}")
    if specified["Ssk"]:
        words.append(f"Ssk {specified['Ssk']:g}")
    words.append(f"Hurst exponent {specified['hurst']:g}")
    if specified["lay"]:
        words.append(f"lay at {specified['lay']:g} degrees")
    if specified["honing"] is not None:
        words.append(f"grooves {specified['honing']:g} degrees apart")
    if specified["turning"] is not None:
        feed, radius = (format_engineering(length, "m") for length in specified["turning"])
        words.append(f"turned with a feed of {feed} and a nose radius of {radius}")
    source = f"numpy.random.default_rng({specified['seed']})"
    return (f"generated: {', '.join(words)}; random phases of {source}",)


def _describe_leveled(specified: _Said, result: _Said) -> tuple[str, ...]:
    form, points = specified["form"], specified["points"]
    if points is not None:
        what = f"plane through the points {', '.join(f'({int(y)}, {int(x)})' for y, x in points)}"
    elif form == "robust":
        what = "robust plane (Tukey's biweight)"
    else:
        what = f"least-squares {form}"
    if result.get("line"):
        # For a profile the plane is a line, and the quadric a parabola.
        what = what.replace("plane", "line").replace("quadric", "parabola")
    return (f"leveled: {what} subtracted",)


def _form_notes(specified: _Said, result: _Said) -> tuple[str, ...]:
    shape, degree = specified["shape"], specified["degree"]
    if degree is not None:
        rms = format_engineering(result["removed_rms"], "m", _DIGITS)
        what = f"polynomial of degree {degree}, {rms} rms"
    else:
        side = "convex" if result["radius"] > 0 else "concave"
        radius = format_engineering(abs(result["radius"]), "m", _DIGITS)
        what = f"{side} {shape} of radius {radius}"
        if shape == "cylinder":
            what += f", axis at {result['angle']:.6g} degrees counter-clockwise from x"
    return (f"form removed: least-squares {what}",)


def _describe_rotated(specified: _Said, result: _Said) -> tuple[str, ...]:
    return (f"rotated: {specified['angle'] % 360:g} degrees counter-clockwise, row 0 on top",)


def _describe_resampled(specified: _Said, result: _Said) -> tuple[str, ...]:
    by_waves = specified["method"] == "bandlimited"
    how = "band-limited, taken as periodic" if by_waves else "by a cubic spline"
    (old_y, old_x), (ny, nx), (dy, dx) = result["from"], result["to"], result["pixel"]
    return (
        f"resampled: {how}, from {old_y} × {old_x} to {ny} × {nx} points, "
        f"pixel {_lengths((dy, dx))}",
    )


def _describe_filtered(specified: _Said, result: _Said) -> tuple[str, ...]:
    parts = [
        f"{name.upper()}-filter at {format_engineering(specified[name], 'm', _DIGITS)}"
        for name in ("s", "l")
        if specified[name] is not None
    ]
    return (f"filtered: Gaussian {' and '.join(parts)} (ISO 16610-61, edges of order zero)",)


def _describe_aligned(specified: _Said, result: _Said) -> tuple[str, ...]:
    words = []
    if specified["mirrored"]:
        words.append("mirrored in x")
    if specified["angle"]:
        words.append(f"turned by {specified['angle']:g} degrees counter-clockwise")
    y, x = specified["offset"]
    if y or x:
        words.append(f"shifted by ({_lengths((y, x), ', ')}) (y, x)")
    words.append("by a bicubic spline" if result["spline"] else "point by point")
    smoothed = [
        f"{format_engineering(length, 'm', _DIGITS)} along {axis}"
        for axis, length in zip("yx", result["smoothing"], strict=True)
        if length
    ]
    after = f" after a Gaussian S-filter at {' and '.join(smoothed)}" if smoothed else ""
    grid = specified["grid"].origin.arguments
    (ny, nx), (dy, dx) = grid["shape"], grid["pixel"]
    off = f", {result['outside']} of them off the map" if result["outside"] else ""
    onto = f"onto {ny} × {nx} points of {_lengths((dy, dx))}"
    return (f"aligned: {', '.join(words)}{after} {onto}{off}",)


def _describe_indented(specified: _Said, result: _Said) -> tuple[str, ...]:
    depth = format_engineering(result["depth"], "m", _DIGITS)
    return (f"indented: by up to {depth} where the ceiling was reached",)


_PART = "rows {rows[0]}:{rows[1]}, columns {columns[0]}:{columns[1]}"

_ORIGINS: dict[str, _Words] = {
    "Surface": "",
    "reference_map": "",
    "generate": _describe_generated,
    "read_surface": _reading_notes,
    "nominal.flat": "",
    **{f"nominal.{name}": _body for name in ("sphere", "ellipsoid", "cylinder", "cone", "wedge")},
    **{f"nominal.{name}": _body for name in ("punch", "rectangular_punch")},
}

_WORDS: dict[str, _Words] = {
    **_ORIGINS,
    NOTE: "{text}",
    "leveled": _describe_leveled,
    "without_form": _form_notes,
    "without_outliers": (
        "outliers removed: {points} points further than {limit:g} robust standard deviations from "
        "the median of {window} × {window} points"
    ),
    "filled": "filled: {missing} missing points by harmonic interpolation",
    "masked": "masked: {missing} missing points never touch",
    "cropped": f"cropped: {_PART}",
    "largest_rectangle": f"cropped to the largest rectangle without holes: {_PART}",
    "inverted": "inverted: heights times -1",
    "flipped": "flipped: {axis} reversed",
    "rotated": _describe_rotated,
    "resampled": _describe_resampled,
    "filtered": _describe_filtered,
    "with_form": lambda specified, result: (f"form added: {specified['form'].in_words()}",),
    "aligned": _describe_aligned,
    "indented": _describe_indented,
    "worn": "worn by {mean} on average",
}
