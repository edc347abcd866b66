"""Normal load in engineering form: force, pressure, line load or Hertz pressure."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.checkpoints import digest_arrays
from roughcontact.contact import nominal_hertz
from roughcontact.contact.pair import Pair
from roughcontact.errors import InputError, input_error
from roughcontact.material.hardness import stress
from roughcontact.units import Quantity, to_si

LOAD_EXAMPLES = (
    "a load such as '1 N', a nominal pressure such as '20 MPa', a line load such as '600 N/mm', "
    "or Hertz's peak pressure such as 'hertz 1.5 GPa'"
)
"""Examples of loads in texts of errors and help."""

_HERTZ = re.compile(r"\s*hertz\s+(.*)", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class _Load:
    """Load that is not a force: its value [SI]."""

    value: float
    dimension: ClassVar[str]

    @validate_arguments
    def __init__(self, value: Quantity) -> None:
        object.__setattr__(self, "value", _positive(value, self.dimension))


@dataclass(frozen=True, init=False)
class NominalPressure(_Load):
    """Load given as a pressure on the area of the whole map.

    Parameters
    ----------
    value : float, str or quantity of pint
        The pressure [Pa].

    Raises
    ------
    InputError
        If it is not positive and finite.

    Examples
    --------
    >>> NominalPressure("20 MPa").value
    20000000.0
    """

    dimension = "pressure"


@dataclass(frozen=True, init=False)
class LineLoad(_Load):
    """Load per length of a nominal cylinder, for the length of the map along its axis.

    Parameters
    ----------
    value : float, str or quantity of pint
        The load per length [N/m].

    Raises
    ------
    InputError
        If it is not positive and finite.

    Examples
    --------
    >>> LineLoad("600 N/mm").value
    600000.0
    """

    dimension = "line load"


@dataclass(frozen=True, init=False)
class HertzPressure(_Load):
    """Load given as the peak pressure of the smooth nominal bodies (Hertz).

    Parameters
    ----------
    value : float, str or quantity of pint
        The peak pressure [Pa].

    Raises
    ------
    InputError
        If it is not positive and finite.

    Examples
    --------
    >>> HertzPressure("1.5 GPa").value
    1500000000.0
    """

    dimension = "pressure"


Load = NominalPressure | LineLoad | HertzPressure
"""Types of loads that depend on the bodies."""

UNITS = {NominalPressure: "Pa", LineLoad: "N/m", HertzPressure: "Pa"}
NAMES: dict[type[Load], str] = {
    NominalPressure: "nominal pressure",
    LineLoad: "line load",
    HertzPressure: "Hertz's peak pressure",
}
"""Names of the forms of a load."""


@dataclass(frozen=True)
class GivenLoad:
    """A load in its given form, and the resulting force."""

    form: Load  # Given form
    force: float  # W [N]

    def summary(self) -> dict[str, Any]:
        """Return the load for JSON: form, value with its unit, force [N]."""
        kind = type(self.form)
        return {
            "form": NAMES[kind],
            "value": self.form.value,
            "unit": UNITS[kind],
            "load": self.force,
        }


def from_summary(text: dict[str, Any]) -> GivenLoad:
    """Return the load of a record of `GivenLoad.summary`."""
    (kind,) = (kind for kind, name in NAMES.items() if name == text["form"])
    return GivenLoad(kind(float(text["value"])), float(text["load"]))


def _positive(value: Any, dimension: str) -> float:
    result = to_si(value, dimension, "load")
    if not (isinstance(result, Real) and 0 < float(result) < math.inf):
        raise input_error("load", value, f"must be a positive and finite {dimension}")
    return float(result)


def parse_load(value: Any, argument: str = "load") -> Any:
    """Return a load in the form in which it is given."""
    if isinstance(value, str):
        return _from_text(value, argument, LOAD_EXAMPLES, positive=False)
    if hasattr(value, "m_as"):
        for dimension, form in _FORMS.items():
            try:
                return form(to_si(value, dimension, argument))
            except InputError:
                continue
        return to_si(value, "force", argument)
    return value


def parse_required_load(text: str, argument: str, needs: str = LOAD_EXAMPLES) -> Any:
    """Return a positive load from its text."""
    return _from_text(text, argument, needs, positive=True)


def _from_text(text: str, argument: str, needs: str, positive: bool) -> Any:
    peak = _HERTZ.fullmatch(text)
    dimensions = {"pressure": HertzPressure} if peak else {"force": float, **_FORMS}
    number = peak[1] if peak else text
    for dimension, form in dimensions.items():
        try:
            value = units.parse(number, dimension, argument, positive=False)
        except InputError:
            continue
        if positive or form is not float:
            # Parse again, so that the error quotes the input.
            units.parse(number, dimension, argument)
        return form(value)
    return units.parse(number, "pressure" if peak else "force", argument, needs=needs)


_FORMS: dict[str, Any] = {"pressure": NominalPressure, "line load": LineLoad}


def force_on_pair(load: Any, pair: Pair, argument: str = "load") -> Any:
    """Return the force of a load on two bodies."""
    match load:
        case NominalPressure():
            return load.value * pair.size[0] * pair.size[1]
        case LineLoad():
            shape = nominal_hertz.shape_of(pair)
            if shape is None or shape.axis is None:
                raise _form_error(load, "cylinder along x or y", shape, argument)
            return load.value * pair.size[shape.axis]
        case HertzPressure():
            shape = nominal_hertz.shape_of(pair)
            result = shape and nominal_hertz.load_of_peak_pressure(pair, shape, load.value)
            if result is None:
                needed = "sphere, ellipsoid, or cylinder along x or y"
                raise _form_error(load, needed, shape, argument)
            return result
    return load


def _form_error(
    load: Load, needed: str, shape: nominal_hertz.ContactShape | None, argument: str
) -> InputError:
    if shape is None:
        result = "no curved one"
    elif shape.kind == nominal_hertz.LINE:
        result = f"one at {shape.angle:g} degrees from x"
    else:
        article = "an" if shape.kind == nominal_hertz.ELLIPSE else "a"
        result = f"bodies that touch in {article} {shape.kind}"
    return InputError(
        f"({NAMES[type(load)]}) needs a nominal {needed}, as body or counter-body, such as "
        f"'cylinder 10 mm'; found {result}",
        argument=argument,
        value=load,
    )


def resolve_force(load: Any, pair: Pair, argument: str = "load") -> tuple[Any, GivenLoad | None]:
    """Return the force of a load on two bodies, and its given form if that is not a force."""
    requested = parse_load(load, argument)
    if pair.is_profile:
        if isinstance(requested, LineLoad):
            return requested.value, None
        if not isinstance(requested, Load):
            # For a profile, a text with the unit of a force raises an error.
            return to_si(load, pair.load_dimension, argument), None
    result = force_on_pair(requested, pair, argument)
    return result, GivenLoad(requested, result) if isinstance(requested, Load) else None


@dataclass(frozen=True, eq=False)
class LoadCase:
    """Load or approach, moments, ceiling and numerical parameters of a solve."""

    load: float | None = None  # As in `roughcontact.solve`
    approach: float | None = None  # As in `roughcontact.solve`
    moments: tuple[float, float] | None = None  # As in `roughcontact.solve`
    ceiling: Any = "auto"  # As in `roughcontact.solve`
    tolerance: float | None = None  # As in `roughcontact.solve`
    max_iterations: int = 2000  # As in `roughcontact.solve`
    precision: str = "double"  # As in `roughcontact.solve`
    specified: GivenLoad | None = None

    def __post_init__(self) -> None:
        """Convert quantities to SI units."""
        for name, dimension in (("load", "force"), ("approach", "length"), ("moments", "moment")):
            object.__setattr__(self, name, to_si(getattr(self, name), dimension, name))
        if not (isinstance(self.ceiling, str) and self.ceiling.isalpha()):
            object.__setattr__(self, "ceiling", stress(self.ceiling, "ceiling"))

    @property
    def control(self) -> str:
        """Given quantity: ``"load"`` or ``"approach"``."""
        return "load" if self.approach is None else "approach"

    @property
    def target(self) -> float:
        """Given load [N] or approach [m]."""
        target = self.load if self.approach is None else self.approach
        assert target is not None
        return target

    @property
    def certificate(self) -> float:
        """Given tolerance, or the default of the precision."""
        if self.tolerance is not None:
            return self.tolerance
        return 1e-6 if self.precision == "double" else 1e-4

    def record(self) -> dict[str, Any]:
        """Return the record of ceiling and accuracy for `checkpoints.lock_folder`."""
        ceiling = self.ceiling
        is_plain = ceiling is None or isinstance(ceiling, str)
        return {
            "ceiling": ceiling if is_plain else digest_arrays(ceiling),
            "tolerance": self.tolerance,
            "max_iterations": self.max_iterations,
        }


# Maximum gap in these units: single precision represents it with a margin for sums.
_MAX_GAP_RATIO = 2.0**64
# Beyond this value and its inverse, sums of squares overflow or vanish even in double precision.
_MAX_RANGE = 1e120


@dataclass(frozen=True)
class ProblemUnits:
    """Units of length and pressure that scale a problem to order one."""

    length: float  # Unit of gaps and displacements [m], a power of two
    pressure: float  # Unit of pressures [Pa], a power of two


def units_of_problem(pair: Pair, terms: LoadCase, gap: NDArray[np.float64]) -> ProblemUnits:
    """Return units that make pressures and displacements of order one, with gaps in range."""
    deepest = float(np.max(gap, where=np.isfinite(gap), initial=0.0))
    softness = math.sqrt(pair.pixel_area) / pair.contact_modulus
    if terms.load is not None:
        mean = terms.load / pair.pixel_area / math.prod(pair.shape)
        _require_range(
            "load", f"{terms.load:.6g} {pair.load_unit} is a mean pressure of {mean:.3g} Pa", mean
        )
        sunk = softness * mean
    else:
        assert terms.approach is not None
        sunk = terms.approach
        _require_range("approach", f"{sunk:.6g} m", sunk)
    length = _power_of_two(max(sunk, deepest / _MAX_GAP_RATIO))
    return ProblemUnits(length, _power_of_two(length / softness))


def _require_range(argument: str, words: str, value: float) -> None:
    if not 1 / _MAX_RANGE < value < _MAX_RANGE:
        raise InputError(
            f"= {words}: too {'small' if value < 1 else 'large'} for the computation; check its "
            "unit and those of the map",
            argument=argument,
            value=value,
        )


def _power_of_two(value: float) -> float:
    return math.ldexp(1.0, math.frexp(value)[1])


@validate_arguments
def space_values(first: float, last: float, number: int, spacing: str = "log") -> list[float]:
    """Return loads or approaches between two positive ends, in equal ratios or differences."""
    values = (np.geomspace if spacing == "log" else np.linspace)(first, last, number)
    return [float(value) for value in values]
