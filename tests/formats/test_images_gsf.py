"""Gwyddion Simple Field."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact.errors import InputError
from roughcontact.formats.read import channels, read_surface
from roughcontact.formats.source import Channel

DATA = Path(__file__).parents[1] / "data"


def field(head: dict[str, object], values: np.ndarray, spare: bytes = b"") -> bytes:
    lines = ["Gwyddion Simple Field 1.0", *(f"{key} = {value}" for key, value in head.items())]
    text = ("\n".join(lines) + "\n").encode()
    return text + b"\0" * (4 - len(text) % 4) + values.astype("<f4").tobytes() + spare


VALUES = np.arange(6.0).reshape(2, 3)
GRID = {"XRes": 3, "YRes": 2}


def test_field_has_its_sides_and_units() -> None:
    surface = read_surface(DATA / "field.gsf")
    assert surface.shape == (32, 48)
    assert surface.size == pytest.approx((32e-6, 48e-6))
    assert surface.heights.std() == pytest.approx(199.884e-9, rel=1e-5)
    assert channels(DATA / "field.gsf") == (Channel("Height", "m", True, (32, 48)),)


@pytest.mark.parametrize("title", ["", "a", "ab", "abc", "abcd"])
def test_field_is_read_for_any_length_of_its_header(title: str, tmp_path: Path) -> None:
    head = GRID | {"XReal": 3, "YReal": 4, "XYUnits": "um", "ZUnits": "nm", "Title": title}
    surface = read_surface(write(tmp_path, "field.bin", field(head, VALUES)))
    np.testing.assert_allclose(surface.heights, 1e-9 * VALUES)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))


def test_field_without_units_needs_them(tmp_path: Path) -> None:
    path = write(tmp_path, "field.gsf", field(GRID, VALUES))
    assert_rejected(path, "no unit of the heights", kind=InputError)
    surface = read_surface(path, unit="um", size=(2e-6, 3e-6))
    np.testing.assert_allclose(surface.heights, 1e-6 * VALUES)


def test_field_of_another_quantity_or_length_raises(tmp_path: Path) -> None:
    path = write(tmp_path, "field.gsf", field(GRID | {"ZUnits": "V", "Title": "Phase"}, VALUES))
    assert_rejected(path, "holds no height map, only the channels 0: 'Phase' [V]")
    path = write(tmp_path, "cut.gsf", field(GRID, VALUES)[:-1])
    assert_rejected(path, "2 × 3 points", "do not end with the file")
