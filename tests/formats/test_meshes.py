"""Height fields as triangles."""

from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact.formats.read import channels, read_surface

DATA = Path(__file__).parents[1] / "data"
HEIGHTS = np.random.default_rng(1).normal(size=(4, 5)).astype(np.float32).astype(float)
Y, X = np.mgrid[:4, :5].astype(float)
VERTICES = np.stack([3 * X, 2 * Y, HEIGHTS], axis=-1).reshape(-1, 3)
CORNERS = np.arange(15).reshape(3, 5)[:, :4].ravel()
TRIANGLES = np.concatenate([[(i, i + 1, i + 5), (i + 1, i + 6, i + 5)] for i in CORNERS.tolist()])


def stl(vertices: np.ndarray, triangles: np.ndarray) -> bytes:
    facets = np.zeros(len(triangles), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("attribute", "<u2")])
    facets["v"] = vertices[triangles]
    return b"solid".ljust(80) + np.uint32(len(triangles)).tobytes() + facets.tobytes()


def ply(kind: str) -> bytes:
    head = (
        f"ply\nformat {kind} 1.0\ncomment made\nelement vertex 20\nproperty uchar red\n"
        "property float z\nproperty double y\nproperty float x\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    if kind == "ascii":
        rows = [f"7 {z!r} {y!r} {x!r}\n" for x, y, z in VERTICES.tolist()]
        return head + "".join(rows).encode() + b"3 0 1 2\n"
    order = "<" if "little" in kind else ">"
    types = {"r": "u1", "z": f"{order}f4", "y": f"{order}f8", "x": f"{order}f4"}
    table = np.zeros(20, list(types.items()))
    table["x"], table["y"], table["z"] = VERTICES.T
    return head + table.tobytes() + b"\3" + np.arange(3, dtype=f"{order}i4").tobytes()


def obj() -> bytes:
    lines = [f"v {x!r} {y!r} {z!r}\nvn 0 0 1\n" for x, y, z in VERTICES.tolist()]
    return ("# made\n" + "".join(lines) + "f 1//1 2//1 3//1\n").encode()


FILES = {
    "map.stl": stl(VERTICES, TRIANGLES),
    "a.ply": ply("ascii"),
    "b.ply": ply("binary_little_endian"),
    "c.ply": ply("binary_big_endian"),
    "map.obj": obj(),
}


@pytest.mark.parametrize("name", FILES)
def test_vertices_on_a_grid_are_a_map(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, name, FILES[name])
    surface = read_surface(path, unit="mm, um")
    np.testing.assert_allclose(surface.heights, 1e-6 * HEIGHTS, rtol=1e-6)
    assert surface.pixel == pytest.approx((2e-3, 3e-3))
    assert channels(path)[0].shape == (4, 5)


def test_text_of_triangles_is_a_map() -> None:
    surface = read_surface(DATA / "surface.stl", unit="mm")
    assert surface.shape == (9, 9)
    assert surface.pixel == pytest.approx((1e-5, 1e-5))
    assert surface.heights.max() == pytest.approx(4.66991e-8)


def test_closed_body_is_no_map(tmp_path: Path) -> None:
    bottom = VERTICES * (1, 1, 0) - (0, 0, 9)
    both = np.concatenate([VERTICES, bottom])
    triangles = np.concatenate([TRIANGLES, TRIANGLES + 20])
    assert_rejected(write(tmp_path, "body.stl", stl(both, triangles)), "a body", unit="mm")


def test_scattered_vertices_are_no_grid(tmp_path: Path) -> None:
    place = np.random.default_rng(2).uniform(size=VERTICES.shape)
    assert_rejected(write(tmp_path, "a.stl", stl(place, TRIANGLES)), "interpolate", unit="mm")
    assert_rejected(write(tmp_path, "b.stl", FILES["map.stl"][:-1]), "as a mesh in STL")
