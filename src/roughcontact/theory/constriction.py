"""Constriction of the flow from one half-space into another through contact spots.

All is told as a length L: divided by the sum of the resistivities of the two bodies, or by the
sum of 1/k of their thermal conductivities, it is the conductance.
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
        kind with the modulus e, e² = 1 - (b/a)²; 4 a of a circle.

    References
    ----------
    Holm, Electric Contacts (4th ed. 1967), §4, doi:10.1007/978-3-662-06688-1

    Examples
    --------
    >>> round(ellipse(1.0, 1.0), 12), round(ellipse(2.0, 0.5) / ellipse(1.0, 1.0), 4)
    (4.0, 1.1215)
    """
    require_positive(first=first, second=second)
    # π/(2 K) is the arithmetic-geometric mean of 1 and b/a: it converges in a few steps.
    large, small = max(first, second), min(first, second)
    while large - small > 1e-15 * large:
        large, small = (large + small) / 2, math.sqrt(large * small)
    return 4 * large


def plastic_joint(pressure: float, hardness: float, slope: float, roughness: float) -> float:
    """Return the constriction length per nominal area of a rough joint whose spots yield [1/m].

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
        2.5 (m/σ) (p̄/H)^0.95: with the harmonic mean k_s of the conductivities, that is
        h = 1.25 k_s (m/σ) (p̄/H)^0.95, the correlation of Cooper, Mikic and Yovanovich's theory of
        Gaussian heights without correlation of the spots.

    References
    ----------
    Cooper, Mikic and Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279,
    doi:10.1016/0017-9310(69)90011-8
    Yovanovich 1982, AIAA paper 82-0888, doi:10.2514/6.1982-888
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
        3.1 (m/σ) (√2 p̄/(E* m))^0.94.

    References
    ----------
    Mikic 1974, Int. J. Heat Mass Transfer 17, 205, doi:10.1016/0017-9310(74)90082-9
    """
    require_positive(
        pressure=pressure, contact_modulus=contact_modulus, slope=slope, roughness=roughness
    )
    strain = math.sqrt(2) * pressure / (contact_modulus * slope)
    return 3.1 * slope / roughness * math.pow(strain, 0.94)
