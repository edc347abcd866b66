"""What ranks do in the tests: ``mpiexec -n N python ranks_case.py TASK FOLDER``."""

import os
import signal
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

import roughcontact as rc
from roughcontact._tools.ranks import Ranks
from roughcontact.contact import archive
from roughcontact.contact.share import row_bands
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.fft import Workspace

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
TOOL = rc.Material(young=210e9, poisson=0.3, coating=[rc.Layer(450e9, 0.25, 2e-6)])
PIXEL = (0.8e-6, 1e-6)
# To so many digits that every rank's and one process's answer are the same to 1e-9.
TIGHT = 1e-11
PROBLEMS = {
    "free, ceiling": {"shape": (96, 75), "load": 0.3},
    "periodic, elastic": {"shape": (72, 128), "boundary": "periodic", "load": 1.0, "ceiling": None},
    "strip, approach": {"shape": (70, 66), "boundary": "periodic-x", "approach": 3e-7},
    "single": {"shape": (66, 64), "load": 0.1, "precision": "single", "tolerance": 1e-4},
    "holes, one corner": {"shape": (128, 130), "load": 0.02, "ceiling": 2e9},
    "coated": {"shape": (66, 64), "load": 0.1, "ceiling": None, "material": TOOL},
}


def heights(name):
    ny, nx = PROBLEMS[name]["shape"]
    rng = np.random.default_rng(len(name))
    y, x = np.mgrid[:ny, :nx]
    found = 4e-8 * rng.normal(size=(ny, nx))
    for waves in range(1, 9):
        turn = rng.uniform(0, 2 * np.pi, 2)
        found += 2e-7 / waves * np.cos(2 * np.pi * waves * y / ny + turn[0])
        found += 2e-7 / waves * np.cos(2 * np.pi * waves * x / nx + turn[1])
    if name == "holes, one corner":
        # Nothing touches on the rows of other ranks.
        found -= 2e-11 * ((y - 8) ** 2 + (x - 100) ** 2) * 10
        found[4:7, 90:99] = np.nan
        found[60:64] = np.nan
    return found


def problem_arguments(name):
    problem = {key: value for key, value in PROBLEMS[name].items() if key != "shape"}
    return {"material": STEEL, "tolerance": TIGHT, **problem}


def slab_of(name, ranks):
    shape = PROBLEMS[name]["shape"]
    rows = rc.mpi.slab_rows(shape, ranks)
    return rc.mpi.Slab(heights(name)[rows], shape, PIXEL, ranks, holes_masked=True)


def solve(folder, ranks):
    for name in PROBLEMS:
        result = rc.solve(slab_of(name, ranks), **problem_arguments(name))
        result.save(folder / f"{name}.nc")
        told = [
            result.contact_area,
            result.perimeter_corrected_area,
            result.mean_gap,
            result.totals.max_indentation,
            result.totals.edge_load or 0.0,
        ]
        # Every rank tells the same.
        assert ranks.communicator.allgather(told) == [told] * ranks.count
        if ranks.is_root:
            np.save(folder / f"{name}.npy", told)


def whole(folder, ranks):
    """What needs the map in one process is refused, and numbers are no matter of all ranks."""
    result = rc.solve(slab_of("free, ceiling", ranks), **problem_arguments("free, ceiling"))
    refused = {
        "spots": result.spots,
        "elastic": result.elastic,
        "stiffness": result.stiffness,
        "figures": lambda: result.plot,
        "surface": lambda: result.surface,
        "page": result.explore,
        "csv": lambda: result.save(folder / "out.csv"),
        "centre": lambda: result.center_of_pressure,
        "slope": lambda: result.pair.rms_slope,
        "tilt": lambda: rc.solve(result.share, material=STEEL, load=0.3, moments=(0.0, 0.0)),
        "start": lambda: rc.solve(
            result.share, material=STEEL, load=0.3, initial_guess=result.pressure
        ),
        "ceiling": lambda: rc.solve(result.share, material=STEEL, load=0.3, ceiling="calibrated"),
        "counter": lambda: rc.solve(
            result.share,
            material=STEEL,
            load=0.3,
            counter_surface=rc.Surface(heights("free, ceiling"), PIXEL),
        ),
    }
    for ask in refused.values():
        with pytest.raises(rc.InputError, match="whole map in one process"):
            ask()
    result.report(folder / "out.html")
    if ranks.is_root:
        # Alone: no other rank would answer.
        told = [str(result), result._repr_html_(), str(result.summary()), str(result.references())]
        told += [str(result.warnings), str(result.regime), str(result.hertz)]
        assert all(told)
        assert result.summary()["ranks"] == ranks.count


