"""Constriction of the flow from one half-space into another through contact spots.

Results are given as a length L: divided by the sum of the resistivities of the two bodies, or by
the sum of 1/k of their thermal conductivities, L is the conductance.
"""

from __future__ import annotations

import math

from roughcontact.errors import require_positive


def disc(radius: float) -> float:
    """Return the constriction length of a circular spot, 4 a [m].

    Parameters
    ----------
    radius : float
        Radius a [m].

    References
    ----------
    Holm, Electric Contacts (4th ed. 1967), §4, doi:10.1007/978-3-662-06688-1
    """
    require_positive(radius=radius)
    return 4 * radius


def ellipse(first: float, second: float) -> float:
    """Return the constriction length of an elliptic spot [m].

    Parameters
    ----------
    first, second : float
        Semi-axes [m], in any order.

    Returns
    -------
    float
        2 π a / K(e), a the larger semi-axis and K the complete elliptic integral of the first
        kind with the modulus e, e² = 1 - (b/a)²; 4 a for a circle.

    References
    ----------
    Holm, Electric Contacts (4th ed. 1967), §4, doi:10.1007/978-3-662-06688-1

    Examples
    --------
    >>> round(ellipse(1.0, 1.0), 12), round(ellipse(2.0, 0.5) / ellipse(1.0, 1.0), 4)
    (4.0, 1.1215)
    """
    require_positive(first=first, second=second)
    # π/(2 K) is the arithmetic-geometric mean of 1 and b/a, which converges in a few steps.
    large, small = max(first, second), min(first, second)
    while large - small > 1e-15 * large:
        large, small = (large + small) / 2, math.sqrt(large * small)
    return 4 * large


def plastic_joint(pressure: float, hardness: float, slope: float, roughness: float) -> float:
    """Return the constriction length per nominal area of a plastic rough joint [1/m].

    Parameters
    ----------
    pressure : float
        Nominal pressure p̄ [Pa].
    hardness : float
        Mean pressure H of the spots [Pa].
    slope : float
        Mean absolute slope m of profiles of the gap.
    roughness : float
        Root-mean-square height σ of the gap [m].

    Returns
    -------
    float
        2.5 (m/σ) (p̄/H)^0.95: with the harmonic mean k_s of the conductivities, this is
        h = 1.25 k_s (m/σ) (p̄/H)^0.95.

    Notes
    -----
    The power law approximates the theory of Gaussian heights with uncorrelated spots,
    h σ/(k_s m) = exp(-λ²/2)/(2√(2π)) / (1 - √α)^1.5 with the contact fraction
    α = p̄/H = ½ erfc(λ/√2), from which it differs by less than 1.6 % for 2 ≤ λ ≤ 4.75, that is
    for p̄/H from 1e-6 to 0.023.

    References
    ----------
    Cooper, Mikic and Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279,
    doi:10.1016/0017-9310(69)90011-8
    Yovanovich 1982, Thermal contact correlations, in Spacecraft Radiative Transfer and Temperature
    Control, Progress in Astronautics and Aeronautics 83, 83; and 2005, IEEE Trans. Compon. Packag.
    Technol. 28, 182, doi:10.1109/TCAPT.2005.848483
    """
    require_positive(pressure=pressure, hardness=hardness, slope=slope, roughness=roughness)
    return 2.5 * slope / roughness * math.pow(pressure / hardness, 0.95)


def elastic_joint(pressure: float, contact_modulus: float, slope: float, roughness: float) -> float:
    """Return the constriction length per nominal area of an elastic rough joint [1/m].

    Parameters
    ----------
    pressure, slope, roughness : float
        As for `plastic_joint`.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        3.1 (m/σ) (√2 p̄/(E* m))^0.94: h = 1.55 k_s (m/σ) (√2 p̄/(E* m))^0.94.

    Notes
    -----
    The underlying theory is that of `plastic_joint` with half of the truncated area in contact,
    α = √2 p̄/(E* m) = ¼ erfc(λ/√2), and h σ/(k_s m) = exp(-λ²/2)/(4√π) /
    (1 - √α)^1.5; the power law differs from it by less than 3.5 % for α from 1e-5 to 0.011. This
    α is √(2π) p̄/(E* h′) for a root-mean-square gradient h′ = √π m, the result of Bush, Gibson and
    Thomas at small loads (1975, Wear 35, 87, doi:10.1016/0043-1648(75)90145-3).

    References
    ----------
    Mikic 1974, Int. J. Heat Mass Transfer 17, 205, doi:10.1016/0017-9310(74)90082-9
    """
    require_positive(
        pressure=pressure, contact_modulus=contact_modulus, slope=slope, roughness=roughness
    )
    strain = math.sqrt(2) * pressure / (contact_modulus * slope)
    return 3.1 * slope / roughness * math.pow(strain, 0.94)


CORRELATION_RANGE = (0.99, 1.44)
"""`plastic_joint` and `elastic_joint` over the solution, in 95 % of rough contacts.

108 contacts, see ``calibration/constriction.py``: periodic maps of Gaussian heights, eight roll-off
wavelengths per side, Hurst exponents 0.5 and 0.8, roll-off over cut-off 4 to 16, elastic and under
a ceiling, 1 to 12 % in contact. Spots form clusters, which the correlations neglect: they
overestimate the conductance.
"""


LORENZ = 2.44e-8
"""Conductivity times resistivity of a metal over its temperature, L [V²/K²]."""


def hottest_spot(voltage: float, temperature: float) -> float:
    """Return the highest temperature in a contact under current, √(T² + V²/(4 L)) [K].

    Parameters
    ----------
    voltage : float
        Contact voltage V [V].
    temperature : float
        Temperature T of the bodies far from the contact [K].

    Notes
    -----
    Temperature is a function of the potential for any shape of the spots, if current and heat flow
    through the same surfaces and k ρ = L T in both bodies.

    References
    ----------
    Kohlrausch 1900, Ann. Phys. 306, 132; Holm, Electric Contacts (4th ed. 1967), §13

    Examples
    --------
    >>> round(hottest_spot(0.43, 293.15))
    1407
    """
    return math.hypot(temperature, voltage / (2 * math.sqrt(LORENZ)))
