"""Write the reference set, or this program's answers to it.

    python reference/generate.py                         # problems.json and the arrays
    python reference/generate.py --answers answers.json  # minutes; judge them by judge.py
    python reference/generate.py --answers answers.json --problems rough ceiling

Every value is a closed form, or is checked against one of them or against plain NumPy and SciPy
(tests/judge.py) before it is written.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

HERE = Path(__file__).parent
for folder in ("tests", "tests/data/peers"):
    # Before this folder, which has another judge.
    sys.path.insert(0, str(HERE.parent / folder))

import indentation  # noqa: E402
import problems  # noqa: E402

import judge  # noqa: E402 - found in tests
import melan  # noqa: E402
import roughcontact as rc  # noqa: E402
from roughcontact.analyses.leak.flow import flow  # noqa: E402
from roughcontact.material.hardening import Linear  # noqa: E402
from roughcontact.theory import hertz, waves  # noqa: E402

Array = NDArray[np.float64]
Inputs = Mapping[str, Any]

# Certificates of the values that are written, and of those that they are compared with.
TIGHT, LOOSE = 1e-11, 1e-9
CERTIFIED = 1e-8
STEEL = {"young": 210e9, "poisson": 0.3}
DISCRETE = (
    "Pressure is constant on each pixel; displacement and gap are taken at its center. The body "
    "is an elastic half-space of contact modulus E* = E/(1 - ν²) on a rigid flat. "
)
FREE = (
    "Nothing is outside the map: the displacement is the sum over pixels of Love's integral of "
    "1/(π E* r). "
)
PERIODIC = (
    "The map is one period: the discrete Fourier transform of the displacement is 2/(E* |q|) "
    "times that of the pressure, and 0 at q = 0. "
)
APPROACH = "The approach is counted from the first contact of the undeformed bodies. "


@dataclass(frozen=True)
class Answer:
    """A reference value; None where it is an array in the file of its problem."""

    value: float | list[float] | None
    unit: str
    error: float
    accept: float
    how: str


@dataclass(frozen=True)
class Problem:
    """A problem with its answers."""

    title: str
    source: str
    statement: str
    inputs: Inputs
    answers: dict[str, Answer]
    arrays: dict[str, Array] = field(default_factory=dict)


def exact(value: float, unit: str, accept: float = 0.01) -> Answer:
    """Return a closed form; what is accepted leaves room for the grid of a program."""
    return Answer(float(value), unit, 1e-15, accept, "closed form")


UNITS = {
    "contact_area": "m²",
    "saturated_area": "m²",
    "max_pressure": "Pa",
    "approach": "m",
    "mean_gap": "m",
    "pressure": "Pa",
    "tilt": "1",
    "stick_area": "m²",
    "shift": "m",
    "traction": "Pa",
}


def certified(
    solve: Callable[[float], dict[str, Any]], how: str
) -> tuple[dict[str, Answer], dict[str, Array]]:
    """Return answers and arrays of a discrete problem, found at two tolerances that agree."""
    values, repeated = solve(TIGHT), solve(LOOSE)
    answers, arrays = {}, {}
    for name, value in values.items():
        expected = np.asarray(value)
        differs = np.linalg.norm(expected - repeated[name]) / np.linalg.norm(expected)
        assert differs < CERTIFIED, f"{name} differs by {differs:.1e}"
        is_map = expected.ndim > 1
        if is_map:
            arrays[name] = expected
        answers[name] = Answer(None if is_map else value, UNITS[name], CERTIFIED, 1e-6, how)
    return answers, arrays


def contact(inputs: Inputs, arrays: Mapping[str, Array], tolerance: float) -> rc.ContactResult:
    """Return the contact of a discrete problem, which the independent judge confirms."""
    pixel = tuple(inputs["pixel"])
    body = rc.Material(
        inputs["young"],
        inputs["poisson"],
        coating=[rc.Layer(*layer) for layer in inputs.get("coating", ())],
    )
    more: dict[str, Any] = {}
    if "counter_heights" in arrays:
        more["counter_surface"] = rc.Surface(arrays["counter_heights"], pixel)
    if "counter_young" in inputs:
        more["counter_material"] = rc.Material(inputs["counter_young"], inputs["counter_poisson"])
    result = rc.solve(
        rc.Surface(arrays["heights"], pixel),
        material=body,
        load=inputs["load"],
        ceiling=inputs.get("ceiling"),
        boundary=inputs["boundary"],
        moments=inputs.get("moments"),
        tolerance=tolerance,
        **more,
    )
    if not body.coating:
        found = judge.judge(result)
        assert found.certificate < 2 * tolerance, f"certificate {found.certificate:.1e}"
    return result


def chosen(result: rc.ContactResult, *names: str) -> dict[str, Any]:
    """Return some of the numbers of a contact."""
    values = {name: getattr(result, name) for name in names if name != "saturated_area"}
    if "saturated_area" in names:
        values["saturated_area"] = result.saturated_fraction * result.nominal_area
    return {name: list(v) if isinstance(v, tuple) else v for name, v in values.items()}


HOW = (
    "certificate 1e-11, recomputed without the program; a solve to 1e-9 differs by less than the "
    "error"
)


# --- The problems, and how this program solves each ---


def sphere() -> Problem:
    """Pose Hertz's contact."""
    inputs = {**STEEL, "radius": 0.01, "load": 1.0}
    modulus = inputs["young"] / (1 - inputs["poisson"] ** 2)
    bodies = inputs["load"], inputs["radius"], modulus
    return Problem(
        "Sphere on a rigid flat",
        "Hertz 1882; Johnson 1985, section 4.2",
        "An elastic paraboloid of given radius of curvature is pressed on a rigid flat, without "
        "friction. Any grid may be used.",
        inputs,
        {
            "contact_area": exact(math.pi * hertz.contact_radius(*bodies) ** 2, "m²"),
            "max_pressure": exact(hertz.max_pressure(*bodies), "Pa"),
            "approach": exact(hertz.approach(*bodies), "m"),
        },
    )


