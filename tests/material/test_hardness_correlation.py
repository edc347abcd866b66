"""Microhardness by the Brinell hardness."""

import pytest

from roughcontact.material.hardness import vickers_correlation


@pytest.mark.parametrize("hardness", [1.3e9, 2e9, 3.178e9, 5e9, 7.6e9])
def test_vickers_correlation_matches_its_second_published_form(hardness: float) -> None:
    # Yovanovich 2005, IEEE Trans. Compon. Packag. Technol. 28, 182: c2 = -0.370 + 0.442 H/c1.
    coefficients = vickers_correlation(hardness)
    assert coefficients is not None
    assert coefficients[1] == pytest.approx(-0.370 + 0.442 * hardness / coefficients[0], abs=0.03)


def test_vickers_correlation_is_limited_to_its_range() -> None:
    assert vickers_correlation(1.2e9) is None
    assert vickers_correlation(8e9) is None
