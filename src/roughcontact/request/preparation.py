"""Reading and preparation of the maps of a request, in a fixed order of steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughcontact._tools.memory import require_grid
from roughcontact.cautions import Caution, merge_cautions
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.formats import read
from roughcontact.formats.source import pixel_of
from roughcontact.request import options
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.request.task import Command, OptionValues
from roughcontact.surface import placement
from roughcontact.surface.cleaning import MAX_FILLED_SHARE, fill_mode
from roughcontact.surface.surface import Surface
from roughcontact.units import format_percent

Reader = Callable[..., Surface]
"""Function ``reader(path, announced, *reading)`` like `formats.read.read_announced`."""


def surfaces(request: Request, say: Say, reader: Reader = read.read_announced) -> list[Surface]:
    """Read and prepare the map, and the map of the counter-body if there is one."""
    requested = preparation(request)
    maps: list[Surface] = []
    form = requested.get(options.BODY)
    for path in request.inputs:
        say(f"reading {path.name}")
        reading: list[Any] = [requested[option] for option in options.READING]
        fits = request.require_prepared
        surface = reader(path, fits, *reading)
        if str(path) in request.names:
            known = surface.provenance.with_name(Path(request.names[str(path)]).name)
            surface = replace(surface, provenance=known)
        maps.append(_prepare(request, requested, surface, path))
    if request.file is None:
        points = requested.require(options.POINTS)
        request.require_memory(points)
        pixel = pixel_of(requested[options.SIZE], points)
        maps.insert(0, requested.require(options.BODY)(shape=points, pixel=pixel))
    elif form is not None:
        maps[0] = maps[0].with_form(form.sample_body(maps[0]))
    if request.aligned:
        say("aligning the maps")
        offset = requested.get(options.OFFSET) or (0.0, 0.0)
        angle = requested.get(options.ANGLE) or 0.0
        matched = placement.match_grids(maps[0], maps[1], offset, angle, requested[options.MIRROR])
        # Points covered by only one map cannot be in contact.
        maps = [surface.masked() for surface in matched]
    counter_form = requested.get(options.COUNTER_BODY)
    if counter_form is not None:
        if len(maps) == 2:
            maps[1] = maps[1].with_form(counter_form.sample_body(maps[1]))
        else:
            maps.append(counter_form.sample_body(maps[0]))
    return maps


def preparation(request: Request) -> OptionValues:
    """Return the options that prepare the maps of a request; other options are excluded."""
    prepares = tuple(option for option in request.task.options if option.prepares)
    return OptionValues(Command(request.task.name, "", prepares), request.values)


def preparation_key(request: Request) -> str:
    """Return a cache key of the prepared maps of a request: its files and options."""
    requested = preparation(request)
    values = {option.name: requested[option] for option in requested.task.options}
    return repr(([str(path) for path in request.inputs], values))


def resolution_cautions(request: Request, maps: Sequence[Surface]) -> tuple[Caution, ...]:
    """Return the cautions on the limits of the lateral resolution of the prepared maps."""
    radius = request.get(options.TIP_RADIUS)
    return merge_cautions(
        [
            (surface.provenance.source, [x.caution for x in surface.resolution_limits(radius)])
            for surface in maps
            if surface.provenance.instrument
        ],
        "maps",
    )


def _prepare(request: Request, requested: OptionValues, surface: Surface, path: Path) -> Surface:
    # First outliers, then form, then waves: each step requires the correction of the previous one.
    form, holes = requested[options.FORM], requested[options.MISSING]
    level, pixel = requested[options.LEVEL], requested[options.PIXEL]
    if requested[options.INVERT]:
        surface = surface.inverted()
    if (crop := requested[options.CROP]) is not None:
        rows, columns = (
            (part.start or 0, points if part.stop is None else part.stop)
            for part, points in zip(crop, surface.shape, strict=True)
        )
        surface = surface.cropped(rows, columns)
    if (outliers := requested[options.OUTLIERS]) is not None:
        surface = surface.without_outliers(outliers)
    if holes == "crop" and surface.missing:
        surface = surface.largest_rectangle()
    if level != "none":
        surface = surface.leveled(level)
    if form is not None:
        surface = surface.without_form(*form)
    share = surface.missing / surface.heights.size
    if surface.missing and holes == "error":
        raise InputError(
            f"{path.name} has {surface.missing} missing points; choose "
            f"{ArgumentRef('missing', fill_mode(share))} (smooth interpolation), "
            f"{ArgumentRef('missing', 'mask')} (no contact there) or "
            f"{ArgumentRef('missing', 'crop')} (the largest rectangle without them), or crop it "
            f"with {ArgumentRef('crop')}"
        )
    if holes == "fill" and share > MAX_FILLED_SHARE:
        raise InputError(
            f"{path.name} has no height at {format_percent(share)} of its points, and at most "
            f"{format_percent(MAX_FILLED_SHARE)} may be filled: crop it with "
            f"{ArgumentRef('crop')}, or choose {ArgumentRef('missing', 'mask')} (no contact "
            f"there) or {ArgumentRef('missing', 'fill-all')} (smooth interpolation of any share)"
        )
    if holes in ("fill", "fill-all"):
        surface = surface.filled(1.0 if holes == "fill-all" else MAX_FILLED_SHARE)
    surface = surface.masked()
    waves = requested[options.S_FILTER], requested[options.L_FILTER]
    if waves != (None, None):
        surface = surface.filtered(*waves)
    if pixel is not None:
        grid = [side / pixel for side in surface.size]
        if surface.is_profile:
            grid[0] = 1.0
        require_grid("pixel", grid, pixel)
        ny, nx = map(round, grid)
        # Without points, `resampled` raises an error before it allocates memory.
        if min(ny, nx) > 0:
            request.require_memory((ny, nx))
        surface = surface.resampled(pixel=(pixel, pixel), method="spline")
    return _orient(requested, surface)


def _orient(requested: OptionValues, surface: Surface) -> Surface:
    axis, turn = requested[options.FLIP], requested[options.ROTATE]
    if axis is not None:
        surface = surface.flipped(axis)
    return surface.rotated(turn) if turn % 360 else surface
