"""Plausible wrong values for every argument of the public face: only the package's own errors."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import roughcontact as rc

SLIPS = {
    "none": None,
    "digits": "0.1",
    "word": "abc",
    "huge": 10**400,
    "endless": 10**5000,
    "nan": np.nan,
    "inf": np.inf,
    "negative": -1,
    "zero": 0,
    "complex": 1j,
    "empty": [],
    "list": [1, 2],
    "huge list": [10**400, 1],
    "mixed": ["0.1", None],
    "array": np.array([1.0, 2.0]),
    "map": np.ones((2, 2)),
    "bytes": b"1",
    "dict": {},
    "object": object(),
}
# Arguments that are no numbers, materials or boundaries.
ELSEWHERE = ("progress", "folder", "on_step", "on_interrupt", "caveat", "options")

Call = tuple[Callable[..., Any], dict[str, Any]]


def call(function: Callable[..., Any], **usual: Any) -> Call:
    """Return a function with arguments that it takes."""
    return function, usual


@cache
def calls() -> dict[str, Call]:
    """Return each function with arguments that it takes."""
    heights, pixel = np.random.default_rng(1).random((16, 16)) * 1e-7, (1e-6, 1e-6)
    surface = rc.Surface(heights, pixel)
    steel = rc.Material(210e9, 0.3, 1e9)
    conductor = rc.Conductor(1e-7, 46.0)
    both: dict[str, Any] = {"surface": surface, "material": steel}
    rough = rc.Surface(*rc.reference_map(64))
    large = both | {"surface": rough}
    contacts = [rc.solve(**both, load=load, calibrated=False) for load in (0.01, 0.1)]
    periodic = [rc.solve(**both, load=load, boundary="periodic") for load in (0.01, 0.1)]
    y, x = np.mgrid[-8:8, -8:8] * 1e-6
    ball = rc.Surface(-(x**2 + y**2) / (2 * 1e-4), pixel=(1e-6, 1e-6))
    plastic: dict[str, Any] = {"surface": ball, "material": steel, "layers": [1e-6, 1e-6]}
    rolled = {**plastic, "counter_surface": rc.Surface(np.zeros((16, 16)), (1e-6, 1e-6))}
    return {
        "Surface": call(rc.Surface, heights=heights, pixel=pixel),
        "Surface.leveled": call(
            surface.leveled, form="three-point", points=[(0, 0), (5, 1), (2, 7)]
        ),
        "Surface.without_form": call(surface.without_form, shape="polynomial", degree=2),
        "Surface.without_outliers": call(surface.without_outliers),
        "Surface.filled": call(surface.filled),
        "Surface.cropped": call(surface.cropped, rows=(0, 8), columns=(0, 8)),
        "Surface.inverted": call(surface.inverted),
        "Surface.flipped": call(surface.flipped),
        "Surface.rotated": call(surface.rotated),
        "Surface.resampled": call(surface.resampled, shape=(8, 8)),
        "Surface.filtered": call(surface.filtered, s=4e-6),
        "Surface.with_form": call(surface.with_form, form=surface),
        "Surface.aligned": call(surface.aligned, grid=surface),
        "Surface.resolution_notes": call(surface.resolution_notes, tip_radius=1e-6),
        "Material": call(rc.Material, young=210e9, poisson=0.3),
        "Conductor": call(rc.Conductor, resistivity=1e-7),
        "Perfect": call(rc.hardening.Perfect, initial=1e9),
        "Linear": call(rc.hardening.Linear, initial=1e9, modulus=1e9),
        "Swift": call(rc.hardening.Swift, coefficient=1e9, offset=0.1, exponent=0.2),
        "Tabulated": call(rc.hardening.Tabulated, strain=[0.0, 0.1], stress=[1e9, 2e9]),
        "Kinematic": call(rc.hardening.Kinematic, isotropic=rc.hardening.Perfect(1e9), modulus=1e9),
        "contact_modulus": call(rc.contact_modulus, material=steel, counter_material=steel),
        "hardness.ceiling": call(rc.hardness.ceiling, hardness="62 HRC"),
        "hardness.pressure": call(rc.hardness.pressure, vickers=700),
        "hardness.vickers": call(rc.hardness.vickers, value=62, scale="HRC"),
        "hardness.brinell_pressure": call(rc.hardness.brinell_pressure, brinell=200),
        "catalogue.material": call(rc.catalog.material, name="100Cr6"),
        "NominalPressure": call(rc.NominalPressure, value=1e6),
        "HertzPressure": call(rc.HertzPressure, value=1e6),
        "LineLoad": call(rc.LineLoad, value=1e6),
        "Stage": call(rc.Stage, load=1.0),
        "PathPoint": call(rc.PathPoint, load=1.0),
        "reference_map": call(rc.reference_map, n=32),
        "self_affine": call(
            rc.self_affine,
            shape=(16, 16),
            pixel=(1e-6, 1e-6),
            rms_height=1e-7,
            rolloff_wavelength=8e-6,
            cutoff_wavelength=4e-6,
            rng=np.random.default_rng(1),
        ),
        "generate": call(
            rc.generate,
            shape=(16, 16),
            pixel=(1e-6, 1e-6),
            Sq=1e-7,
            rolloff_wavelength=8e-6,
            cutoff_wavelength=4e-6,
        ),
        "partition": call(rc.partition, surface=rough),
        "solve": call(rc.solve, **both, load=0.1, calibrated=False),
        "load_curve": call(rc.sweep, **both, loads=[0.1]),
        "load_history": call(rc.history, **both, path=[0.1]),
        "find_load": call(rc.find_load, **both, contact_fraction=0.01),
        "estimate": call(rc.estimate, **large, pressure=1e8),
        "compare": call(rc.compare, maps=[surface, surface], material=steel, pressure=1e6, steps=2),
        "sampling_error": call(rc.sampling_study, **large, pressure=1e6),
        "resolution_study": call(rc.resolution_study, **large, load=0.1),
        "subsurface_stress": call(rc.subsurface_stress, result=contacts[1], depths=[1e-6]),
        "yield_onset": call(rc.first_yield_load, surface=ball, material=steel),
        "indented_surface": call(rc.indented_surface, result=contacts[1]),
        "leakage": call(
            rc.leakage,
            contacts=contacts,
            viscosity=1e-3,
            pressure_difference=1e5,
            seal_width=1e-3,
            seal_length=1e-2,
        ),
        "conductance": call(
            rc.conductance, contacts=contacts, conductor=conductor, counter_conductor=conductor
        ),
        "interface_law": call(rc.interface_law, contacts=periodic),
        "solve_elastoplastic": call(rc.solve_elastoplastic, **plastic, load=0.01),
        "compare_models": call(
            rc.compare_models, surface=ball, material=steel, loads=[0.01], increments=1
        ),
        "roll": call(rc.roll, **rolled, load=0.01, passes=1, steps=2, travel=4e-6),
        "shakedown_load": call(
            rc.shakedown_load,
            **rolled,
            low=0.002,
            high=0.02,
            passes=2,
            steps=4,
            travel=1e-6,
            rel_tol=0.9,
        ),
    }


NAMES = tuple(calls())


@pytest.mark.parametrize("name", NAMES)
def test_mistaken_argument_works_or_raises_package_error(name: str) -> None:
    function, usual = calls()[name]
    # Of shakedown the loads would have to be on both sides.
    if name != "shakedown_load":
        function(**usual)
    for argument, parameter in inspect.signature(function).parameters.items():
        for slip, value in SLIPS.items():
            if argument in ELSEWHERE or value is parameter.default:
                continue
            result = ""
            try:
                function(**{**usual, argument: value})
            except rc.RoughcontactError as error:
                result = str(error)
            assert len(result) < 400, (argument, slip)


def test_plain_arguments_are_accepted() -> None:
    surface, steel = rc.Surface(*rc.reference_map(32)), rc.catalog.material("100Cr6")
    one = {"Sq": 1e-7, "rolloff_wavelength": 1.6e-5, "cutoff_wavelength": 4e-6}
    square, pair = rc.generate(32, 1e-6, **one), rc.generate((32, 32), (1e-6, 1e-6), **one)
    assert square.heights.tobytes() == pair.heights.tobytes()
    curve = rc.sweep(surface, material="100Cr6", loads=0.1)
    assert curve.steps[0].load == 0.1
    assert rc.history(surface, 0.1, material=steel).steps[0].load == 0.1
    result = rc.solve(surface, material=steel, counter_material="100Cr6", load=0.1)
    assert result.pair.counter_material == steel
    assert rc.subsurface_stress(result, 1e-6, friction=np.array(0.1)).friction == 0.1


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (
            lambda: rc.compare(rc.Surface(*rc.reference_map(32)), material="100Cr6", pressure=1e6),
            "maps is a single map",
        ),
        (
            lambda: rc.interface_law([1, 2]),
            "contacts must be a list, each a ContactResult, got 1 as number 1",
        ),
        (lambda: rc.Material(10**400, 0.3), "got a whole number of 401 digits"),
        (lambda: rc.PathPoint(1.0, friction="0.1"), "friction must be a number, got '0.1'"),
        (lambda: rc.generate((32, 32), None, Sq=1e-6), "pixel must be a list of quantities or"),
        (
            lambda: rc.Surface(np.eye(4), (1e-6, 1e-6)).leveled(np.ones(3)),
            "form must be a text such as 'plane'",
        ),
    ],
)
def test_mistaken_argument_is_quoted_in_error(call: Callable[[], Any], expected: str) -> None:
    with pytest.raises(rc.InputError) as caught:
        call()
    assert expected in str(caught.value)
