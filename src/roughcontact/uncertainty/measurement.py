"""Intervals of the quantities of a contact, from the measurement of its map.

`uncertainty`: two corrections of a quantity Q for the instrument, in logarithms.

A: Q of draws of the surface behind the map (`reconstruction.Reconstruction.draw`).
B: Q of the map, times Q of random surfaces over Q of their maps, measured by the same
instrument. Under a tip, estimates of the surfaces (`Reconstruction.simulate`) replace the maps. Of
worn surfaces, Q of draws over Q of their maps.

The center is ``w A + (1 - w) B`` with ``w = s_B²/(s_A² + s_B²)``, s the standard deviation of K
draws less the effects of their parameters. The half width is ``√(Σ h² + r² + 2 √(w (1 - w)) (A -
B)²)``: h is the change of A by the 95 % bound of a parameter, which both have in common, to either
side, and ``r² = t² (1 + 1/K) (w s_A² + (1 - w) s_B²)`` with t of Student at 95 %. Grid, remainder
of the method and material add in squares. The remainder decreases with the largest correction below
10 %: a perfect instrument gives the interval of the grid. Resolution, shape of the transfer, tip
radius, noise, exponent, level and shortest wave are drawn once per draw, each as K quantiles.

For a quantity of the surface rather than of the map, the scatter of the random surfaces, ``t s``,
adds; approach and largest pressure stay those of the map.

Grid: with f = Q for twice the points per side over Q, a factor ``f^1.5`` and a half width of
``ln f / 2``; for the largest pressure a factor f; for the stiffness no factor and a half width of
``2 ln f``. Material: by dimensional analysis ``S_E = n - S_p - S_lim``, with S the logarithmic
derivative with respect to load and ceiling and n the power of a pressure in Q.

Marks and edges: waves of draws have random phases, and those of the marks of a tool and of the
edges of craters have not. The correction is low by 0 to 60 % for surfaces with marks
(`Reconstruction.marks`), and by 0 to 40 % for skewed heights; not under a tip, which touches marks
and edges. The change of the mean gap due to valleys that it does not reach may be twice that of
random surfaces, and filled points may hide valleys as deep as their flanks continue.

Model: the removed form and the ceiling are choices. Their errors, added in squares, are the change
by the next form, and that by plasticity of the volume (`intervals.volume_plasticity`). The latter
is known for the contact area A; other quantities change by its ``S_lim(Q)/S_lim(A)``-fold.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.statistics import student
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.stiffness import constriction_length, contact_growth
from roughcontact.errors import ArgumentRef, InputError, Sentence, require_choice, require_count
from roughcontact.halfspace.fft import Workspace, limit_threads
from roughcontact.solvers.progress import Progress, Step, Tell
from roughcontact.surface import filters, resolution
from roughcontact.surface.form import level
from roughcontact.surface.grid import FILL
from roughcontact.surface.instrument import Instrument
from roughcontact.surface.random_surfaces import seed_of
from roughcontact.surface.surface import Surface
from roughcontact.uncertainty import reconstruction
from roughcontact.uncertainty.intervals import (
    Cause,
    ErrorSource,
    Interval,
    Uncertainty,
    volume_plasticity,
)
from roughcontact.uncertainty.reconstruction import Reconstruction
from roughcontact.units import Quantity, format_change, format_engineering, format_percent, to_si

Array = NDArray[np.float64]

CERTIFICATE = 1e-4
"""Certificate (tolerance) of the solve of a draw."""

# Relative standard uncertainty of the noise from a plateau of the spectrum.
_PLATEAU = 0.05

MAX_POINTS = 1 << 20
"""Maximum number of points of a draw: about 40 contacts of this size are solved."""

MAX_FILLED_SHARE = 0.1
"""Largest share of filled points of a map with intervals."""


class _Number(NamedTuple):
    """Quantity of a contact, and the remaining relative error of the method."""

    of: Callable[[ContactResult], float]
    remainder: float  # Half width of the remaining error
    pressure: int = 0  # Power of a pressure in the quantity
    grid: float = 1.5  # Power of the factor of the grid
    rest: float = 0.5  # Half width of the grid, as a power of the factor


def _floor(part: float, result: ContactResult) -> float:
    """Return a share of the map, at least half a pixel, since a logarithm follows."""
    return max(part, 0.5 / result.pressure.size)


NUMBERS: dict[str, _Number] = {
    "contact_fraction": _Number(
        lambda r: _floor(r.perimeter_corrected_area / r.nominal_area, r), 0.01
    ),
    "saturated_fraction": _Number(lambda r: _floor(r.saturated_fraction, r), 0.015),
    "mean_gap": _Number(lambda r: r.mean_gap, 0.02),
    "approach": _Number(lambda r: r.approach, 0.03),
    # With a ceiling, the stiffness is due to single pixels of the rim: its grid error is random.
    "stiffness": _Number(lambda r: contact_growth(r).stiffness, 0.02, 1, 0.0, 2.0),
    "constriction_length": _Number(constriction_length, 0.02),
    "mean_pressure": _Number(lambda r: r.load / r.perimeter_corrected_area, 0.01, 1),
    "max_pressure": _Number(lambda r: r.max_pressure, 0.1, 1, 1.0),
}
"""Quantities with an interval."""

SOURCES = {
    Cause.RESOLUTION: ("resolution",),
    Cause.TRANSFER: ("shape",),
    Cause.TIP: ("tip",),
    Cause.NOISE: ("noise",),
    Cause.SHORT_WAVES: ("exponent", "level"),
    Cause.SHORTEST_WAVE: ("waves",),
    Cause.OTHER_MAPS: ("finer resolution", "finer level"),
    Cause.SUMMITS: ("summits",),
}
"""Causes that vary between draws, each with its deviations."""


def uncertainty(
    result: ContactResult,
    instrument: Instrument | str | None = None,
    shortest_wave: Quantity | None = None,
    material: Mapping[str, float] | None = None,
    draws: int = 8,
    rng: int | np.random.Generator | None = 0,
    also: Sequence[Surface | tuple[Surface, Instrument | str]] = (),
    of: str = "map",
    progress: Tell = None,
) -> Uncertainty:
    """Return the intervals of a contact; see `ContactResult.uncertainty`."""
    if isinstance(instrument, str):
        instrument = Instrument.from_name(instrument)
    require_choice(("map", "surface"), of=of)
    for name, needs in (("also", bool(also)), ("of", of == "surface")):
        if needs and instrument is None:
            raise InputError("is needed with ", ArgumentRef(name), argument="instrument")
    wave = to_si(shortest_wave, "length", "shortest_wave")
    require_count(4, 1000, draws=draws)
    seed = seed_of(rng)
    known = _material(result, material)
    check(result)
    measured = _reconstruction(result, instrument, wave, also)
    if math.prod(measured.shape) > MAX_POINTS:
        part = _solve_central_part(result, measured)
        arguments = (instrument, shortest_wave, material, draws, seed, also, of, progress)
        return _rescale_intervals(uncertainty(part, *arguments), part, result)
    if instrument is not None:
        measured = _require_solvable(measured, result.surface)
    is_sample = of == "surface" and measured.has_rolloff
    study = _ContactDraws(result, measured, draws if instrument else 0, seed, is_sample)
    numbers = study.solve_draws(progress)
    intervals, closing = _intervals(study, numbers, known)
    remarks = (
        *_remarks(measured, instrument, wave, intervals),
        *((_NO_SAMPLE,) if of == "surface" and not is_sample else ()),
        *_seam_remark(result, measured),
        *_form_remark(study, numbers, intervals),
    )
    return Uncertainty(
        intervals,
        closing,
        instrument,
        wave,
        1 / measured.reach,
        draws,
        seed,
        remarks,
        Surface(study.base, measured.fine),
    )


def _material(result: ContactResult, material: Mapping[str, float] | None) -> dict[str, float]:
    known = {"E": 0.03, "yield": 0.05, **(material or {})}
    for name, value in known.items():
        if name not in ("E", "yield") or not 0 <= value < 1:
            raise InputError(
                f"must hold relative standard uncertainties of E and yield, got {name} = {value!r}",
                argument="material",
            )
    return known


def check(result: ContactResult) -> None:
    """Raise `InputError` for a contact without intervals."""
    pair = result.pair
    pair.require_map("an interval")
    if not (result.converged and result.load and result.contact_area):
        raise InputError("intervals need a converged contact under a load")
    refused = {
        "moments": result.moments is not None,
        "approach": result.control == "approach",
        "counter_surface": pair.counter_surface is not None,
        "ceiling": isinstance(result.ceiling, np.ndarray),
    }
    for argument, is_refused in refused.items():
        if is_refused:
            raise InputError("has no intervals; omit it", argument=argument)
    surface = result.surface
    if surface.missing:
        raise InputError(
            f"has missing points; intervals need a filled map: {ArgumentRef(FILL)}",
            argument="surface",
        )
    share = surface.provenance.filled_share(surface.heights.size)
    if share > MAX_FILLED_SHARE:
        raise InputError(
            f"has {format_percent(share)} filled points; intervals need at most "
            f"{format_percent(MAX_FILLED_SHARE)}",
            argument="surface",
        )


def _reconstruction(
    result: ContactResult,
    instrument: Instrument | None,
    wave: float | None,
    also: Sequence[Surface | tuple[Surface, Instrument | str]],
) -> Reconstruction:
    """Return the reconstruction of the map, with a perfect instrument if none is given."""
    surface, tool = result.surface, instrument or Instrument(resolution=0.0, u_resolution=0.0)
    # Without an instrument there is nothing to correct: the map is taken as solved.
    is_periodic = instrument is not None and result.boundary.periodic_axes == (0, 1)
    measured = _reconstruct(surface, tool, wave, is_periodic)
    if instrument is None:
        return measured
    reconstruction.require_octaves(measured)
    others = tuple(_other_map(item, wave) for item in also)
    measured = replace(measured, others=others)
    if others:
        reconstruction.require_one_surface(measured)
    least = min(max(maps.pixel) for maps in (measured, *others))
    if wave is not None and not wave >= least:
        raise InputError(
            f"must be at least one pixel = {format_engineering(least, 'm')}, got "
            f"{format_engineering(wave, 'm')}",
            argument="shortest_wave",
        )
    # Four points per shortest wave, or two if that needs more than four points per pixel.
    finest = (wave or 1 / measured.reach / reconstruction.UNKNOWN) / max(surface.pixel)
    if finest < 2:
        measured = replace(measured, finer=max(4, 2 ** math.ceil(math.log2(2 / finest))))
    return measured


def _require_solvable(measured: Reconstruction, surface: Surface) -> Reconstruction:
    """Return a reconstruction, with its wear if worn; raise `InputError` if unknown."""
    _require_unsmoothed(surface, measured.instrument, measured.shortest_wave)
    if measured.is_worn:
        if measured.hides_summits:
            raise InputError(
                "has summits smoother than its valleys, as worn surfaces have, and noise hides how "
                "smooth: measure with less noise",
                argument="surface",
            )
        measured = replace(measured, wear=measured.relative_roughness)
    _require_random(measured)
    return measured


def _solve_central_part(result: ContactResult, measured: Reconstruction) -> ContactResult:
    """Return the contact of the largest central part that can be drawn, as highly loaded."""
    surface, rows, columns = result.surface, *measured.shape
    factor = math.sqrt(MAX_POINTS / math.prod(measured.shape))
    counts = [2 * int(points * factor / 2) for points in surface.shape]
    parts = [
        ((points - count) // 2, (points + count) // 2)
        for points, count in zip(surface.shape, counts, strict=True)
    ]
    if result.boundary.periodic_axes != (0, 1) or has_nominal_body(result.pair.origins):
        crops = [step for step in surface.provenance.operations if step.method == "cropped"]
        text = ",".join(
            ":".join(str(end + sum(step.arguments[name][0] for step in crops)) for end in part)
            for name, part in zip(("rows", "columns"), parts, strict=True)
        )
        raise InputError(
            f"needs {rows} × {columns} points for intervals, the limit is {math.isqrt(MAX_POINTS)} "
            f"× {math.isqrt(MAX_POINTS)}: use ",
            ArgumentRef("crop", text),
            ", or give ",
            ArgumentRef("shortest_wave"),
            argument="surface",
        )
    part = surface.cropped(*parts)
    if measured.form:
        part = part.leveled(measured.form)
    terms = LoadCase(
        result.load * math.prod(part.size) / math.prod(surface.size),
        ceiling=result.ceiling,
        tolerance=result.tolerance,
    )
    return solve_pair(replace(result.pair, surface=part), terms)


def _rescale_intervals(
    known: Uncertainty, part: ContactResult, result: ContactResult
) -> Uncertainty:
    """Return the intervals of a contact from those of a part, by the ratio as measured."""
    intervals = []
    for item in known.intervals:
        number = NUMBERS[item.name]
        whole = number.of(result)
        value = item.value * whole / number.of(part)
        measured = result.contact_fraction if item.name == "contact_fraction" else whole
        intervals.append(replace(item, value=value, measured=measured))
    rows, columns = part.surface.shape
    remark = f"The corrections were determined on the central {rows} × {columns} points."
    return replace(known, intervals=tuple(intervals), remarks=(*known.remarks, remark))


def _other_map(
    item: Surface | tuple[Surface, Instrument | str], wave: float | None
) -> Reconstruction:
    """Return another map of the surface, with its instrument."""
    surface, tool = item if isinstance(item, tuple) else (item, Instrument.from_map(item))
    if surface.missing:
        raise InputError("has missing points; fill them first", argument="also")
    tool = Instrument.from_name(tool) if isinstance(tool, str) else tool
    return _reconstruct(surface, tool, wave)


def _reconstruct(
    surface: Surface, tool: Instrument, wave: float | None, is_periodic: bool = False
) -> Reconstruction:
    leveled = (
        step.arguments["form"] for step in surface.provenance.operations if step.method == "leveled"
    )
    forms = [form for form in leveled if form in ("plane", "quadric")]
    form = forms[-1] if forms else None
    # Edges that match but for a plane are those of a periodic surface.
    closed = reconstruction.close_edges(surface.heights)
    is_closed = is_periodic and form == "plane" and not reconstruction.has_seam(closed)
    return Reconstruction(
        closed if is_closed else reconstruction.periodic_part(surface.heights),
        surface.pixel,
        _with_plateau(tool, surface),
        wave,
        surface._filled,
        form,
        is_closed=is_closed,
    )


def _with_plateau(tool: Instrument, surface: Surface) -> Instrument:
    """Return an instrument with the noise of the spectrum, if close to the given noise."""
    seen = resolution.noise_height(surface.heights, surface.pixel)
    if not tool.noise / 2 < seen < 2 * tool.noise:
        return tool
    return replace(tool, noise=seen, u_noise=min(tool.u_noise, _PLATEAU))


def _require_unsmoothed(surface: Surface, tool: Instrument, wave: float | None) -> None:
    """Raise `InputError` for a map that is smoother than its instrument."""
    cutoff = resolution.smoothing_cutoff(surface.heights, surface.pixel) or 0.0
    if tool.kind != "tip" and cutoff > 2 * max(tool.resolution, wave or 0.0) > 0:
        raise InputError(
            f"holds hardly any waves below {format_engineering(cutoff, 'm')}, though its "
            "instrument "
            f"resolves {format_engineering(tool.resolution, 'm')}: it was smoothed. Give the true "
            f"resolution, or {ArgumentRef('shortest_wave')} of a surface that is so smooth",
            argument="surface",
        )


def _require_random(measured: Reconstruction) -> None:
    """Raise `InputError` for a map with structures that random surfaces do not have."""
    skewness, kurtosis = measured.structure
    # Wear skews heights as well; its draws have the heights of the map, as those under a tip.
    has_heights = measured.wear or measured.instrument.tip_radius
    if not (has_heights or _MIN_SKEWNESS <= skewness) or skewness > _MAX_SKEWNESS:
        raise InputError(
            f"has skewed heights (Ssk {skewness:.2g}), as structured surfaces have: its waves "
            "below the resolution are not random; measure finer, and omit ",
            ArgumentRef("uncertainty"),
            argument="surface",
        )
    if kurtosis > _PEAKED:
        raise InputError(
            f"has peaks or pits among its shortest waves (kurtosis {kurtosis:.2g}, of random ones "
            "3): remove outliers, or measure finer",
            argument="surface",
        )


# Range of the skewness of the heights, and maximum kurtosis of the shortest waves. Intervals
# covered three measured maps with up to -0.6 and 7, but neither tracks of a disc (1.3 and 4) nor a
# face with particles (-0.5 and 96); they covered a map with a pit (-0.2 and 51), which is rejected
# as well. Without the limits, they held 9 of 13 values of the disc, 11 of 40 of maps with a
# kurtosis of 17 to 22, and 39 of 40 of maps with 10.6 to 11.7.
_MIN_SKEWNESS, _MAX_SKEWNESS, _PEAKED = -2.0, 1.0, 10.0


class _ContactDraws:
    """Draws of the surface of a contact, and the solves of their contacts."""

    def __init__(
        self, result: ContactResult, measured: Reconstruction, draws: int, seed: int, sampled: bool
    ) -> None:
        self.sampled = sampled
        self.result, self.measured, self.draws, self.seed = result, measured, draws, seed
        self.smooth = np.zeros(measured.shape)
        self.map = filters.resample(measured.heights, measured.shape)
        self.estimate: Callable[[Array], Array] = partial(filters.resample, shape=measured.shape)
        if draws and measured.instrument.tip_radius:
            invert = measured.simulate({}, seed)[2]
            self.estimate = lambda part: invert(part)[0]
        # A periodic surface has no step between its edges: leveling caused the step.
        is_split = measured.heights is not result.surface.heights
        if is_split and not (result.boundary.periodic_axes and measured.form):
            rest = result.surface.heights - measured.heights
            self.smooth = filters.resample(rest, measured.shape, "spline")
        tool = measured.instrument
        active = {
            Cause.RESOLUTION: tool.resolution * tool.u_resolution,
            Cause.TRANSFER: tool.u_shape,
            Cause.TIP: tool.tip_radius * tool.u_tip_radius,
            Cause.NOISE: tool.noise * tool.u_noise,
            Cause.SHORT_WAVES: measured.reach < 1 / (measured.shortest_wave or 1e-300),
            Cause.SHORTEST_WAVE: measured.shortest_wave is None,
            Cause.OTHER_MAPS: bool(measured.others),
            Cause.SUMMITS: measured.wear is not None,
        }
        self.sources = [cause for cause in SOURCES if active[cause]] if draws else []
        names = [name for source in self.sources for name in SOURCES[source]]
        strata = _stratified_normals(len(names), draws, np.random.default_rng(seed))
        self.deviations = [dict(zip(names, row, strict=True)) for row in strata]

    def solve_draws(self, progress: Tell) -> dict[Any, Array]:
        """Return the logarithms of all quantities of each contact, by the name of the contact."""
        jobs = self._jobs()
        found: dict[Any, Array] = {}
        done = itertools.count(1)

        def solve(name: Any) -> None:
            with limit_threads(1):
                for key, contact in jobs[name]():
                    found[key] = np.log(_numbers(contact))
            if callable(progress):
                last = contact.pair.shape, contact.iterations, contact.convolutions
                step = Step(*last, contact.certificate, contact.tolerance)
                progress(Progress(next(done), len(jobs), step, "uncertainty"))

        Workspace().each(solve, jobs)
        return found

    @cached_property
    def base(self) -> Array:
        """Corrected map: a draw with the given values of the instrument [m]."""
        return self._draw_map({}, self.seed)[0] + self.smooth

    def _jobs(self) -> dict[Any, Callable[[], Any]]:
        result, (ny, nx) = self.result, self.measured.shape

        def draw(k: int) -> Any:
            # Seeds of different draws are independent.
            drawn, twin, image = self._draw_map(self.deviations[k], self.seed + 1 + k)
            yield ("draw", k), self._solve_heights(drawn + self.smooth)
            yield ("twin", k), self._solve_heights(twin)
            # On the same grid, so that its error cancels.
            rest = self.smooth if self.measured.wear else 0.0
            yield ("image", k), self._solve_heights(self.estimate(image) + rest)

        def moved(source: Cause) -> Any:
            for name, sign in itertools.product(SOURCES[source], (-1, 1)):
                drawn = self._draw_map({name: sign * _NORMAL}, self.seed)[0]
                yield (name, sign), self._solve_heights(drawn + self.smooth)

        def base() -> Any:
            yield "base", self._solve_heights(self.base)

        def deeper() -> Any:
            yield "deeper", self._solve_heights(self.base - self.measured.hidden_depth)

        def finer() -> Any:
            heights = filters.resample(self.base, (2 * ny, 2 * nx), self._method)
            yield "finer", self._solve_heights(heights)

        def loaded() -> Any:
            yield "load", self._solve_heights(result.surface.heights, load=_STEP)

        def yielding() -> Any:
            yield "ceiling", self._solve_heights(result.surface.heights, ceiling=_STEP)

        def leveled() -> Any:
            yield "form", self._solve_heights(level(result.surface.heights, self.next_form))

        def measured() -> Any:
            yield "map", self._solve_heights(self.map + self.smooth)
            if self.measured.instrument.tip_radius:
                known = self.estimate(self.measured.heights)
                yield "estimate", self._solve_heights(known + self.smooth)
            yield "measured", result

        jobs: dict[Any, Callable[[], Any]] = {"finer": finer, "base": base}
        jobs |= {("draw", k): partial(draw, k) for k in range(self.draws)}
        jobs |= {source: partial(moved, source) for source in self.sources}
        jobs |= {"load": loaded, "measured": measured}
        if self.draws and self.next_form:
            jobs["form"] = leveled
        if self.draws and self.measured.instrument.tip_radius:
            jobs["deeper"] = deeper
        return jobs if result.ceiling is None else {**jobs, "ceiling": yielding}

    @cached_property
    def missing_correction(self) -> float:
        """Largest share of the correction that random surfaces lack for marks and edges.

        Of worn surfaces, marks are valleys that a flat does not touch. A tip shows the places that
        it touches: marks and edges as well.
        """
        if self.measured.wear or self.measured.instrument.tip_radius:
            return 0.0
        marks = min(self.measured.marks / _FULL_MARKS, 1.0)
        skewness = abs(self.measured.structure[0])
        edges = min(max(skewness / _GAUSSIAN - 1, 0.0), 1.0)
        return max(_MISSING_OF_MARKS * marks, _MISSING_OF_EDGES * edges)

    @property
    def next_form(self) -> str:
        """Form of the next degree after the leveled form; empty after the last."""
        return {None: "plane", "plane": "quadric"}.get(self.measured.form, "")

    @property
    def _method(self) -> str:
        return "bandlimited" if not self.smooth.any() else "spline"

    def _draw_map(self, deviations: Mapping[str, float], seed: int) -> tuple[Array, Array, Array]:
        if not self.draws:
            return self.map, self.map, self.map
        return self.measured.draw(deviations, seed)

    def _solve_heights(
        self, heights: Array, load: float = 1.0, ceiling: float = 1.0
    ) -> ContactResult:
        """Return the contact of other heights on a map of the same size."""
        result = self.result
        edges = [side / n for side, n in zip(result.surface.size, heights.shape, strict=True)]
        pair = replace(result.pair, surface=Surface(heights, (edges[0], edges[1])))
        top = None if result.ceiling is None else float(result.ceiling) * ceiling
        terms = LoadCase(result.load * load, ceiling=top, tolerance=CERTIFICATE)
        return solve_pair(pair, terms, workers=1)


_STEP = 1.05


def _numbers(result: ContactResult) -> Array:
    return np.array([number.of(result) for number in NUMBERS.values()])


def _stratified_normals(columns: int, rows: int, rng: np.random.Generator) -> Array:
    """Return columns of equal standard normal quantiles, each in a random order."""
    inverse = NormalDist().inv_cdf
    quantiles = np.array([inverse((row + 0.5) / rows) for row in range(rows)])
    if rows:
        quantiles /= quantiles.std(ddof=1)
    return rng.permuted(np.tile(quantiles, (columns, 1)), axis=1).T


def _intervals(
    study: _ContactDraws, numbers: Mapping[Any, Array], known: Mapping[str, float]
) -> tuple[tuple[Interval, ...], dict[str, float]]:
    """Return the intervals, and the closure of the variances of the sources, by quantity."""
    result, measured = study.result, np.exp(numbers["measured"])
    # A step between the edges of a periodic map has the same effect as an edge.
    at_edge = result.ceiling is None and (
        result.totals.edge_load is not None
        or bool(result.boundary.periodic_axes and study.smooth.any())
    )
    columns = {
        name: {key: float(value[index]) for key, value in numbers.items()}
        for index, name in enumerate(NUMBERS)
        if not (name == "saturated_fraction" and not result.saturated_fraction)
        and not (name == "max_pressure" and at_edge)
    }
    columns = {
        name: column for name, column in columns.items() if all(map(math.isfinite, column.values()))
    }
    corrected = {name: _combine_draws(study, name, column) for name, column in columns.items()}
    # Without a correction, the method has no error.
    shifts = [abs(corrected[name][0] - column["map"]) for name, column in columns.items()]
    part = min(max(shifts, default=0.0) / _FULL_CORRECTION, 1.0)
    area = _derivative(columns.get("contact_fraction", {}), "ceiling")
    as_measured = dict(zip(NUMBERS, map(float, measured), strict=True))
    # The area of the headline includes the excess of the rim, the corrected area does not.
    as_measured["contact_fraction"] = result.contact_fraction
    intervals = tuple(
        Interval(
            name,
            *_corrected_interval(study, name, column, corrected[name], part, known, area),
            as_measured[name],
        )
        for name, column in columns.items()
    )
    return intervals, {name: closing for name, (_, _, closing) in corrected.items()}


def _derivative(values: Mapping[Any, float], key: str) -> float:
    """Return the logarithmic derivative of a quantity with respect to load or ceiling."""
    return (values[key] - values["measured"]) / math.log(_STEP) if key in values else 0.0


def _corrected_interval(
    study: _ContactDraws,
    name: str,
    values: Mapping[Any, float],
    corrected: tuple[float, Mapping[Cause, float], float],
    part: float,
    known: Mapping[str, float],
    area_by_ceiling: float,
) -> tuple[float, tuple[ErrorSource, ...]]:
    """Return a corrected quantity and its error sources."""
    center, squares = corrected[0], dict(corrected[1])
    # Marks and edges have a larger correction than random surfaces.
    missing = study.missing_correction * (center - values["map"]) / 2
    center += missing
    number = NUMBERS[name]
    factor = values["finer"] - values["base"]
    center += number.grid * factor
    squares[Cause.GRID] = (number.rest * factor) ** 2
    saturated = name == "max_pressure" and study.result.saturated_fraction > 0
    is_area = name in ("contact_fraction", "mean_pressure")
    is_elastic_tip = study.measured.instrument.tip_radius and study.result.ceiling is None
    wider = _ELASTIC_AREA if is_area and is_elastic_tip else 1.0
    squares = {key: wider**2 * square for key, square in squares.items()}
    squares[Cause.MARKS] = missing**2
    if study.draws and not saturated:
        squares[Cause.METHOD] = (part * number.remainder) ** 2
    by_load, by_ceiling = (_derivative(values, key) for key in ("load", "ceiling"))
    squares[Cause.YOUNG] = (_NORMAL * known["E"] * (number.pressure - by_load - by_ceiling)) ** 2
    squares[Cause.YIELD] = (_NORMAL * known["yield"] * by_ceiling) ** 2
    halves = {cause: math.sqrt(square) for cause, square in squares.items() if square}
    doubts = (
        *(_source_error(cause, values, wider) for cause in study.sources),
        *(
            ErrorSource(cause, math.expm1(-half), math.expm1(half))
            for cause, half in halves.items()
        ),
        *_hidden_valleys(values, corrected[0] - values["map"] if name == "mean_gap" else 0.0),
        *_model_sources(study, values, area_by_ceiling, by_ceiling),
    )
    return min(math.exp(center), 1.0 if name.endswith("fraction") else math.inf), doubts


def _source_error(cause: Cause, values: Mapping[Any, float], wider: float) -> ErrorSource:
    """Return the error due to parameters of a source: the changes by their 95 % bounds, widened."""
    down = up = 0.0
    for name in SOURCES[cause]:
        changes = [values[name, sign] - values["base"] for sign in (-1, 1)]
        small, large = sorted(changes, key=abs)
        # Of two changes with the same sign, the smaller one is random: it may have either sign.
        ends = (large, small) if large < 0 else (small, large)
        down, up = math.hypot(down, ends[0]), math.hypot(up, ends[1])
    return ErrorSource(cause, math.expm1(-wider * down), math.expm1(wider * up))


def _model_sources(
    study: _ContactDraws, values: Mapping[Any, float], area_by_ceiling: float, by_ceiling: float
) -> Iterator[ErrorSource]:
    """Yield the errors of the removed form, and of the ceiling as a model of plasticity.

    ``by_ceiling`` is the logarithmic derivative of the quantity with respect to the ceiling. It
    converts the error of the contact area to an error of the quantity.
    """
    if "form" in values:
        yield _one_sided(Cause.FORM, values["form"] - values["measured"])
    volume = volume_plasticity("contact_fraction", study.result)
    if volume is None or not volume.known or not area_by_ceiling:
        return
    ends = [math.log1p(end) * by_ceiling / area_by_ceiling for end in (volume.low, volume.high)]
    if any(ends):
        yield ErrorSource(Cause.YIELDING, math.expm1(min(ends)), math.expm1(max(ends)))


def _hidden_valleys(values: Mapping[Any, float], shift: float) -> Iterator[ErrorSource]:
    """Yield the error due to valleys that a tip did not show.

    Those between the flanks of filled points may be as deep as these flanks continue. Those that it
    did not reach may be as much deeper than those of random surfaces as these are than the image:
    the mean gap may have the shift by its correction twice.
    """
    if "deeper" in values:
        yield _one_sided(Cause.VALLEYS, values["deeper"] - values["base"] + shift)


def _one_sided(cause: Cause, change: float) -> ErrorSource:
    """Return the error source of a change, given as a logarithm, that may be right or not."""
    return ErrorSource(cause, math.expm1(min(change, 0.0)), math.expm1(max(change, 0.0)))


_NORMAL = NormalDist().inv_cdf(0.975)

# Missing shares of the correction of marks and edges; share of marks in the squared slope from
# which it is missing in full; skewness of Gaussian heights, half of that of edges.
_MISSING_OF_MARKS, _MISSING_OF_EDGES, _FULL_MARKS, _GAUSSIAN = 0.6, 0.4, 0.2, 0.3

# Factor of half widths of the elastic contact area under a tip, from 96 surfaces.
_ELASTIC_AREA = 1.25

# Correction, as a logarithm, from which the remaining error of the method applies in full.
_FULL_CORRECTION = 0.1


def _combine_draws(
    study: _ContactDraws, name: str, values: Mapping[Any, float]
) -> tuple[float, dict[Cause, float], float]:
    """Return the combined center, squared half widths by cause, and variance closure."""
    count = study.draws
    if not count:
        return values["base"], {}, math.nan
    drawn, twin, image = (
        np.array([values[key, k] for k in range(count)]) for key in ("draw", "twin", "image")
    )
    bracket = (drawn if study.measured.wear else twin) - image
    estimate = values.get("estimate", values["map"])
    first, second = float(drawn.mean()), estimate + float(bracket.mean())
    # Regression of the draws on their deviations; the rest is random.
    moves = {
        key: (values[key, 1] - values[key, -1]) / (2 * _NORMAL)
        for source in study.sources
        for key in SOURCES[source]
    }
    shared = np.array([sum(moves[key] * row[key] for key in moves) for row in study.deviations])
    # The instrument has the same error in both corrections; their random parts are independent.
    chance, scatter = (float(np.var(part - shared, ddof=1)) for part in (drawn, bracket))
    weight = scatter / (chance + scatter) if scatter else 1.0
    factor = student(count - 1) ** 2 * (1 + 1 / count)
    squares = {Cause.CHANCE: factor * (weight * chance + (1 - weight) * scatter)}
    if study.sampled and name not in _EXTREMES:
        sample = float(np.var(twin - shared, ddof=1))
        squares[Cause.SAMPLE] = student(count - 1) ** 2 * sample
    squares[Cause.CORRECTIONS] = 2 * math.sqrt(weight * (1 - weight)) * (first - second) ** 2
    spread = float(np.var(drawn, ddof=1))
    closing = (sum(move**2 for move in moves.values()) + chance) / spread if spread else 1.0
    return weight * first + (1 - weight) * second, squares, closing


# Quantities without the scatter between samples: extremes increase with the size of the surface.
_EXTREMES = ("approach", "max_pressure")

_NO_SAMPLE = (
    "The intervals are of this place: the waves of the map grow up to the length of its side, so "
    "it is not a sample of the surface."
)


# Share of the difference of the corrections if it equals two half widths of either.
_DISAGREEING = 0.8


def _remarks(
    measured: Reconstruction,
    instrument: Instrument | None,
    wave: float | None,
    intervals: Sequence[Interval],
) -> Iterator[str]:
    """Yield the remarks on the limits of the intervals."""
    if instrument is None:
        yield Sentence(
            "The intervals include only the grid and the material. Give ",
            ArgumentRef("instrument"),
            " to include the measurement.",
        )
        return
    resolved = 1 / measured.reach
    if wave is None:
        yield Sentence(
            f"The intervals assume that the shortest wave of the surface is between "
            f"{format_engineering(resolved, 'm', 2)}, which the map shows, and "
            f"{format_engineering(resolved / reconstruction.UNKNOWN, 'm', 2)}; give ",
            ArgumentRef("shortest_wave"),
            ".",
        )
    if instrument.name.startswith("estimated"):
        yield "The noise was estimated from the map. It is a lower bound."
    elif not instrument.noise:
        yield Sentence("The noise was taken as zero. Give ", ArgumentRef("noise"), ".")
    if any(item.budget.get(Cause.CORRECTIONS, 0.0) > _DISAGREEING for item in intervals):
        yield "The two ways of correcting the map disagree. Do not use the intervals."
    if instrument.tip_radius:
        yield "Valleys that the tip did not reach are not known. The mean gap is uncertain."


def _seam_remark(result: ContactResult, measured: Reconstruction) -> Iterator[str]:
    """Yield the remark on different opposite edges of a periodic map."""
    surface = result.surface
    step = float(np.std(surface.heights - measured.heights))
    if result.boundary.periodic_axes and measured.form and step > _STEPPED * surface.Sq:
        # Free edges are no remedy: their message recommends the periodic boundary.
        yield (
            "Opposite edges of the map do not match, so the periodic map has a step there. Remove "
            "the form, or measure a larger map."
        )


# Standard deviation of the removed part over that of the heights.
_STEPPED = 0.2


def _form_remark(
    study: _ContactDraws, numbers: Mapping[Any, Array], intervals: Sequence[Interval]
) -> Iterator[str]:
    """Yield the remark on the changes of the next form, which the intervals include."""
    if "form" not in numbers:
        return
    change = dict(zip(NUMBERS, np.expm1(numbers["form"] - numbers["measured"]), strict=True))
    changes = [
        f"{_NAMES[item.name]} {format_change(change[item.name])}"
        for item in intervals
        if item.name in _NAMES
    ]
    if changes:
        yield f"The intervals include leveling a {study.next_form}: {', '.join(changes)}."


_NAMES = {"contact_fraction": "contact area", "mean_gap": "mean gap", "approach": "approach"}
