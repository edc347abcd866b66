r"""
14 A ground raceway runs in
===========================

A roller passes over a ground raceway at a Hertz pressure of 1.5 GPa. The smooth contact would stay
elastic; the peaks of the roughness do not. Which of them are pressed in, after how many passes does
that end, and what residual stress stays below them? The volume model follows every step of every
pass; the model of the source paper, a ceiling on the pressure, does the same at the surface alone.
"""

# %%
# A strip of ground steel, the lay along y, the axis of the roller, and of its period; it is
# generated here, and `rc.read_surface` takes a measured one.

import matplotlib.pyplot as plt
import numpy as np

import roughcontact as rc
from roughcontact.plots import rolling as plots
from roughcontact.surface import nominal
from roughcontact.surface.shifting import shifted

POINTS = 64
PASSES, STEPS = 10, 16
SIDE, RADIUS, HERTZ = 200e-6, 2.0e-3, 1.5e9

grid = {"shape": (POINTS // 4, POINTS), "pixel": (SIDE / POINTS, SIDE / POINTS)}
ground = rc.generate(
    size=(SIDE / 4, SIDE), points=grid["shape"], Sq=0.12e-6, Sal=9e-6, Ssk=-0.5, seed=4
)
