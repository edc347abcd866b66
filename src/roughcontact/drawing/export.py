"""Export of figures to files; PNG files can be drawn in several processes."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools import memory, processes as forks
from roughcontact._tools.files import atomic_write
from roughcontact.drawing.style import DPI
from roughcontact.errors import InputError, RoughcontactError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Level of zlib: files are a tenth larger than with the default of 6, in two thirds of the time.
_COMPRESSION = 3

_OPAQUE = 255

_SUFFIXES = {".png": "png", ".svg": "svg", ".pdf": "pdf"}


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure to a PNG, SVG or PDF file.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : str or path
        File to write; the suffix selects the type. The file appears only when complete; an
        existing file is unchanged until then.

    Raises
    ------
    InputError
        If the suffix is none of ``.png``, ``.svg``, ``.pdf``, or the folder does not exist.
    RoughcontactError
        If the file cannot be written.
    """
    target = Path(path)
    kind = _SUFFIXES.get(target.suffix.lower())
    if kind is None:
        raise InputError(
            f"unknown suffix of the figure {str(target)!r}; use one of {', '.join(_SUFFIXES)}"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the figure {str(target)!r} does not exist; create it first"
        )
    try:
        with atomic_write(target) as stream:
            if kind == "png":
                stream.write(png(figure))
            else:
                figure.savefig(stream, format=kind, dpi=DPI)
    except OSError as error:
        raise RoughcontactError(
            f"the figure {str(target)!r} could not be written: {error.strerror or str(error)}"
        ) from error


def png(figure: Figure) -> bytes:
    """Return a figure as the content of a PNG file.

    Parameters
    ----------
    figure : Figure
        The figure.

    Returns
    -------
    bytes
        The same image as from ``savefig``, which draws every figure twice, the first time only for
        the layout; a canvas computes the layout while drawing. Without the opacity, which is 1
        everywhere, compression takes three quarters of the time.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    shown_on, dpi = figure.canvas, figure.dpi
    canvas: Any = FigureCanvasAgg(figure)
    try:
        figure.set_dpi(max(dpi, DPI))
        canvas.draw()
    finally:
        figure.set_dpi(dpi)
        figure.set_canvas(shown_on)
    dots = np.asarray(canvas.buffer_rgba())
    picture = Image.fromarray(dots if dots[..., 3].min() < _OPAQUE else dots[..., :3].copy())
    stream = io.BytesIO()
    picture.save(stream, "png", compress_level=_COMPRESSION, dpi=(DPI, DPI))
    return stream.getvalue()


Drawing = Callable[[], "Figure"]

# Maximum number of figures: their numbers are single bytes.
_MAX_DRAWINGS = 256


def draw_pngs(
    drawings: Sequence[Drawing], processes: int = 1, tell: Callable[[int, int], None] | None = None
) -> list[bytes]:
    """Draw figures and return each as the content of a PNG file.

    Parameters
    ----------
    drawings : sequence of callable
        Functions that draw the figures.
    processes : int
        Maximum number of parallel processes: forks of this process, if supported and if memory
        suffices. Use more than one only in a program that controls its threads.
    tell : callable, optional
        ``tell(number, count)`` is called before this process draws the figure of that number.

    Returns
    -------
    list of bytes
        The same bytes with any number of processes.
    """
    result: dict[int, bytes] = {}
    many = min(processes, len(drawings), _process_limit() if processes > 1 else 1)
    if many > 1 and len(drawings) <= _MAX_DRAWINGS:
        result = _draw_in_processes(drawings, many, tell)
    # A figure that failed in another process is drawn here and raises the same error.
    for number, draw in enumerate(drawings):
        if number not in result:
            if tell is not None:
                tell(number + 1, len(drawings))
            result[number] = png(draw())
    return [result[number] for number in range(len(drawings))]


def _process_limit() -> int:
    """Return the maximum number of processes if each needs as much memory as this one."""
    if not forks.can_fork():
        return 1
    return 1 + memory.free_bytes() // memory.resident_bytes()


def _draw_in_processes(
    drawings: Sequence[Drawing], processes: int, tell: Callable[[int, int], None] | None
) -> dict[int, bytes]:
    """Return the figures drawn by this process and its forks, by number."""
    _load_matplotlib()
    queue, numbers = os.pipe()
    # The last figures are the largest and start first; small figures balance the end.
    os.write(numbers, bytes(reversed(range(len(drawings)))))
    os.close(numbers)
    helpers: list[forks.ForkedCall] = []
    try:
        # The solver threads are idle, and drawing does not use them.
        helpers.extend(
            forks.ForkedCall(_draw_remaining, queue, drawings) for _ in range(processes - 1)
        )
        result = _draw_remaining(queue, drawings, tell)
        for helper in helpers:
            with contextlib.suppress(Exception):
                result |= helper.result()
        return result
    finally:
        os.close(queue)
        for helper in helpers:
            helper.end()


def _load_matplotlib() -> None:
    """Import the modules that figures need before a fork, so that they are loaded only once."""
    from matplotlib import artist

    # Docstrings of setters, which no figure needs, take two fifths of the time of the imports.
    kwdoc, artist.kwdoc = artist.kwdoc, lambda artist: ""
    try:
        import matplotlib.backends.backend_agg
        import matplotlib.figure  # noqa: F401 - for what it loads
    finally:
        artist.kwdoc = kwdoc


def _draw_remaining(
    queue: int, drawings: Sequence[Drawing], tell: Callable[[int, int], None] | None = None
) -> dict[int, bytes]:
    """Draw the remaining figures; all processes read their numbers from one pipe."""
    result = {}
    while number := os.read(queue, 1):
        if tell is not None:
            tell(len(drawings) - number[0], len(drawings))
        result[number[0]] = png(drawings[number[0]]())
    return result
