"""A surface asked for in words, made and written."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.formats.scale import pixel_of
from roughcontact.request import outputs
from roughcontact.request.options import GENERATE, Given, offered, parsed
from roughcontact.request.outputs import Say, Task
from roughcontact.surface.generation import generate
from roughcontact.surface.surface import Surface

_PLACES = ("output", "figure")
_GRID = ("size", "points", "seed")


def made(given: Given, say: Say) -> tuple[Surface, list[Path]]:
    """Return the surface that options ask for, and the files that it was written to.

    Parameters
    ----------
    given : Mapping
        Options of `GENERATE` as text, by name.
    say : callable
        Called with a few words before every stage.

    Raises
    ------
    InputError
        If an option cannot be used, or no such surface is possible.
    """
    values = {name: option.default for name, option in offered(GENERATE).items()}
    values |= parsed(given, GENERATE)
    places = _places(values)
    if values["sq"] is None:
        raise InputError("must be given: how high the surface is", argument="Sq")
    shape = values["points"]
    pixel = pixel_of(values["size"], shape)
    say("generating the surface")
    surface = generate(shape, pixel, seed=values["seed"], **_arguments(values))
    tasks: list[Task] = [
        (path, _drawn(surface) if argument == "figure" else partial(_saved, surface))
        for argument, path in places
    ]
    return surface, outputs.write(tasks, say)


def _arguments(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of options by the names of the arguments of `generate`."""
    others = (*_GRID, *_PLACES, "json", "quiet")
    return {
        (option.arguments or (option.argument,))[0]: values[name]
        for name, option in offered(GENERATE).items()
        if name not in others
    }


def _places(values: Mapping[str, Any]) -> list[tuple[str, Path]]:
    """Return the files to write, each with the option that asks for it; refuse those that fail."""
    figure = [] if values["figure"] is None else [values["figure"]]
    places = [("output", path) for path in values["output"]] + [("figure", p) for p in figure]
    for name, path in places:
        outputs.check_suffix(path, offered(GENERATE)[name], "")
        outputs.check_place(path, name)
    return places


def _saved(surface: Surface, path: Path) -> None:
    export.save_surface(surface, path)


def _drawn(surface: Surface) -> Any:
    def draw() -> Any:
        from roughcontact.plots import maps

        return maps.surface(surface)

    return outputs.saver(draw)
