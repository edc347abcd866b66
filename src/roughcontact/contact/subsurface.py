"""Stress below a solved contact: where each body is strained most, and when it first yields.

The stress is elastic. Where it exceeds the yield strength it says how far the body is from being
elastic, not what the body carries.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import ArrayLike

from roughcontact import memory
from roughcontact._version import __version__
from roughcontact.arguments import checked
from roughcontact.contact.checks import row
from roughcontact.contact.memory import overhead
from roughcontact.contact.pair import BODIES, Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.stress import StressResult
from roughcontact.errors import InputError
from roughcontact.halfspace import stress, stress_summary
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import default_workers
from roughcontact.units import Quantities, quantity

# Bytes of the blocks that a thread works on, beyond those of a solve.
_THREAD = 2**23


@checked
def subsurface_stress(
    result: ContactResult,
    depths: Quantities | ArrayLike | None = None,
    *,
    body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
) -> StressResult:
    """Return the elastic stress below a solved contact.

    Parameters
    ----------
    result : ContactResult
        The contact; its boundary is kept.
    depths : array_like, or sequence of str or quantity of pint, optional
        Depths z > 0 [m]; by default the surface and from half a pixel to three contact radii, with
        more around the largest stress (`stress_summary.summarise`).
    body : {"body", "counter_body"}
        The rough body, or its counter-body. Both feel the same pressure; the stress differs by
        Poisson's ratio and by the sign of the friction.
    friction : float
        Coefficient μ of the traction μ p on the rough body. That it alters the pressure a little
        between unlike bodies is neglected.
    direction : float
        Angle of that traction from x [degrees], counter-clockwise as seen in the map, whose first
        row is drawn on top: 90 points to smaller y.
    precision : {"double", "single"}
        Arithmetic of the transforms; single is good to 1e-6 of the largest pressure.

    Returns
    -------
    StressResult
        Largest stresses, their places, and the planes through the largest.

    Raises
    ------
    InputError
        If an argument cannot be used, the body is rigid, or there is no pressure.
    InsufficientMemoryError
        If the memory that is free does not hold a few layers.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-31.5:32, -31.5:32] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 0.01), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = subsurface_stress(solve(ball, material=steel, load=0.1))
    >>> round(found.max_von_mises / found.solution.max_pressure, 2)
    0.62
    """
    material = result.pair.material_of(body)
    if math.isinf(material.young):
        raise InputError(f"the {BODIES[body]} is rigid: there is no stress in it to compute")
    wanted = quantity(depths, "length", "depths")
    _check_depths(wanted)
    require_memory(
        result.surface.shape, boundary=result.boundary, precision=precision, friction=friction
    )
    options = {**traction(result.pair, body, friction, direction), "precision": precision}
    pressure, pixel = result.pressure, result.pair.pixel
    profile = stress_summary.summarise(
        pressure, pixel, material.poisson,
        depths=wanted, yield_strength=material.yield_strength, **options,
    )  # fmt: skip
    section_x, section_y = stress.sections(
        pressure, pixel, profile.depths, material.poisson, profile.pixel_of_max, **options
    )
    return StressResult(
        solution=result,
        body=body,
        friction=friction,
        direction=direction,
        precision=precision,
        profile=profile,
        section_x=section_x,
        section_y=section_y,
        version=__version__,
    )


def _check_depths(depths: ArrayLike | None) -> None:
    if depths is None:
        return
    least = float(row(depths, "depths").min())
    if least <= 0:
        raise InputError(
            f"must lie below the surface, got {least!r} m; the "
            "surface itself is `stress.slices` at 0",
            argument="depths",
            value=least,
        )


def traction(pair: Pair, body: str, friction: float, direction: float) -> dict[str, Any]:
    """Return what a body feels at its surface, in the words of `halfspace.stress`.

    Parameters
    ----------
    pair : Pair
        The bodies.
    body, friction, direction
        As for `subsurface_stress`.

    Returns
    -------
    dict
        ``boundary``, the coefficient ``friction`` with the sign of the body, and the
        ``direction`` as an angle from x towards y [rad].
    """
    return {
        "boundary": pair.boundary,
        "friction": friction if body == "body" else -friction,
        # A map is drawn with y downwards. Zero minus zero has no sign.
        "direction": math.radians(0.0 - direction),
    }


def memory_estimate(
    shape: tuple[int, int],
    *,
    boundary: str = "free",
    precision: str = "single",
    friction: float = 0.0,
) -> int:
    """Return the memory that `subsurface_stress` needs beyond the contact itself.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    boundary, precision, friction
        As for `subsurface_stress`.

    Returns
    -------
    int
        Bytes, however many depths there are.
    """
    ny, nx = shape
    pixels, real = ny * nx, 4 if precision == "single" else 8
    # Scaled pressure and largest stress over depth; row spectra of six components.
    maps = 8 * pixels + real * pixels + overhead() + _THREAD * default_workers()
    if friction != 0:
        # For the rims: scaled pressure, displacement, and the stress along the surface.
        maps += (8 + 8 + 3 * real) * pixels
        maps += max(Boundary(boundary).operator_memory(shape, "double") - 6 * real * pixels, 0)
    if not Boundary(boundary).free_axes:
        return maps + (6 + 1) * real * ny * (nx + 2)
    padded = (2 * ny) * (2 * nx + 2)
    # Spectra of the pressure, the second with room to blend kernels; samples of the kernels.
    spectra = real * padded + (real * padded * 25 // 16 if precision == "single" else 0)
    kernels = 6 if friction == 0 else 12
    return maps + 6 * real * padded // 2 + spectra + kernels * real * (ny + 1) * (nx + 1)


def require_memory(
    shape: tuple[int, int],
    *,
    boundary: str = "free",
    precision: str = "single",
    friction: float = 0.0,
) -> None:
    """Raise `InsufficientMemoryError` unless the stress below a map fits into what is free.

    Parameters
    ----------
    shape, boundary, precision, friction
        As for `memory_estimate`.
    """
    needed = memory_estimate(shape, boundary=boundary, precision=precision, friction=friction)
    memory.require(
        needed,
        f"the stress below {shape[0]} × {shape[1]} points needs",
        advice=("solve the contact on a part of the map, surface.cropped(...)",),
    )
