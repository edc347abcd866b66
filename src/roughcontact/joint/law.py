"""The law of an interface from contacts that were solved."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.arguments import checked
from roughcontact.contact import spots
from roughcontact.contact.cautions import Caution, Kind
from roughcontact.contact.judgment import over_loads
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.smooth import shape_of
from roughcontact.contact.stiffness import local_stiffness
from roughcontact.errors import InputError, Mention
from roughcontact.joint import law_judgment
from roughcontact.joint.conductance import conductor_of
from roughcontact.joint.interface import InterfaceLaw, LawPoint, MapLaw
from roughcontact.joint.series import require_alike, require_one_model, same_heights
from roughcontact.joint.window import Window, window_of
from roughcontact.material.conductor import Conductor
from roughcontact.surface import spectrum
from roughcontact.units import Quantity, quantity

Array = NDArray[np.float64]

OF = "an interface law"
"""What needs maps, in messages."""

# Heights that were lowered by this part of the largest gap are no rounding.
_ROUNDING = 1e-9


@checked
def interface_law(
    contacts: Iterable[ContactResult],
    unloading: Iterable[ContactResult] = (),
    *,
    body: Conductor | str | None = None,
    counter_body: Conductor | str | None = None,
    thermal_film: Quantity = 0.0,
) -> InterfaceLaw:
    """Return the law of a nominally flat joint: pressure, contact and stiffness over separation.

    Parameters
    ----------
    contacts : iterable of ContactResult
        Solutions of one map or several of one surface, each under two loads at least, one map
        after the other. One at a time is looked at.
    unloading : iterable of ContactResult
        Solutions under loads up to the largest of the maps as that left them
        (`roughcontact.indented_surface`), the maps in the same order. Without them, the law has no
        second branch; where nothing was saturated it needs none.
    body, counter_body : Conductor or str, optional
        What the bodies conduct, or their names in the catalogue of materials, for the thermal
        conductance over pressure.
    thermal_film : float, str or quantity of pint
        Thermal resistance of a film on the contact times its area [m² K/W].

    Returns
    -------
    InterfaceLaw
        Each map's law, their mean and scatter, what they resolve, tables for other programs.

    Raises
    ------
    InputError
        If there are fewer than two contacts of a map, the maps are profiles, curved, too small or
        of different grids, or the bodies differ in more than their maps.
    ConvergenceError, InsufficientMemoryError
        As for `roughcontact.contact.stiffness.local_stiffness`.

    Notes
    -----
    The *separation* ū is the distance of the mean planes of the two rough surfaces, each displaced
    by its elastic deformation: the mean of the gap where what is indented counts as negative. Far
    above and below the joint, bodies move towards each other by as much as ū falls and by their own
    compression. At *first touch*, under no load, ū is the height of the highest summit above the
    mean plane. *Overclosure*, as finite-element programs have it, is -ū: zero where the mean planes
    meet, negative before.

    On first loading the stiffness is that of the elastic contact alone, saturated points going on
    to flow; in unloading, and loading again up to the largest load, all of the contact resists.

    With a periodic boundary all of the map counts. On a free one, a rim along its edges is left
    out (`roughcontact.joint.window`), and p̄ and ū are means inside it, which follow the same local
    relation although the pressure of a flat body rises towards its edges.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3)
    >>> rough = rc.Surface(*rc.reference_map(64))
    >>> law = rc.interface_law(
    ...     rc.solve(rough, material=steel, load=rc.NominalPressure(p), boundary="periodic")
    ...     for p in ("100 MPa", "300 MPa", "1 GPa")
    ... )
    >>> first, *_, last = law.steps
    >>> first.separation > last.separation, first.stiffness < last.stiffness
    (True, True)
    """
    collected = _collected(contacts)
    for number, (samples, after) in enumerate(
        zip(collected, _after(unloading, collected), strict=True), start=1
    ):
        if len(samples.points) < 2:
            raise InputError(
                f"has {len(samples.points)} pressure at which map {number} touches inside its rim: "
                "a law needs two at least",
                argument="contacts",
            )
        samples.unloading = after
    film = quantity(thermal_film, "thermal film", "thermal_film")
    bodies = None
    if body is not None and counter_body is not None:
        bodies = (conductor_of(body), conductor_of(counter_body))
    rims = [samples.rim for samples in collected]
    return InterfaceLaw(
        maps=tuple(_law(samples, number, collected) for number, samples in enumerate(collected, 1)),
        rim=math.fsum(rims) / len(rims),
        largest=collected[0].largest,
        found=_judged(collected),
        bodies=bodies,
        thermal_film=float(film),
    )


@dataclass(eq=False)
class _Samples:
    """What was seen of one map so far."""

    pair: Pair
    window: Window | None
    rim: float
    largest: ContactResult
    points: list[tuple[LawPoint, float]] = field(default_factory=list)
    judged: list[tuple[float, tuple[Caution, ...]]] = field(default_factory=list)
    unloading: list[tuple[LawPoint, float]] = field(default_factory=list)

    @property
    def loads(self) -> list[float]:
        """The loads that were seen [N]."""
        return [load for load, _ in self.judged]

    def add(self, result: ContactResult) -> None:
        point = _point(result, self.window, 0.0)
        self.judged.append((result.load, result.cautions))
        if point.contact_points and point.pressure > 0:
            self.points.append((point, 0.0))
        if result.load >= self.largest.load:
            self.largest = result


def _collected(contacts: Iterable[ContactResult]) -> list[_Samples]:
    """Return what the contacts show, map by map."""
    found: list[_Samples] = []
    for result in [contacts] if isinstance(contacts, ContactResult) else contacts:
        # Under a load that a map has had, it is another that is the same.
        known = (one for one in found if result.load not in one.loads)
        _check(result, found[0].largest if found else result)
        samples = next((one for one in known if same_heights(one.pair, result.pair)), None)
        if samples is None:
            samples = _Samples(result.pair, *window_of(result.pair), result)
            found.append(samples)
        samples.add(result)
    if not found:
        raise InputError("is empty: give two contacts at least", argument="contacts")
    return found


def _after(
    unloading: Iterable[ContactResult], collected: Sequence[_Samples]
) -> list[list[tuple[LawPoint, float]]]:
    """Return the points of the second branch of each map, with the separation of first touch."""
    pairs: list[Pair] = []
    points: list[list[tuple[LawPoint, float]]] = []
    loads: set[float] = set()
    for result in unloading:
        again = result.load in loads
        require_alike(
            collected[0].pair, result.pair, "unloading", "; give the maps pressed alike",
            only_elastic=True,
        )  # fmt: skip
        if not pairs or again or not same_heights(pairs[-1], result.pair):
            loads.clear()
            if len(pairs) == len(collected):
                raise _stranger(len(pairs) + 1)
            pairs.append(result.pair)
            points.append([])
        loads.add(result.load)
        samples = collected[len(pairs) - 1]
        lowered = _lowered(samples, result.pair, len(pairs))
        point = _point(result, samples.window, lowered)
        if point.contact_points and point.pressure > 0:
            points[-1].append((point, _first_touch(result.pair, samples.window) - lowered))
    if pairs and len(pairs) < len(collected):
        raise InputError(
            f"has {len(pairs)} maps, and there are {len(collected)}: give all of them, or none",
            argument="unloading",
        )
    return points or [[] for _ in collected]


def _lowered(samples: _Samples, pair: Pair, number: int) -> float:
    """Return the mean depth by which the largest load of a map indented it inside its rim [m]."""
    depth = samples.pair.heights - pair.heights
    scale = float(np.nanmax(np.abs(samples.pair.heights)))
    if np.nanmin(depth) < -_ROUNDING * scale:
        raise _stranger(number)
    return float(np.nanmean(_inside(depth, samples.window)))


def _stranger(number: int) -> InputError:
    return InputError(
        f"map {number} is not map {number} of the contacts as its largest load left it: give the "
        "maps in their order, each from ", Mention("indented_surface"), argument="unloading",
    )  # fmt: skip


def _point(result: ContactResult, window: Window | None, lowered: float) -> LawPoint:
    """Return what one contact shows inside its rim."""
    pressure, gap = _inside(result.pressure, window), _inside(result.gap, window)
    contact = pressure > 0
    loading, whole = local_stiffness(result, window)
    axes = result.boundary.periodic_axes if window is None else ()
    return LawPoint(
        pressure=float(pressure.mean()),
        separation=float(np.nanmean(gap)) - lowered,
        mean_gap=float(np.nanmean(np.maximum(gap, 0))),
        contact_fraction=float(contact.mean()),
        saturated_fraction=float(_inside(result.saturated, window).mean()),
        # What has flowed before resists like all else.
        stiffness=whole if lowered else loading,
        unloading_stiffness=whole,
        spots=spots.find(np.ascontiguousarray(pressure), result.pair.pixel, axes).count,
        contact_points=int(contact.sum()),
        open_points=int(np.count_nonzero(~contact & ~np.isnan(gap))),
    )


def _inside(values: NDArray[Any], window: Window | None) -> NDArray[Any]:
    return values if window is None else values[window]


def _first_touch(pair: Pair, window: Window | None) -> float:
    """Return the separation at which the bodies first touch inside the rim [m]."""
    gap = _inside(pair.initial_gap, window)
    return float(np.nanmean(gap) - np.nanmin(gap))


def _law(samples: _Samples, number: int, all_of_them: Sequence[_Samples]) -> MapLaw:
    pair = samples.pair
    source = pair.surface.provenance.source
    alone = [one.pair.surface.provenance.source for one in all_of_them].count(source) == 1
    first = _first_touch(pair, samples.window)
    loading, after = (
        tuple(sorted((point for point, _ in points), key=lambda point: point.pressure))
        for points in (samples.points, samples.unloading)
    )
    return MapLaw(
        name=source if source and alone else f"{source or 'map'} {number}".strip(),
        pair=pair,
        window=samples.window,
        first_touch=first,
        unloading_touch=samples.unloading[0][1] if samples.unloading else first,
        loading=loading,
        unloading=after,
        **_spectrum(pair, samples.window),
    )


def _spectrum(pair: Pair, window: Window | None) -> dict[str, Array]:
    """Return wave numbers and variances of the gap for Persson's theory.

    What is inside a rim is no period: a window of Hann takes its edges down, at the same variance.
    """
    gap = np.array(_inside(pair.initial_gap, window), dtype=np.float64)
    if np.isnan(gap).any():
        return {"wave_numbers": np.empty(0), "variances": np.empty(0)}
    gap -= gap.mean()
    if window is not None:
        variance = gap.var()
        for axis in pair.boundary.free_axes:
            taper = np.hanning(gap.shape[axis] + 2)[1:-1]
            gap *= taper[:, None] if axis == 0 else taper
        gap -= gap.mean()
        gap *= math.sqrt(variance / gap.var())
    q, density, waves = spectrum.radial_spectrum(gap, pair.pixel)
    area = gap.size * pair.pixel_area
    return {"wave_numbers": q, "variances": density * waves / area}


def _check(result: ContactResult, first: ContactResult) -> None:
    """Refuse a map that has no law, or no part in that of the first."""
    pair, other = result.pair, first.pair
    pair.require_map(OF)
    if shape_of(pair) is not None:
        raise InputError(
            "are of curved bodies, and an interface law is one of nominally flat ones: take the "
            "form away, or leave the nominal bodies out",
            argument="contacts",
        )
    require_alike(
        other, pair, "contacts",
        "; contact and stiffness depend on all of them: give maps of one surface on one grid (",
        Mention("pixel"), "), pressed alike",
    )  # fmt: skip
    require_one_model(first.ceiling is None, result.ceiling is None)


def _judged(collected: Sequence[_Samples]) -> tuple[Caution, ...]:
    """Return the cautions of all contacts, one of each kind."""
    judged = sorted(
        (one for samples in collected for one in samples.judged), key=lambda told: told[0]
    )
    # That a flat body is loaded up to its edges is why a rim is left out.
    found = tuple(told for told in over_loads(judged, "N") if told.kind != Kind.EDGE)
    if collected[0].pair.counter_surface is not None:
        return found
    return (*found, law_judgment.SMOOTH)
