"""Results do not depend on how many threads share the work, bit by bit."""

import ast
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import layers
from paths import ROOT
from roughcontact.halfspace import convolution
from roughcontact.halfspace.convolution import ArrayCache
from roughcontact.halfspace.fft import Workspace

# Sums by BLAS or LAPACK, whose last digits depend on their threads in large arrays.
BLAS = {
    "cholesky",
    "cov",
    "det",
    "dot",
    "eigh",
    "eigvalsh",
    "inner",
    "inv",
    "lstsq",
    "matmul",
    "norm",
    "pinv",
    "polyfit",
    "qr",
    "solve",
    "svd",
    "tensordot",
    "vdot",
    "vecdot",
}

# Functions that may, and why it is never much: module -> function -> reason.
ALLOWED_PRODUCTS = {
    "contact.archive": {"verify_solution": "a gap that is compared with a bound only"},
    "analyses.leak.fluid_load": dict.fromkeys(
        ("nominal_contact", "_covered_part"), "a curvature of two by two"
    ),
    "analyses.sweep.model": {"low_load_slope": "the loads of a curve"},
    "halfspace.plastic_halfspace": {
        "_restrict": "a sparse matrix, no BLAS",
        "_prolong": "a sparse matrix, no BLAS",
    },
    "halfspace.layers": {"_mean_displacement": "layers"},
    "halfspace.stress_summary": {"_with_slope": "six parameters of a paraboloid"},
    "solvers.aggregation": dict.fromkeys(
        ("excess", "smooth", "factors"), "sparse matrices, no BLAS"
    ),
    "elastoplastic.increments": {"add": "five components", "_least_squares": "a handful of steps"},
    "analyses.tangential.model": {"_append_step": "two components"},
    "solvers.partial_slip": dict.fromkeys(
        ("_dual", "iterates", "merit", "project_with_sum", "stiffness"), "two components"
    ),
    "solvers.active_set": {"_orthonormal": "three by three"},
    "solvers.problem": {"_balance_multipliers": "three by three"},
    "solvers.rigid_tilt": {
        "rigid_tilt": "the few points on which rigid bodies rest",
        "excess": "two components",
    },
    "surface.alignment": {"grid_positions": "two axes"},
    "uncertainty.reconstruction": {"_power_law": "bins of a spectrum"},
    "contact.nominal_hertz": {"_rotate_curvature": "two by two", "principal_radii": "two by two"},
    "surface.cleaning": {
        "_solve_iteratively": "a sparse matrix, no BLAS",
        "_multigrid": "sparse matrices, no BLAS",
        "cycle": "sparse matrices, no BLAS",
    },
    "surface.filters": {"excess": "forty weights"},
    "surface.form": {
        "inverse": "six parameters",
        "quadric": "six parameters",
        "solve": "six parameters",
        "_remove_cylinder": "six parameters",
        "subtract_terms": "eigenvalues that are compared with a bound only",
    },
    "surface.resolution": {"_exponent": "bins of a spectrum"},
    "surface.spectrum": dict.fromkeys(
        ("lay_direction", "_likeliest_wave"), "costs of directions, of which the smallest is taken"
    ),
    "elastoplastic.plastic_flow": {"plastic_volume": "layers"},
    "elastoplastic.volume_result": {"plastic_volume": "layers"},
}


def products(path):
    """Yield the functions that multiply matrices or call linear algebra."""

    def visit(node, function):
        if isinstance(node, ast.FunctionDef):
            function = node.name
        if isinstance(node, ast.MatMult):
            yield function
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            library = ast.unparse(node.func.value).split(".")[0]
            if node.func.attr in BLAS and library in ("np", "scipy", "linalg"):
                yield function
        for child in ast.iter_child_nodes(node):
            yield from visit(child, function)

    yield from visit(layers.parse_module(path), "")


@pytest.mark.usefixtures("parsed_sources")
def test_large_products_do_not_use_blas():
    found = {module: set(products(path)) for module, path in layers.module_paths().items()}
    assert {module: names for module, names in found.items() if names} == {
        module: set(names) for module, names in ALLOWED_PRODUCTS.items()
    }


def fingerprints(cores, threads, blas):
    """Start the work of `fingerprints` on a number of cores and threads."""
    names = ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB_MAXIMUM", "DUCC0")
    return subprocess.Popen(
        [sys.executable, ROOT / "tests" / "fingerprints.py", str(cores), str(threads)],
        stdout=subprocess.PIPE,
        env=os.environ
        | {"PYTHONPATH": str(layers.PACKAGE.parent)}
        | {f"{name}_NUM_THREADS": str(blas) for name in names},
    )


def compare_runs(*ways):
    runs = [fingerprints(*way) for way in ways]
    first, *others = (json.loads(run.communicate()[0]) for run in runs)
    assert len(first) > 40
    for way, other in zip(ways[1:], others, strict=True):
        assert [what for what in first if first[what] != other[what]] == [], way


@pytest.mark.process
def test_one_thread_and_three_give_the_same_bits():
    compare_runs((1, 1, 1), (2, 3, 2))


@pytest.mark.slow
def test_any_number_of_threads_gives_the_same_bits():
    compare_runs((1, 1, 1), (1, 2, 4), (2, 2, 1), (2, 2, 2), (4, 4, 4))


@pytest.mark.parametrize("shape", [(3, 2), (100, 100), (301, 97)], ids=str)
def test_operators_do_not_depend_on_threads(shape, backend, monkeypatch):
    # Each makes its own.
    monkeypatch.setattr(convolution, "SPECTRA", ArrayCache(0))
    makers = [convolution.free] + [
        lambda *given, axis=axis, **more: convolution.strip(*given, axis, **more) for axis in (0, 1)
    ]
    for make in makers:
        one, *others = (
            make(shape, (1e-6, 1e-6), 1e11, workspace=Workspace(workers)).spectrum
            for workers in (1, 2, 3, 4)
        )
        for other in others:
            np.testing.assert_array_equal(other, one)
