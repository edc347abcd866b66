"""The numbers of docs/assumptions.md, each from its formula or from the solver."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize

import ceiling_error
import ceiling_rule
import roughcontact as rc
from paths import ROOT
from roughcontact.contact import plausibility
from roughcontact.contact.ceiling import ceiling_factor
from roughcontact.contact.result import CalibratedCeiling
from roughcontact.surface import shapes
from roughcontact.theory import hertz, indenters

NU = 0.3
STEEL = rc.Material(young=210e9, poisson=NU, yield_strength=1e9)
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
PAGE = ROOT / "docs" / "assumptions.md"
# The page is wrapped anywhere.
TEXT = " ".join(PAGE.read_text(encoding="utf-8").replace("\\*", "*").split())


def test_first_yield_and_the_load_up_to_the_ceiling() -> None:
    factor = 1.295 * math.exp(0.736 * NU)
    assert f"{factor:.3f} σ_Y at ν = 0.3" in TEXT
    assert STEEL.first_yield_pressure == pytest.approx(factor * 1e9)
    assert f"up to {(3 / factor) ** 3:.1f} times the load of its first yield" in TEXT


def mean_pressure(load_ratio: float) -> float:
    """Return load over area of the ceiling model in yield strengths, the load in first yields."""
    peak = 1.295 * math.exp(0.736 * NU) * load_ratio ** (1 / 3) * 1e9
    points, side = 128, 1e-4
    a_hertz = side / 6
    radius = 2 * MODULUS * a_hertz / (math.pi * peak)
    load = 4 * MODULUS * a_hertz**3 / (3 * radius)
    assert hertz.max_pressure(load, radius, MODULUS) == pytest.approx(peak)
    pixel = (side / points, side / points)
    ball = rc.Surface(shapes.paraboloid((points, points), pixel, radius), pixel)
    return load / rc.solve(ball, material=STEEL, load=load).perimeter_corrected_area / 1e9


# Mean pressures of a perfectly plastic sphere from the volume solution that the page names.
@pytest.mark.parametrize(("load", "true"), [(40, 2.17), (120, 2.41), (300, 2.61), (700, 2.77)])
def test_the_ceiling_is_high_in_the_transition(load: float, true: float) -> None:
    assert f"{true:.2f}" in TEXT
    quoted = {40: 35, 120: 24, 300: 15, 700: 8}[load]
    assert f"{quoted} %" in TEXT
    # The area of a contact of 20 pixels in radius is known to one or two per cent.
    assert 100 * (mean_pressure(load) / true - 1) == pytest.approx(quoted, abs=2)


def test_three_and_twelve_times_the_load_of_first_yield() -> None:
    # The finite elements of Kogut and Etsion 2002, and the volume solution.
    for load, others, quoted in ((3, (1.48, 1.44), "5 to 8 %"), (12, (1.96, 1.89), "25 to 29 %")):
        low, high = (float(word) for word in quoted[:-2].split(" to "))
        excess = sorted(100 * (mean_pressure(load) / other - 1) for other in others)
        assert excess == pytest.approx([low, high], abs=2)
        assert quoted in TEXT
    assert "15 % at six" in TEXT
    assert 100 * (mean_pressure(6) / 1.71 - 1) == pytest.approx(15, abs=2)


def test_the_most_that_three_yield_strengths_are_wrong_by() -> None:
    found = ceiling_error.read_stored()
    three = found["factors"].index(3.0)
    errors = [row["errors"] for row in found["spheres"] if row["law"] == "perfect"]
    high = max(100 * row["mean_pressure"][three] for row in errors)
    low = min(100 * row["contact_area"][three] for row in errors)
    words = f"mean pressure up to {high:.0f} % high in the transition, area up to {-low:.0f} % too"
    assert words in TEXT


def test_the_rim_moves_inwards_under_hertz_pressure() -> None:
    # Boussinesq: u_r = -(1 - 2ν)(1 + ν)/(2πE) P/s² (towards a point load) summed over the disc;
    # by symmetry only what is within r acts, as if it was in the center (Gauss's law in 2-D).
    within = scipy.integrate.quad(lambda r: 2 * math.pi * r * math.sqrt(1 - r * r), 0, 1)[0]
    displacement = (1 - 2 * NU) * (1 + NU) / (2 * math.pi) * within
    # In units of a p0/E; p0 = 2 E* a/(πR), E* = E/(1 - ν²).
    relative = displacement * 2 / (math.pi * (1 - NU**2))
    assert relative == pytest.approx(2 / (3 * math.pi) * (1 - 2 * NU) / (1 - NU))
    assert f"{100 * relative * 0.1:.1f} % of the radius at a slope of 0.1" in TEXT


def test_slopes() -> None:
    def cone(slope: float) -> float:
        # Hay, Bolshakov and Pharr 1999, eq. (12); 1.067 is their value for a Berkovich tip.
        c = (1 - 2 * NU) / (4 * (1 - NU)) * slope
        above = math.pi / 4 + 0.15483073 * c
        return math.pi * above / (math.pi / 2 - 0.83119312 * c) ** 2 - 1

    def sphere(slope: float) -> float:
        # Sneddon 1965: load of the sphere over that of its paraboloid at the same contact radius.
        exact = 0.5 * (1 + slope**2) * math.log((1 + slope) / (1 - slope)) - slope
        return exact / (4 / 3 * slope**3) - 1

    assert cone(1 / math.tan(math.radians(70.3))) == pytest.approx(0.067, abs=5e-4)
    assert sphere(0.01) == pytest.approx(0.4e-4, rel=1e-2)
    small, middle, large = (100 * cone(slope) for slope in (0.1, 0.3, 0.5))
    assert f"{small:.1f} % more load at a slope of 0.1, {middle:.1f} % at 0.3" in TEXT
    assert f"{large:.1f} % at 0.5 (Hay" in TEXT
    small, middle, large = (100 * sphere(slope) for slope in (0.1, 0.3, 0.5))
    assert f"{small:.1f} % more at a slope of 0.1, {middle:.1f} % at 0.3, {large:.0f} % at" in TEXT
    small, middle, large = (100 * (math.hypot(1, slope) - 1) for slope in (0.1, 0.3, 0.5))
    assert f"{small:.1f} % at 0.1, {middle:.1f} % at 0.3, {large:.0f} % at 0.5" in TEXT
    assert f"at a slope of {3e9 / MODULUS:.3f} if σ_Y = 1 GPa" in TEXT


def test_a_layer_on_a_rigid_base() -> None:
    # Compliance of a bonded layer over that of the half-space, at the wave number s/t.
    kappa = 3 - 4 * NU

    def rest(s: float) -> float:
        over = 2 * kappa * math.cosh(2 * s) + 1 + kappa**2 + 4 * s * s
        return 1 - (2 * kappa * math.sinh(2 * s) - 4 * s) / over

    # A patch of load that is small against t misses ∫ (1 - M) ds · W/(πE*t) of displacement.
    missing = scipy.integrate.quad(rest, 0, 50)[0]
    # The fit of Dimitriadis et al. 2002 to the same response, made for all ν.
    assert missing == pytest.approx((1.2876 - 1.4678 * NU + 1.3442 * NU**2) / (1 - NU), rel=0.01)
    # δ = a²/R - missing W/(πE*t), W ~ (δR)^(3/2): the load grows by 2 missing/π per a/t.
    growth = 2 * missing / math.pi
    assert f"{growth:.2f} a/t more load" in TEXT
    assert f"{100 * growth * 0.01:.1f} % at a/t = 0.01, {100 * growth * 0.1:.0f} % at 0.1" in TEXT
    assert f"{100 * growth * 0.3:.0f} % at 0.3" in TEXT


def test_an_edge_nearby() -> None:
    # Image load 1.4 W at 2d: 1.4 W/(2πE*d) over δ = a²/R with W = 4E*a³/(3R).
    factor = 1.4 * 4 / (3 * 2 * math.pi)
    assert factor == pytest.approx(0.3, abs=0.005)
    assert factor / 3 == pytest.approx(0.10, abs=0.005)
    assert factor / 10 == pytest.approx(0.03, abs=0.002)
    assert "0.3 a/d" in TEXT
    assert "10 % at d = 3a, 3 % at d = 10a" in TEXT


def test_friction() -> None:
    stick = (1 - NU) * math.log(3 - 4 * NU) / (1 - 2 * NU) - 1
    assert f"{100 * stick:.1f} % at ν = 0.3 (Spence" in TEXT
    growth = [100 * (math.sqrt(1 + 9 * mu**2) - 1) for mu in (0.1, 0.2, 0.3)]
    assert "{:.0f} % at μ = 0.1, {:.0f} % at 0.2, {:.0f} % at 0.3".format(*growth) in TEXT


def test_adhesion() -> None:
    # Johnson, Kendall and Roberts 1971, a³ over that of Hertz, the load in πwR.
    def excess(load: float) -> float:
        return float(((load + 3 + math.sqrt(6 * load + 9)) / load) ** (2 / 3) - 1)

    loads = [scipy.optimize.brentq(lambda w, t=t: excess(w) - t, 1, 1e7) for t in (0.1, 0.05, 0.01)]
    assert f"10 % at a load of {loads[0]:.0f} πwR" in TEXT
    assert loads[1:] == pytest.approx([1120, 27_000], rel=0.01)
    assert "by 5 % at 1120, by 1 % at 27 000" in TEXT
    newton = loads[0] * math.pi * 0.05 * 1e-3
    assert f"10 % more at {newton:.3f} N" in TEXT
    assert 0.05 / MODULUS == pytest.approx(2e-13, rel=0.1)


def test_page_states_effect_of_waves_below_pixel() -> None:
    assert f"{100 * (2**0.2 - 1):.0f} % for H = 0.8" in TEXT
    assert f"{100 * (1 - 2**-0.2):.0f} % less area" in TEXT
    # White noise of 1 nm at a pixel of 0.4 µm.
    noise = np.random.default_rng(0).normal(scale=1e-9, size=(256, 256))
    assert rc.Surface(noise, (4e-7, 4e-7)).Sdq == pytest.approx(0.005, rel=0.02)
    assert "Sdq of 0.005" in TEXT


@pytest.mark.long
def test_friction_brings_first_yield_to_the_surface() -> None:
    from roughcontact.analyses.stress.model import subsurface_stress

    points, side, radius = 128, 1e-4, 1e-3
    pixel = (side / points, side / points)
    a_hertz = side / 6
    load = 4 * MODULUS * a_hertz**3 / (3 * radius)
    ball = rc.Surface(shapes.paraboloid((points, points), pixel, radius), pixel)
    result = rc.solve(ball, material=STEEL, load=load, ceiling=None)
    depths = a_hertz * np.linspace(0.002, 1, 21)
    peak = hertz.max_pressure(load, radius, MODULUS)
    below = subsurface_stress(result, depths, friction=0.30)
    above = subsurface_stress(result, depths, friction=0.37)
    assert below.max_von_mises_at[0] > 0.3 * a_hertz
    assert above.max_von_mises_at[0] == depths[0]
    assert peak / above.max_von_mises < 1.5 < peak / below.max_von_mises


def test_the_tables_of_ceilings_are_those_of_the_stored_comparison() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for script, stored in (
        (ceiling_error, ceiling_error.read_stored()),
        (ceiling_rule, ceiling_rule.read_stored()["rows"]),
    ):
        for name, table in script.tables(stored).items():
            start, end = script.MARKS[name]
            assert page[page.index(start) + len(start) : page.index(end)].strip() == table


def test_the_regimes_have_the_ceilings_of_the_rule() -> None:
    number = r"([\d.]+)"
    formula = re.search(rf"exp\(−{number} n l \+ {number} l² − {number} l³\)", TEXT)
    result = np.array([float(formula[1]), -float(formula[2]), float(formula[3])])
    assert result == pytest.approx(ceiling_rule.read_stored()["fit"], rel=0.005)
    assert ceiling_rule.fit_constants(ceiling_rule.read_stored()["rows"]) == pytest.approx(
        result, rel=0.005
    )
    way, steepness = math.log(10), 2 * 1.615 / 3 / (3 - 2 * 1.615 / 3)
    fall = result @ [steepness * way, way**2, way**3]
    assert indenters.mean_pressure(10 * math.pi * 1.615 / 2) == pytest.approx(
        3 - (3 - 2 * 1.615 / 3) * math.exp(-fall), rel=1e-9
    )
    # E*a/(σ_Y R) of a sphere whose mean pressure is the ceiling.
    first = 1.295 * math.exp(0.736 * NU)
    for words in re.findall(
        r"\| (\d+) to (\d+) \| (\d+) to (\d+) \| ([\d.]+) to ([\d.]+) σ_Y", TEXT
    ):
        loads, indices, factors = (tuple(map(float, words[i : i + 2])) for i in (0, 2, 4))
        expected = [ceiling_factor(load) for load in loads]
        assert factors == pytest.approx(expected, abs=0.06)
        assert indices == pytest.approx(
            [
                math.sqrt(load * math.pi**2 * first**3 / (6 * factor))
                for load, factor in zip(loads, expected, strict=True)
            ],
            rel=0.1,
        )
    # Three yield strengths are right to 5 % from here on.
    assert ceiling_factor(1300) == pytest.approx(3 / 1.05, rel=0.002)
    assert math.sqrt(1300 * math.pi**2 * first**3 / (6 * 3 / 1.05)) == pytest.approx(56, abs=0.5)


def test_errors_of_calibrated_ceiling_are_within_limits() -> None:
    found = ceiling_error.read_stored()
    perfect, beyond, hard = (
        [
            row["calibrated"]
            for row in found["spheres"]
            if (row["law"] == "perfect") is same and low < row["load_ratio"] <= high
        ]
        for same, low, high in ((True, 0, 700), (True, 700, 3000), (False, 0, 700))
    )
    assert max(abs(row["contact_area"]) for row in perfect) < 0.035
    assert max(abs(row["contact_area"]) for row in beyond) < 0.035
    assert 0.1 < max(abs(row["approach"]) for row in beyond) < 0.145
    assert max(abs(row["contact_area"]) for row in hard) < 0.075
    assert max(abs(row["approach"]) for row in perfect + hard) < 0.075
    rough = [row for row in found["maps"] if row["nominal"] > 0.05]
    errors = np.array([row["calibrated"]["contact_area"] for row in rough])
    assert np.abs(errors).max() < 0.085
    assert np.mean(np.abs(errors) < 0.055) > 0.9
    usual = {
        law: [r["errors"]["contact_area"][0] for r in rough if r["law"] == law]
        for law in ("perfect", "Swift")
    }
    assert min(usual["perfect"]) == pytest.approx(-0.25, abs=0.03)
    assert max(usual["Swift"]) == pytest.approx(0.55, abs=0.1)


def test_rule_errors_on_stored_cases_are_within_limits() -> None:
    rows = ceiling_rule.read_stored()["rows"]
    kinds = ("sphere", "line", "map", *ceiling_rule.CONFINED_NAMES)
    found = {kind: [row for row in rows if row["kind"] == kind] for kind in kinds}
    others = ("finer", *found)
    found["pair"] = [row for row in rows if row["kind"] not in others]
    assert {row["poisson"] for row in found["sphere"]} == {0.0, 0.15, 0.3, 0.45, 0.49}
    most = {"sphere": 0.035, "pair": 0.03, "line": 0.05, "map": 0.09}
    most |= {"confined": 0.08, "bi-sinusoidal": 0.11}
    for kind, limit in most.items():
        assert max(abs(row["calibrated"]["area"]) for row in found[kind]) < limit, kind
    assert np.mean([abs(row["calibrated"]["area"]) < 0.055 for row in found["map"]]) > 0.7
    assert min(row["auto"]["area"] for row in found["sphere"]) == pytest.approx(-0.35, abs=0.03)


def test_predicted_residual_indentation_matches_stored_cases() -> None:
    rows = [row for row in ceiling_rule.read_stored()["rows"] if row["kind"] in ("sphere", "map")]
    left = [(row["calibrated"]["depth"], row["calibrated"]["energy"]) for row in rows]
    assert (np.min(left, axis=0) > (1, 1.2)).all()
    assert (np.max(left, axis=0) < (1.32, 1.55)).all()
    for row in rows:
        first = 1.295 * math.exp(0.736 * row["poisson"])
        if row["kind"] == "sphere":
            factor = ceiling_factor(row["load_ratio"], first)
            advice = CalibratedCeiling(row["load_ratio"], 0.0, 1.0, first, factor, factor)
            depth, energy = plausibility.ratio_to_elastoplastic(advice, 3.0)
            assert row["auto"]["depth"] == pytest.approx(depth, abs=0.06)
            assert row["auto"]["energy"] == pytest.approx(energy, abs=0.06)
