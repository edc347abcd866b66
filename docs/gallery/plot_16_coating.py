r"""
16 A coated tool
================

A hard layer is said to protect what it covers. Whether it does depends on its thickness over the
radius of the contact: a thin one passes the load on, and a stiff one of half that radius even raises
the stress below it. Materials take layers, and ``rc.subsurface_stress`` computes the stress of each.
"""

# %%
# Titanium nitride on steel
# -------------------------
# A ball is pressed on steel with layers of TiN, from a twentieth of Hertz's radius to twice it.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.surface import shapes

POINTS = 128

radius, a_hertz = 10e-3, 100e-6
steel = {"young": 210e9, "poisson": 0.3}
modulus = rc.contact_modulus(rc.Material(**steel), rc.RIGID)
load, p_hertz = 4 * modulus * a_hertz**3 / (3 * radius), 2 * modulus * a_hertz / (np.pi * radius)
pixel = (3 * a_hertz / POINTS,) * 2
ball = rc.Surface(shapes.paraboloid((POINTS, POINTS), pixel, radius), pixel)

thickness = np.array([0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0])
layer, base, tension = [], [], []
for depth in thickness * a_hertz:
    tool = rc.Material(**steel, coating=[rc.Layer(450e9, 0.25, depth, name="TiN")])
    contact = rc.solve(ball, material=tool, load=load, ceiling=None)
    stress = rc.subsurface_stress(contact)
    layer.append(stress.parts[0].max_von_mises / p_hertz)
    base.append(stress.parts[1].max_von_mises / p_hertz)
    tension.append(stress.faces[1].tension.value / p_hertz)

figure, axes = plt.subplots(figsize=(6.5, 4), layout="constrained")
axes.plot(thickness, layer, "o-", color="#d55e00", label="von Mises in the layer")
axes.plot(thickness, base, "s-", color="#0072b2", label="von Mises in the steel")
axes.plot(thickness, tension, "^-", color="#009e73", label="tension at the bottom of the layer")
axes.axhline(0.62, color="0.5", ls="--", lw=1)
axes.annotate("bare steel", (2.0, 0.62), xytext=(0, 3), textcoords="offset points", ha="right")
axes.set(
    xlabel="thickness over Hertz's radius", ylabel="stress over the peak pressure on bare steel"
)
axes.set(xscale="log", ylim=(0, None))
axes.set_xticks([0.05, 0.1, 0.2, 0.5, 1, 2], ["0.05", "0.1", "0.2", "0.5", "1", "2"])
axes.legend(frameon=False)

half, one = (base[int(np.flatnonzero(thickness == ratio)[0])] for ratio in (0.5, 1.0))
print(f"largest stress in the steel: {half:.2f} at h = a/2, {one:.2f} at h = a, 0.62 bare")
assert abs(one - 0.496) < 0.01  # by quadrature of axisymmetric waves

# %%
# The steel is relieved only where the layer is about as thick as the contact is wide. Before that
# the layer bends, and its largest tension is at its bottom: cracks through it start there.
