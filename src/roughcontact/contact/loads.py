"""A normal load as an engineer has it: a force, or what stands for one on two given bodies."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from numbers import Real
from typing import Any

from roughcontact import units
from roughcontact.arguments import checked
from roughcontact.contact import smooth
from roughcontact.contact.pair import Pair
from roughcontact.errors import InputError
from roughcontact.units import Quantity, quantity

NEEDS = (
    "a load such as '1 N', a nominal pressure such as '20 MPa', a line load such as '600 N/mm', "
    "or Hertz's peak pressure such as 'hertz 1.5 GPa'"
)
"""What a text has to be."""

_HERTZ = re.compile(r"\s*hertz\s+(.*)", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class NominalPressure:
    """A load given as a pressure on the area of the whole map.

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

    value: float

    @checked
    def __init__(self, value: Quantity) -> None:
        object.__setattr__(self, "value", _positive(value, "pressure"))


@dataclass(frozen=True)
class LineLoad:
    """A load given per length of a nominal cylinder, for the length of the map along its axis.

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

    value: float

    @checked
    def __init__(self, value: Quantity) -> None:
        object.__setattr__(self, "value", _positive(value, "line load"))


@dataclass(frozen=True)
class HertzPressure:
    """A load given as the peak pressure that the nominal bodies have under it where smooth.

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

    value: float

    @checked
    def __init__(self, value: Quantity) -> None:
        object.__setattr__(self, "value", _positive(value, "pressure"))


Load = NominalPressure | LineLoad | HertzPressure
"""A load that is no force before the bodies are known."""

UNITS = {NominalPressure: "Pa", LineLoad: "N/m", HertzPressure: "Pa"}
NAMES = {
    NominalPressure: "nominal pressure",
    LineLoad: "line load",
    HertzPressure: "Hertz's peak pressure",
}
"""What the forms are called."""


@dataclass(frozen=True)
class GivenLoad:
    """A load in the form in which it was given, and the force that it came to.

    Parameters
    ----------
    form : NominalPressure, LineLoad or HertzPressure
        As it was given.
    force : float
        W [N].
    """

    form: Load
    force: float

    def summary(self) -> dict[str, Any]:
        """Return it ready for JSON: form, value with its unit, force [N]."""
        kind = type(self.form)
        return {
            "form": NAMES[kind], "value": self.form.value, "unit": UNITS[kind], "load": self.force,
        }  # fmt: skip


def from_summary(told: dict[str, Any]) -> GivenLoad:
    """Return the load that `GivenLoad.summary` told of.

    Raises
    ------
    KeyError, ValueError, TypeError, InputError
        If it is another mapping.
    """
    (kind,) = (kind for kind in (NominalPressure, LineLoad, HertzPressure)
               if NAMES[kind] == told["form"])  # fmt: skip
    return GivenLoad(kind(float(told["value"])), float(told["load"]))


def _positive(value: Any, dimension: str) -> float:
    found = quantity(value, dimension, "load")
    if not (isinstance(found, Real) and 0 < float(found) < math.inf):
        raise InputError(
            f"must be a positive and finite {dimension}, got {value!r}",
            argument="load",
            value=value,
        )
    return float(found)


def given(value: Any, argument: str = "load") -> Any:
    """Return a load in the form in which it is given.

    Parameters
    ----------
    value : object
        A number [N], a text with its unit, a quantity of pint, or a `Load`.
    argument : str
        What it is given for, which errors carry.

    Returns
    -------
    object
        A force as its number [N], any other text or quantity as the `Load` that it is; all else as
        it was given, for the checks of whoever takes it.

    Raises
    ------
    InputError
        If a text or a quantity is no load.

    Examples
    --------
    >>> given("50 N"), given("20 MPa"), given("600 N/mm"), given("hertz 1.5 GPa")
    (50.0, NominalPressure(value=20000000.0), LineLoad(value=600000.0), \
HertzPressure(value=1500000000.0))
    """
    if isinstance(value, str):
        return _from_text(value, argument, NEEDS, positive=False)
    if hasattr(value, "m_as"):
        for dimension, form in _FORMS.items():
            try:
                return form(quantity(value, dimension, argument))
            except InputError:
                continue
        return quantity(value, "force", argument)
    return value


def required(text: str, argument: str, needs: str = NEEDS) -> Any:
    """Return a load above zero from its text, as `given` does.

    Parameters
    ----------
    text : str
        The load.
    argument : str
        What it is given for, which errors carry.
    needs : str
        What errors say is needed.

    Raises
    ------
    InputError
        If the text is no load, or not positive.
    """
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
            # Once more, for the error in the words of what was given.
            units.parse(number, dimension, argument)
        return form(value)
    return units.parse(number, "pressure" if peak else "force", argument, needs=needs)


_FORMS: dict[str, Any] = {"pressure": NominalPressure, "line load": LineLoad}


def force(load: Any, pair: Pair, argument: str = "load") -> Any:
    """Return the force that a load is on two bodies.

    Parameters
    ----------
    load : object
        As `given` returns it.
    pair : Pair
        The bodies.
    argument : str
        What it is given for, which errors carry.

    Returns
    -------
    object
        W [N]; what is no `Load` as it is.

    Raises
    ------
    InputError
        If the bodies do not go with the form of the load.
    """
    match load:
        case NominalPressure():
            return load.value * pair.size[0] * pair.size[1]
        case LineLoad():
            shape = smooth.shape_of(pair)
            if shape is None or shape.axis is None:
                raise _misfit(load, "cylinder that lies along x or y", shape, argument)
            return load.value * pair.size[shape.axis]
        case HertzPressure():
            shape = smooth.shape_of(pair)
            found = None if shape is None else smooth.load_of(pair, shape, load.value)
            if found is None:
                needed = "sphere, ellipsoid, or cylinder that lies along x or y"
                raise _misfit(load, needed, shape, argument)
            return found
    return load


def _misfit(load: Load, needed: str, shape: smooth.Shape | None, argument: str) -> InputError:
    if shape is None:
        found = "none that curves"
    elif shape.kind == smooth.LINE:
        found = f"one at {shape.angle:g} degrees from x"
    else:
        found = f"bodies that touch in {'an' if shape.kind == smooth.ELLIPSE else 'a'} {shape.kind}"
    return InputError(
        f"({NAMES[type(load)]}) needs a nominal {needed}, as body or counter-body, such as "
        f"'cylinder 10 mm'; found {found}",
        argument=argument,
        value=load,
    )


def on(load: Any, pair: Pair, argument: str = "load") -> tuple[Any, GivenLoad | None]:
    """Return the force that a load is on two bodies, and how it was given if that was no force.

    Parameters
    ----------
    load : object
        As for `given`.
    pair : Pair
        The bodies. On profiles all loads are per length [N/m], and a `LineLoad` is what a force is
        on maps.
    argument : str
        What it is given for, which errors carry.

    Raises
    ------
    InputError
        As for `given` and `force`.
    """
    asked = given(load, argument)
    if pair.is_profile:
        if isinstance(asked, LineLoad):
            return asked.value, None
        if not isinstance(asked, Load):
            # A force with its unit is refused.
            return quantity(load, pair.load_dimension, argument), None
    found = force(asked, pair, argument)
    return found, GivenLoad(asked, found) if isinstance(asked, Load) else None
