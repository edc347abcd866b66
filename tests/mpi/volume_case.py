"""What ranks that share a volume do in tests: ``mpiexec -n N python volume_case.py TASK DIR``."""

import json
import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

import roughcontact as rc
from roughcontact._tools.ranks import Ranks
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.layers import graded_layers
from roughcontact.halfspace.plastic_halfspace import PlasticHalfSpace
from roughcontact.halfspace.volume_partition import DistributedPartition
from roughcontact.material.hardening import Kinematic, Linear

PIXEL = (1.4e-6, 1.5e-6)
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1.6e9)
HARDENING = rc.Material(210e9, 0.3, hardening=Linear(1.2e9, 10e9))
PROBLEMS = {
    # Grows deeper on its way, and is unloaded.
    "grows": {
        "shape": (12, 16),
        "material": STEEL,
        "loads": [0.25, 0.0],
        "depth": 3e-6,
        "increments": 1,
    },
    # Steps are chosen by their error.
    "both bodies yield": {
        "shape": (13, 12),
        "material": STEEL,
        "counter_material": HARDENING,
        "load": 0.05,
        "depth": 6e-6,
        "tolerance": 1e-3,
    },
    "periodic, double": {
        "shape": (12, 10),
        "boundary": "periodic",
        "precision": "double",
        "depth": 8e-6,
        "material": rc.Material(210e9, 0.3, hardening=Kinematic(Linear(1.2e9, 5e9), 20e9)),
        "load": 0.1,
        "increments": 2,
        "tolerance": 1e-6,
    },
}


def surface(name):
    ny, nx = PROBLEMS[name]["shape"]
    y, x = np.mgrid[:ny, :nx]
    y, x = (y - 0.4 * ny) * PIXEL[0], (x - 0.55 * nx) * PIXEL[1]
    rng = np.random.default_rng(len(name))
    return rc.Surface(-(x**2 + y**2) / (2 * 105e-6) + 3e-9 * rng.normal(size=(ny, nx)), PIXEL)


def problem_arguments(name):
    return {key: value for key, value in PROBLEMS[name].items() if key != "shape"}


def numbers_of_result(result):
    """Return all that a result tells without its fields."""
    numbers = {**result.summary(), "corrected": result.perimeter_corrected_area}
    del numbers["seconds"]
    found = {
        "numbers": numbers,
        "cautions": result.warnings,
        "increments": [repr(step) for step in result.increments],
    }
    for number in range(len(result.bodies)):
        drawn = (
            result.profile(body=number),
            result.section("x", body=number),
            result.section("y", body=number),
            result.layers(number),
        )
        found[f"body {number}"] = [
            np.asarray(value).tobytes().hex() for one in drawn for value in vars(one).values()
        ]
    return json.loads(json.dumps(found, default=str))


def solve(folder, ranks):
    comm = ranks.communicator
    for name in PROBLEMS:
        result = rc.solve_elastoplastic(surface(name), **problem_arguments(name), ranks=comm)
        result.save(folder / f"{name}.nc")
        words = numbers_of_result(result)
        # Every rank tells the same.
        assert comm.allgather(words) == [words] * ranks.count
        if ranks.is_root:
            (folder / f"{name}.json").write_text(json.dumps(words))
    with pytest.raises(rc.InputError, match="distributed over several ranks"):
        result.save(folder / "fields.vtr")


def apply(folder, ranks):
    """Every layer of strain, pressure and pull gives the stress of one process, to the bit."""
    rng = np.random.default_rng(4)
    thickness = graded_layers(0.5, 6.0)
    cases = [
        ((9, 12), "periodic"),
        ((12, 9), "periodic"),
        ((10, 12), "periodic"),
        ((11, 9), "periodic"),
        ((13, 14), "free"),
    ]
    for shape, boundary in cases:
        strain = rng.normal(size=(thickness.size, 5, *shape))
        strain[2:5] = 0
        pressure = rng.random(shape)
        share = DistributedPartition(ranks, Workspace(2))
        here = share.layers(thickness.size)
        spaces = [
            PlasticHalfSpace(
                shape,
                (1.0, 1.2),
                thickness,
                shear_modulus=2.0,
                poisson=0.3,
                boundary=boundary,
                workspace=Workspace(1),
                share=one,
            )
            for one in (share, None)
        ]
        for strained in (strain, 0 * strain):
            found = [
                answers(space, strained[layers], pressure)
                for space, layers in zip(spaces, (list(here), slice(None)), strict=True)
            ]
            np.testing.assert_array_equal(found[0][0], found[1][0])
            for mine, all_of_them in zip(found[0][1:], found[1][1:], strict=True):
                np.testing.assert_array_equal(mine, all_of_them[list(here)])


def answers(space, strain, pressure):
    """Return the displacement by a strain, and both kinds of stress with a pressure that pulls."""

    def fill(layer, out):
        out[...] = strain[layer]
        rows = np.flatnonzero(strain[layer].any(axis=(0, 2)))
        return slice(int(rows[0]), int(rows[-1]) + 1) if rows.size else None

    displacement = space.displacement(fill, trace=True)
    deviator = np.full_like(strain, np.nan)
    mean = np.full_like(strain[:, 0], np.nan)
    pull = 0.3, -0.2
    space.stress(pressure, lambda layer, values: np.copyto(deviator[layer], values), pull)
    space.mean_stress(pressure, lambda layer, values: np.copyto(mean[layer], values), pull)
    return displacement, deviator, mean


def die_solving(folder, ranks):
    def kill_last_rank(_):
        if ranks.number == ranks.count - 1:
            os.kill(os.getpid(), signal.SIGKILL)

    problem = problem_arguments("both bodies yield")
    rc.solve_elastoplastic(
        surface("both bodies yield"), **problem, ranks=ranks.communicator, progress=kill_last_rank
    ).save(folder / "out.nc")


def die_writing(folder, ranks):
    problem = problem_arguments("both bodies yield")
    result = rc.solve_elastoplastic(surface("both bodies yield"), **problem, ranks=ranks)
    if not ranks.is_root:
        ranks.sent_to_first = lambda part, sender: os.kill(os.getpid(), signal.SIGKILL)
    result.save(folder / "out.nc")


def refuse(folder, ranks):
    """What is known of a volume in one place is refused on all ranks, and so are too many."""
    for more in ({"folder": folder}, {"on_step": print}, {"layers": [20e-6]}, {"load": 1e6}):
        problem = {"material": STEEL, "load": 0.3, **more}
        try:
            rc.solve_elastoplastic(surface("grows"), **problem, ranks=ranks)
        except rc.RoughcontactError as error:
            (folder / f"{next(iter(more))}-{ranks.number}").write_text(str(error))


if __name__ == "__main__":
    globals()[sys.argv[1]](Path(sys.argv[2]), Ranks(MPI.COMM_WORLD))
