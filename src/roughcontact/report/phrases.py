"""Short texts for bodies, loads, materials, hardening laws, ceilings and progress."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact._tools.statistics import Mean
from roughcontact.contact import load_case
from roughcontact.contact.ceiling import CEILING_TOLERANCE
from roughcontact.contact.nominal_hertz import has_nominal_body, shape_of
from roughcontact.contact.result import MIN_SHOWN_CHANGE, ContactResult, Regime
from roughcontact.material.hardening import Kinematic, Linear, Perfect, Swift, Tabulated
from roughcontact.material.material import RIGID, Material, softer_material
from roughcontact.solvers.progress import Progress, Step
from roughcontact.surface.provenance import Provenance
from roughcontact.units import (
    format_change,
    format_engineering,
    format_percent,
    group_digits,
    join_ends,
    order_of_magnitude,
)

if TYPE_CHECKING:
    from roughcontact.contact.result import CalibrationRecord
    from roughcontact.elastoplastic.increments import IterationInfo
    from roughcontact.elastoplastic.volume_result import ElastoplasticResult


def progress_text(state: Progress) -> str:
    """Return the state of a solver in one line."""
    part = f"{state.number} of {state.count}: " if state.count > 1 else ""
    label = f"{state.label}: " if state.label else ""
    if state.kept:
        return f"{label}{part}from an earlier run"
    if state.step is None:
        return f"{label}{part}".removesuffix(": ")
    text = _step(state.step) if isinstance(state.step, Step) else _iteration_text(state.step)
    return f"{label}{part}{text}"


def _step(step: Step) -> str:
    ny, nx = step.shape
    return (
        f"solving {ny} × {nx}: {step.convolutions} convolutions, "
        f"certificate {step.certificate:.1e}, target {step.tolerance:.0e}"
    )


def _iteration_text(look: IterationInfo) -> str:
    load = units.format_engineering(look.load, "N")
    return f"at {load}: iteration {look.iteration}, residual {look.residual:.1e}"


def ceiling(result: ContactResult) -> str:
    """Return the ceiling of a result and its source, without a full stop."""
    both = (result.material, result.counter_material)
    return ceiling_text(result.ceiling, *both, agreed=result.calibration)


def ceiling_text(
    ceiling: float | NDArray[np.float64] | str | None,
    material: Material,
    counter_material: Material,
    agreed: CalibrationRecord | None = None,
) -> str:
    """Return the ceiling of two bodies and its source, in the format of `ceiling`."""
    if isinstance(ceiling, str):
        return "calibrated, by map and load"
    if ceiling is None:
        known = softer_material(material.uncoated, counter_material.uncoated) is not None
        return "none: purely elastic" + ("" if known else ", no yield strength is given")
    if isinstance(ceiling, np.ndarray):
        low, high = float(ceiling.min()), float(ceiling.max())
        return f"given point by point, {format_engineering(low, 'Pa')} to " + (
            format_engineering(high, "Pa") if math.isfinite(high) else "none"
        )
    text = format_engineering(float(ceiling), "Pa")
    body = softer_material(material, counter_material)
    if body is None or body.ceiling is None:
        return f"{text}, as given"
    automatic = agreed is None and math.isclose(float(ceiling), body.ceiling, rel_tol=1e-9)
    ceilings = {material.ceiling, counter_material.ceiling} - {None}
    whose = "" if len(ceilings) == 1 else " of the softer body"
    if body.yield_strength is None:
        if automatic:
            return f"{text}, the hardness{whose}"
        return f"{text}, as given: {float(ceiling) / body.ceiling:.3g} times the hardness{whose}"
    if automatic:
        return f"{text}, three times the yield strength{whose}"
    if agreed is not None:
        return f"{text}, {ceiling_method(agreed)}"
    factor = float(ceiling) / body.yield_strength
    return f"{text}, as given: {factor:.3g} times the yield strength{whose}"


def largest_pressure(result: ContactResult) -> str:
    """Return the largest pressure as text, with a remark if it is the ceiling."""
    value = format_engineering(result.max_pressure, "Pa")
    return f"{value}, the ceiling" if result.saturated_fraction else value


def source(provenance: Provenance) -> str:
    """Return the name of a map."""
    source = provenance.source or "surface"
    return f"the {source}" if source.startswith(("nominal", "surface")) else source


def load_phrase(result: ContactResult) -> str:
    """Return the load or approach of a result as the end of a question."""
    if result.control == "approach":
        return f"at an approach of {format_engineering(result.approach, 'm')}"
    specified = result.specified_load
    if specified is None:
        if result.pair.is_profile:
            return f"under {_line_load(result.load)}"
        return f"under {format_engineering(result.total_load, result.pair.load_unit)}"
    value = _form(specified.form)
    if isinstance(specified.form, load_case.NominalPressure):
        return f"at {value}"
    if isinstance(specified.form, load_case.HertzPressure):
        return f"at a Hertz pressure of {value}"
    return f"under {value}"


def span(texts: Sequence[str]) -> str:
    """Return the first and the last of several values with units."""
    first, last = texts[0], texts[-1]
    return first if first == last else f"{first} to {last}"


def _has_pressure(contact: ContactResult) -> bool:
    """Return whether the load was given as a nominal pressure."""
    specified = contact.specified_load
    return specified is not None and isinstance(specified.form, load_case.NominalPressure)


def load_range(result: Any) -> str:
    """Return the loads of several contacts as the end of a question."""
    contact = result.largest
    if _has_pressure(contact):
        area = contact.nominal_area
        ends = [format_engineering(step.load / area, "Pa", 3) for step in result.steps]
        return f"at {span(ends)}"
    return f"under {span([_force_on_bodies(contact, step.load) for step in result.steps])}"


def given_load(specified: load_case.GivenLoad, result: ContactResult) -> str:
    """Return a load in its given form, with the resulting force."""
    force = format_engineering(specified.force, result.pair.load_unit)
    words = f"{load_case.NAMES[type(specified.form)]}: {_form(specified.form)}"
    if isinstance(specified.form, load_case.NominalPressure):
        what, unit = ("profile", "m") if result.pair.is_profile else ("map", "m²")
        area = format_engineering(result.nominal_area, unit)
        return f"{words} on the whole {what}, {area}, are {force}"
    smooth = result.hertz
    match specified.form:
        case load_case.LineLoad() if smooth is not None and smooth.length is not None:
            return (
                f"{words} on {format_engineering(smooth.length, 'm')}, the length of the map, are "
                f"{force}"
            )
        case load_case.HertzPressure() if smooth is not None:
            line = ""
            if smooth.length is not None and not result.pair.is_profile:
                line = f", {_line_load(specified.force / smooth.length)}"
            return f"{words} of the smooth bodies ({smooth.shape.kind}), under {force}{line}"
    return f"{words}, {force}"


def given_loads(specified: Sequence[load_case.GivenLoad], unit: str = "N") -> str:
    """Return several loads in their given forms, with the resulting forces [``unit``]."""
    parts = []
    for form, group in groupby(dict.fromkeys(specified), lambda item: type(item.form)):
        values = [f"{_form(item.form)} ({format_engineering(item.force, unit)})" for item in group]
        text = ", ".join(values) if len(values) <= _FEW_LOADS else f"{values[0]} to {values[-1]}"
        parts.append(f"{load_case.NAMES[form]} {text}")
    return "; ".join(parts)


def _form(form: load_case.NominalPressure | load_case.LineLoad | load_case.HertzPressure) -> str:
    if isinstance(form, load_case.LineLoad):
        return _line_load(form.value)
    return format_engineering(form.value, "Pa")


def _line_load(value: float) -> str:
    # N/mm is the usual unit of line loads.
    return f"{format_engineering(value / 1e3, 'N')}/mm"


# Largest number of loads of one form that are listed separately.
_FEW_LOADS = 4


def ceiling_method(result: CalibrationRecord) -> str:
    """Return the method of a self-consistent ceiling as text."""
    if math.isnan(result.mismatch):
        return f"{result.factor:.3g} yield strengths, not calibrated"
    times = float(f"{result.load_ratio:.2g}")
    text = f"calibrated: {result.factor:.3g} yield strengths at {times:g} times first yield"
    if abs(result.mismatch) > CEILING_TOLERANCE:
        text += f", where its own solution gives {format_change(result.mismatch)}"
    return text


def under_other_ceiling(result: ContactResult) -> str:
    """Return contact and gap under the second ceiling; empty without a noticeable difference."""
    known, other = result.calibration, result.calibrated
    if known is not None:
        is_equal = abs(known.usual_contact_area / result.contact_area - 1) <= MIN_SHOWN_CHANGE
        return "" if is_equal else f"With three yield strengths: {with_usual_ceiling(result)}"
    if other is None or not other.differs:
        return ""
    area = format_change(other.contact_fraction / result.contact_fraction - 1)
    gap = format_change(other.mean_gap / result.mean_gap - 1) if result.mean_gap else "0 %"
    ceiling = f"Calibrated ceiling ({other.factor:.3g} σ_Y)"
    if other.is_of_base:
        ceiling = f"Ceiling of the base ({format_engineering(other.ceiling, 'Pa', 3)})"
    return (
        f"{ceiling}: contact {format_share(other.contact_fraction)} ({area}), mean gap "
        f"{format_short(other.mean_gap, 'm')} ({gap})"
    )


def ceiling_heads(first: Any, other: Any) -> tuple[str, str]:
    """Return the heads of two columns under the two ceilings of contacts or estimates."""
    if getattr(other, "is_of_base", False):
        return "ceiling of the coating", "of the base"
    names = ("ceiling", "calibrated")
    names = names[::-1] if getattr(first, "calibration", None) else names
    one, two = (
        f"{name} {format_engineering(float(np.max(item.ceiling or 0)), 'Pa', 3)}"
        for name, item in zip(names, (first, other), strict=True)
    )
    return one, two


def with_range(value: float, other: float | None, form: Callable[[float], str]) -> str:
    """Return a value as text, with the range to its value under the second ceiling."""
    text = form(value)
    if other is None or form(other) == text:
        return text
    low, high = sorted((value, other))
    return f"{text} ({range_text(low, high, form)})"


def with_usual_ceiling(result: ContactResult) -> str:
    """Return the quantities under the ceiling of three yield strengths, for comparison."""
    answer = result.calibration
    assert answer is not None
    text = (
        ("contact area", answer.usual_contact_area, result.contact_area, "m²"),
        ("approach", answer.usual_approach, result.approach, "m"),
        ("indentation", answer.usual_indentation, float(result.residual_indentation.max()), "m"),
    )
    parts = []
    for name, usual, now, unit in text:
        change = f" ({format_change(usual / now - 1)})" if now else ""
        parts.append(f"{name} {format_engineering(usual, unit) if usual else 'none'}{change}")
    return ", ".join(parts)


def hardening(body: Material) -> str:
    """Return the hardening of a material as text."""
    if is_rigid(body):
        return "rigid"
    if body.yield_strength is None:
        return "elastic"
    law = body.law
    if isinstance(law, Kinematic):
        back = f"kinematic hardening, modulus {format_engineering(law.modulus, 'Pa')}"
        if isinstance(law.isotropic, Perfect):
            return back
        return f"{hardening(replace(body, hardening=law.isotropic))}, and {back}"
    if isinstance(law, Linear):
        return f"linear hardening, modulus {format_engineering(law.modulus, 'Pa')}"
    if isinstance(law, Swift):
        strength = format_engineering(law.coefficient, "Pa")
        text = f"Swift hardening, {strength} ({law.offset:g} + 1e6 e)^{law.exponent:.3g}"
        return text if body.hardening is not None else f"{text}, from yield strength and hardness"
    if isinstance(law, Tabulated):
        last = format_engineering(law.stress[-1], "Pa")
        return f"tabulated hardening, {last} from a strain of {law.strain[-1]:g} on"
    return "perfectly plastic"


def coating(body: Material) -> str:
    """Return the layers of a body, the outermost first."""
    return "; ".join(
        f"{layer.name or 'layer'} {format_engineering(layer.thickness, 'm')} "
        f"(E {format_engineering(layer.young, 'Pa')}, ν {layer.poisson:g})"
        for layer in body.coating
    )


def is_rigid(body: Material) -> bool:
    """Return whether a material is rigid."""
    return body.young == RIGID.young


def step_error(result: ElastoplasticResult) -> str:
    """Return the error of the finite load steps of the volume model."""
    error = result.step_error
    if error is None:
        return "not estimated: the increments were given"
    return f"about {100 * error:.2g} % of approach and contact area" if error else "none"


def regime(result: ContactResult, *, in_layers: bool = False) -> str:
    """Return the regime of a result as a sentence with its numbers.

    Empty for a coated body if a stress result already gives the yielding ``in_layers``.
    """
    largest = format_engineering(result.max_pressure, "Pa", 3)
    name = result.regime
    if name is Regime.SATURATED:
        share = format_percent(result.saturated_fraction / result.contact_fraction)
        area = _extent(result) if result.measurement is None else f"{_extent(result)} as measured"
        return (
            f"The material yields at the surface: on {share} of the contact {area} the pressure "
            "is at its ceiling, and the surface there keeps an indentation."
        )
    if result.pair.is_coated:
        return "" if in_layers else "Yielding of a coated body needs the stress in its layers."
    body = result.pair.softer
    if name is Regime.UNKNOWN and (body is None or body.hardness is None):
        return f"Yielding is unknown without a yield strength (maximum pressure {largest})."
    assert body is not None
    if name in (Regime.UNKNOWN, Regime.BEYOND_HARDNESS):
        assert body.hardness is not None
        hardness = format_engineering(body.hardness, "Pa", 3)
        if name is Regime.UNKNOWN:
            return (
                f"The largest pressure, {largest}, stays below the hardness of the softer body, "
                f"{hardness}. Whether it yields below the surface cannot be said without a yield "
                "strength."
            )
        return (
            f"The elastic pressure, up to {largest}, exceeds the hardness of the softer body, "
            f"{hardness}, more than it can carry. The true contact {_extent(result)} is larger, "
            "the true pressure lower."
        )
    yielding = result.pair.first_to_yield
    assert yielding is not None
    pressure = result.pair.yields_at(yielding)
    assert pressure is not None
    first = format_engineering(pressure, "Pa", 3)
    if name is Regime.BELOW_FIRST_YIELD:
        return (
            f"Nothing yields: the largest pressure, {largest}, stays below {first}, at which "
            f"{_sphere(result)} first yields below its surface.{_other(result)}"
        )
    if name is Regime.YIELDING_BELOW:
        strength = "three yield strengths." if body.yield_strength else "the hardness."
        return (
            f"The material yields below the surface of the most loaded spots: the largest "
            f"pressure, {largest}, exceeds {first}, at which {_sphere(result)} first yields, but "
            "no point reaches "
            + ("the ceiling." if result.ceiling is not None else strength)
            + " The pressures shown are those of an elastic body."
        )
    assert name is Regime.BEYOND_CEILING
    assert body.yield_strength is not None
    times = result.max_pressure / body.yield_strength
    return (
        f"The elastic pressure, up to {largest}, is {times:.3g} times the yield strength of the "
        f"softer body, more than it can carry. The true contact {_extent(result)} is larger, the "
        "true pressure lower."
    )


def _sphere(result: ContactResult) -> str:
    """Return the sphere that yields first as text, with its body if both can yield."""
    pair = result.pair
    what = "a cylinder" if pair.is_profile else "a sphere"
    if None in (pair.material.first_yield_pressure, pair.counter_material.first_yield_pressure):
        return what
    whose = "body" if pair.first_to_yield is pair.material else "counter-body"
    return f"{what} of the {whose}"


def _extent(result: ContactResult) -> str:
    return "length" if result.pair.is_profile else "area"


def _other(result: ContactResult) -> str:
    """Return the sentence for two deformable bodies of which only one has a known strength."""
    pair = result.pair
    for body, who in ((pair.material, "body"), (pair.counter_material, "counter-body")):
        if not is_rigid(body) and body.ceiling is None:
            return f" Yielding of the {who} is unknown without its strength."
    return ""


def volume_regime(result: ElastoplasticResult) -> str:
    """Return the regime of a result of the volume model as a sentence with its numbers."""
    from roughcontact.elastoplastic.volume_result import PlasticRegime

    if result.regime is PlasticRegime.ELASTIC:
        share = format_percent(min(1 + result.yield_excess, 1.0))
        return (
            f"Nothing has yielded: the von Mises stress is at most {share} of the yield strength."
        )
    reached = format_engineering(result.plastic_depth, "m", 3)
    strain = format_percent(result.max_plastic_strain)
    text = f"Plastic strain, up to {strain}, reaches down to {reached}"
    surface = (
        " and up to the surface."
        if result.regime is PlasticRegime.AT_SURFACE
        else "; the surface above it remained elastic."
    )
    if result.solution.load:
        return text + surface
    deepest = format_engineering(float(result.residual_displacement.max()), "m", 3)
    return f"{text}{surface} After unloading, an indentation remains of up to {deepest}."


DIGITS = 3
"""Number of significant digits of the headline."""


_SHARE_DIGITS = 2


def format_share(value: float) -> str:
    """Return a share as text in per cent, with two digits."""
    text = f"{100 * value:.{_SHARE_DIGITS}g}"
    return format_percent(value) if "e" in text else f"{text} %"


def format_short(value: float, unit: str) -> str:
    """Return a quantity as text, with the digits of the headline."""
    return group_digits(format_engineering(value, unit, DIGITS))


def range_text(low: float, high: float, form: Any) -> str:
    """Return both ends of an interval as text, with a common unit only once."""
    return join_ends(form(low), form(high), _SHARE_DIGITS if form is format_share else 0)


def map_name(surface: Any) -> str:
    """Return the file name of a map, or its nominal form."""
    source = str(surface.provenance.source)
    made = source.partition(", ")[0]
    if made.startswith(("nominal ", "generated ")):
        return f"a {made.removeprefix('nominal ')}"
    return source or "an unnamed map"


def material_name(body: Material) -> str:
    """Return the name of a material with its layers, or its modulus."""
    if body.coating:
        layers = (
            f"{layer.name or 'layer'} {format_short(layer.thickness, 'm')}"
            for layer in body.coating
        )
        return f"{' on '.join(layers)} on {material_name(body.uncoated)}"
    if is_rigid(body):
        return body.name
    return body.name or f"E {format_engineering(body.young, 'Pa', DIGITS)}"


def _counter_body(contact: ContactResult) -> str:
    other = contact.counter_material
    rigid = is_rigid(other)
    if contact.counter_surface is None:
        return "a rigid flat" if rigid else f"a flat ({material_name(other)})"
    return f"{map_name(contact.counter_surface)} ({'rigid' if rigid else material_name(other)})"


def bodies(contact: ContactResult, name: str = "") -> str:
    """Return both bodies and their materials; the first by its file or by ``name``."""
    against = "on" if contact.counter_surface is None else "against"
    name = name or map_name(contact.surface)
    return f"{name} ({material_name(contact.material)}) {against} {_counter_body(contact)}"


def load_column(contact: ContactResult, loads: Iterable[float]) -> tuple[str, list[str]]:
    """Return head and cells of loads: nominal pressures, or forces on nominal bodies."""
    if has_nominal_body(contact.pair.origins):
        return "load", [_force_on_bodies(contact, load) for load in loads]
    return "pressure", [format_short(load / contact.nominal_area, "Pa") for load in loads]


def _force_on_bodies(contact: ContactResult, load: float) -> str:
    """Return a force, or the force per length of a line contact, as text."""
    shape = None if contact.pair.is_profile else shape_of(contact.pair)
    if shape is None or shape.axis is None:
        return force(load, contact.pair.load_unit)
    return force(load / contact.pair.size[shape.axis], "N/m")


def force(value: float, unit: str) -> str:
    """Return a force, or a line load [N/m] in N/mm, as text."""
    return f"{format_short(1e-3 * value, 'N')}/mm" if unit == "N/m" else format_short(value, unit)


def load(contact: ContactResult) -> str:
    """Return the load in its given form, and the force if that has another value."""
    if contact.control == "approach":
        return f"approach {format_short(contact.approach, 'm')}"
    specified = contact.specified_load
    # For an unloaded body, the largest load.
    largest = contact.total_load if specified is None else specified.force
    total = force(largest, contact.pair.load_unit)
    match None if specified is None else specified.form:
        case load_case.NominalPressure(value=value):
            return f"{format_short(value, 'Pa')} nominal ({total})"
        case load_case.HertzPressure(value=value):
            acting = _force_on_bodies(contact, largest)
            return f"Hertz pressure {format_short(value, 'Pa')} ({acting})"
        case load_case.LineLoad(value=value):
            return f"{force(value, 'N/m')} ({total})"
    return total


def boundary(contact: ContactResult) -> str:
    """Return the boundary condition after a comma; empty for a free boundary."""
    return "" if str(contact.boundary) == "free" else f", {contact.boundary}"


def problem(contact: ContactResult) -> str:
    """Return the problem of a contact in one line."""
    return f"{bodies(contact)}, {load(contact)}{boundary(contact)}"


def draws_text(draws: Sequence[Mean]) -> list[str]:
    """Return the sentence on the number of pairs of faces that a joint is averaged over."""
    return [f"Mean of {draws[0].count} pairs of faces; places are of the first"] if draws else []


def problem_of_loads(contact: ContactResult, loads: Sequence[float]) -> str:
    """Return the problem of a contact under several loads, with the smallest and largest."""
    if len(loads) == 1:
        return problem(contact)
    ends = (min(loads), max(loads))
    if _has_pressure(contact):
        area = contact.nominal_area
        span = range_text(ends[0] / area, ends[1] / area, lambda value: format_short(value, "Pa"))
        what = f"nominal pressures from {span}"
    else:
        what = f"loads from {range_text(*ends, lambda value: _force_on_bodies(contact, value))}"
    return f"{bodies(contact)}, {len(loads)} {what}{boundary(contact)}"


def place(center: Sequence[float], is_profile: bool = False) -> str:
    """Return a place ``(y, x)`` on a map or a profile [m]."""
    y, x = (format_engineering(length, "m") for length in center)
    return f"at x = {x}" if is_profile else f"at y, x = {y}, {x}"


def status(contact: ContactResult) -> str:
    """Return the solver status of a contact: certificate and time."""
    limit = f"{order_of_magnitude(contact.certificate)} (limit {contact.tolerance:.0e})"
    if not contact.converged:
        return f"Not converged: certificate {limit}. Do not use these numbers."
    return f"Solved: certificate {limit}, {format_short(contact.seconds, 's')}"


def worst(certificate: float, tolerance: float, count: int) -> str:
    """Return the solver status of several contacts: the worst certificate."""
    return (
        f"Solved: {count} contacts, certificate {order_of_magnitude(certificate)} (limit "
        f"{tolerance:.0e})"
    )
