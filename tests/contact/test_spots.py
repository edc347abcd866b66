import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, strategies as st

import roughcontact as rc
from roughcontact.contact import spots

PIXEL = (2e-6, 3e-6)


def flood(mask: np.ndarray, periodic_axes: tuple[int, ...]) -> list[int]:
    """Sizes of the edge-connected parts, one pixel after the other."""
    ny, nx = mask.shape
    left = set(zip(*np.nonzero(mask), strict=True))
    sizes = []
    while left:
        front, size = [left.pop()], 0
        while front:
            y, x = front.pop()
            size += 1
            for ny_, nx_ in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                place = (
                    ny_ % ny if 0 in periodic_axes else ny_,
                    nx_ % nx if 1 in periodic_axes else nx_,
                )
                if place in left:
                    left.remove(place)
                    front.append(place)
        sizes.append(size)
    return sorted(sizes, reverse=True)


@given(
    st.integers(2, 9),
    st.integers(2, 9),
    st.integers(0, 2**32 - 1),
    st.floats(0, 1),
    st.sampled_from([(), (0,), (1,), (0, 1)]),
)
def test_spots_are_those_of_a_flood_fill(
    ny: int, nx: int, seed: int, share: float, periodic_axes: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(seed)
    pressure = np.where(rng.random((ny, nx)) < share, rng.random((ny, nx)) + 0.1, 0.0)
    found = spots.find_spots(pressure, PIXEL, periodic_axes)
    area = PIXEL[0] * PIXEL[1]
    assert np.round(found.area / area).astype(int).tolist() == flood(pressure > 0, periodic_axes)
    assert found.count == found.label.max(initial=0)
    assert ((found.label > 0) == (pressure > 0)).all()
    for number in range(1, found.count + 1):
        here = pressure[found.label == number]
        assert found.load[number - 1] == pytest.approx(here.sum() * area, rel=1e-12)
        assert found.peak[number - 1] == here.max()
        assert found.area[number - 1] == pytest.approx(here.size * area, rel=1e-12)


def test_a_corner_does_not_join_and_an_edge_of_a_period_does() -> None:
    pressure = np.zeros((5, 6))
    pressure[0, 2], pressure[1, 3], pressure[4, 2] = 1, 1, 1
    assert spots.find_spots(pressure, PIXEL).count == 3
    assert spots.find_spots(pressure, PIXEL, periodic_axes=(0, 1)).count == 2
    # The column extends beyond the upper edge, which only y as a periodic axis joins.
    assert spots.find_spots(pressure, PIXEL, periodic_axes=(0,)).count == 2
    assert spots.find_spots(pressure, PIXEL, periodic_axes=(1,)).count == 3


def test_no_contact_has_no_spots() -> None:
    found = spots.find_spots(np.zeros((3, 4)), PIXEL, periodic_axes=(0, 1))
    assert found.count == 0
    assert found.load.size == found.peak.size == 0


def test_result_returns_spots() -> None:
    y, x = np.mgrid[-16:16, -16:16] * 1e-6
    surface = rc.Surface(-(x**2 + y**2) / 0.02, (1e-6, 1e-6))
    result = rc.solve(surface, load=0.05, material=rc.Material(210e9, 0.3))
    found = result.spots()
    assert found.count == 1
    assert found.load[0] == pytest.approx(0.05)
    assert found.area[0] == pytest.approx(result.contact_area)


@pytest.mark.parametrize("periodic_axes", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.55, 0.7, 1.0])
def test_spots_are_numbered_as_scipy_labels_them(
    share: float, periodic_axes: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(3)
    pressure = rng.random((40, 31)) * (rng.random((40, 31)) < share)
    found = spots.find_spots(pressure, (1.0, 1.0), periodic_axes)
    label, count = scipy.ndimage.label(pressure > 0)
    if not periodic_axes:
        assert found.count == count
    # Every label of a map that ends is in one spot, and spots of one size keep its order.
    inside = {(int(a), int(b)) for a, b in zip(label.ravel(), found.label.ravel(), strict=True)}
    assert len(inside) == count + bool((pressure == 0).any())
    sizes = np.bincount(found.label.ravel(), minlength=found.count + 1)[1:]
    assert (np.diff(sizes) <= 0).all()
    first = [int(np.argmax(found.label.ravel() == number + 1)) for number in range(found.count)]
    if not periodic_axes:
        assert all(
            a < b for a, b, m, n in zip(first, first[1:], sizes, sizes[1:], strict=False) if m == n
        )
    numbers = np.arange(1, found.count + 1)
    peaks = scipy.ndimage.maximum(pressure, found.label, numbers)
    np.testing.assert_array_equal(found.peak, peaks)
    sums = np.bincount(found.label.ravel(), pressure.ravel(), minlength=found.count + 1)[1:]
    np.testing.assert_array_equal(found.load, sums)
