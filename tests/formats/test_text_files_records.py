"""Profiles in records of text."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact.formats.read import channels, read_surface

HEIGHTS = np.array([0.5, -1.25, 3.0, 2.0])
ROWS = "".join(f"{z:.4f}\r\n" for z in HEIGHTS)
FILES = {
    # ISO 5436-2, with its control characters.
    "a.smd": "ISO 5436-2:2012\0name\0\r\nPRF\0 1 X\0\r\n"
    "CX\0 I\0 4 mm\0 1.0e0 D\0 2.0e-3\r\nCZ\0 A\0 4 um\0 1.0e0 D\0\r\n\x03\r\n"
    f"DATE: 1\0\r\n\x03\r\n{ROWS}\x03\r\n999\r\n\x03\r\n\x1a",
    "b.smd": "ISO 5436-2:2000\0name\0\r\nPRF\0 1 X\0\r\n"
    "CX\0 I\0 4 um\0 0.5 D\0 4\r\nCZ\0 A\0 4 nm\0 1.0e3 D\0\r\n\x03\r\n"
    f"\x03\r\n{ROWS}\x03\r\n999\r\n\x03\r\n\x1a",
    # Taylor Hobson; a suffix that Mahr has, too.
    "c.prf": "1 2\r\nname 0.0e+000 PRF\r\nCX M 4.0e+000 MM 1.0e+000 D\r\n"
    "CZ M 4.0e+000 MM 1.0e-007 L\r\nEOR\r\nSTYLUS_RADIUS 2.0e-003 MM\r\nSPACING CX 2.0e-003\r\n"
    "MAP 1.0e0 CZ CZ 1.0e0 1.0e0\r\nEOR\r\n"
    + "".join(f"{z * 1e4:.0f}\r\n" for z in HEIGHTS)
    + "EOR\r\nEOF\r\n",
    "d.sig": "SigmaSurf_Data 1.0\r\nIDENTIFICATION: x\r\nDATE: 1\r\nSPACING_UM: 2.00000\r\n"
    f"NUMBER_OF_POINTS: 4\r\nPROFILE_UM:\r\n{ROWS}",
}


@pytest.mark.parametrize("name", FILES)
def test_profile_has_its_spacing_and_unit(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, name, FILES[name])
    surface = read_surface(path)
    assert surface.is_profile
    np.testing.assert_allclose(surface.heights[0], 1e-6 * HEIGHTS)
    assert surface.pixel[1] == pytest.approx(2e-6)
    assert channels(path)[0].shape == (1, 4)


def test_missing_points_are_no_heights(tmp_path: Path) -> None:
    text = FILES["a.smd"].replace("-1.2500", "BAD")
    surface = read_surface(write(tmp_path, "a.smd", text))
    assert np.isnan(surface.heights[0]).tolist() == [False, True, False, False]


def test_wrong_number_of_points_raises(tmp_path: Path) -> None:
    path = write(tmp_path, "a.smd", FILES["a.smd"].replace("-1.2500\r\n", ""))
    assert_rejected(path, "3 heights, 4 announced")
