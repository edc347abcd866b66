"""
01 A first contact
==================

A rough steel surface of 0.1 mm × 0.1 mm is pressed on a rigid flat with 1 N. Five lines give
pressure, real contact area and gap, and how far the result may be trusted.
"""

# %%
# The map here is generated; ``rc.read_surface("ground.opd")`` reads a measured one.

import roughcontact as rc
from roughcontact import plots

POINTS = 512

heights, pixel = rc.reference_map(POINTS)
surface = rc.Surface(heights, pixel)
steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
result = rc.solve(surface, load=1.0, material=steel)

print(f"real contact area  {100 * result.contact_fraction:.2f} % of the map")
print(f"saturated area     {100 * result.saturated_fraction:.2f} % of the map")
print(f"largest pressure   {result.max_pressure / 1e9:.2f} GPa")
print(f"mean gap           {result.mean_gap * 1e6:.3f} µm")
print(f"regime             {result.regime}")
print(f"certificate        {result.certificate:.1e} ({result.status})")

# %%
# One figure shows it all: about one part in thirty of the surface touches, on islands, and most
# of that is at the ceiling of three yield strengths.

figure = plots.overview(result)

# %%
# The certificate is the number to look at first. It says how exactly the stated problem is
# solved, whatever the units: here to better than one part in a million. The regime is the second:
# *saturated at the surface* means that the material flows where it touches, and that the pressure
# there is the ceiling that was put in, not a prediction.
#
# What is predicted is where the bodies touch and how large that area is. It has to carry the
# load:

share_at_ceiling = result.saturated_fraction / result.contact_fraction
area_under_ceiling = result.load / steel.ceiling / (surface.size[0] * surface.size[1])
print(f"{100 * share_at_ceiling:.0f} % of the contact is saturated")
print(f"{100 * area_under_ceiling:.2f} % of the map under the ceiling alone would carry 1 N")
assert abs(area_under_ceiling - 1 / 30) < 1e-9
