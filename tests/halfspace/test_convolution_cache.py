"""Spectra that outlive an operator: the same numbers, within a stated memory."""

import numpy as np
import pytest

from roughcontact.halfspace import convolution, kernels
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.convolution import ArrayCache

PIXEL, MODULUS = (0.7e-6, 1e-6), 1e11


def test_cache_keeps_last_used_arrays():
    store, made = ArrayCache(3 * 80), []

    def get(key):
        def make():
            made.append(key)
            return np.full(10, float(key))

        array = store.get(key, make)
        assert (array == key).all()
        return array

    for key in (1, 2, 3, 1, 4):
        get(key)
    assert store.nbytes == 240
    # The second was used least lately.
    for key in (1, 3, 4, 2):
        get(key)
    assert made == [1, 2, 3, 4, 2]
    with pytest.raises(ValueError, match="read-only"):
        get(1)[0] = 0


def test_too_large_array_is_not_cached():
    store = ArrayCache(79)
    first = store.get("a", lambda: np.ones(10))
    assert store.get("a", lambda: np.ones(10)) is not first
    assert store.nbytes == 0


@pytest.mark.parametrize("boundary", ["free", "periodic-x", "periodic-y"])
def test_a_second_operator_makes_no_kernel(boundary, monkeypatch):
    monkeypatch.setattr(convolution, "SPECTRA", ArrayCache(convolution.MAX_CACHE_BYTES))
    calls, rng = [], np.random.default_rng(0)
    for name in ("love", "strip"):
        real = getattr(kernels, name)
        monkeypatch.setattr(
            kernels, name, lambda *given, real=real, **more: calls.append(1) or real(*given, **more)
        )
    pressure = rng.random((30, 40))
    first = Boundary(boundary).operator((30, 40), PIXEL, MODULUS)(pressure)
    made = len(calls)
    assert made > 0
    again = Boundary(boundary).operator((30, 40), PIXEL, MODULUS)(pressure)
    np.testing.assert_array_equal(again, first)
    # Of another size and another body, alike.
    doubled = tuple(2 * edge for edge in PIXEL)
    other = Boundary(boundary).operator((30, 40), doubled, 4 * MODULUS)(pressure)
    np.testing.assert_allclose(other, first / 2, rtol=1e-13)
    assert len(calls) == made
    Boundary(boundary).operator((30, 41), PIXEL, MODULUS)
    assert len(calls) > made