def apply(folder, ranks):
    """Operator, gather and inverse are those of one process, and level like one."""
    shape, rng = (96, 75), np.random.default_rng(1)
    pressure = np.where(rng.random(shape) < 0.2, rng.random(shape), 0)
    pressure[20:50] = 0
    rows = rc.mpi.slab_rows(shape, ranks)
    here = pressure[rows]
    index = np.flatnonzero(here)
    for boundary, coatings in product(Boundary, (None, Coatings.from_bodies(TOOL, STEEL))):
        alone = boundary.operator(shape, PIXEL, 2e11, coatings=coatings, workspace=Workspace(1))
        make = boundary.slab_operators(
            row_bands(shape, ranks.count),
            shape,
            PIXEL,
            2e11,
            ranks,
            coatings=coatings,
            workspace=Workspace(3),
        )
        whole = make(shape, (1, 1))
        expected = alone(pressure)
        largest = np.abs(expected).max()
        np.testing.assert_allclose(whole(pressure), expected, rtol=0, atol=1e-14 * largest)
        gathered = whole.gather(whole.support(index), here.ravel()[index])
        np.testing.assert_allclose(
            gathered, expected[rows].ravel()[index], rtol=0, atol=1e-14 * largest
        )
        assert abs(whole.self_displacement / alone.self_displacement - 1) < 1e-13
        inverse = alone.approximate_inverse()(pressure)
        found = whole.approximate_inverse()(pressure)
        np.testing.assert_allclose(found, inverse, rtol=0, atol=3e-6 * np.abs(inverse).max())
    reduces(ranks)
    tilted = heights("free, ceiling") + 1e-7 * np.arange(75) - 3e-8 * np.arange(96)[:, None]
    level = rc.mpi.Slab(tilted[rows], shape, PIXEL, ranks).leveled()
    expected = rc.Surface(tilted, PIXEL).leveled().heights[rows]
    np.testing.assert_allclose(level.heights, expected, rtol=0, atol=1e-19)


def reduces(ranks):
    """Blocks of pixels are those of the whole map, also where the last of them is a part."""
    shape = (1031, 130)
    values = np.random.default_rng(2).normal(size=shape)
    slab = rc.mpi.Slab(values[rc.mpi.slab_rows(shape, ranks)], shape, PIXEL, ranks)
    mean, largest = slab.reduce_blocks(slab.heights), slab.reduce_blocks(slab.heights, largest=True)
    if not ranks.is_root:
        assert mean is largest is None
        return
    edge = -(-shape[1] // mean.shape[1])
    assert edge > 1
    for found, of in ((mean, np.mean), (largest, np.max)):
        expected = [
            [of(values[y : y + edge, x : x + edge]) for x in range(0, shape[1], edge)]
            for y in range(0, shape[0], edge)
        ]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def die_solving(folder, ranks):
    def kill_last_rank(at):
        whole = at.step.shape == PROBLEMS["free, ceiling"]["shape"]
        if whole and ranks.number == ranks.count - 1:
            os.kill(os.getpid(), signal.SIGKILL)

    result = rc.solve(
        slab_of("free, ceiling", ranks),
        progress=kill_last_rank,
        **problem_arguments("free, ceiling"),
    )
    result.save(folder / "out.nc")


def die_writing(folder, ranks):
    archive._ARCHIVE_PART = 4096
    result = rc.solve(slab_of("free, ceiling", ranks), **problem_arguments("free, ceiling"))
    if not ranks.is_root:
        ranks.sent_to_first = lambda part, sender: os.kill(os.getpid(), signal.SIGKILL)
    result.save(folder / "out.nc")


def fail_writing(folder, ranks):
    result = rc.solve(slab_of("free, ceiling", ranks), **problem_arguments("free, ceiling"))
    if ranks.is_root:
        add = archive.netcdf.checksums.RunningChecksum.update

        def full(self, part):
            add(self, part)
            raise OSError(28, "No space left on device")

        archive.netcdf.checksums.RunningChecksum.update = full
    try:
        result.save(folder / "out.nc")
    except OSError as error:
        (folder / f"told-{ranks.number}").write_text(str(error.strerror))


def fail_alone(folder, ranks):
    """One rank of the command line fails by itself."""
    from roughcontact.analyses.solve import mpi
    from roughcontact.cli import app

    run = mpi.run

    def failing(request, ranks, *more):
        if not ranks.is_root:
            raise MemoryError("no room")
        return run(request, ranks, *more)

    mpi.run = failing
    arguments = ["--unit", "m", "--size", "0.1 mm", "--load", "1 N", "--material", "100Cr6"]
    sys.exit(app.main(["solve", str(folder / "map.npy"), *arguments]))


if __name__ == "__main__":
    globals()[sys.argv[1]](Path(sys.argv[2]), Ranks(MPI.COMM_WORLD))
