"""What a ceiling leaves behind, beside what plasticity of the volume does: depth and energy."""

from __future__ import annotations

from roughcontact.contact.advice import RECOMMENDED, RecommendedCeiling
from roughcontact.contact.cautions import Caution, Kind, careful, warned
from roughcontact.errors import Mention, Part
from roughcontact.theory import yielding_sphere

TRANSITION = 2.0
"""Load over that of first yield from which on there is anything to compare."""

NEAR = 0.05
"""Distance of a ceiling from the recommended one within which the two leave the same behind."""

# What the recommended ceiling leaves over what the volume does: 1.0 to 1.3 and 1.2 to 1.5, on
# spheres and rough maps from 4 times the load of first yield on (benchmarks/ceiling_rule.py).
_DEPTH, _ENERGY = 1.1, 1.3

# Below this part the two have little in common.
_FAR = 0.5


def over_volume(advice: RecommendedCeiling, ceiling: float) -> tuple[float, float]:
    """Return what a ceiling leaves of a sphere over what plasticity of the volume leaves.

    Parameters
    ----------
    advice : RecommendedCeiling
        What is recommended at the largest load.
    ceiling : float
        The ceiling that was taken [Pa].

    Returns
    -------
    (float, float)
        Permanent indentation and dissipated energy over those of the volume; zero where the
        ceiling is not reached.

    Notes
    -----
    The recommended ceiling leaves 1.1 and 1.3 times as much on perfectly plastic spheres; from
    there to another ceiling both follow from the ceiling model itself. On rough maps, whose
    spots differ, both are nearer to one.
    """
    depth, energy = _left(advice, ceiling)
    usual_depth, usual_energy = _left(advice, advice.ceiling)
    return _DEPTH * depth / usual_depth, _ENERGY * energy / usual_energy


def _left(advice: RecommendedCeiling, ceiling: float) -> tuple[float, float]:
    """Return depth and energy of a sphere under a ceiling, in units that do not depend on it."""
    share = ceiling / advice.first_yield
    depth, energy = yielding_sphere.left_under_ceiling(advice.load_ratio / share**3)
    return depth * share**2, energy * share**5


def doubt(advice: RecommendedCeiling, ceiling: float, hardens: bool = False) -> Caution | None:
    """Return how far what a ceiling leaves behind is from plasticity of the volume.

    Parameters
    ----------
    advice : RecommendedCeiling
        What is recommended at the largest load.
    ceiling : float
        The ceiling that was taken [Pa].
    hardens : bool
        Whether the material has a law of hardening, for which nothing was measured.

    Returns
    -------
    Caution or None
        ``None`` where hardly anything flows.
    """
    if advice.load_ratio < TRANSITION:
        return None
    depth, energy = over_volume(advice, ceiling)
    excess = ceiling / advice.ceiling - 1
    near = abs(excess) <= NEAR
    where = "the recommended one"
    if not near:
        where = f"{100 * abs(excess):.0f} % {'above' if excess > 0 else 'below'} {where}"
    times = float(f"{advice.load_ratio:.2g}")
    parts: list[Part] = [
        f"permanent indentation and dissipated energy are those of a ceiling, {where}: on a "
        f"smooth sphere at {times:.7g} times the load of first yield about {depth:.1f} and "
        f"{energy:.1f} times those of plasticity in the volume",
        " (of metals that do not harden)" if hardens else "",
        "; on rough maps both are nearer to 1",
    ]
    helps = abs(depth - 1) > abs(_DEPTH - 1) or abs(energy - 1) > abs(_ENERGY - 1)
    if not near and helps:
        parts += [
            "; ",
            Mention("ceiling", RECOMMENDED),
            f" brings them to about {_DEPTH:.1f} and {_ENERGY:.1f}",
        ]
    parts.append(
        "; loading and unloading with plasticity in the volume has neither error "
        "(solve_elastoplastic, roughcontact solve --model volume --unload)"
    )
    said = warned if min(depth, energy) < _FAR else careful
    return said(
        Kind.IMPRINT,
        *parts,
        indentation_over_volume=depth,
        energy_over_volume=energy,
        load_ratio=advice.load_ratio,
        recommended_ceiling=advice.ceiling,
    )
