"""One surface, elastic and with a ceiling, on one scale of pressure."""

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

heights, pixel = rc.reference_map(256)
surface = rc.Surface(heights, pixel)
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
results = {
    "elastic": rc.solve(surface, material=steel, load=1.0, ceiling=None),
    "with a ceiling of 3 GPa": rc.solve(surface, material=steel, load=1.0),
}

side = 1e6 * surface.size[0]
figure, panels = plt.subplots(1, 3, figsize=(11.5, 3.9), layout="constrained")
image = panels[0].imshow(1e9 * heights, extent=(0, side, side, 0), cmap="viridis")
figure.colorbar(image, ax=panels[0], label="height [nm]", shrink=0.8)
panels[0].set_title("the surface", fontsize=11)
for axes, (name, result) in zip(panels[1:], results.items(), strict=True):
    pressure = np.where(result.contact, result.pressure / 1e9, np.nan)
    image = axes.imshow(
        pressure, extent=(0, side, side, 0), cmap="inferno_r", norm="log", vmin=0.3, vmax=30
    )
    axes.set_facecolor("#f1f1ee")
    share = 100 * result.contact_fraction
    axes.set_title(f"{name}: {share:.1f} % in contact", fontsize=11)
bar = figure.colorbar(
    image, ax=panels[1:], label="pressure [GPa]", shrink=0.8, ticks=[0.3, 1, 3, 10, 30]
)
bar.ax.set_yticklabels(["0.3", "1", "3", "10", "30"])
for axes in panels:
    axes.set(xlabel="x [µm]")
panels[0].set_ylabel("y [µm]")
