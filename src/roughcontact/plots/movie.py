"""A movie of repeated passes: the pressure and the strain below it, step by step."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.files import replacing, require_suffix
from roughcontact.plots.style import LABEL, OPEN, TICK, TITLE, layout, listed, prefixed
from roughcontact.volume.passes import Frame
from roughcontact.volume.rolling import Rolling

# Pictures of a movie at most, the time of each [ms] and of the last, and their dots an inch.
MOST_FRAMES = 240
_SHOWN, _LAST = 100, 1500
_DPI = 72


def save(rolling: Rolling, frames: Sequence[Frame], path: str | os.PathLike[str]) -> None:
    """Write a movie of passes as an animated GIF, which every browser plays.

    Parameters
    ----------
    rolling : Rolling
        The passes.
    frames : sequence of Frame
        One for each step; of more than 240 some are left out, at equal distances.
    path : str or path
        File to write; it must end in ``.gif``.

    Raises
    ------
    InputError
        If the suffix is another, or there are no frames.
    OSError
        If the file cannot be written; an old file survives.
    """
    require_suffix(path, ".gif")
    if not frames:
        raise InputError("must hold a picture at least", argument="frames")
    chosen = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), MOST_FRAMES)).astype(int))
    first, *more = _pictures(rolling, [frames[number] for number in chosen])
    with replacing(Path(path)) as stream:
        first.save(
            stream, "gif", save_all=True, append_images=more, loop=0, optimize=False,
            duration=[_SHOWN] * len(more) + [_LAST],
        )  # fmt: skip


def _pictures(rolling: Rolling, frames: Sequence[Frame]) -> list[Any]:
    """Return the pictures, in the colours of one scale for all of them."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    ny, nx = rolling.result.solution.surface.shape
    wide = 9.0
    tall = min(max(wide * ny / nx, 1.6), 6.0)
    figure = Figure(figsize=(wide, tall + 3.6), dpi=_DPI, layout=layout())
    canvas: Any = FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, height_ratios=(tall, 3.0))
    pressure = _draw_pressure(above, rolling, frames)
    strain = _draw_strain(below, rolling, frames)
    title = figure.suptitle(" ", fontsize=TITLE)
    count = len(rolling.passes)
    pictures: list[Any] = []
    for frame in frames:
        pressure.set_data(_touching(frame.pressure))
        values = np.zeros((rolling.result.bodies[0].thickness.size, frame.strain.shape[1]))
        values[: len(frame.strain)] = 100 * frame.strain
        strain.set_array(np.ma.masked_equal(values, 0))
        title.set_text(f"pass {frame.number} of {count}, step {frame.step}")
        canvas.draw()
        # Laid out once: nothing moves from one picture to the next.
        figure.set_layout_engine("none")
        dots = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
        # One palette for all, or colours would flicker.
        pictures.append(dots.quantize(palette=pictures[0]) if pictures else _with_palette(dots))
    return pictures


def _with_palette(picture: Any) -> Any:
    """Return the first picture with colours for those after it, too."""
    from matplotlib import colormaps
    from PIL import Image

    scale = (255 * colormaps["inferno_r"](np.linspace(0, 0.63, 200))[:, :3]).astype(np.uint8)
    greys = np.linspace(0, 255, 50).astype(np.uint8)[:, None].repeat(3, axis=1)
    rest = np.array([[255, 255, 255], _rgb(OPEN), [0, 0, 0]], np.uint8)
    colours = Image.new("P", (1, 1))
    colours.putpalette(np.concatenate([scale, greys, rest]).ravel().tolist())
    return picture.quantize(palette=colours, dither=Image.Dither.NONE)


def _rgb(colour: Any) -> list[int]:
    from matplotlib.colors import to_rgb

    return [round(255 * part) for part in to_rgb(colour)]


def _touching(pressure: NDArray[Any]) -> Any:
    return np.ma.masked_equal(pressure, 0)


def _colours() -> Any:
    from matplotlib import colormaps

    return listed(colormaps["inferno_r"](np.linspace(0, 0.63, 256))).with_extremes(bad=OPEN)


def _draw_pressure(axes: Any, rolling: Rolling, frames: Sequence[Frame]) -> Any:
    size = rolling.result.solution.surface.size
    length, unit = prefixed(max(size), "m")
    top = max(float(frame.pressure.max()) for frame in frames)
    factor, shown = prefixed(top, "Pa")
    image = axes.imshow(
        _touching(frames[0].pressure), origin="lower", cmap=_colours(), vmin=0, vmax=top,
        extent=(0, size[1] * length, 0, size[0] * length), aspect="auto", interpolation="nearest",
    )  # fmt: skip
    axes.set_ylabel(f"y [{unit}]", fontsize=LABEL)
    axes.set_title("contact pressure", fontsize=TICK, loc="left")
    bar = axes.figure.colorbar(image, ax=axes, format=lambda value, _: f"{value * factor:.3g}")
    bar.set_label(f"[{shown}]", fontsize=TICK)
    bar.ax.tick_params(labelsize=TICK)
    return image


def _draw_strain(axes: Any, rolling: Rolling, frames: Sequence[Frame]) -> Any:
    size = rolling.result.solution.surface.size
    along = along_of(rolling.direction)
    length, unit = prefixed(max(size), "m")
    faces = np.append(0.0, np.cumsum(rolling.result.bodies[0].thickness)) * length
    points = frames[-1].strain.shape[1]
    edges = np.linspace(0, size[1 if along == "x" else 0] * length, points + 1)
    top = 100 * max(float(frame.strain.max()) for frame in frames)
    mesh = axes.pcolormesh(
        edges, faces, np.zeros((faces.size - 1, points)), cmap=_colours(), vmin=0, vmax=top or 1.0
    )
    axes.set_ylim(faces[-1], 0)
    axes.set_xlabel(f"{along} [{unit}]", fontsize=LABEL)
    axes.set_ylabel(f"depth [{unit}]", fontsize=LABEL)
    axes.set_title(
        f"accumulated plastic strain, the largest across {along}", fontsize=TICK, loc="left"
    )
    bar = axes.figure.colorbar(mesh, ax=axes)
    bar.set_label("[%]", fontsize=TICK)
    bar.ax.tick_params(labelsize=TICK)
    return mesh


def along_of(direction: float) -> str:
    """Return the axis of the map that a direction [degrees] is closest to."""
    return "x" if abs(np.cos(np.radians(direction))) >= np.sqrt(0.5) - 1e-9 else "y"
