"""Load history: a path of loads and positions, and what saturated pixels leave behind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import limits
from roughcontact.arguments import checked
from roughcontact.contact import imprint, judgment, loads
from roughcontact.contact.advice import AgreedCeiling
from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.loads import GivenLoad, Load
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError, require_count
from roughcontact.result import Result
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, quantity

Array = NDArray[np.float64]

SHAKEN_DOWN = 1e-5
"""Share of the whole indentation volume up to which a step counts as elastic."""

# A load or approach is reached again if it is missed by no more than this part.
_REACHED = 1e-6

VOLUME_ACCOUNT = (
    "the indented volume is lost: saturated pixels are lowered and nothing is raised in return "
    "(no pile-up), pixels below the ceiling keep their height to the bit, and no other residual "
    "displacement or stress stays behind"
)
"""What the model conserves and what it does not."""


@dataclass(frozen=True)
class Stage:
    """One point of a path: a load or an approach, at a lateral position.

    Parameters
    ----------
    load : float, str, quantity of pint or `Load`, optional
        Normal load W [N], 0 for bodies that just touch, or in any form that `solve` takes; give
        either this or ``approach``.
    approach : float, str or quantity of pint, optional
        Approach ω from the first touch of the undeformed bodies at the first position [m]; where
        they do not touch at it the load is 0.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from its first position [m], a whole number
        of pixels.

    Raises
    ------
    InputError
        If a value cannot be used.
    """

    load: float | Load | None = None
    approach: float | None = None
    shift: tuple[float, float] = (0.0, 0.0)

    @checked
    def __init__(
        self,
        load: Quantity | Load | None = None,
        approach: Quantity | None = None,
        shift: Quantities = (0.0, 0.0),
    ) -> None:
        object.__setattr__(self, "load", loads.given(load))
        object.__setattr__(self, "approach", quantity(approach, "length", "approach"))
        object.__setattr__(self, "shift", quantity(shift, "length", "shift"))
        self._check()

    def _check(self) -> None:
        """Refuse what is no point of a path."""
        if (self.load is None) == (self.approach is None):
            raise InputError("a stage needs either a load or an approach, and only one of them")
        plain = self.load is not None and not isinstance(self.load, Load)
        if plain and not (_is_finite(self.load) and self.force >= 0):
            raise InputError(
                f"must be finite and not negative [N], got {self.load!r}",
                argument="load",
                value=self.load,
            )
        if self.approach is not None and not _is_finite(self.approach):
            raise InputError(
                f"must be finite [m], got {self.approach!r}",
                argument="approach",
                value=self.approach,
            )
        try:
            y, x = (float(length) for length in self.shift)
        except (TypeError, ValueError):
            y = x = math.nan
        if not (math.isfinite(y) and math.isfinite(x)):
            raise InputError(
                f"must be a pair (y, x) of lengths [m], got {self.shift!r}",
                argument="shift",
                value=self.shift,
            )
        object.__setattr__(self, "shift", (y, x))

    @property
    def force(self) -> float:
        """The load [N], once `on` has made one of what stands for it."""
        assert self.load is not None
        assert not isinstance(self.load, Load)
        return self.load

    def on(self, pair: Pair) -> Stage:
        """Return the stage with the force that its load is on two bodies."""
        if not isinstance(self.load, Load):
            return self
        return replace(self, load=loads.force(self.load, pair))


@dataclass(frozen=True)
class HistoryStep:
    """The scalars of one solved stage.

    Parameters
    ----------
    load : float
        W [N].
    approach : float
        ω from the first touch of the undeformed bodies at the first position [m].
    shift_y, shift_x : float
        Lateral shift of the counter-body [m].
    contact_area, saturated_area : float
        Area with pressure, and at the ceiling to a millionth of it [m²]: under a load that comes
        again points that flowed are at it, without flowing.
    max_pressure : float
        Largest pressure [Pa].
    indentation_volume : float
        Volume newly indented in this step [m³].
    dissipated_energy : float
        Ceiling times newly indented volume, summed over the pixels [J].
    elastic_energy : float
        Elastic energy stored at the end of the step, ½ Σ p u ΔxΔy [J].
    certificate, load_error : float
        How exactly the step is solved.
    convolutions : int
        On the full grid.
    seconds : float
        Wall time of the solve.
    """

    load: float
    approach: float
    shift_y: float
    shift_x: float
    contact_area: float
    saturated_area: float
    max_pressure: float
    indentation_volume: float
    dissipated_energy: float
    elastic_energy: float
    certificate: float
    load_error: float
    convolutions: int
    seconds: float


_FIELDS = tuple(field.name for field in fields(HistoryStep))


@dataclass(frozen=True, eq=False, repr=False)
class LoadHistory(Result):
    """A path of loads and positions, and what it left behind.

    Parameters
    ----------
    path : tuple of Stage
        The stages that were followed.
    steps : tuple of HistoryStep
        What was found, one a stage.
    indented_body : {"surface", "counter_surface"}
        The body that keeps the indentation.
    indentation : ndarray
        Permanent lowering d ≥ 0 of that body [m], on its own grid; read-only.
    origin : (int, int)
        Pixel of ``indentation`` that faced pixel (0, 0) of the surface at the first position. It
        is (0, 0) unless a counter-body without a map, a flat, was indented at several positions.
    residual : Surface
        That body with its indentation, unloaded.
    last : ContactResult
        The last stage. Its surfaces are those before the stage, its approach counts from their
        first touch, and its ``residual_indentation`` is what the stage added.
    largest : ContactResult
        The stage with the largest load, the first of them if several have it.
    before : Pair
        The bodies at the position of that stage, as they were before the path.
    recommended : AgreedCeiling or None
        How the ceiling of the path was found, if it is one that was recommended: that of a first
        loading to the largest load.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    given : tuple of GivenLoad
        The loads in the form in which they were given, those that were no forces.
    passes : int
        How often the path was followed.
    requested_passes : int
        How often it was to be followed; fewer passes suffice once one indents nothing.
    """

    path: tuple[Stage, ...]
    steps: tuple[HistoryStep, ...]
    indented_body: str
    indentation: Array
    origin: tuple[int, int]
    residual: Surface
    last: ContactResult
    largest: ContactResult
    before: Pair
    recommended: AgreedCeiling | None = None
    remarks: tuple[Caution, ...] = ()
    given: tuple[GivenLoad, ...] = ()
    passes: int = 1
    requested_passes: int = 1

    @property
    def under_largest(self) -> ContactResult:
        """The contact under the largest load, on the bodies as they were before the path.

        Its slopes and summits are those that were measured; pressure and gap are those of the
        stage.
        """
        return replace(
            self.largest, pair=self.before, recommended=self.recommended, remarks=self.remarks
        )

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know: of the contact under the largest load."""
        largest = self.under_largest
        advice, ceiling = judgment.advice(largest), largest.ceiling
        if advice is None or not isinstance(ceiling, float):
            return largest.cautions
        bodies = (largest.material, largest.counter_material)
        left = imprint.doubt(advice, ceiling, any(body.hardens for body in bodies))
        return largest.cautions if left is None else ordered([*largest.cautions, left])

    def column(self, name: str) -> Array:
        """Return one field of all steps, shape (n,); see `HistoryStep` for names and units."""
        if name not in _FIELDS:
            raise InputError(
                f"must be one of {', '.join(_FIELDS)}, got {name!r}", argument="name", value=name
            )
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

    @property
    def hysteresis(self) -> tuple[Array, Array]:
        """Approach [m] and load [N] of the steps, each of shape (n,)."""
        return self.column("approach"), self.column("load")

    @cached_property
    def dissipated_energy(self) -> float:
        """Energy dissipated along the whole path [J]."""
        return math.fsum(self.column("dissipated_energy"))

    @cached_property
    def indentation_volume(self) -> float:
        """Volume of the whole indentation [m³]."""
        dy, dx = self.residual.pixel
        return math.fsum(self.indentation.ravel()) * dy * dx

    @cached_property
    def shaken_down(self) -> bool:
        """Whether going on along the path would stay elastic.

        True if no step indents, or if after the last step that does (more than 1e-5 of the whole
        volume) every position of the path has seen its largest load, or its largest approach,
        again.
        """
        volume = self.column("indentation_volume")
        plastic = np.flatnonzero(volume > SHAKEN_DOWN * self.indentation_volume)
        if plastic.size == 0:
            return True
        wanted = self._largest(0)
        seen = self._largest(int(plastic[-1]) + 1)
        return all(
            what in seen and seen[what] >= value - _REACHED * abs(value)
            for what, value in wanted.items()
        )

    def _largest(self, first: int) -> dict[tuple[tuple[float, float], str], float]:
        """Return the largest load and approach asked for at each position from a stage on."""
        found: dict[tuple[tuple[float, float], str], float] = {}
        for stage in self.path[first:]:
            load = None if stage.load is None else stage.force
            for control, value in (("load", load), ("approach", stage.approach)):
                if value is not None:
                    what = stage.shift, control
                    found[what] = max(found.get(what, value), value)
        return found


