"""Loading, unloading and reloading with a ceiling against closed forms and the energy balance."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.history.model import Stage, history

STEEL = rc.Material(210e9, 0.3, 1e9)
MODULUS = 210e9 / 0.91
RADIUS = 2e-4
SIDE = 64e-6


def ball(n: int) -> rc.Surface:
    x = (np.arange(n) - (n - 1) / 2) * SIDE / n
    return rc.Surface(-(x**2 + x[:, None] ** 2) / (2 * RADIUS), (SIDE / n, SIDE / n))


@pytest.mark.parametrize("fraction", [0.1, 0.2])
def test_imprint_of_a_ball_under_a_low_ceiling(fraction: float) -> None:
    # Uniform pressure p on a circle of radius a displaces its centre by 2pa/E*, its rim by
    # 4pa/(πE*), its mean by 16pa/(3πE*) (Johnson 1985, eqs. 3.29). The gap closes at the rim, so
    # the imprint is a²/2R - (2 - 4/π) pa/E* deep and has the volume πa⁴/4R - 4pa³/3E*.
    load = 0.3 if fraction == 0.1 else 1.0
    hertz_radius = (3 * load * RADIUS / (4 * MODULUS)) ** (1 / 3)
    ceiling = fraction * 1.5 * load / (math.pi * hertz_radius**2)
    a = math.sqrt(load / (math.pi * ceiling))
    depth = a**2 / (2 * RADIUS) - (2 - 4 / math.pi) * ceiling * a / MODULUS
    volume = math.pi * a**4 / (4 * RADIUS) - 4 * ceiling * a**3 / (3 * MODULUS)
    found = history(
        ball(128), [load, 0.0], material=rc.RIGID, counter_material=STEEL, ceiling=ceiling
    )
    # A pixel is 2 to 3 % of the radius, and the outermost ones are not saturated: measured
    # 0.1 and 0.7 % of the depth, 0.1 and 0.4 % of the volume.
    assert found.indentation.max() == pytest.approx(depth, rel=0.01)
    assert found.indentation_volume == pytest.approx(volume, rel=0.01)
    # A bowl: deepest in the middle, and nothing beyond the contact.
    y, x = np.indices(found.indentation.shape)
    r = np.hypot(y - 63.5, x - 63.5) * SIDE / 128
    order = np.argsort(r, axis=None)
    profile = found.indentation.ravel()[order]
    assert (np.diff(profile[::16]) <= 1e-3 * depth).all()
    assert not found.indentation[r > a + SIDE / 128].any()
    assert found.residual.heights.min() == -found.indentation.max()


@pytest.mark.slow
@pytest.mark.parametrize("control", ["load", "approach"])
def test_work_is_stored_plus_dissipated_energy(control: str) -> None:
    # Loaded, unloaded, reloaded higher, unloaded again; finer and finer. The trapezoidal rule
    # and the implicit step leave an error that falls faster than the step.
    surface = rc.Surface(*rc.reference_map(32))
    errors = []
    for steps in (8, 16, 32, 64):
        up = np.linspace(0, 1, steps + 1)[1:]
        cycle = [*up, *up[-2::-1], 0.0, *(1.5 * up), *(1.5 * up[-2 : steps // 2 : -1])]
        scale = 1.0 if control == "load" else 2e-7
        path = [Stage(**{control: scale * value}) for value in cycle]
        found = history(surface, path, material=STEEL)
        approach, load = (np.concatenate([[0.0], values]) for values in found.hysteresis)
        work = float((0.5 * (load[1:] + load[:-1]) * np.diff(approach)).sum())
        stored = found.steps[-1].elastic_energy
        assert stored > 0
        errors.append((work - stored) / found.dissipated_energy - 1)
    assert abs(errors[-1]) < 0.02
    order = np.polyfit(np.log2([8, 16, 32, 64]), np.log2(np.abs(errors)), 1)[0]
    assert order < -1
