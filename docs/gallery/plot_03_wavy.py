r"""
03 Waves, from first touch to full contact
==========================================

A wave that is pressed flat is the second contact with an exact solution, and the one that reaches
full contact. Westergaard (1939) solved the single wave; for crossed waves Johnson, Greenwood and
Higginson (1985) give both ends.
"""

# %%
# One wavelength, periodic in both directions. The contact closes at the mean pressure :math:`p^*
# = \pi E^* \Delta/\lambda`.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import waves

POINTS = 256

steel = rc.Material(young=210e9, poisson=0.3)
modulus = rc.contact_modulus(steel, rc.RIGID)
wavelength, amplitude = 1e-4, 1e-7
pixel = (wavelength / POINTS, wavelength / POINTS)
strip = rc.Surface(shapes.wavy((4, POINTS), pixel, amplitude, wavelength), pixel)
closing = waves.wavy_full_contact_pressure(amplitude, wavelength, modulus)

ratios = np.array([0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95])
strip_area = strip.size[0] * strip.size[1]
widths, results = [], []
for ratio in ratios:
    result = rc.solve(strip, material=steel, load=ratio * closing * strip_area, boundary="periodic")
    results.append(result)
    widths.append(result.perimeter_corrected_area / strip_area)
exact = [2 * waves.wavy_half_width(m * closing, closing, wavelength) / wavelength for m in ratios]

# %%
# Pressure and gap of four loads, compared with the exact lines. The strip widens with the load, and
# the pressure changes from Hertz's half-circle to the cosine of full contact.

x = np.arange(POINTS) * pixel[1]
shifted = np.roll(np.arange(POINTS), POINTS // 2)
place = (x - wavelength / 2) / wavelength
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
fine = np.linspace(-0.5, 0.5, 800)
for index in (1, 4, 7, 10):
    m = ratios[index]
    line = left.plot(
        place,
        results[index].pressure[0][shifted] / closing,
        ".",
        ms=5,
        label=f"$\\bar p = {m:g}\\,p^*$",
    )[0]
    exact_pressure = waves.wavy_pressure(fine * wavelength, m * closing, closing, wavelength)
    left.plot(fine, exact_pressure / closing, "k-", lw=0.8)
    right.plot(place, results[index].gap[0][shifted] / amplitude, ".", ms=5, color=line.get_color())
    exact_gap = waves.wavy_gap(fine * wavelength, m * closing, closing, wavelength, amplitude)
    right.plot(fine, exact_gap / amplitude, "k-", lw=0.8)
left.set(xlabel=r"$x/\lambda$", ylabel="$p/p^*$", title="pressure (points solved, lines exact)")
right.set(xlabel=r"$x/\lambda$", ylabel=r"gap$/\Delta$", title="gap")
left.legend(fontsize=8, frameon=False)

# %%
# The same for crossed waves. Johnson, Greenwood and Higginson give the two limits. Between them only
# the solver has an answer.

crossed = rc.Surface(shapes.crossed_waves((POINTS, POINTS), pixel, amplitude, wavelength), pixel)
crossed_closing = waves.crossed_full_contact_pressure(amplitude, wavelength, modulus)
areas = []
start = None
for ratio in ratios:
    start = rc.solve(
        crossed,
        material=steel,
        load=ratio * crossed_closing * wavelength**2,
        boundary="periodic",
        initial_guess=start,
    )
    areas.append(start.perimeter_corrected_area / wavelength**2)

figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
m = np.linspace(1e-3, 1, 300)
axes.plot(
    m,
    2 / math.pi * np.arcsin(np.sqrt(m)),
    "-",
    color="#0072b2",
    label="one wave, exact (Westergaard)",
)
axes.plot(ratios, widths, "o", color="#0072b2", label="one wave, solved")
light = [waves.crossed_contact_fraction_light(v, 1.0) for v in m]
heavy = [waves.crossed_contact_fraction_heavy(v, 1.0) for v in m]
axes.plot(
    m[m < 0.45], np.array(light)[m < 0.45], "--", color="#d55e00", label="crossed waves, light load"
)
axes.plot(
    m[m > 0.6], np.array(heavy)[m > 0.6], ":", color="#d55e00", label="crossed waves, near closing"
)
axes.plot(ratios, areas, "s", color="#d55e00", label="crossed waves, solved")
axes.set(xlabel=r"$\bar p/p^*$", ylabel="contact area / nominal area", xlim=(0, 1), ylim=(0, 1))
axes.set_title("Both waves close exactly where theory says", loc="left", fontsize=11)
axes.legend(frameon=False, fontsize=9)

# %%
# The width of the single strip differs from Westergaard's by at most

width_error = float(np.max(np.abs(np.array(widths) - exact)))
print(f"{100 * width_error:.2f} % of the wavelength; a pixel is {100 / POINTS:.2f} %")
assert width_error < 2 / POINTS  # a pixel at either edge
