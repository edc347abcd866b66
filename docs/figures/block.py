"""Pressure of the rough block by finite elements and by this program, from stored answers."""

import matplotlib.pyplot as plt
import numpy as np

import cross_code

rows = [row for row in cross_code.compare_block() if row.points == 64]
shown = {row.program: row for row in rows if row.program in ("calculix", "roughcontact")}
titles = {"calculix": "CalculiX, finite elements", "roughcontact": "roughcontact, half-space"}
panels = plt.figure(figsize=(10, 3.4), layout="constrained").subplots(1, 3)
for axes, (name, row) in zip(panels, shown.items(), strict=False):
    image = axes.imshow(
        np.where(row.pressure > 0, row.pressure / 1e9, np.nan),
        origin="lower",
        extent=(0, 64, 0, 64),
        vmin=0,
        vmax=26,
    )
    axes.set(title=titles[name], xlabel="x [µm]", ylabel="y [µm]")
panels[0].figure.colorbar(image, ax=panels[:2], label="pressure [GPa]")
middle = int(shown["roughcontact"].pressure.sum(1).argmax())
x = np.arange(65)
for name, style in (("roughcontact", "-"), ("calculix", ".")):
    panels[2].plot(x, shown[name].pressure[middle] / 1e9, style, label=titles[name])
panels[2].set(title=f"y = {middle} µm", xlabel="x [µm]", ylabel="pressure [GPa]")
panels[2].legend(fontsize=8, frameon=False, loc="upper left")
