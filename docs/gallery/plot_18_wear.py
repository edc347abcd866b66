r"""
18 Wear of a finish
===================

A rough face slides on a smooth one. Its summits wear first: contact spreads, the pressure falls, and a
plateau with pits remains. ``rc.wear`` follows it by Archard's law, in steps that are contacts.
"""

# %%
# Two finishes with the same Sq
# -----------------------------
# One has a long tail of summits, the other one is cut off at its summits, as after honing in two steps.

import math

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc

POINTS = 256

heights, pixel = rc.reference_map(POINTS)
ground = rc.Surface(heights, pixel)
cut = np.minimum(heights, np.quantile(heights, 0.8))
cut = (cut - cut.mean()) * ground.Sq / cut.std()
finishes = {"ground": ground, "plateau": rc.Surface(cut, pixel)}

steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
terms = {"material": steel, "load": "50 MPa", "boundary": "periodic", "wear_coefficient": 1e-15}
worn = {name: rc.wear(face, distance="2 m", **terms) for name, face in finishes.items()}
for name, result in worn.items():
    print(name, result, sep="\n")

# %%
# Contact and roughness over the wear depth do not depend on the wear coefficient; the distance does.

figure, axes = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained")
for name, result in worn.items():
    wear = 1e9 * result.column("wear")[1:]
    contact = 100 * result.column("contact_area")[1:] / result.last.nominal_area
    axes[0].semilogx(wear, contact, "o-", ms=3, label=name)
    axes[1].semilogx(wear, result.column("Ssk")[1:], "o-", ms=3, label=name)
axes[0].set(xlabel="mean wear depth [nm]", ylabel="contact [%]")
axes[1].set(xlabel="mean wear depth [nm]", ylabel="skewness Ssk")
axes[0].legend(frameon=False)
figure_all = worn["ground"].plot()

# %%
# The worn map is a map like any other. Run in, the face seals better.

for name, face in {"new": ground, "worn": worn["ground"].worn}.items():
    contact = rc.solve(face, material=steel, load="50 MPa", boundary="periodic")
    print(
        f"{name}: mean gap {1e9 * contact.mean_gap:.0f} nm, contact {contact.contact_fraction:.1%}"
    )

# %%
# The number to check: the removed volume is wear coefficient times load times distance,

result = worn["ground"]
removed = float(result.depth.sum()) * result.last.pixel_area
error = removed / (1e-15 * result.last.load * 2.0) - 1
print(f"removed volume: {error:+.1e} from Archard's law")
assert math.isclose(error, 0, abs_tol=1e-10)
