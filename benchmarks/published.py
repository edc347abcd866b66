"""This program and published results: set-up, source, published value, own value with interval.

    python benchmarks/published.py                 # every row; some minutes on two cores
    python benchmarks/published.py hertz patir     # the rows whose names begin so
    python benchmarks/published.py --write         # every row, and docs/evidence/published.md

Own values are those of the finest grid, their interval the difference to half the points per side;
of random surfaces the mean, with two standard errors over the realizations. A row agrees if both
intervals overlap.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft
import scipy.ndimage
from numpy.typing import NDArray

import roughcontact as rc
from measuring import EVIDENCE, make_parser, markdown, write_parts
from roughcontact.surface import shapes
from roughcontact.theory import hertz, waves

Array = NDArray[np.float64]
Interval = tuple[float, float]

PAGE = EVIDENCE / "published.md"
STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
# Half width over middle above which an interval is shown by its ends.
WIDE = 0.1
# Of a sphere on a flat: 0.1 mm under 1 N.
RADIUS, LOAD = 1e-4, 1.0
CONTACT_RADIUS = hertz.contact_radius(LOAD, RADIUS, MODULUS)
# Amplitude and length of the waves of a wavy surface.
AMPLITUDE, WAVELENGTH = 1e-7, 1e-4


@dataclass(frozen=True)
class Row:
    """A published and an own value, both as low and high end, in the same unit."""

    setup: str
    source: str
    published: Interval
    found: Interval
    unit: str = ""
    note: str = ""

    @property
    def agrees(self) -> bool:
        """Return whether the intervals overlap, but for rounding."""
        (low, high), (least, most) = self.published, self.found
        return max(low, least) <= min(high, most) * (1 + 1e-9)


def refinement_interval(solve: Callable[[int], float], points: int) -> Interval:
    """Return the value on a grid, less and plus its difference to that on half the points."""
    fine, coarse = solve(points), solve(points // 2)
    return fine - abs(fine - coarse), fine + abs(fine - coarse)


def mean_interval(values: Iterable[float]) -> Interval:
    """Return the mean over realizations, less and plus two standard errors."""
    array = np.array(list(values))
    error = 2 * array.std(ddof=1) / math.sqrt(array.size)
    return float(array.mean() - error), float(array.mean() + error)


def exact_interval(value: float) -> Interval:
    """Return the interval of a closed form."""
    return value, value


def sphere(points: int, half: float, roughness: Array | None = None) -> rc.Surface:
    """Return a paraboloid on a map of twice the half side, rough or smooth."""
    pixel = (2 * half / points,) * 2
    y = (np.arange(points) - (points - 1) / 2) * pixel[0]
    heights = -(y[:, None] ** 2 + y**2) / (2 * RADIUS)
    return rc.Surface(heights if roughness is None else heights + roughness, pixel)


def gradient_of(heights: Array, side: float) -> float:
    """Return the RMS gradient of a periodic square map by its Fourier sum."""
    power = np.abs(scipy.fft.fft2(heights) / heights.size) ** 2
    q = 2 * math.pi * np.fft.fftfreq(len(heights), side / len(heights))
    return math.sqrt((power * (q[:, None] ** 2 + q**2)).sum())


def rough_surface(
    points: int, seed: int, gradient: float, side: float = 1e-3, waves: int = 8, finest: int = 8
) -> rc.Surface:
    """Return a self-affine map, Hurst 0.8: waves a side, points in the shortest, RMS gradient."""
    pixel = side / points
    heights = rc.self_affine(
        points,
        pixel,
        rms_height=1e-6,
        rolloff_wavelength=side / waves,
        cutoff_wavelength=finest * pixel,
        rng=seed,
    )
    return rc.Surface(heights * (gradient / gradient_of(heights, side)), (pixel, pixel))


def solve_periodic(surface: rc.Surface, pressure: float, **more: object) -> rc.ContactResult:
    """Solve a periodic contact of steel on a rigid flat under a nominal pressure [Pa]."""
    options = {"material": STEEL, "ceiling": None, "boundary": "periodic"} | more
    return rc.solve(surface, load=rc.NominalPressure(pressure), **options)  # type: ignore[arg-type]


def fraction(result: rc.ContactResult) -> float:
    """Return the perimeter-corrected contact fraction."""
    return result.perimeter_corrected_area / result.nominal_area


def constriction(result: rc.ContactResult) -> float:
    """Return the constriction length of a contact [m]."""
    conductor = rc.Conductor(conductivity=1.0)
    return rc.conductance(result, conductor, conductor).steps[0].length


# --- Closed forms ---


def hertz_sphere() -> Iterator[Row]:
    """Largest pressure of a sphere."""

    def peak(points: int) -> float:
        ball = sphere(points, 1.3 * CONTACT_RADIUS)
        return rc.solve(ball, material=STEEL, load=LOAD, ceiling=None).max_pressure

    yield Row(
        "Sphere on a flat, elastic: largest pressure",
        "Hertz 1882 ([formula in Bahrami et al. 2005]"
        "(https://studylib.net/doc/11187891)), 3F/(2πa²)",
        exact_interval(1.5 * LOAD / (math.pi * CONTACT_RADIUS**2) / 1e9),
        tuple(end / 1e9 for end in refinement_interval(peak, 256)),  # type: ignore[arg-type]
        "GPa",
    )


def westergaard() -> Iterator[Row]:
    """Contact fraction of one wave."""
    closing = waves.wavy_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)

    def share(points: int) -> float:
        pixel = (WAVELENGTH / points,) * 2
        heights = shapes.wavy((4, points), pixel, AMPLITUDE, WAVELENGTH)
        return fraction(solve_periodic(rc.Surface(heights, pixel), 0.5 * closing))

    yield Row(
        "One wave at half the pressure that closes it: contact fraction",
        "Westergaard 1939, (2/π) arcsin (p̄/p*)^½",
        exact_interval(50.0),
        tuple(100 * end for end in refinement_interval(share, 512)),  # type: ignore[arg-type]
        "%",
    )


def crossed_waves() -> Iterator[Row]:
    """Both ends of the contact of crossed waves, and the pressure that closes them."""
    closing = waves.crossed_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)
    source = "Johnson, Greenwood, Higginson 1985: "

    def solve(points: int, ratio: float) -> rc.ContactResult:
        pixel = (WAVELENGTH / points,) * 2
        heights = shapes.crossed_waves((points, points), pixel, AMPLITUDE, WAVELENGTH)
        return solve_periodic(rc.Surface(heights, pixel), ratio * closing)

    light = refinement_interval(lambda points: fraction(solve(points, 0.003)), 1024)
    yield Row(
        "Crossed waves at 0.003 of the closing pressure: contact fraction",
        source + "π(3p̄/8πp*)^⅔",
        exact_interval(100 * waves.crossed_contact_fraction_light(0.003, 1.0)),
        tuple(100 * end for end in light),  # type: ignore[arg-type]
        "%",
        "An asymptote for p̄ → 0.",
    )
    heavy = refinement_interval(lambda points: 1 - fraction(solve(points, 0.97)), 512)
    yield Row(
        "Crossed waves at 0.97 of the closing pressure: open fraction",
        source + "(3/2π)(1 - p̄/p*)",
        exact_interval(100 * (1 - waves.crossed_contact_fraction_heavy(0.97, 1.0))),
        tuple(100 * end for end in heavy),  # type: ignore[arg-type]
        "%",
        "An asymptote for p̄ → p*.",
    )
    ratios = (0.99, 0.995, 0.999, 1.001, 1.005)
    closed = [solve(128, ratio).contact_fraction == 1 for ratio in ratios]
    first = closed.index(True)
    yield Row(
        "Crossed waves: pressure that closes them",
        source + "√2 πE*Δ/λ",
        exact_interval(closing / 1e9),
        (ratios[first - 1] * closing / 1e9, ratios[first] * closing / 1e9),
        "GPa",
    )


def mindlin() -> Iterator[Row]:
    """Shift of a sphere under half of the force that slides it."""
    friction, part = 0.2, 0.5
    modulus = rc.contact_modulus(STEEL, STEEL)
    radius = hertz.contact_radius(LOAD, RADIUS, modulus)
    shear = STEEL.young / (2 * (1 + STEEL.poisson))
    shift = 3 * friction * LOAD / (16 * radius) * 2 * (2 - STEEL.poisson) / shear
    shift *= 1 - (1 - part) ** (2 / 3)

    def solve(points: int) -> float:
        ball = sphere(points, 1.3 * radius)
        contact = rc.solve(ball, material=STEEL, counter_material=STEEL, load=LOAD, ceiling=None)
        return rc.tangential(contact, friction=friction, force=part * friction * LOAD).last.shift

    yield Row(
        "Sphere on its like, friction 0.2, half of the sliding force: shift",
        "Mindlin 1949, 3μF/(16a) Σ(2-ν)/G (1 - (1-Q/μF)^⅔)",
        exact_interval(shift * 1e9),
        tuple(1e9 * end for end in refinement_interval(solve, 128)),  # type: ignore[arg-type]
        "nm",
        "The formula neglects the traction across the force.",
    )


def first_yield() -> Iterator[Row]:
    """Largest pressure at which a sphere begins to yield."""
    material = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    depth = np.linspace(0.3, 0.7, 4001)
    # On the axis: σ_r and σ_z over the largest pressure, at depths over the contact radius.
    axial = -1 / (1 + depth**2)
    radial = -1.3 * (1 - depth * np.arctan(1 / depth)) + 0.5 / (1 + depth**2)

    def solve(points: int) -> float:
        ball = sphere(points, 1.3 * CONTACT_RADIUS)
        return rc.first_yield_load(ball, material=material).solution.max_pressure / 1e9

    yield Row(
        "Sphere on a flat, ν = 0.3: largest pressure over yield strength at first yield",
        "Huber 1904: stress on the axis under Hertz's pressure",
        exact_interval(float(1 / (radial - axial).max())),
        refinement_interval(solve, 64),
    )


# --- Rough surfaces, elastic ---


def gfmd_area() -> Iterator[Row]:
    """Contact fraction over pressure of a self-affine surface."""
    side, height, hurst, breadth = 2 * math.pi / 1e4, 6e-6, 0.8, 100
    q = 1e4 * np.array([1, breadth])
    gradient = math.sqrt(
        height**2
        * hurst
        / (1 - hurst)
        * np.subtract(*q[::-1] ** (2 - 2 * hurst))
        / np.subtract(*q ** (-2 * hurst))
    )
    values = ((0.005, 3.993, 0.029), (0.025, 18.524, 0.074), (0.113, 65.714, 0.048))
    surfaces = [rough_surface(1024, seed, gradient, side, 1, 1024 / breadth) for seed in range(3)]
    coarse = rc.Surface(surfaces[0].heights[::4, ::4], (side / 256, side / 256))
    rows = []
    for pressure, mean, deviation in values:
        fine = [100 * fraction(solve_periodic(each, pressure * MODULUS)) for each in surfaces]
        result = solve_periodic(coarse, pressure * MODULUS)
        counted = 100 * result.contact_fraction, 100 * fraction(result) / fine[0] - 1
        rows.append((pressure, (mean - deviation, mean + deviation), mean_interval(fine), counted))
    whole = ", ".join(f"{counted[0]:.3g}" for *_, counted in rows)
    change = max(abs(counted[1]) for *_, counted in rows)
    note = (
        f"Same spectrum and RMS gradient, own realizations. Their grid is not given: whole pixels "
        f"at 2.6 points per shortest wave (here 10) give {whole} % on the first one. The corrected "
        f"area of this grid differs by {change:.1%} at most."
    )
    for pressure, published, found, _ in rows:
        yield Row(
            f"Self-affine surface, Hurst 0.8, waves from the side to 1/100 of it, RMS gradient "
            f"{gradient:.3f}, {pressure:g} E*: contact fraction",
            "GFMD of Y. Zhou ([data](https://github.com/xylcsi/PerssonModelFudgeFactor), "
            "`Area_GFMD_Zhou.mat`), mean and deviation",
            published,
            found,
            "%",
            note,
        )


def challenge() -> Iterator[Row]:
    """Contact fraction of the Contact-Mechanics Challenge without its adhesion."""
    side, points, modulus = 0.1e-3, 2048, 25e6
    body = rc.Material(young=modulus, poisson=0.0)

    def share(seed: int) -> float:
        pixel = side / points
        heights = rc.self_affine(
            points,
            pixel,
            rms_height=1e-6,
            rolloff_wavelength=20e-6,
            cutoff_wavelength=0.1e-6,
            rng=seed,
        )
        surface = rc.Surface(heights / gradient_of(heights, side), (pixel, pixel))
        return 100 * fraction(solve_periodic(surface, 0.01 * modulus, material=body))

    yield Row(
        "Contact-Mechanics Challenge (Müser 2015, arXiv:1512.02403) without adhesion, own "
        "realizations, 0.01 E*: contact fraction",
        "Wang and Müser 2017 ([points of their figure 2]"
        "(https://github.com/xylcsi/PerssonModelFudgeFactor)), sum of the pressure distribution",
        (2.02, 2.08),
        mean_interval(share(seed) for seed in range(3)),
        "%",
        "The points carry 1.033 of the load; the lower value is scaled by it.",
    )


def percolation() -> Iterator[Row]:
    """Contact fraction above which no open path crosses the map."""

    def crosses(result: rc.ContactResult) -> bool:
        labels = scipy.ndimage.label(~result.contact)[0]
        return bool(set(labels[0]) & set(labels[-1]) - {0})

    def critical(seed: int) -> float:
        surface = rough_surface(512, seed, 0.1)
        low, high, share = 0.1, 0.4, 0.0
        result = None
        for _ in range(8):
            middle = (low + high) / 2
            result = solve_periodic(surface, middle * 0.1 * MODULUS, initial_guess=result)
            low, high = (middle, high) if crosses(result) else (low, middle)
            share = fraction(result)
        return 100 * share

    yield Row(
        "Self-affine surface: contact fraction at which no open path crosses",
        "Wang and Müser 2020 ([abstract](https://ar5iv.labs.arxiv.org/html/2010.13470): near "
        "0.415); Persson and Yang 2008 ([abstract](https://tomesphere.com/paper/0805.0699): of "
        "order 0.4)",
        (40.0, 41.5),
        mean_interval(critical(seed) for seed in range(6)),
        "%",
    )


def stiffness_exponent() -> Iterator[Row]:
    """Exponent of the stiffness over the pressure."""
    pressures = np.array([0.01, 0.04, 0.12])

    def logarithms(seed: int) -> Array:
        surface = rough_surface(512, seed, 0.1)
        return np.log([solve_periodic(surface, p * 0.1 * MODULUS).stiffness() for p in pressures])

    found = np.array([logarithms(seed) for seed in range(6)])
    slopes = np.diff(found.mean(0)) / np.diff(np.log(pressures))

    yield Row(
        "Self-affine surface, 2 to 24 % in contact: exponent of stiffness over pressure",
        "Pastewka et al. 2013 ([abstract](https://ar5iv.labs.arxiv.org/html/1210.4635): linear "
        "over a wide range, sublinear at small pressure by finite size)",
        exact_interval(1.0),
        mean_interval((found[:, 2] - found[:, 0]) / math.log(pressures[2] / pressures[0])),
        "",
        f"{slopes[0]:.2f} up to 8 %, by the finite size (eight roll-off waves a side), "
        f"{slopes[1]:.2f} above.",
    )


def stiffness_ratio() -> Iterator[Row]:
    """Ratio of tangential and normal stiffness of a rough contact."""

    def ratio(seed: int) -> float:
        contact = solve_periodic(
            rough_surface(256, seed, 0.1), 0.05 * 0.1 * MODULUS / 2, counter_material=STEEL
        )
        both = (
            rc.tangential(contact, friction=0.3, force=1e-3 * contact.load, direction=angle)
            for angle in (0.0, 90.0)
        )
        return np.mean([one.initial_stiffness for one in both]) / contact.stiffness()

    nu = STEEL.poisson
    yield Row(
        "Self-affine surface, like bodies, ν = 0.3: tangential over normal stiffness",
        "Campañá, Persson and Müser 2011 ([abstract](https://juser.fz-juelich.de/record/19590)), "
        "after Mindlin: 2(1-ν)/(2-ν)",
        exact_interval(2 * (1 - nu) / (2 - nu)),
        mean_interval(ratio(seed) for seed in range(3)),
        "",
        "Exact for a circle; the source derives it for rough surfaces with an isotropic mean.",
    )


def rough_sphere() -> Iterator[Row]:
    """Deviation from Hertz of a rough sphere with α = σR/a² = 0.05."""

    def growth(seed: int) -> float:
        half, points = 2 * CONTACT_RADIUS, 512
        roughness = rough_surface(points, seed, 1.0, 2 * half, 16).heights
        roughness = roughness * (0.05 * CONTACT_RADIUS**2 / RADIUS / roughness.std())
        ball = sphere(points, half, roughness)
        result = rc.solve(ball, material=STEEL, load=LOAD, ceiling=None)
        y = (np.arange(points) - (points - 1) / 2) * ball.pixel[0]
        second = (result.pressure * (y[:, None] ** 2 + y**2)).sum() / result.pressure.sum()
        # ⟨r²⟩ is 0.4 a² under Hertz's pressure.
        return 100 * (math.sqrt(2.5 * second) / CONTACT_RADIUS - 1)

    yield Row(
        "Rough sphere, σR/a² = 0.05: growth of the contact radius (from the second moment of the "
        "pressure)",
        "Greenwood, Johnson and Matsubara 1984 ([abstract]"
        "(http://publications.eng.cam.ac.uk/565837/): errors not likely above about 7 %)",
        (0.0, 7.0),
        mean_interval(growth(seed) for seed in range(6)),
        "%",
    )


# --- Plasticity, heat, flow ---


def kogut_etsion() -> Iterator[Row]:
    """Approach and contact area of a sphere that yields."""
    sigma, ratio = 1e9, 20.0
    material = rc.Material(young=210e9, poisson=0.3, yield_strength=sigma)
    critical = (math.pi * (0.454 + 0.41 * 0.3) * 2.8 * sigma / (2 * MODULUS)) ** 2 * RADIUS
    load = ratio * 4 / 3 * MODULUS * math.sqrt(RADIUS) * critical**1.5
    approach = (ratio / 1.40) ** (1 / 1.263)
    area = 0.94 * approach**1.146
    half = 2.3 * math.sqrt(area * RADIUS * critical)
    results = {}

    def solve(points: int) -> rc.ContactResult:
        if points not in results:
            ball = sphere(points, half)
            results[points] = rc.solve_elastoplastic(ball, material=material, load=load).contact
        return results[points]

    source = (
        "Kogut and Etsion 2002, finite elements ([fit in public code]"
        "(https://github.com/TaoYang1999/SCHC-framework)), "
    )
    setup = "Sphere on a flat, perfectly plastic, 20 times the load of first yield: "
    note = "The fit has no error; that of Jackson and Green 2005 differs from it by up to 4 %."
    yield Row(
        setup + "approach over that of first yield",
        source + "(F/1.40)^(1/1.263)",
        (approach * 0.96, approach * 1.04),
        refinement_interval(lambda points: solve(points).approach / critical, 64),
        "",
        note,
    )
    yield Row(
        setup + "contact area over that of first yield",
        source + "0.94 ω^1.146",
        (area * 0.96, area * 1.04),
        refinement_interval(
            lambda points: solve(points).perimeter_corrected_area / (math.pi * RADIUS * critical),
            64,
        ),
        "",
        note,
    )


def conductance() -> Iterator[Row]:
    """Conductance of a plastic joint."""
    relative, hardness = 0.02, 2e9
    published = 1.25 * relative**0.95

    def solve(seed: int) -> float:
        gradient = 0.2
        surface = rough_surface(512, seed, gradient)
        result = solve_periodic(
            surface, relative * hardness, ceiling=hardness, counter_material=STEEL
        )
        slope = gradient / math.sqrt(math.pi)
        return constriction(result) / 2 / result.nominal_area * float(surface.heights.std()) / slope

    yield Row(
        "Plastic joint of Gaussian surfaces, p̄ = 0.02 H: conductance h σ/(k m)",
        "Yovanovich 1982 after Cooper, Mikic and Yovanovich 1969 (public code that cites it), "
        "1.25 (p̄/H)^0.95",
        exact_interval(published),
        mean_interval(solve(seed) for seed in range(4)),
        "",
        "On 108 solved maps the correlation was 0.99 to 1.44 times the solved value "
        "([](estimates.md)).",
    )


def vacuum_joints() -> Iterator[Row]:
    """Resistance of joints in vacuum."""
    table = {
        ("304", "stainless steel"): {10.0: (0.7, 4.0)},
        ("6061-T6", "aluminum"): {0.1: (1.5, 5.0), 10.0: (0.2, 0.4)},
    }
    for (name, words), rows in table.items():
        material, conductor = rc.catalog.material(name), rc.catalog.entry(name).conductor
        for pressure, published in rows.items():
            found = rc.estimate(
                pressure=pressure * 1e6,
                Ra="1.6 um",
                finish="milled",
                counter_Ra="1.6 um",
                counter_finish="milled",
                material=material,
                counter_material=material,
                conductor=conductor,
                counter_conductor=conductor,
            ).vacuum_conductance
            yield Row(
                f"Joint of {words} in vacuum, {pressure:g} MPa, estimated (milled, Ra 1.6 µm): "
                "resistance",
                "Typical joints ([mekesim.com](https://github.com/mekesim/Hardware-IOT))",
                published,
                (1e4 / found.high, 1e4 / found.low),
                "10⁻⁴ m² K/W",
                "The table does not define finish and roughness. Its 0.1 MPa on stainless steel (6 "
                "to 25) are below the range of the formulas.",
            )


def patir() -> Iterator[Row]:
    """Flow factor of an isotropic gap."""

    def solve(seed: int) -> Interval:
        surface = rough_surface(512, seed, 0.1, finest=16)
        sigma = float(surface.heights.std())
        low, high = 1e-7, 1e-2
        for _ in range(12):
            middle = math.sqrt(low * high)
            result = solve_periodic(surface, middle * MODULUS)
            low, high = (middle, high) if result.mean_gap > 2 * sigma else (low, middle)
        factor = rc.leakage(result, flow_axis="x").flow_factor(1)[0]
        return float(factor), result.mean_gap / sigma

    found = [solve(seed) for seed in range(4)]
    ratio = float(np.mean([gap for _, gap in found]))
    yield Row(
        f"Gap of an isotropic rough surface, mean gap {ratio:.2f} σ: pressure flow factor",
        "Patir and Cheng 1978 (public code that cites it), 1 - 0.90 exp(-0.56 h/σ)",
        exact_interval(1 - 0.9 * math.exp(-0.56 * ratio)),
        mean_interval(factor for factor, _ in found),
        "",
        "Theirs is the mean of small maps in which overlapping peaks are cut off, undeformed.",
    )


def loading_stiffness() -> Iterator[Row]:
    """Ratio of the stiffness in unloading and in loading."""

    def ratio(seed: int) -> float:
        surface, ceiling = rough_surface(512, seed, 0.2), 3e9
        lower, middle, upper = (
            solve_periodic(surface, p * 1e6, ceiling=ceiling) for p in (63, 70, 77)
        )
        loading = 14e6 / (upper.approach - lower.approach)
        # Stiffness of the whole contact outline, saturated or not, as in conductance.
        unloading = middle.contact_modulus * constriction(middle) / 2 / middle.nominal_area
        return unloading / loading

    yield Row(
        "Plastic joint at 70 MPa: stiffness in unloading over that in loading",
        "Mulvihill et al. 2013 ([abstract](https://link.springer.com/article/10.1007/"
        "s11340-013-9718-5)): ultrasound about three times as stiff as image correlation",
        (2.5, 3.5),
        mean_interval(ratio(seed) for seed in range(3)),
        "",
        "The surfaces of the source were not reached. Image correlation also measures the bulk "
        "near the interface.",
    )


ROWS: dict[str, Callable[[], Iterator[Row]]] = {
    "hertz": hertz_sphere,
    "westergaard": westergaard,
    "crossed": crossed_waves,
    "mindlin": mindlin,
    "yield": first_yield,
    "gfmd": gfmd_area,
    "challenge": challenge,
    "percolation": percolation,
    "exponent": stiffness_exponent,
    "tangential": stiffness_ratio,
    "sphere": rough_sphere,
    "kogut": kogut_etsion,
    "conductance": conductance,
    "vacuum": vacuum_joints,
    "patir": patir,
    "unloading": loading_stiffness,
}


def format_interval(ends: Interval, unit: str) -> str:
    """Return an interval as text, a narrow one with two digits of its half width."""
    low, high = ends
    middle, half = (low + high) / 2, (high - low) / 2
    if half <= 1e-9 * abs(middle):
        text = f"{middle:.5g}"
    elif half > WIDE * abs(middle):
        text = f"{low:.3g} to {high:.3g}"
    else:
        digits = max(0, 1 - math.floor(math.log10(half)))
        text = f"{middle:.{digits}f} ± {half:.{digits}f}"
    return f"{text} {unit}".rstrip()


def main() -> None:
    """Print the table."""
    parser = make_parser(__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of names of rows")
    parser.add_argument("--write", action="store_true", help=f"renew {PAGE.name}")
    options = parser.parse_args()
    if options.write and options.names:
        parser.error("the page has every row: give no names with --write")
    cells, notes = [], []
    for name, make in ROWS.items():
        if options.names and not name.startswith(tuple(options.names)):
            continue
        began = time.process_time()
        rows = list(make())
        seconds = time.process_time() - began
        for row in rows:
            if row.note and row.note not in notes:
                notes.append(row.note)
            mark = f" [{notes.index(row.note) + 1}]" if row.note else ""
            values = format_interval(row.published, row.unit), format_interval(row.found, row.unit)
            verdict = "yes" if row.agrees else "**no**"
            if row.published[1] - row.published[0] < WIDE * sum(row.published):
                difference = round(100 * (sum(row.found) / sum(row.published) - 1), 3)
                verdict += f", {difference:+.2g} %"
            named = f"`{name}`, {seconds:.1f} s"
            source = "″" if row is not rows[0] and row.source == rows[0].source else row.source
            cells.append([named, row.setup, source, *values, verdict + mark])
            print(named, row.setup, *values, verdict, sep=" | ", flush=True)
    head = ("row, time", "set-up", "source", "published", "this program", "agrees, difference")
    text = "\n".join([markdown(head, cells), "", *(f"{n + 1}. {t}" for n, t in enumerate(notes))])
    if options.write:
        write_parts("result", text, page=PAGE)


if __name__ == "__main__":
    main()
