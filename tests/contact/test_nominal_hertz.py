"""The curvature of the nominal body of a map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact import nominal_hertz
from roughcontact.surface import nominal_bodies, provenance

GRID: dict[str, Any] = {"shape": (41, 31), "pixel": (1e-6, 2e-6)}

BODIES = {
    "flat": nominal_bodies.flat(**GRID),
    "sphere": nominal_bodies.sphere(radius=0.01, **GRID),
    "ellipsoid": nominal_bodies.ellipsoid(radii=(0.01, 0.004), angle=25, **GRID),
    "cylinder": nominal_bodies.cylinder(radius=0.01, **GRID),
    "askew": nominal_bodies.cylinder(radius=0.01, angle=35, **GRID),
}


def fitted_curvature(surface: rc.Surface) -> np.ndarray:
    """Second derivatives of the depth, by a least-squares quadric."""
    y, x = np.meshgrid(*(np.arange(n) - (n - 1) / 2 for n in surface.shape), indexing="ij")
    y, x = y.ravel() * surface.pixel[0], x.ravel() * surface.pixel[1]
    terms = np.stack([np.ones_like(y), y, x, y**2, y * x, x**2], axis=1)
    known = np.isfinite(surface.heights.ravel())
    scale = np.abs(terms).max(axis=0)
    fit = np.linalg.lstsq(terms[known] / scale, -surface.heights.ravel()[known], rcond=None)[0]
    _, _, _, yy, yx, xx = fit / scale
    return np.array([[2 * yy, yx], [yx, 2 * xx]])


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize(
    "prepared",
    [
        lambda s: s,
        lambda s: s.rotated(90),
        lambda s: s.rotated(180),
        lambda s: s.leveled("plane"),
        lambda s: s.cropped((3, 40), (1, 30)),
        lambda s: s.resampled(shape=(50, 40), method="spline"),
        lambda s: s.aligned(nominal_bodies.flat(shape=(15, 9), pixel=(1e-6, 2e-6)), angle=20),
        lambda s: s.aligned(nominal_bodies.flat(shape=(15, 9), pixel=(1e-6, 2e-6)), mirrored=True),
        lambda s: s.with_form(s),
        lambda s: rc.Surface(np.zeros(s.shape), s.pixel).with_form(s).masked(),
    ],
)
def test_curvature_matches_heights(name: str, prepared: Any) -> None:
    surface = prepared(BODIES[name])
    # Spheres deviate from their paraboloid by 1e-5 at this size; splines by a little more.
    found = nominal_hertz.curvature_of_map(surface.provenance)
    np.testing.assert_allclose(found, fitted_curvature(surface), rtol=1e-4, atol=3e-3)


def test_curvature_is_none_where_unknown_and_zero_where_removed() -> None:
    for body in (nominal_bodies.cone(slope=0.1, **GRID), nominal_bodies.punch(radius=1e-5, **GRID)):
        assert nominal_hertz.curvature_of_map(body.provenance) is None
    ball = BODIES["sphere"]
    assert nominal_hertz.curvature_of_map(ball.without_form("sphere").provenance) is None
    assert nominal_hertz.curvature_of_map(ball.filtered(l=20e-6).provenance) is None
    flat = nominal_hertz.curvature_of_map(ball.leveled("quadric").provenance)
    assert flat is not None
    assert not flat.any()
    rough = rc.Surface(np.zeros(GRID["shape"]), GRID["pixel"])
    plain = nominal_hertz.curvature_of_map(
        rough.without_form("polynomial", 2).filtered(l=20e-6).provenance
    )
    assert plain is not None
    assert not plain.any()


def test_the_curvature_survives_a_file() -> None:
    made = BODIES["flat"].with_form(BODIES["ellipsoid"]).provenance
    again = provenance.from_text(provenance.to_text(made))
    np.testing.assert_array_equal(
        nominal_hertz.curvature_of_map(again), nominal_hertz.curvature_of_map(made)
    )


@pytest.mark.parametrize("angle", [0, 30, 90, 135])
def test_the_principal_radii_and_their_direction(angle: float) -> None:
    # R_y and R_x before the turn: the larger one lies along y then.
    body = nominal_bodies.ellipsoid(radii=(0.01, 0.004), angle=angle, **GRID)
    found = nominal_hertz.curvature_of_map(body.provenance)
    assert found is not None
    radii, direction = nominal_hertz.principal_radii(found)
    assert radii == pytest.approx((0.01, 0.004))
    assert direction == pytest.approx((90 + angle) % 180)
    line = nominal_hertz.curvature_of_map(
        nominal_bodies.cylinder(radius=0.01, angle=angle, **GRID).provenance
    )
    assert line is not None
    (along, across), axis = nominal_hertz.principal_radii(line)
    assert (along, across, axis) == (math.inf, pytest.approx(0.01), pytest.approx(angle % 180))