def passes(
    loads: Sequence[Stage | Quantity | Load], count: int, shift: Quantities = (0.0, 0.0)
) -> list[Stage]:
    """Return the stages of a load cycle that is repeated, each time a step further.

    Parameters
    ----------
    loads : sequence of Stage, float, str, quantity of pint or `Load`
        Stages or normal loads of one pass, in their order.
    count : int
        Number of passes; all of them together have at most 10,000 stages.
    shift : (float, float)
        Lateral shift ``(y, x)`` of the counter-body from pass to pass [m].

    Returns
    -------
    list of Stage
        ``count × len(loads)`` stages, the first pass at the first position.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    >>> [stage.load for stage in passes([1.0, 0.0], 2)]
    [1.0, 0.0, 1.0, 0.0]
    >>> passes([1.0], 3, shift=(0.0, 2e-6))[2].shift
    (0.0, 4e-06)
    """
    require_count(1, most_passes(len(loads)), count=count)
    dy, dx = Stage(load=0.0, shift=shift).shift
    stages = [one if isinstance(one, Stage) else Stage(load=one) for one in loads]
    return [
        replace(stage, shift=(stage.shift[0] + number * dy, stage.shift[1] + number * dx))
        for number in range(count)
        for stage in stages
    ]


def most_passes(stages: int) -> int:
    """Return how often a path of so many stages may be followed."""
    return max(1, limits.STEPS // max(1, stages))


def _is_finite(value: Any) -> bool:
    return isinstance(value, Real) and math.isfinite(value)
