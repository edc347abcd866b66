r"""
12 The ceiling against elastoplastic model
===============================================

The ceiling represents plastic flow. ``solve_elastoplastic`` computes it: plastic
strain in the volume below the contact, the displacement and the stress that it leaves behind. It takes
about a thousand times longer. ``compare_models`` solves the same contact by both and says how far the
shortcut may be trusted, and with which ceiling.
"""

# %%
# A perfectly plastic ball
# ------------------------
# Steel with a yield strength of 1 GPa that does not harden, from first yield to full plasticity. Loads
# are counted in loads of first yield; each map is scaled so that its contact is as well resolved as
# that of all others. On a half-space nothing but this ratio matters: modulus, strength and radius set
# the scales. Each load is solved once in the volume and with a row of ceilings.

import time

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.contact.ceiling import ceiling_factor, recommended_ceiling
from roughcontact.surface import shapes
from roughcontact.theory import hertz

POINTS = 40

began = time.perf_counter()
radius = 1e-3
factors = [1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0, 3.2]
three = factors.index(3.0)


def ball(
    load_ratio: float, material: rc.Material, wide: float = 4.6
) -> tuple[rc.Surface, float, float]:
    """Return a map of so many contact radii, the load [N], and its Hertz radius [m]."""
    modulus = rc.contact_modulus(material, rc.RIGID)
    load = load_ratio * hertz.first_yield_load(radius, modulus, material.first_yield_pressure)
    a_hertz = hertz.contact_radius(load, radius, modulus)
    plateau = ceiling_factor(load_ratio) * material.yield_strength
    side = wide * max(a_hertz, np.sqrt(load / (np.pi * plateau)))
    pixel = (side / POINTS, side / POINTS)
    return rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel), load, a_hertz


def compared(
    load_ratio: float, material: rc.Material, tried: list[float]
) -> rc.results.ModelComparison:
    """Return both models, loaded in three steps; the last is the one to look at."""
    surface, load, _ = ball(load_ratio, material)
    steps = [load * step / 3 for step in (1, 2, 3)]
    return rc.compare_models(surface, material=material, increments=1, loads=steps, factors=tried)


steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
ratios = (1.5, 3, 6, 12, 40, 120, 300)
balls = {ratio: compared(ratio, steel, factors) for ratio in ratios}


def last(name: str, model: str) -> np.ndarray:
    """Return a quantity of the perfectly plastic balls at their last load."""
    return np.array([both.column(model, name)[..., -1] for both in balls.values()])


figure, axes = plt.subplots(figsize=(7.5, 4.4), layout="constrained")
fine = np.geomspace(1, 400, 200)
axes.semilogx(fine, 2 / 3 * 1.615 * np.cbrt(fine), "k:", label="Hertz, elastic")
axes.semilogx(
    ratios,
    last("mean_pressure", "ceiling")[:, three] / 1e9,
    "s-",
    color="#7f0d1b",
    label="ceiling 3 $\\sigma_Y$",
)
axes.semilogx(
    ratios,
    last("mean_pressure", "elastoplastic") / 1e9,
    "o-",
    color="#0072b2",
    label="elastoplastic model",
)
light = 1.19 * (fine / 1.03) ** (0.289 / 1.425)
heavy = 1.61 * (fine / 1.40) ** (0.117 / 1.263)
change = 1.03 * 6**1.425
axes.semilogx(
    fine, np.where(fine < change, light, heavy), "--", color="0.4", label="Kogut and Etsion 2002"
)
axes.set(xlabel="load / load of first yield", ylabel="mean pressure / $\\sigma_Y$", ylim=(0.9, 3.3))
axes.set_title(
    "Between first yield and full plasticity the ceiling is too high", loc="left", fontsize=11
)
axes.legend(frameon=False)

# %%
# The error, over load and ceiling
# --------------------------------
# A lower ceiling gives more area and approach. Where the error changes its sign the ceiling is right:
# for the area along a line that grows with the logarithm of the load, from the pressure of first yield,
# 1.6 σ_Y, to three yield strengths. This line is ``ceiling.ceiling_factor``. Approach and map of
# pressures want a tenth to a quarter of a yield strength more.

