"""Shared helpers for tests of readers: files, and the words of a FormatError."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from roughcontact.errors import FormatError, InputError
from roughcontact.formats.read import read_surface

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"

needs_reader = pytest.mark.skipif(
    importlib.util.find_spec("SurfaceTopography") is None, reason="SurfaceTopography is absent"
)

# Anisotropic grid and pixel, so that a swap of axes shows.
HEIGHTS = np.array([[0.0, 1.0, 2.0, 3.0], [4.0, np.nan, 6.0, 7.0], [8.0, 9.0, 10.0, 11.5]])


def measurement(name: str) -> Path:
    path = MEASUREMENTS / name
    if not path.exists():
        pytest.skip(f"shared/measurements/{name} is absent")
    return path


def write(tmp_path: Path, name: str, content: str | bytes) -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def assert_rejected(
    path: Path, *words: str, kind: type[InputError] = FormatError, **arguments: object
) -> None:
    """Check that reading fails with one sentence that names the file and has these words."""
    with pytest.raises(InputError) as caught:
        read_surface(path, **arguments)  # type: ignore[arg-type]
    assert type(caught.value) is kind
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message
