"""Results of many tasks as hashes of all bits: run by `test_threads` on a number of threads.

``python fingerprints.py CORES THREADS`` limits the cores, where the system can, and shares
the work out to a number of threads. How many BLAS takes is set by the environment.
"""

import hashlib
import json
import os
import sys
import warnings
from dataclasses import replace

if __name__ == "__main__" and hasattr(os, "sched_setaffinity"):
    # Before anything is imported: libraries count the cores once.
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: int(sys.argv[1])])

import numpy as np

import roughcontact as rc
from roughcontact.elastoplastic import solve as volume_solve
from roughcontact.halfspace import fft
from roughcontact.material.hardening import Perfect
from roughcontact.solvers import rigid_tilt
from roughcontact.surface import random_surfaces, spectrum

STEEL = rc.Material(210e9, 0.3, 1e9)


def rough(shape, pixel=(1e-6, 1e-6), holes=None):
    """Return a rough surface, made without transforms or products, with or without holes."""
    rng = np.random.default_rng(5)
    heights = rng.standard_normal(shape).cumsum(axis=0).cumsum(axis=1)
    heights *= 3e-7 / np.abs(heights).max()
    if holes is not None:
        heights[holes] = np.nan
    return rc.Surface(heights, pixel)


def bend_surface(surface, curvature_y, curvature_x):
    """Return a surface on a rotund body."""
    ny, nx = surface.heights.shape
    y, x = np.mgrid[:ny, :nx] - np.array([ny // 2, nx // 2])[:, None, None]
    form = -((y * surface.pixel[0]) ** 2 * curvature_y + (x * surface.pixel[1]) ** 2 * curvature_x)
    return replace(surface, heights=surface.heights + form)


def iter_prepared():
    """Yield (what, arrays) for everything that prepares and judges a surface."""
    yield "synthetic map", random_surfaces.reference_map(256)[0]
    surface = rough((301, 283), (1e-6, 1.2e-6))
    for form in ("plane", "quadric", "mean", "robust"):
        yield f"leveled: {form}", surface.leveled(form).heights
    for form, degree in (("polynomial", 4), ("polynomial", 12)):
        yield f"without {form} {degree}", surface.without_form(form, degree=degree).heights
    yield "without sphere", bend_surface(surface, 300, 300).without_form("sphere").heights
    yield "without cylinder", bend_surface(surface, 0, 300).without_form("cylinder").heights
    yield "filtered", surface.filtered(s=5e-6, l=80e-6).heights
    wide = np.zeros((240, 240), bool)
    wide[7:-7, 6:-6] = True
    yield "filled at once", rough((120, 240), holes=wide[:120]).filled(most=1.0).heights
    yield "filled step by step", rough((240, 240), holes=wide).filled(most=1.0).heights
    for method in ("spline", "bandlimited"):
        yield f"resampled: {method}", surface.resampled((200, 310), method=method).heights
    grid = rc.Surface(np.zeros((120, 130)), (1.5e-6, 1.5e-6))
    yield "aligned", surface.aligned(grid, angle=12.0).heights
    yield "roughness", list(surface.roughness().values())
    yield "spectrum", np.concatenate(spectrum.radial_spectrum(surface.heights, surface.pixel))


def iter_contacts():
    """Yield (what, arrays) for contacts."""
    small, wide = rough((60, 51)), rough((137, 260), (1.3e-6, 1e-6))
    for boundary in ("free", "periodic", "periodic-x", "periodic-y"):
        for ceiling in (None, "auto"):
            for surface in (small, wide):
                result = rc.solve(
                    surface,
                    material=STEEL,
                    boundary=boundary,
                    ceiling=ceiling,
                    load=1e9 * 0.05 * surface.size[0] * surface.size[1],
                )
                name = f"{boundary}, ceiling {ceiling}, {surface.heights.shape}"
                yield name, np.stack([result.pressure, result.gap])
    single = rc.solve(wide, material=STEEL, load=1.0, precision="single")
    yield "single precision", single.pressure
    tilted = rc.solve(wide, material=STEEL, load=3.0, moments=(2e-5, -3e-5))
    yield "tilted", [tilted.pressure, tilted.tilt]
    rng = np.random.default_rng(1)
    y, x, share = rng.standard_normal((3, 30_000))
    balance = rigid_tilt.excess(np.array([2.0, 1.0]), y, x, 5e-5 + 1e-5 * np.abs(share))
    yield "what a map balances", balance


def iter_stresses():
    """Yield (what, arrays) for stress and plasticity below contacts."""
    small = rough((60, 51))
    stress = rc.subsurface_stress(rc.solve(small, material=STEEL, load=0.2))
    yield "stress", [stress.section_x, stress.section_y]
    yield "first yield", rc.first_yield_load(small, material=STEEL).solution.load
    ball, metal = (
        bend_surface(rough((40, 36)), 2e3, 2e3),
        rc.Material(210e9, 0.3, hardening=Perfect(1e9)),
    )
    # So small a volume would be left to one thread.
    volume_solve.MIN_SHARED_POINTS = 0
    volume = rc.solve_elastoplastic(ball, material=metal, increments=1, loads=[0.05])
    pressure, body = volume.solution.pressure, volume.bodies[0]
    yield "volume", [pressure, body.plastic_strain, body.stress, body.mean_residual_stress]


def hash_bits(values):
    """Return a hash of the bits of numbers."""
    digest = hashlib.sha256()
    for part in values if isinstance(values, list) else [values]:
        digest.update(np.ascontiguousarray(part, dtype=np.float64).tobytes())
    return digest.hexdigest()[:16]


if __name__ == "__main__":
    threads = int(sys.argv[2])
    fft.default_workers = lambda: threads
    warnings.simplefilter("ignore")
    found = {
        what: hash_bits(values)
        for part in (iter_prepared, iter_contacts, iter_stresses)
        for what, values in part()
    }
    if fft._ducc0 is not None:
        fft._ducc0 = None
        found |= {f"{what}, SciPy": hash_bits(values) for what, values in iter_contacts()}
    print(json.dumps(found))