figure_error, panels = plt.subplots(1, 3, figsize=(11, 4.2), sharey=True, layout="constrained")
quantities = {"contact_area": "contact area", "approach": "approach", "map": "pressure map"}
for axes, (name, title) in zip(panels, quantities.items(), strict=True):
    error = 100 * np.array(
        [
            (both.map_error() if name == "map" else both.excess(name))[:, -1]
            for both in balls.values()
        ]
    )
    image = axes.contourf(
        ratios, factors, error.T, levels=np.arange(-40, 41, 5), cmap="RdBu_r", extend="both"
    )
    if name != "map":
        axes.contour(ratios, factors, error.T, levels=[0], colors="k", linewidths=1.2)
    rule = [ceiling_factor(ratio) for ratio in fine]
    axes.plot(fine, rule, "--", color="#009e73", lw=2, label="ceiling_factor")
    axes.axhline(3, color="#7f0d1b", lw=1)
    axes.set(xscale="log", xlabel="load / load of first yield", title=title, xlim=(1.5, 300))
panels[0].set(ylabel="ceiling / $\\sigma_Y$", ylim=(1.4, 3.2))
panels[0].legend(loc="upper left")
figure_error.colorbar(image, ax=panels, label="error of the ceiling model [%]")

print("load/first yield    area at 3 σ_Y   approach   best for area, approach   rule")
for ratio, both in balls.items():
    area, approach = (100 * both.excess(q)[three, -1] for q in ("contact_area", "approach"))
    best = [both.best_factor(q)[-1] for q in ("contact_area", "approach")]
    print(
        f"{ratio:10g} {area:16.0f} % {approach:10.0f} % {best[0]:14.2f} {best[1]:8.2f} "
        f"{ceiling_factor(ratio):14.2f}"
    )

# %%
# The pressure
# ------------
# The ceiling that fits is read from the solution with three yield strengths: from mean pressure and
# slope of the surface within the contact, ``recommended_ceiling`` finds the ball that is loaded alike.
# With perfect plasticity single pixels scatter, so that means over rings are drawn.