def solve_sphere(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it on 256² points over three contact radii."""
    modulus = inputs["young"] / (1 - inputs["poisson"] ** 2)
    edge = 3 * hertz.contact_radius(inputs["load"], inputs["radius"], modulus) / 256
    y, x = (np.mgrid[:256, :256] - 127.5) * edge
    heights = -(x**2 + y**2) / (2 * inputs["radius"])
    specified = {**inputs, "pixel": (edge, edge), "boundary": "free"}
    result = contact(specified, {"heights": heights}, LOOSE)
    return chosen(result, "contact_area", "max_pressure", "approach")


def wave() -> Problem:
    """Pose Westergaard's contact."""
    inputs = {**STEEL, "wavelength": 50e-6, "amplitude": 0.2e-6, "pressure": 0.0}
    modulus = inputs["young"] / (1 - inputs["poisson"] ** 2)
    full = waves.wavy_full_contact_pressure(inputs["amplitude"], inputs["wavelength"], modulus)
    mean = inputs["pressure"] = round(full / 2e6) * 1e6
    half = waves.wavy_half_width(mean, full, inputs["wavelength"])
    peak = waves.wavy_pressure(np.zeros(1), mean, full, inputs["wavelength"])[0]
    return Problem(
        "Sinusoidal wave on a rigid flat",
        "Westergaard 1939; Johnson 1985, section 13.2",
        "Heights are amplitude × cos(2π x/wavelength), periodic, in plane strain, under a mean "
        "pressure. Any grid may be used.",
        inputs,
        {
            "contact_fraction": exact(2 * half / inputs["wavelength"], "1"),
            "max_pressure": exact(peak, "Pa"),
            "mean_gap": exact(waves.wavy_mean_gap(mean, full, inputs["amplitude"]), "m"),
        },
    )


def solve_wave(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it on 1024 points."""
    length = inputs["wavelength"]
    x = np.arange(1024) / 1024
    heights = np.tile(inputs["amplitude"] * np.cos(2 * math.pi * x), (4, 1))
    specified = {
        **inputs,
        "pixel": (length / 4, length / 1024),
        "boundary": "periodic",
        "load": inputs["pressure"] * length**2,
    }
    result = contact(specified, {"heights": heights}, LOOSE)
    return chosen(result, "contact_fraction", "max_pressure", "mean_gap")


def discrete(
    title: str, words: str, inputs: Inputs, arrays: dict[str, Array], names: tuple[str, ...]
) -> Problem:
    """Return a contact on the pixels of a map, with some of its numbers."""
    boundary = FREE if inputs["boundary"] == "free" else PERIODIC
    answers, maps = certified(lambda tol: chosen(contact(inputs, arrays, tol), *names), HOW)
    statement = DISCRETE + boundary + words
    return Problem(title, "this set", statement, inputs, answers, arrays | maps)


def posed(name: str) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return inputs and heights of a problem that other programs have solved as well."""
    known = problems.PROBLEMS[name]
    inputs = {
        "young": problems.MODULUS,
        "poisson": 0.0,
        "load": known.load,
        "pixel": list(known.pixel),
        "boundary": known.boundary,
    }
    if known.ceiling:
        inputs["ceiling"] = known.ceiling
    return inputs, {"heights": known.heights}


FIELDS = "pressure", "contact_area", "max_pressure", "approach"


def rough() -> Problem:
    """Pose a rough periodic map."""
    return discrete(
        "Rough map, elastic, periodic",
        APPROACH + "The mean gap is that over all pixels.",
        *posed("rough-128-periodic"),
        (*FIELDS, "mean_gap"),
    )


def ceiling() -> Problem:
    """Pose a rough map with a largest pressure, on oblong pixels."""
    return discrete(
        "Rough map under a pressure ceiling, free, oblong pixels",
        APPROACH + "No pressure exceeds the ceiling; pixels at the ceiling may indent.",
        *posed("rough-96x128-ceiling"),
        ("pressure", "contact_area", "saturated_area", "approach"),
    )


def tilt() -> Problem:
    """Pose a rough map that tilts under a load off its center."""
    inputs, arrays = posed("rough-64")
    inputs["moments"] = [inputs["load"] * 8e-6, -inputs["load"] * 5e-6]
    return discrete(
        "Rough map that tilts, free",
        "The load acts at the point (y, x) = moments/load from the center of the map, and the "
        "body tilts until the pressure balances it: the initial gap is max(h) - h + tilt_y y + "
        "tilt_x x, with y and x from the center.",
        inputs,
        arrays,
        ("pressure", "contact_area", "max_pressure", "tilt"),
    )


def two_bodies() -> Problem:
    """Pose two rough bodies of different materials."""
    inputs, arrays = posed("rough-64-periodic")
    inputs |= {**STEEL, "counter_young": 70e9, "counter_poisson": 0.33}
    counter = rc.self_affine(
        64,
        inputs["pixel"],
        rms_height=0.1e-6,
        rolloff_wavelength=40e-6,
        cutoff_wavelength=8e-6,
        rng=np.random.default_rng(1),
    )
    return discrete(
        "Two rough bodies, elastic, periodic",
        APPROACH + "Both bodies deform: 1/E* = Σ (1 - ν²)/E; heights of both are positive towards "
        "the other, and add pixel by pixel.",
        inputs,
        arrays | {"counter_heights": counter},
        FIELDS,
    )


def solve_discrete(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve a contact on the pixels of a map."""
    result = contact(inputs, arrays, LOOSE)
    return chosen(result, *FIELDS, "mean_gap", "saturated_area", "tilt")


def coating() -> Problem:
    """Pose a rough map on a coated half-space: a dense linear problem of the pixels that touch."""
    inputs, arrays = posed("rough-64-periodic")
    inputs |= {**STEEL, "coating": [[450e9, 0.25, 3e-6]]}
    heights, pixel_area = arrays["heights"], math.prod(inputs["pixel"])
    table = scipy.fft.ifft2(coated_symbol(inputs, heights.shape)).real
    touching = contact(inputs, arrays, TIGHT).contact
    y, x = np.nonzero(touching)
    size = y.size
    matrix = np.ones((size + 1, size + 1))
    matrix[:-1, :-1] = table[y[:, None] - y, x[:, None] - x]
    matrix[-1, -1] = 0
    closed = heights.max() - heights
    *loaded, minus_approach = np.linalg.solve(
        matrix, np.append(-closed[touching], inputs["load"] / pixel_area)
    )
    pressure = np.zeros(heights.shape)
    pressure[touching] = loaded
    displaced = scipy.fft.ifft2(scipy.fft.fft2(pressure) * scipy.fft.fft2(table)).real
    assert pressure.min() >= 0
    assert (displaced + closed + minus_approach)[~touching].min() > 0
    values = {
        "contact_area": size * pixel_area,
        "max_pressure": float(pressure.max()),
        "approach": float(-minus_approach),
    }
    how = "dense linear solve with Burmister's closed form; all pressures and gaps are positive"
    return Problem(
        "Rough map with an elastic coating, periodic",
        "Burmister 1945",
        DISCRETE + PERIODIC + APPROACH + "One layer (E, ν, thickness) is bonded to the half-space: "
        "the factor 2/(E* |q|) is that of the layer's material times Burmister's function of |q| × "
        "thickness.",
        inputs,
        {
            key: Answer(value, UNITS[key], CERTIFIED, 1e-6, how)
            for key, value in ({"pressure": None} | values).items()
        },
        arrays | {"pressure": pressure},
    )


def coated_symbol(inputs: Inputs, shape: tuple[int, ...]) -> Array:
    """Return displacement over pressure of a wave, for one bonded layer (Burmister 1945)."""
    young, poisson, thickness = inputs["coating"][0]
    q = (
        2
        * math.pi
        * np.hypot(
            *np.meshgrid(
                *(
                    scipy.fft.fftfreq(n, edge)
                    for n, edge in zip(shape, inputs["pixel"], strict=True)
                ),
                indexing="ij",
            )
        )
    )
    shear = young / (1 + poisson) * (1 + inputs["poisson"]) / inputs["young"]
    first = 1 - 4 * (1 - poisson) / (1 + shear * (3 - 4 * inputs["poisson"]))
    second = (shear - 1) / (shear + 3 - 4 * poisson)
    h = q * thickness
    fall = np.exp(-2 * h)
    above = 1 + 4 * h * second * fall - first * second * fall**2
    below = 1 - (first + second + 4 * second * h**2) * fall + first * second * fall**2
    symbol = np.zeros(shape)
    np.divide(2 * (1 - poisson**2) / young * above, q * below, out=symbol, where=q > 0)
    return symbol


def stick_slip() -> Problem:
    """Pose partial slip by superposition, which is exact where ν is 0."""
    inputs, arrays = posed("rough-64")
    young = 2 * inputs.pop("young")
    inputs |= {"young": young, "counter_young": young, "counter_poisson": 0.0}
    inputs |= {"friction": 0.2, "force": 0.1 * inputs["load"]}
    released = {**inputs, "load": inputs["load"] - inputs["force"] / inputs["friction"]}

    def superposed(tolerance: float) -> dict[str, Any]:
        whole, part = (contact(given, arrays, tolerance) for given in (inputs, released))
        traction = inputs["friction"] * (whole.pressure - part.pressure)
        # The stick zone is the contact under the smaller load.
        traction[part.pressure == 0] = (inputs["friction"] * whole.pressure)[part.pressure == 0]
        return {
            "traction": traction,
            "shift": inputs["friction"] * (whole.approach - part.approach),
            "stick_area": part.contact_area,
        }

    how = f"Ciavarella and Jäger: two contacts without friction, each with {HOW}"
    answers, maps = certified(superposed, how)
    return Problem(
        "Rough map that sticks and slips, free",
        "Ciavarella 1998; Jäger 1998",
        DISCRETE.replace("on a rigid flat", "on one of the same material")
        + FREE
        + "1/E* = Σ (1 - ν²)/E. With ν = 0 the tangential displacement by a traction is that by a "
        "pressure. Under the constant load a tangential force along x rises from 0; traction is at "
        "most friction × pressure (Coulomb). The shift is the rigid one of one body on the other.",
        inputs,
        answers,
        arrays | maps,
    )


def solve_stick_slip(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it by iterating on the traction itself."""
    found = rc.tangential(
        contact(inputs, arrays, TIGHT),
        friction=inputs["friction"],
        force=inputs["force"],
        tolerance=LOOSE,
    )
    pixel_area = math.prod(inputs["pixel"])
    return {
        "traction": found.traction[1],
        "shift": found.last.shift,
        "stick_area": np.count_nonzero(found.stick) * pixel_area,
    }


def conductance() -> Problem:
    """Pose the constriction resistance of a contact, a dense linear problem."""
    inputs, arrays = posed("rough-64")
    touching = contact(inputs, arrays, TIGHT).contact
    resistivity = 2e-8
    given = {key: inputs[key] for key in ("pixel", "boundary")} | {"resistivity": resistivity}
    y, x = (index * edge for index, edge in zip(np.nonzero(touching), inputs["pixel"], strict=True))
    # ∫ 1/(π r) over each pixel, E* u = matrix @ p: the stiffness of a punch of this outline.
    matrix = judge.love_coefficients(y[:, None] - y, x[:, None] - x, tuple(inputs["pixel"]), 1.0)
    flux = np.linalg.solve(matrix.astype(float), np.ones(y.size))
    length = 2 * math.prod(inputs["pixel"]) * flux.sum()
    how = "dense linear solve in double precision"
    return Problem(
        "Constriction resistance of a rough contact",
        "Holm 1967; Barber 2003",
        "Current passes between two half-spaces of equal resistivity through the pixels that "
        "touch (contact = 1), with constant current density on each and the same potential at "
        "their centers. The resistance is 2 × resistivity/constriction length; a disc of radius a "
        "has a length of 4 a.",
        given,
        {
            "constriction_length": Answer(float(length), "m", CERTIFIED, 1e-6, how),
            "resistance": Answer(float(2 * resistivity / length), "Ω", CERTIFIED, 1e-6, how),
        },
        {"contact": touching.astype(float)},
    )


def solve_conductance(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it as the contact of a punch of this outline."""
    pixel = tuple(inputs["pixel"])
    # Deep enough that no other pixel touches.
    punch = rc.Surface((arrays["contact"] - 1) * 1e-3, pixel)
    result = rc.solve(punch, material=rc.Material(1e9, 0.0), load=1e-9, tolerance=1e-6)
    conductor = rc.Conductor(resistivity=inputs["resistivity"])
    found = rc.conductance(result, conductor, conductor)
    return {
        "constriction_length": float(found.column("length")[0]),
        "resistance": float(found.electrical_resistance[0]),
    }


def gap_map(points: int) -> Array:
    """Return a smooth periodic gap [m] on a grid of 0.1 mm."""
    y, x = np.mgrid[:points, :points] * (2 * math.pi / points)
    height = (
        0.5 * np.cos(x + 2 * y)
        + 0.4 * np.sin(2 * x - y)
        + 0.35 * np.cos(3 * y + 0.5)
        + 0.3 * np.cos(3 * x + 3 * y + 1)
        + 0.25 * np.sin(4 * x - 2 * y + 2)
    )
    return 1e-6 * (1 + 0.5 * height)


def rate(gap: Array, inputs: Inputs, axis: int) -> float:
    """Return the flow [m³/s] along an axis of a square face."""
    pixel = (inputs["side"] / len(gap),) * 2
    found = flow(gap, pixel, axis, (0, 1)).permeability[axis]
    return float(found * inputs["pressure_difference"] / (12 * inputs["viscosity"]))


def leak() -> Problem:
    """Pose flow through a gap, by extrapolation from grids."""
    inputs = {"side": 0.1e-3, "viscosity": 1e-3, "pressure_difference": 1e5}
    assert gap_map(512).min() > 0
    answers = {}
    for axis, name in enumerate("yx"):
        grids = [rate(gap_map(points), inputs, axis) for points in (128, 256, 512, 1024)]
        # The error falls with the square of the pixel; the step before shows how well it does.
        _, first, last = (new + (new - old) / 3 for old, new in pairwise(grids))
        error = abs(last - first) / last
        how = "finite volumes on 128² to 1024² points, Richardson; the error is its last step"
        answers[f"rate_{name}"] = Answer(last, "m³/s", error, 0.01, how)
    return Problem(
        "Flow through a rough gap",
        "Reynolds 1886; Patir and Cheng 1978",
        "∇·(g³ ∇p) = 0, periodic along both axes. The gap on a square face is 1 µm × (1 + 0.5 s), "
        "s = 0.5 cos(X + 2Y) + 0.4 sin(2X - Y) + 0.35 cos(3Y + 0.5) + 0.3 cos(3X + 3Y + 1) + 0.25 "
        "sin(4X - 2Y + 2), X = 2πx/side, Y = 2πy/side. The rate is the mean flow g³/(12 η) across "
        "the side where the pressure falls by the difference along it. Any grid may be used.",
        inputs,
        answers,
    )


def solve_leak(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it on 256² points."""
    return {f"rate_{name}": rate(gap_map(256), inputs, axis) for axis, name in enumerate("yx")}


def indented(inputs: Inputs, points: int, nodes: int) -> dict[str, float]:
    """Return the numbers of an elastoplastic indentation on a grid."""
    edge = inputs["side"] / points
    x = (np.arange(points) - points // 2) * edge
    thickness = np.full(nodes, inputs["depth"] / (nodes - 1))
    thickness[[0, -1]] /= 2
    law = Linear(inputs["yield_strength"], inputs["hardening"])
    result = rc.solve_elastoplastic(
        rc.Surface(-(x[:, None] ** 2 + x**2) / (2 * inputs["radius"]), (edge, edge)),
        material=rc.Material(inputs["young"], inputs["poisson"], hardening=law),
        loads=[inputs["load"] * part / 5 for part in range(1, 6)],
        increments=1,
        boundary="periodic",
        layers=thickness,
        tolerance=1e-5,
        precision="double",
    )
    return {
        "max_pressure": result.contact.max_pressure,
        "max_plastic_strain": result.max_plastic_strain,
        "approach": result.contact.approach,
    }


def plasticity() -> Problem:
    """Pose an indentation that hardens, with the change between two grids as its error."""
    young, side = 200e9, 1e-4
    inputs = {
        "young": young,
        "poisson": indentation.POISSON,
        "side": side,
        "depth": 0.4 * side,
        "radius": indentation.RADIUS * side,
        "load": indentation.LOADS[-1] * young * side**2,
        "yield_strength": indentation.YIELD * young,
        "hardening": indentation.HARDENING * young,
    }
    coarse, fine = indented(inputs, 32, 16), indented(inputs, 64, 32)
    theirs = indentation.load("tamaas")[1]["sphere-64"]
    peer = {
        "max_pressure": theirs.pressure[-1].max() * young,
        "max_plastic_strain": theirs.strain[-1].max(),
    }
    answers = {}
    units = {"max_pressure": "Pa", "max_plastic_strain": "1", "approach": "m"}
    for name, value in fine.items():
        others = [coarse[name], *([float(peer[name])] if name in peer else [])]
        error = max(abs(other / value - 1) for other in others)
        how = (
            "64² points, 32 layers; the error is the largest difference from 32² points, 16 layers"
        )
        how += " and from Tamaas 2.9.0 on the same grid" if name in peer else ""
        answers[name] = Answer(value, units[name], error, 0.05, how)
    return Problem(
        "Sphere that indents an elastoplastic half-space",
        "Jacq et al. 2002; Frérot et al. 2019",
        "A rigid paraboloid is pressed on a half-space, periodic over the side, with small strains "
        "and von Mises plasticity of linear isotropic hardening: the yield strength rises by "
        "hardening × accumulated plastic strain. The load rises from 0. Plastic strain is above "
        "the depth. The mean pressure leaves no mean strain in the plane. The largest plastic "
        "strain is that on the grid.",
        inputs,
        answers,
    )


def solve_plasticity(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve it on the coarser grid."""
    return dict(indented(inputs, 32, 16))


def rolling() -> Problem:
    """Pose the limits of a rolling line contact by Melan's theorem."""
    inputs = {**STEEL, "yield_strength": 1e9}
    shear = inputs["yield_strength"] / math.sqrt(3)
    fine = "closed-form stresses of a half-plane; the largest von Mises stress on a grid of a 500th"
    return Problem(
        "Rolling line contact without friction",
        "Melan 1938; Johnson 1985, sections 9.2 and 9.3",
        "A rigid cylinder rolls repeatedly over an elastic, perfectly plastic half-space (von "
        "Mises), in plane strain. Answers are the Hertz pressures of first yield and of the limit "
        "of elastic shakedown.",
        inputs,
        {
            "first_yield": Answer(
                melan.first_yield(0.0, inputs["poisson"]) * shear, "Pa", 1e-5, 0.02, fine
            ),
            "shakedown": exact(4 * shear, "Pa", 0.06),
        },
    )


def solve_rolling(inputs: Inputs, arrays: Mapping[str, Array]) -> dict[str, Any]:
    """Solve both by search, on a row of rollers far apart."""
    modulus = inputs["young"] / (1 - inputs["poisson"] ** 2)
    radius, pixel, shape = 0.5e-3, (1e-6, 1e-6), (8, 128)
    body = rc.Material(inputs["young"], inputs["poisson"], inputs["yield_strength"])
    roller = rc.cylinder(radius, angle=90.0)
    shear = inputs["yield_strength"] / math.sqrt(3)
    width = shape[0] * pixel[0]

    def load(pressure: float) -> float:
        return math.pi * radius * pressure**2 / modulus * width

    def peak(force: float) -> float:
        return math.sqrt(force * modulus / (math.pi * radius * width))

    # The mean pressure of a row of rollers adds a stress of its own.
    wide = rc.Surface(np.zeros((8, 2048)), pixel)
    common: dict[str, Any] = {"counter_surface": roller, "material": body, "boundary": "periodic"}
    yields = rc.first_yield_load(wide, **common, initial_load=load(3 * shear))
    low, high = rc.shakedown_load(
        rc.Surface(np.zeros(shape), pixel),
        low=load(3 * shear),
        high=load(4.6 * shear),
        rel_tol=0.04,
        passes=4,
        steps=32,
        tolerance=1e-3,
        **common,
    )
    return {"first_yield": peak(yields.solution.load), "shakedown": peak((low + high) / 2)}


Solve = Callable[[Inputs, Mapping[str, Array]], dict[str, Any]]

POSED: dict[str, tuple[Callable[[], Problem], Solve]] = {
    "sphere": (sphere, solve_sphere),
    "wave": (wave, solve_wave),
    "rough": (rough, solve_discrete),
    "ceiling": (ceiling, solve_discrete),
    "tilt": (tilt, solve_discrete),
    "two_bodies": (two_bodies, solve_discrete),
    "coating": (coating, solve_discrete),
    "stick_slip": (stick_slip, solve_stick_slip),
    "conductance": (conductance, solve_conductance),
    "leak": (leak, solve_leak),
    "plasticity": (plasticity, solve_plasticity),
    "rolling": (rolling, solve_rolling),
}


def write(target: Path) -> None:
    """Write all problems."""
    described = {}
    for name, (pose, _) in POSED.items():
        problem = pose()
        described[name] = {
            "title": problem.title,
            "source": problem.source,
            "statement": problem.statement,
            "inputs": problem.inputs,
            "arrays": sorted(problem.arrays),
            "answers": {key: asdict(answer) for key, answer in problem.answers.items()},
        }
        if problem.arrays:
            np.savez_compressed(target / f"{name}.npz", **problem.arrays)
        print(name, {k: a.value for k, a in problem.answers.items()}, flush=True)
    text = json.dumps(described, indent=1, ensure_ascii=False)
    (target / "problems.json").write_text(text + "\n", encoding="utf-8")


def answers(names: list[str], source: Path = HERE) -> dict[str, dict[str, Any]]:
    """Return this program's answers to some problems, from their files alone."""
    described = json.loads((source / "problems.json").read_text(encoding="utf-8"))
    found = {}
    for name in names:
        problem, arrays = described[name], {}
        if problem["arrays"]:
            with np.load(source / f"{name}.npz", allow_pickle=False) as stored:
                arrays = {key: stored[key] for key in stored.files}
        values = POSED[name][1](problem["inputs"], arrays)
        found[name] = {
            key: np.asarray(value).tolist()
            for key, value in values.items()
            if key in problem["answers"]
        }
        print(name, flush=True)
    return found


def main() -> None:
    """Write problems, or answers to them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--answers", type=Path, help="write this program's answers there")
    parser.add_argument("--problems", nargs="+", choices=POSED, default=list(POSED))
    options = parser.parse_args()
    if options.answers:
        options.answers.write_text(json.dumps(answers(options.problems)), encoding="utf-8")
    else:
        write(HERE)


if __name__ == "__main__":
    main()
