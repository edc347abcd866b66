"""Analyses of joints, with contacts that are solved on demand.

Several analyses of one contact share its solution; see `cached_solver`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields, replace
from typing import IO, TYPE_CHECKING, Any

from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, CapacityError, ConvergenceError, InputError
from roughcontact.formats import export
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, parsing
from roughcontact.request.options import EXCLUDES, NEEDED, NEEDS, Option, Rule
from roughcontact.request.outcome import OnProgress, Outcome, Solve, TaskContext, solve_uncalibrated
from roughcontact.request.parsing import quantity
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress, one_of_several

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.material.material import Conductor
    from roughcontact.surface.surface import Surface

LOAD = Option.value("load", parsing.loads, 'Loads or nominal pressures: "1 N" or "20 MPa, 50 MPa".')
FROM = Option.value("from", parsing.nominal, 'Smallest nominal pressure: "1 MPa".')
TO = Option.value("to", parsing.nominal, 'Largest nominal pressure: "300 MPa".')
STEPS = Option(
    "steps",
    parsing.int_parser(2, memory.STEPS),
    "Number of pressures (logarithmic); default: 13.",
    13,
)
RANGE = (FROM, TO, STEPS)
SHORT_RANGE = tuple(zip(RANGE, ("1 MPa", "100 MPa", "5"), strict=True))
"""Initial range of nominal pressures in the app."""
OUTPUT = Option.output("Table of loads", export.TABLES)

RESISTIVITY = Option.value(
    "resistivity",
    quantity("resistivity"),
    'Electrical resistivity: "17 nohm m"; default: from --material.',
)
CONDUCTIVITY = Option.value(
    "conductivity",
    quantity("conductivity"),
    'Thermal conductivity: "46 W/m/K"; default: from --material.',
)
COUNTER_RESISTIVITY = Option.value(
    "counter-resistivity", quantity("resistivity"), "Electrical resistivity of the counter-body."
)
COUNTER_CONDUCTIVITY = Option.value(
    "counter-conductivity", quantity("conductivity"), "Thermal conductivity of the counter-body."
)
THERMAL_FILM = Option.value(
    "thermal-film",
    quantity("thermal film"),
    'Thermal film resistance × area: "1e-6 m^2 K/W"; default: none.',
)

TEMPERATURE = Option.value(
    "temperature", quantity("temperature"), 'Temperature of the gas: "20 °C"; default: 25 °C.'
)

FRICTION = Option.value("friction", parsing.number, "Friction coefficient: 0.15.")

PRESSURE_RULES = tuple(
    Rule(NEEDED, end, text="a nominal pressure such as '20 MPa'") for end in (FROM, TO)
)
LOAD_RULES = (Rule(EXCLUDES, LOAD, FROM, TO),)
FACES = (options.COUNTER_MAPS, options.DRAWS)
CONTACT = (*options.SHAPES, *FACES, options.CEILING, options.BOUNDARY, *options.SOLVER)
FACE_RULES = (
    Rule(NEEDS, options.DRAWS, options.COUNTER_MAPS),
    Rule(EXCLUDES, options.COUNTER_MAPS, options.COUNTER_SURFACE, options.COUNTER_BODY),
    Rule(NEEDS, options.COUNTER_MAPS, options.BOUNDARY, value=Boundary.PERIODIC),
)


def loads(request: Request) -> list[Any]:
    """Return the loads of the contacts of a joint, in their given form."""
    from roughcontact.contact.load_case import NominalPressure, space_values

    single = request.get(LOAD)
    if single is not None:
        return list(single)
    first, last = request.require(FROM), request.require(TO)
    return [NominalPressure(pressure) for pressure in space_values(first, last, request[STEPS])]


def check_pressures(request: Request) -> None:
    """Raise `InputError` for an invalid range of nominal pressures."""
    first, last = request[FROM], request[TO]
    if first is not None and last is not None:
        check_range(request, first, last)


def check_range(request: Request, first: float, last: float) -> None:
    """Raise `InputError` unless the ends of a range are positive and ascend."""
    if not 0 < first < last:
        raise InputError(
            f"must be positive and below {ArgumentRef('to')}, got "
            f"{request.specified[FROM.name]!r} and {request.specified[TO.name]!r}",
            argument="from",
        )


def check_loads(request: Request) -> None:
    """Raise `InputError` unless single loads or a range of nominal pressures are given."""
    if request[LOAD] is not None:
        return
    if request[FROM] is None and request[TO] is None:
        raise InputError(
            "is needed, such as '1 N', or several: '1 N, 3 N, 10 N'; or "
            f"{ArgumentRef('from', '1 MPa')} and {ArgumentRef('to', '100 MPa')}",
            argument="load",
        )
    options.check_rules(PRESSURE_RULES, request)
    check_pressures(request)


def conductors(request: Request) -> tuple[Conductor, Conductor]:
    """Return the conductivities of both bodies."""
    return (
        _conductor(request, options.MATERIAL, RESISTIVITY, CONDUCTIVITY),
        _conductor(request, options.COUNTER_MATERIAL, COUNTER_RESISTIVITY, COUNTER_CONDUCTIVITY),
    )


def _conductor(request: Request, material: Option[Any], *specified: Option[Any]) -> Conductor:
    from roughcontact.material import catalog
    from roughcontact.material.material import Conductor

    known = request[material]
    result = Conductor() if known is None else catalog.entry(known.name).conductor
    values = dict(zip(("resistivity", "conductivity"), map(request.get, specified), strict=True))
    return replace(result, **{name: value for name, value in values.items() if value is not None})


def outcome(request: Request, work: TaskContext, result: Any) -> Outcome:
    """Return the outcome of a joint analysis, with remarks on the measurement."""
    largest = replace(result.largest, extra_cautions=work.extra_cautions)
    return Outcome(
        request, replace(result, largest=largest, extra_cautions=work.extra_cautions), largest
    )


@dataclass(frozen=True, eq=False)
class JointContacts:
    """Contacts of a request, solved on demand."""

    request: Request  # The request
    work: TaskContext  # Context of the task
    maps: Sequence[Surface]  # Maps of the bodies in contact
    more: Sequence[Surface] = ()  # Further maps of the surface
    counter_maps: Sequence[Surface] = ()  # Maps of the counter-body's face

    @classmethod
    def from_request(cls, request: Request, work: TaskContext) -> JointContacts:
        """Return the contacts of the maps of a request."""
        last = len(work.maps) - len(request[options.COUNTER_MAPS])
        # Several files are maps of one surface.
        first = 1 if len(request.files) > 1 else last
        return cls(request, work, work.maps[:first], work.maps[first:last], work.maps[last:])

    def iter_maps(self) -> Iterator[JointContacts]:
        """Yield the contacts of each map of the surface, or of each drawn pair of faces."""
        pairs: Sequence[tuple[Surface, ...]] = [
            (surface, *self.maps[1:]) for surface in (self.maps[0], *self.more)
        ]
        if self.counter_maps:
            from roughcontact.surface.placement import drawn_pairs

            surfaces = [surface for surface, *_ in pairs]
            pairs = drawn_pairs(surfaces, self.counter_maps, self.request[options.DRAWS])
        for number, maps in enumerate(pairs, start=1):
            look = one_of_several(self.work.look, number, len(pairs))
            yield replace(self.replace_map(maps[0]), maps=maps, work=replace(self.work, look=look))

    def replace_map(self, surface: Surface) -> JointContacts:
        """Return the contacts of another map."""
        return replace(self, maps=(surface, *self.maps[1:]), more=(), counter_maps=())

    def by_ceiling(self, compute: Callable[[JointContacts], Any]) -> Any:
        """Return a joint result, of a coated body under both ceilings if requested."""
        from roughcontact.contact.ceiling import is_bracket
        from roughcontact.contact.result import BASE, COATING

        if not is_bracket(self.request.pair(self.maps), self.request[options.CEILING]):
            return compute(self)
        coating, base = (
            compute(self._under_ceiling(ceiling, one_of_several(self.work.look, number, 2)))
            for number, ceiling in enumerate((COATING, BASE), start=1)
        )
        return replace(coating, base=base)

    def _under_ceiling(self, ceiling: str, look: OnProgress) -> JointContacts:
        """Return the same contacts under another ceiling."""
        values = {**self.request.values, options.CEILING.name: ceiling}
        request = replace(self.request, values=values)
        return replace(self, request=request, work=replace(self.work, look=look))

    def require_map(self, what: str) -> None:
        """Raise `InputError` for profiles, before anything is solved."""
        self.request.pair(self.maps).require_map(what)

    def solve_loads(self, loads: Sequence[Any]) -> Iterator[ContactResult]:
        """Yield the contacts under several loads, given in any form."""
        pair = self.request.pair(self.maps)
        forces = [self.request.force(pair, load) for load in loads]
        forces.sort(key=lambda load: -load[0])
        arguments = self.request.arguments(self.maps)
        for number, (force, specified) in enumerate(forces, start=1):

            def watch(state: Progress, number: int = number) -> None:
                self.work.look(replace(state, number=number, count=len(forces)))

            result = self.work.solve(self.maps[0], **arguments, load=force, progress=watch)
            yield replace(result, specified_load=specified)

    def over_draws(self, compute: Callable[[JointContacts], Any]) -> Any:
        """Return the mean of a joint result over its pairs of faces."""
        first, *others = self.iter_maps()
        result = first.with_variants(compute(first))
        return result.with_draws([compute(pair) for pair in others]) if others else result

    def with_variants(self, result: Any) -> Any:
        """Return a joint result with its changes for the calibrated ceiling and a coarser grid."""
        from roughcontact.contact import plausibility
        from roughcontact.uncertainty.resolution import coarsen_pair

        largest, arguments = result.largest, self.request.arguments(self.maps)
        arguments |= {"surface": self.maps[0], "load": largest.total_load}
        ceiling, pair = plausibility.other_ceiling(largest), coarsen_pair(largest.pair)
        # The longer solve comes first, so that the remaining time is overestimated.
        variants: dict[str, dict[str, Any]] = {}
        if ceiling is not None:
            variants["calibrated ceiling"] = {"ceiling": ceiling}
        if pair is not None and (largest.ceiling is None or isinstance(largest.ceiling, float)):
            variants["coarser grid"] = {
                "surface": pair.surface,
                "counter_surface": pair.counter_surface,
                "ceiling": largest.ceiling,
            }
        for number, (label, changes) in enumerate(variants.items(), start=1):
            look = one_of_several(self.work.look, number, len(variants))

            def watch(state: Progress, label: str = label, look: OnProgress = look) -> None:
                look(replace(state, label=label))

            try:
                contact = self.work.solve(**arguments | changes, progress=watch)
            except (ConvergenceError, CapacityError):
                continue
            result = getattr(result, f"with_{label.replace(' ', '_')}")(contact)
        return result


@contextmanager
def cached_solver() -> Iterator[Solve]:
    """Yield a solver that caches contacts in temporary files."""
    with ExitStack() as stack:
        solved: list[tuple[dict[str, Any], dict[str, Any], IO[bytes]]] = []

        def solve_once(
            surface: Surface, *, progress: Any = None, **arguments: Any
        ) -> ContactResult:
            requested = {"surface": surface, **arguments}
            for known, rest, file in solved:
                if _same(known, requested):
                    return _load_maps(rest, file)
            result = solve_uncalibrated(surface, progress=progress, **arguments)
            file = stack.enter_context(tempfile.TemporaryFile())
            solved.append((requested, _spill_maps(result, file), file))
            return result

        yield solve_once


def _same(known: dict[str, Any], requested: dict[str, Any]) -> bool:
    """Return whether two contacts are equal, even if their maps are different objects."""
    maps = ("surface", "counter_surface")
    return all(
        _are_equal(known.get(name), requested.get(name))
        if name in maps
        else name in known and known[name] == requested[name]
        for name in requested
    )


def _are_equal(first: Surface | None, second: Surface | None) -> bool:
    import numpy as np

    if first is second or first is None or second is None:
        return first is second
    return first.pixel == second.pixel and np.array_equal(
        first.heights, second.heights, equal_nan=True
    )


def _spill_maps(result: ContactResult, file: IO[bytes]) -> dict[str, Any]:
    """Write the maps of a contact to a file and return the other arguments."""
    import numpy as np

    np.save(file, result.pressure)
    np.save(file, result.gap)
    there = {item.name: getattr(result, item.name) for item in fields(result)}
    return {name: there[name] for name in there.keys() - {"pressure", "gap"}}


def _load_maps(known: dict[str, Any], file: IO[bytes]) -> ContactResult:
    """Return a cached contact with the maps from its file."""
    import numpy as np

    from roughcontact.contact.result import ContactResult

    file.seek(0)
    return ContactResult(**known, pressure=np.load(file), gap=np.load(file))