def rings(result: rc.ContactResult, unit: float, count: int = 15) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean pressure over rings around the axis [GPa], and their radii over a unit."""
    points, pixel = result.pressure.shape[0], result.surface.pixel[0]
    y, x = (np.indices(result.pressure.shape) - (points - 1) / 2) * pixel
    r = np.hypot(y, x) / unit
    edges = np.linspace(0, r[0].min(), count + 1)
    held = np.histogram(r, edges)[0]
    total = np.histogram(r, edges, weights=result.pressure)[0]
    return (edges[1:] + edges[:-1]) / 2, total / np.maximum(held, 1) / 1e9


figure_profile, panels = plt.subplots(1, 3, figsize=(11, 3.8), sharey=True, layout="constrained")
for axes, ratio in zip(panels, (3, 40, 300), strict=True):
    both = balls[ratio]
    usual, true = both.ceiling[three][-1], both.volume[-1].contact
    advice = recommended_ceiling(usual)
    better = rc.solve(usual.surface, material=steel, load=usual.load, ceiling=advice.ceiling)
    _, load, a_hertz = ball(ratio, steel)
    peak = hertz.max_pressure(load, radius, usual.contact_modulus) / 1e9
    rho = np.linspace(0, 1, 200)
    axes.plot(rho, peak * np.sqrt(1 - rho**2), "k:", label="Hertz, elastic")
    axes.plot(*rings(usual, a_hertz), "s-", ms=4, color="#7f0d1b", label="ceiling 3 $\\sigma_Y$")
    axes.plot(*rings(better, a_hertz), "-", color="#009e73", lw=2, label="calibrated ceiling")
    axes.plot(*rings(true, a_hertz), "o-", ms=5, color="#0072b2", label="elastoplastic model")
    axes.set(xlabel="$r/a_H$", ylim=(0, 4), xlim=(0, None))
    axes.set_title(f"{ratio} × first yield: {advice.factor:.2f} $\\sigma_Y$", loc="left")
panels[0].set_ylabel("pressure [GPa]")
panels[0].legend(frameon=False, fontsize=8)

# %%
# Metals that harden
# ------------------
# Hardening raises the plateau above three times the initial yield strength. The rule uses the flow
# stress at the representative strain of a ball, about 0.15 a/R. Solid: elastoplastic model. Dashed: the calibrated ceiling. Dotted: three times the first
# yield strength, which is too high for the first two metals and, beyond some forty loads of first yield,
# too low for the bearing steel.

laws = {
    "perfect": steel,
    "linear, $H = E/50$": rc.Material(210e9, 0.3, hardening=rc.hardening.Linear(1e9, 210e9 / 50)),
    "bearing steel, Swift": rc.Material(
        210e9, 0.3, hardening=rc.hardening.Swift(1240e6, 30, 0.085)
    ),
}
steps = (3, 12, 40, 120, 300)
figure_laws, panels = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
print("law                   load   error of the area: at 3 σ_Y   recommended")
for (name, material), colour in zip(laws.items(), ("#0072b2", "#009e73", "#d55e00"), strict=True):
    unit = np.pi * ball(1, material)[2] ** 2
    table = []
    for ratio in steps:
        both = balls[ratio] if material is steel else compared(ratio, material, [3.0])
        usual = both.ceiling[both.factors.index(3.0)][-1]
        advice = recommended_ceiling(usual)
        better = rc.solve(usual.surface, material=material, load=usual.load, ceiling=advice.ceiling)
        areas = [
            both.volume[-1].perimeter_corrected_area,
            better.perimeter_corrected_area,
            usual.perimeter_corrected_area,
        ]
        table.append([*areas, advice.factor])
        wrong = [100 * (area / areas[0] - 1) for area in (areas[2], areas[1])]
        print(f"{name:20} {ratio:5g} {wrong[0]:24.0f} % {wrong[1]:14.0f} %")
    true, better_area, usual_area, factor = np.array(table).T
    for values, style in ((true, "o-"), (better_area, "--"), (usual_area, ":")):
        panels[0].loglog(steps, np.sqrt(values / unit), style, color=colour, ms=5)
        panels[1].semilogx(steps, values / unit / np.array(steps) ** (2 / 3), style, color=colour)
    panels[2].semilogx(steps, factor, "--", color=colour, label=name)
    hardness = np.array(steps) * 2 / 3 * 1.615 * unit / true
    panels[2].semilogx(steps, hardness, "o-", color=colour, ms=5)
panels[0].set(ylabel="contact radius / that of first yield", title="contact radius")
panels[0].minorticks_off()
panels[0].set_yticks([1, 2, 5, 10], ["1", "2", "5", "10"])
panels[1].set(ylabel="contact area / that of Hertz", title="contact area")
panels[2].set(ylabel="pressure / first yield strength", title="mean pressure; dashed: ceiling")
panels[2].legend(frameon=False)
for axes in panels:
    axes.set_xlabel("load / load of first yield")

# %%
# A rough map
# -----------
# The same on a period of a rough surface with E*h′/σ_Y = 12: in the transition. Its spots are of all
# sizes; the rule takes them for one ball.

heights, pixel = rc.reference_map(64)
rough = rc.Surface(heights, pixel)
nominal = np.array([0.02, 0.06, 0.12, 0.2, 0.3])
figure_rough, panels = plt.subplots(1, 3, figsize=(11, 3.8), layout="constrained")
index = 12
young = 210e9
print("law       nominal p/σ_Y   contact   error of the area: at 3 σ_Y   recommended  (factor)")
for axes, (name, law) in zip(
    panels, (("perfect", None), ("Swift", rc.hardening.Swift(1240e6, 30, 0.085))), strict=False
):
    strength = rough.Sdq * young / 0.91 / index
    if law is None:
        body = rc.Material(young, 0.3, strength)
    else:
        # The same law, scaled to the strength wanted.
        swift = rc.hardening.Swift(1240e6 * strength / law.initial, 30, 0.085)
        body = rc.Material(young, 0.3, hardening=swift)
    loads = nominal * body.yield_strength * rough.size[0] * rough.size[1]
    both = rc.compare_models(
        rough, material=body, increments=1, loads=loads, factors=[3.0], boundary="periodic"
    )
    better = []
    for usual in both.ceiling[0]:
        advice = recommended_ceiling(usual)
        better.append(
            rc.solve(
                rough, material=body, load=usual.load, ceiling=advice.ceiling, boundary="periodic"
            )
        )
    elastic = [result.elastic() for result in better]
    nominal_area = rough.size[0] * rough.size[1]
    curves = {
        "elastoplastic model": (both.column("elastoplastic", "contact_area"), "o-", "#0072b2"),
        "calibrated ceiling": ([r.perimeter_corrected_area for r in better], "--", "#009e73"),
        "ceiling 3 $\\sigma_Y$": (both.column("ceiling", "contact_area")[0], "s:", "#7f0d1b"),
        "elastic": ([r.perimeter_corrected_area for r in elastic], ":", "0.4"),
    }
    for label, (values, style, colour) in curves.items():
        axes.plot(nominal, 100 * np.array(values) / nominal_area, style, color=colour, label=label)
    axes.set(xlabel="nominal pressure / $\\sigma_Y$", ylabel="contact area [%]", title=name)
    true = both.column("elastoplastic", "contact_area")
    for place, result in enumerate(better):
        wrong = 100 * both.excess("contact_area")[0, place]
        right = 100 * (result.perimeter_corrected_area / true[place] - 1)
        print(
            f"{name:9} {nominal[place]:12g} {100 * true[place] / nominal_area:10.1f} % "
            f"{wrong:20.0f} % {right:14.0f} % {result.ceiling / body.yield_strength:10.2f}"
        )
    if law is None:
        shown, rough_error = (both.volume[-1].contact, both.ceiling[0][-1], better[-1]), wrong
        rough_better = right
        unit_pressure = body.yield_strength
panels[0].legend(frameon=False, fontsize=8)
bins = np.linspace(0, 4.2, 22)
for result, label, colour in zip(
    shown,
    ("volume", "ceiling 3 $\\sigma_Y$", "recommended"),
    ("#0072b2", "#7f0d1b", "#009e73"),
    strict=True,
):
    values = result.pressure[result.contact] / unit_pressure
    panels[2].hist(
        values,
        bins,
        weights=values / values.sum(),
        histtype="step",
        color=colour,
        lw=1.5,
        label=label,
    )
panels[2].set(
    xlabel="pressure / $\\sigma_Y$", ylabel="share of the load", title="perfect, last load"
)
panels[2].legend(frameon=False, fontsize=8, loc="upper left")

# %%
# Position and size of the spots are right with any ceiling. In the elastoplastic model some spots carry
# a higher pressure than others, which no single ceiling can represent.

figure_maps, panels = plt.subplots(1, 3, figsize=(11, 3.7), sharey=True, layout="constrained")
titles = ("elastoplastic model", "ceiling 3 $\\sigma_Y$", "calibrated ceiling")
for axes, result, title in zip(panels, shown, titles, strict=True):
    image = axes.imshow(
        np.where(result.contact, result.pressure / unit_pressure, np.nan),
        origin="lower",
        extent=(0, 100, 0, 100),
        vmin=0,
        vmax=4,
        cmap="inferno_r",
    )
    axes.set(title=title, xlabel="x [µm]")
panels[0].set_ylabel("y [µm]")
figure_maps.colorbar(image, ax=panels, label="pressure / $\\sigma_Y$")

# %%
# Results that a ceiling does not have
# ------------------------------------
# Plastic strain below the contact, and the residual stress after unloading: a ball at forty
# times the load of first yield.

chosen = 40
result = balls[chosen].volume[-1]
body = result.bodies[0]
a_hertz = ball(chosen, steel)[2]
middle = body.accumulated.shape[1] // 2
edge = result.contact.surface.pixel[0]
place = (np.arange(body.accumulated.shape[2]) - (body.accumulated.shape[2] - 1) / 2) * edge
figure_volume, panels = plt.subplots(1, 2, figsize=(10, 3.8), sharey=True, layout="constrained")
for axes, values, title, label in (
    (panels[0], 100 * body.accumulated[:, middle], "plastic strain", "accumulated strain [%]"),
    (panels[1], body.residual_von_mises[:, middle] / 1e9, "stress that stays", "von Mises [GPa]"),
):
    image = axes.pcolormesh(place / a_hertz, body.depth / a_hertz, values, cmap="inferno_r")
    figure_volume.colorbar(image, ax=axes, label=label)
    axes.set(xlabel="$x/a_H$", title=title, xlim=(-2.2, 2.2), ylim=(2.6, 0))
panels[0].set_ylabel("$z/a_H$")

print(f"largest plastic strain {100 * body.max_plastic_strain:.1f} %")
print(f"plastic down to {result.plastic_depth / a_hertz:.1f} Hertz radii")
print(f"all of this page took {time.perf_counter() - began:.0f} s")

# %%
# The numbers to check: the mean pressure at forty loads of first yield, 2.19 yield strengths by Kogut and
# Etsion's finite elements, and the remaining error of the area with the calibrated ceiling.

plateau = balls[chosen].mean_pressure_ratio[-1]
excess = balls[chosen].excess("mean_pressure")[three, -1]
print(f"mean pressure {plateau:.2f} σ_Y; three yield strengths are {100 * excess:.0f} % high")
assert abs(plateau - 2.2) < 0.25  # a contact of five pixels in radius is rough
print(f"rough map: area {rough_error:+.0f} % with three, {rough_better:+.0f} % as recommended")
