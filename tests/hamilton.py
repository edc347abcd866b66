"""Stress below a sliding sphere in closed form (Hamilton 1983)."""

import math

import numpy as np


def sliding_sphere(x, y, z, poisson, friction):
    """Stress (xx, yy, zz, yz, xz, xy) per p0 under a sliding sphere, lengths in a; not at r = 0.

    Hamilton, Proc. IMechE 197C (1983) 53, doi:10.1243/PIME_PROC_1983_197_076_02, in a form derived
    again: the pressure is that of forces at imaginary depths it, |t| ≤ a, with the weight a² - t²,
    and twice integrated by parts nothing but the ends is left. So the potential n times integrated
    over z enters at z + ia only, where h[n] is 1/ρ, ln(ρ + z), z ln(ρ + z) - ρ, ...
    """
    x, y, z = np.broadcast_arrays(*(np.asarray(part, dtype=float) for part in (x, y, z)))
    w, r2 = z + 1j, x * x + y * y
    rho = np.sqrt(r2 + w * w)
    log = np.log(rho + w)
    # Polynomials next to the logarithm, then the potentials, each the derivative of the next.
    c = [0, 1, w, w**2 / 2 - r2 / 4, w**3 / 6 - w * r2 / 4, w**4 / 24 - w**2 * r2 / 8 + r2**2 / 64]
    h = {
        -1: -w / rho**3,
        0: 1 / rho,
        1: log,
        2: w * log - rho,
        3: c[3] * log - 0.75 * w * rho,
        4: c[4] * log + (r2 / 9 - 11 / 36 * w**2) * rho,
        5: c[5] * log + rho * w * (55 / 576 * r2 - 25 / 288 * w**2),
    }
    # (1/r ∂/∂r) of each by its degree, and twice more by Laplace's equation.
    g = {n: ((n - 1) * h[n] + c[n] - w * h[n - 1]) / r2 for n in range(6)}
    g1 = {n: -(2 * g[n] + h[n - 2]) / r2 for n in range(1, 6)}
    g2 = {n: -(4 * g1[n] + g[n - 2]) / r2 for n in range(2, 6)}
    derivatives = {
        "z": lambda n: h[n - 1],
        "zz": lambda n: h[n - 2],
        "x": lambda n: x * g[n],
        "y": lambda n: y * g[n],
        "xz": lambda n: x * g[n - 1],
        "yz": lambda n: y * g[n - 1],
        "xx": lambda n: g[n] + x * x * g1[n],
        "yy": lambda n: g[n] + y * y * g1[n],
        "xy": lambda n: x * y * g1[n],
        "xxx": lambda n: 3 * x * g1[n] + x**3 * g2[n],
        "xyy": lambda n: x * g1[n] + x * y * y * g2[n],
        "xxy": lambda n: y * g1[n] + x * x * y * g2[n],
    }

    def potential(order, by):
        return 4 * (derivatives[by](order + 3).imag - derivatives[by](order + 2).real)

    def v(by):
        return potential(0, by)

    def chi(by):
        return potential(1, by)

    def omega(by):
        return potential(2, by)

    # The formulas of `stress_kernels.uniform_pressure` and `shares_of_parts`.
    k = 1 - 2 * poisson
    pressed = [
        2 * poisson * v("z") - z * v("xx") - k * chi("xx"),
        2 * poisson * v("z") - z * v("yy") - k * chi("yy"),
        v("z") - z * v("zz"),
        -z * v("yz"),
        -z * v("xz"),
        -k * chi("xy") - z * v("xy"),
    ]
    pulled = [
        2 * v("x") - 2 * poisson * omega("xyy") - z * chi("xxx"),
        2 * poisson * (v("x") + omega("xyy")) - z * chi("xyy"),
        -z * v("xz"),
        -z * v("xy"),
        v("z") - z * v("xx"),
        v("y") + 2 * poisson * omega("xxy") - z * chi("xxy"),
    ]
    return (np.array(pressed) + friction * np.array(pulled)) / 4


def rim_stress(poisson, friction):
    """Stresses along and across the traction at the trailing rim, per p0 (Hamilton 1983)."""
    spread, pull = (1 - 2 * poisson) / 3, math.pi * friction / 8
    return spread + (4 + poisson) * pull, -spread + 3 * poisson * pull
