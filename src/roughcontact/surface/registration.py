"""Two measured maps brought to one grid, as they lie on each other."""

from __future__ import annotations

from roughcontact.errors import InputError
from roughcontact.surface import alignment
from roughcontact.surface.nominal import flat
from roughcontact.surface.surface import Surface


def matched(
    first: Surface,
    second: Surface,
    offset: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
    mirrored: bool = False,
) -> tuple[Surface, Surface]:
    """Return two maps on one grid, cropped to the rectangle that both cover.

    Parameters
    ----------
    first : Surface
        The map that stays.
    second : Surface
        The map that is laid on it.
    offset, angle, mirrored
        Motion of the second map, see `Surface.aligned`.

    Returns
    -------
    first, second : Surface
        Of the same shape and pixel, ready for `contact.solve`, along the axes of the first map.
        Holes stay holes.

    Raises
    ------
    InputError
        If the maps have no 2 × 2 points in common.

    Notes
    -----
    The grid is that of the first map, which then keeps its bits, unless along an axis the pixel
    of the second is smaller by more than √2: then it has the finer edge. The finest waves of
    either body carry the highest pressures, and a grid that cannot hold them would make the
    contact too large; a coarse map on a fine grid is merely interpolated.
    """
    for name, body in (("first", first), ("second", second)):
        if not isinstance(body, Surface):
            raise InputError(f"must be a Surface, got {type(body).__name__}", argument=name)
    pixel = alignment.common_pixel(first.pixel, second.pixel, angle)
    # Points between the centres of the outer pixels of the first map, around the same middle.
    ny, nx = (
        points if edge == own else int((points - 1) * own / edge) + 1
        for points, own, edge in zip(first.shape, first.pixel, pixel, strict=True)
    )
    shape = ny, nx
    rows, columns = alignment.common_rectangle(
        [
            (first.shape, alignment.place(first.shape, first.pixel, shape, pixel)),
            (
                second.shape,
                alignment.place(
                    second.shape, second.pixel, shape, pixel, offset, angle, mirrored
                ),
            ),
        ],
        shape,
    )  # fmt: skip
    # From the middle of the rectangle to that of the whole grid.
    back_y, back_x = (
        ((points - 1) / 2 - (stop + start - 1) / 2) * edge
        for points, (start, stop), edge in zip(shape, (rows, columns), pixel, strict=True)
    )
    grid = flat(shape=(rows[1] - rows[0], columns[1] - columns[0]), pixel=pixel)
    return (
        first.aligned(grid, (back_y, back_x)),
        second.aligned(grid, (back_y + offset[0], back_x + offset[1]), angle, mirrored),
    )
