"""Figures into files."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.files import replacing
from roughcontact.plots.style import DPI

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Of zlib: a tenth larger than its default of 6, in two thirds of the time.
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
        File to write, its type told by the suffix; it appears only once it is complete, and a
        file that was there stays as it was until then.

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
            f"cannot tell the type of the figure {str(target)!r} from its suffix; "
            f"use one of {', '.join(_SUFFIXES)}"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the figure {str(target)!r} does not exist; create it first"
        )
    try:
        with replacing(target) as stream:
            if kind == "png":
                stream.write(png(figure))
            else:
                figure.savefig(stream, format=kind, dpi=DPI)
    except OSError as error:
        reason = error.strerror or str(error)
        raise RoughcontactError(
            f"the figure {str(target)!r} could not be written: {reason}"
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
        The picture that ``savefig`` makes. That draws every figure twice, the first time only to
        lay it out; a canvas lays it out as it draws. Without an opacity that is 1 everywhere, it
        takes three quarters of the time to pack.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    shown_on, dpi = figure.canvas, figure.dpi
    canvas: Any = FigureCanvasAgg(figure)
    try:
        figure.set_dpi(DPI)
        canvas.draw()
    finally:
        figure.set_dpi(dpi)
        figure.set_canvas(shown_on)
    dots = np.asarray(canvas.buffer_rgba())
    picture = Image.fromarray(dots if dots[..., 3].min() < _OPAQUE else dots[..., :3].copy())
    stream = io.BytesIO()
    picture.save(stream, "png", compress_level=_COMPRESSION, dpi=(DPI, DPI))
    return stream.getvalue()
