"""Fluid pressure in a curved seal against a separate solution of contact and flow in turn."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

import roughcontact as rc
from roughcontact.analyses.leak.flow import flow
from roughcontact.analyses.leak.fluid_load import fluid_potential, nominal_contact
from roughcontact.cli import app
from roughcontact.contact.pair import Pair
from roughcontact.surface import nominal_bodies

Array = NDArray[np.float64]

PIXEL = 4e-6
RADIUS, LINE_LOAD, DIFFERENCE = 5e-3, 30e3, 150e6
STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / (1 - 0.3**2)
HALF_WIDTH = math.sqrt(4 * LINE_LOAD * RADIUS / (math.pi * MODULUS))


def seat(rows: int, columns: int = 16) -> Array:
    """Return a rough seat: the middle rows of one map."""
    heights = rc.self_affine(
        (192, columns),
        (PIXEL, PIXEL),
        rms_height=0.5e-6,
        rolloff_wavelength=48e-6,
        cutoff_wavelength=16e-6,
        hurst=0.8,
        rng=np.random.default_rng(3),
    )
    return heights[96 - rows // 2 : 96 + rows // 2]


# --- The separate solution: dense matrices, Love's coefficients of images, Kirchhoff's law --------


def influence(rows: int, columns: int, images: int = 60) -> Array:
    """Return the displacement of each pixel by each, periodic along x, but for a constant.

    Love 1929 for a square pixel under unit pressure, summed over its images.
    """
    y = np.arange(-rows + 1, rows)[:, None] * PIXEL
    x = np.arange(-images * columns, (images + 1) * columns)[None, :] * PIXEL
    half = PIXEL / 2

    def corner(v: Array, u: Array) -> Array:
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    love = corner(y + half, x + half) - corner(y + half, x - half)
    love += corner(y - half, x - half) - corner(y - half, x + half)
    love /= math.pi * MODULUS
    period = love.reshape(2 * rows - 1, -1, columns).sum(axis=1)
    row, column = (index.ravel() for index in np.indices((rows, columns)))
    difference = row[:, None] - row + rows - 1
    result: Array = period[difference, (column[:, None] - column) % columns]
    return result


def solve_elastic_contact(matrix: Array, gap: Array, load: float) -> tuple[Array, Array]:
    """Return pressure and gap of an elastic contact, by its active set."""
    active = gap < np.quantile(gap, 0.3)
    for _ in range(200):
        count = int(active.sum())
        system = np.zeros((count + 1, count + 1))
        system[:-1, :-1] = matrix[np.ix_(active, active)] / matrix[0, 0]
        system[:-1, -1], system[-1, :-1] = -1, 1
        right = np.append(-gap[active] / matrix[0, 0], load / PIXEL**2)
        solved = np.linalg.solve(system, right)
        pressure = np.zeros(gap.size)
        pressure[active] = solved[:-1]
        opened = matrix @ pressure + gap - solved[-1] * matrix[0, 0]
        negative, closing = pressure < 0, ~active & (opened < -1e-13)
        if not negative.any() and not closing.any():
            return pressure, opened
        # Pixels that close are taken in once no pixel pulls.
        active = active & ~negative if negative.any() else active | closing
    raise AssertionError("the active set does not settle")


def through(gap: Array) -> tuple[float, Array]:
    """Return the permeability along y and the pressure; closed points conduct next to nothing."""
    rows, columns = gap.shape
    cube = np.maximum(gap, 1e-4 * gap.max()) ** 3
    number = np.arange(gap.size).reshape(gap.shape)
    links = [(number[:-1], number[1:]), (number, np.roll(number, -1, 1))]
    first, second = (np.concatenate([link[k].ravel() for link in links]) for k in (0, 1))
    flat = cube.ravel()
    k = 2 * flat[first] * flat[second] / (flat[first] + flat[second])
    total = np.zeros(gap.size)
    np.add.at(total, first, k)
    np.add.at(total, second, k)
    right = np.zeros(gap.size)
    right[:columns] = 2 * flat[:columns]
    total[:columns] += 2 * flat[:columns]
    total[-columns:] += 2 * flat[-columns:]
    matrix = sparse.diags(total) - sparse.coo_matrix((k, (first, second)), shape=(gap.size,) * 2)
    matrix = matrix - sparse.coo_matrix((k, (second, first)), shape=(gap.size,) * 2)
    pressure = sparse_linalg.spsolve(sparse.csc_matrix(matrix), right)
    out = float((2 * flat[-columns:] * pressure[-columns:]).sum())
    return out * rows / columns, pressure.reshape(gap.shape)


def leaks(rows: int) -> tuple[float, float]:
    """Return the leak rate per Δp/12η [m³] and the load share of the fluid, solved in turn."""
    heights = seat(rows)
    y = (np.arange(rows) - (rows - 1) / 2) * PIXEL
    gap = (y[:, None] ** 2 / (2 * RADIUS) - heights).ravel()
    gap -= gap.min()
    matrix = influence(*heights.shape)
    load = LINE_LOAD * heights.shape[1] * PIXEL
    inside = np.clip((HALF_WIDTH - np.abs(y)) / PIXEL + 0.5, 0, 1)[:, None]
    fluid = np.zeros(heights.shape)
    for _ in range(6):
        carried = float(fluid.sum()) * PIXEL**2
        pressure, opened = solve_elastic_contact(
            matrix, gap + matrix @ fluid.ravel(), load - carried
        )
        opened[pressure > 0] = 0
        permeability, fraction = through(opened.reshape(heights.shape))
        fluid = DIFFERENCE * fraction * inside
    return permeability * heights.shape[1] / rows, carried / load


def run_middle_rows(
    path: Path, capsys: pytest.CaptureFixture[str], rows: int, *more: str
) -> dict[str, Any]:
    """Return the output of the command for the middle rows of the seat under the cylinder."""
    np.save(path, seat(rows) * 1e6)
    options = f"--unit um --size {rows * 4}umx64um --level none --ceiling none"
    options += " --young 210GPa --poisson 0.3 --boundary periodic-x --viscosity 1mPa*s --json"
    arguments = ["leak", str(path), *options.split(), "--counter-body", "cylinder 5mm"]
    fluid = () if "--pressure-difference" in more else ("--pressure-difference", "1500 bar")
    load = () if "--load" in more else ("--load", "30 N/mm")
    assert app.main([*arguments, *load, *fluid, *more]) == app.SOLVED
    record: dict[str, Any] = json.loads(capsys.readouterr().out)
    return record


RATE = DIFFERENCE / 12e-3


def test_curved_seal_matches_separate_solution(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    expected, carried = leaks(96)
    found = run_middle_rows(tmp_path / "seat.npy", capsys, 96, "--set", "flow-axis=y")
    assert found["leak_rate_y"][0] == pytest.approx(expected * RATE, rel=0.03)
    assert found["fluid_share"][0] == pytest.approx(carried, rel=0.15)
    assert found["load"] == [pytest.approx(30e3 * 64e-6)]
    assert "30 N/mm (1.92 N)" in found["answer"]
    # The map outside of the contact changes nothing; a plain force is shown as it was given.
    load = ("--load", "1.92 N")
    longer = run_middle_rows(tmp_path / "seat.npy", capsys, 192, "--set", "flow-axis=y", *load)
    assert longer["leak_rate_y"] == pytest.approx(found["leak_rate_y"], rel=0.03)
    assert " at 1.92 N." in longer["answer"]


def test_flow_axes_have_separate_fluid_pressures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    both, along_y, along_x = (
        run_middle_rows(tmp_path / "seat.npy", capsys, 64, *axis)
        for axis in ((), ("--set", "flow-axis=y"), ("--set", "flow-axis=x"))
    )
    assert both["leak_rate_y"] == along_y["leak_rate_y"]
    assert both["leak_rate_x"] == along_x["leak_rate_x"]
    # Along its axis, the cylinder is a sample of a longer one, under the mean pressure.
    mean = DIFFERENCE / 2 * 2 * HALF_WIDTH / LINE_LOAD
    assert along_x["fluid_share"][0] == pytest.approx(mean, rel=0.01)


def test_fluid_above_the_load_raises_input_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(AssertionError):
        run_middle_rows(tmp_path / "seat.npy", capsys, 64, "--pressure-difference", "12000 bar")
    assert "lifts the bodies" in capsys.readouterr().err
    # The land of a curved seal is as long as the load makes it.
    with pytest.raises(AssertionError):
        run_middle_rows(tmp_path / "seat.npy", capsys, 64, "--seal-length", "1 mm")
    assert "--seal-length is not valid with a nominal body" in capsys.readouterr().err


FLAT = rc.Surface(np.zeros((64, 48)), (2e-6, 2e-6))


@pytest.mark.parametrize(
    ("form", "boundary"),
    [
        ("sphere 1 mm", "free"),
        ("ellipsoid 2 mm 1 mm 30 deg", "free"),
        ("cylinder 5 mm 90 deg", "periodic-y"),
        ("punch 30 um", "free"),
    ],
)
def test_nominal_contact_matches_smooth_bodies(form: str, boundary: str) -> None:
    body, load = nominal_bodies.parse(form), 3.0
    rough = rc.Surface(2e-9 * np.random.default_rng(1).standard_normal((64, 48)), FLAT.pixel)
    pair = Pair.from_arguments(rough, STEEL, body, STEEL, boundary)
    part = nominal_contact(pair, load, None)
    assert part is not None
    smooth = rc.solve(
        FLAT,
        material=STEEL,
        counter_material=STEEL,
        counter_surface=body,
        load=load,
        boundary=boundary,
    )
    assert np.abs(part - smooth.contact).sum() < 0.05 * part.sum()
    assert nominal_contact(Pair(FLAT, STEEL), 5.0, None) is None


def test_nominal_contact_follows_tilt_and_ceiling() -> None:
    y = (np.arange(64) - 31.5) * 2e-6
    tilted = rc.Surface(4e-3 * y[:, None] + np.zeros(48), FLAT.pixel)
    pair = Pair.from_arguments(tilted, STEEL, rc.cylinder("5 mm"), STEEL, "periodic-x")
    part = nominal_contact(pair, 1.0, None)
    assert part is not None
    assert (part[:, 0] * y).sum() / part[:, 0].sum() == pytest.approx(20e-6, abs=1e-7)
    wider = nominal_contact(pair, 1.0, 1.6e8)
    assert wider is not None
    assert wider.mean() > 1.3 * part.mean()


def test_closed_pools_have_pressure_of_their_side() -> None:
    gap = np.full((9, 6), 1e-6)
    gap[4] = 0.0
    closed = fluid_potential(gap, flow(gap, (1e-6, 1e-6), 0, (1,)), (1,))
    assert (closed[:4] == 1).all()
    assert (closed[5:] == 0).all()
    gap[4, 2] = 1e-7
    opened = fluid_potential(gap, flow(gap, (1e-6, 1e-6), 0, (1,)), (1,))
    assert np.isfinite(opened).all()
    assert opened[4, 2] == pytest.approx(0.5, abs=1e-3)
    assert (np.diff(opened, axis=0) <= 1e-6).all()


def test_excess_of_gas_matches_mean_pressure() -> None:
    found = rc.leakage(
        rc.solve(FLAT, material=STEEL, counter_surface=rc.sphere("1 mm"), load=1.0),
        gas="helium",
        inlet="101 bar",
        outlet="1 bar",
    )
    assert found.seal is not None
    potential = (np.arange(10000) + 0.5) / 10000
    assert found.seal.excess(potential).mean() == pytest.approx(found.seal.mean_pressure, rel=1e-4)
