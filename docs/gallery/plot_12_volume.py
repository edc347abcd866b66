r"""
12 The ceiling against plasticity of the volume
===============================================

The ceiling stands for plastic flow without computing it. ``solve_elastoplastic`` computes it: plastic
strain in the volume below the contact, the displacement and the stress that it leaves behind. It takes
a thousand times longer, and it says how far the shortcut may be trusted.
"""

# %%
# A perfectly plastic ball
# ------------------------
# The ball of the source paper's comparison: steel with a yield strength of 1 GPa that does not harden.
# Loads are counted in loads of first yield; each map is scaled so that its contact is well resolved.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact import generate, hertz
from roughcontact.elastoplastic import solve_elastoplastic

POINTS = 48

steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
modulus = rc.contact_modulus(steel, rc.RIGID)
radius = 1e-3
first = hertz.first_yield_load(radius, modulus, steel.first_yield_pressure)


def ball(points: int, load: float, wide: float) -> rc.Surface:
    """Return a map that is so many Hertz radii wide."""
    side = wide * hertz.contact_radius(load, radius, modulus)
    pixel = (side / points, side / points)
    return rc.Surface(generate.paraboloid((points, points), pixel, radius), pixel)


ratios = (1.5, 3, 6, 12, 40, 120)
volume, ceiling = {}, {}
for ratio in ratios:
    load = ratio * first
    volume[ratio] = solve_elastoplastic(
        ball(POINTS, load, 4), material=steel, load=load, increments=4
    )
    ceiling[ratio] = rc.solve(ball(4 * POINTS, load, 4), material=steel, load=load)


def mean_pressure(result: rc.ContactResult) -> float:
    """Return load over contact area, in yield strengths."""
    return result.load / result.contact_area / steel.yield_strength


figure, axes = plt.subplots(figsize=(7.5, 4.4), layout="constrained")
fine = np.geomspace(1, 150, 100)
axes.semilogx(fine, 2 / 3 * 1.615 * np.cbrt(fine), "k:", label="Hertz, elastic")
axes.semilogx(
    ratios,
    [mean_pressure(ceiling[ratio]) for ratio in ratios],
    "s-",
    color="#7f0d1b",
    label="ceiling 3 $\\sigma_Y$",
)
axes.semilogx(
    ratios,
    [mean_pressure(volume[ratio].contact) for ratio in ratios],
    "o-",
    color="#0072b2",
    label="plasticity of the volume",
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

print("load/first yield   volume   ceiling   ceiling is high by")
for ratio in ratios:
    true, model = mean_pressure(volume[ratio].contact), mean_pressure(ceiling[ratio])
    print(f"{ratio:12g} {true:13.2f} {model:9.2f} {100 * (model / true - 1):13.0f} %")

# %%
# The pressure
# ------------
# At forty loads of first yield. With perfect plasticity single pixels scatter, so that means over
# rings are drawn. The real profile is as flat as the ceiling, but lower and wider.

chosen = 40


def rings(result: rc.ContactResult, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean pressure over rings around the axis, in GPa over Hertz radii."""
    points, pixel = result.pressure.shape[0], result.surface.pixel[0]
    y, x = (np.indices(result.pressure.shape) - (points - 1) / 2) * pixel
    r = np.hypot(y, x) / hertz.contact_radius(result.load, radius, modulus)
    edges = np.linspace(0, 1.6, count + 1)
    held = np.histogram(r, edges)[0]
    total = np.histogram(r, edges, weights=result.pressure)[0]
    return (edges[1:] + edges[:-1]) / 2, total / np.maximum(held, 1) / 1e9


load = chosen * first
p_hertz = hertz.max_pressure(load, radius, modulus) / 1e9
figure_profile, axes = plt.subplots(figsize=(7.5, 4), layout="constrained")
rho = np.linspace(0, 1, 200)
axes.plot(rho, p_hertz * np.sqrt(1 - rho**2), "k:", label="Hertz, elastic")
axes.plot(*rings(ceiling[chosen], 60), "-", color="#7f0d1b", label="ceiling 3 $\\sigma_Y$")
axes.plot(
    *rings(volume[chosen].contact, 14), "o-", color="#0072b2", label="plasticity of the volume"
)
axes.set(xlabel="$r/a_H$", ylabel="pressure [GPa]", ylim=(0, 4))
axes.set_title(f"{chosen} times the load of first yield", loc="left", fontsize=11)
axes.legend(frameon=False)

# %%
# What the ceiling cannot say
# ---------------------------
# Plastic strain below the contact, and the stress that stays when the load is gone.

body = volume[chosen].bodies[0]
a_hertz = hertz.contact_radius(load, radius, modulus)
middle = body.accumulated.shape[1] // 2
pixel = volume[chosen].contact.surface.pixel[0]
place = (np.arange(body.accumulated.shape[2]) - (body.accumulated.shape[2] - 1) / 2) * pixel
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
print(f"plastic down to {volume[chosen].plastic_depth / a_hertz:.1f} Hertz radii")
seconds = sum(result.seconds for result in volume.values())
print(f"{len(ratios)} solutions with plasticity of the volume took {seconds:.0f} s")

# %%
# The number to check: the mean pressure at forty loads of first yield, 2.20 yield strengths by Kogut and
# Etsion's finite elements.

plateau = mean_pressure(volume[chosen].contact)
excess = mean_pressure(ceiling[chosen]) / plateau - 1
print(f"mean pressure {plateau:.2f} σ_Y; the ceiling is {100 * excess:.0f} % high")
