"""What a joint does, asked of contacts that are solved as they are looked at.

Several questions about one contact share what is solved: see `once`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, fields, replace
from typing import IO, TYPE_CHECKING, Any, TypeAlias

from roughcontact.errors import CapacityError, ConvergenceError
from roughcontact.request import problem
from roughcontact.request.option import CONDUCTANCE, LAW
from roughcontact.request.request import Request
from roughcontact.request.tasks import TASKS
from roughcontact.solvers.progress import Progress

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.joint.conductance import Conductance
    from roughcontact.joint.interface import InterfaceLaw
    from roughcontact.surface.surface import Surface

    Joint: TypeAlias = Conductance | InterfaceLaw | Any
    """What is found: it has ``largest``, ``remarks``, ``summary`` and ``save``."""

Solve = Callable[..., "ContactResult"]
"""`contact.solve.solve`, or what gives the same for the same arguments."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """The contacts of a request, solved as they are asked for.

    Parameters
    ----------
    request : Request
        What was asked for.
    maps : sequence of Surface
        The maps that are pressed, prepared.
    look : callable
        Called with the `Progress` of the solver.
    solve : callable
        What solves them.
    more : sequence of Surface
        Further maps of the same surface, each of which is pressed in place of the first.
    """

    request: Request
    maps: Sequence[Surface]
    look: Callable[[Progress], None]
    solve: Solve
    more: Sequence[Surface] = ()

    def each(self) -> Iterator[Contacts]:
        """Yield the contacts of each map of the surface."""
        for surface in (self.maps[0], *self.more):
            yield self.of(surface)

    def of(self, surface: Surface) -> Contacts:
        """Return the contacts of another map."""
        return replace(self, maps=(surface, *self.maps[1:]), more=())

    def require_map(self, what: str) -> None:
        """Raise `InputError` for profiles, before anything is solved."""
        problem.pair_of(self.request, self.maps).require_map(what)

    def under(self, loads: Sequence[Any]) -> Iterator[ContactResult]:
        """Yield the contacts under some loads, in whatever form they were given.

        The largest comes first: what is too much for the bodies is refused at once.
        """
        forces = [problem.pressed(self.request, self.maps, load) for load in loads]
        forces.sort(key=lambda load: -load[0])
        options = problem.arguments(
            self.request, self.maps, "tolerance", "max-iterations", "precision"
        )
        for number, (force, given) in enumerate(forces, start=1):

            def watch(at: Progress, number: int = number) -> None:
                self.look(replace(at, number=number, count=len(forces)))

            found = self.solve(self.maps[0], **options, load=force, progress=watch)
            yield replace(found, given=given)

    def coarser(self, result: ContactResult) -> ContactResult | None:
        """Return the same contact on a grid of twice the pixel; None where it has too few points.

        None as well where it cannot be solved: it is looked at for the change alone.
        """
        from roughcontact.contact.resolution_study import coarsened

        pair, ceiling = coarsened(result.pair), result.ceiling
        if pair is None or not (ceiling is None or isinstance(ceiling, float)):
            return None
        options = problem.arguments(
            self.request, self.maps, "tolerance", "max-iterations", "precision"
        )
        options |= {"counter_surface": pair.counter_surface, "ceiling": ceiling}

        def watch(at: Progress) -> None:
            self.look(replace(at, label="coarser grid"))

        with suppress(ConvergenceError, CapacityError):
            return self.solve(pair.surface, **options, load=result.load, progress=watch)
        return None


def fresh(surface: Surface, **options: Any) -> ContactResult:
    """Solve a contact; see `contact.solve.solve`."""
    from roughcontact.contact.solve import solve

    return solve(surface, **options, calibrated=False)


@contextmanager
def once() -> Iterator[Solve]:
    """Give what solves a contact that it is asked for again only once.

    Yields
    ------
    callable
        What gives the same as `fresh` for the same arguments, bit by bit. The maps of pressure
        and gap wait in a file without a name, which goes with the block or the process, so that
        one contact at a time is in memory.
    """
    with ExitStack() as stack:
        kept: list[tuple[dict[str, Any], dict[str, Any], IO[bytes]]] = []

        def solve_once(surface: Surface, *, progress: Any = None, **options: Any) -> ContactResult:
            asked = {"surface": surface, **options}
            for known, rest, file in kept:
                if _same(known, asked):
                    return _filled(rest, file)
            result = fresh(surface, progress=progress, **options)
            file = stack.enter_context(tempfile.TemporaryFile())
            kept.append((asked, _emptied(result, file), file))
            return result

        yield solve_once


def _same(known: dict[str, Any], asked: dict[str, Any]) -> bool:
    """Return whether two contacts are one, whichever objects hold their maps."""
    maps = ("surface", "counter_surface")
    return all(
        _alike(known.get(name), asked.get(name))
        if name in maps
        else name in known and known[name] == asked[name]
        for name in asked
    )


def _alike(first: Surface | None, second: Surface | None) -> bool:
    import numpy as np

    if first is second or first is None or second is None:
        return first is second
    return first.pixel == second.pixel and np.array_equal(
        first.heights, second.heights, equal_nan=True
    )


def _emptied(result: ContactResult, file: IO[bytes]) -> dict[str, Any]:
    """Return what makes a contact but for its maps, which go to a file."""
    import numpy as np

    np.save(file, result.pressure)
    np.save(file, result.gap)
    there = {one.name: getattr(result, one.name) for one in fields(result)}
    return {name: there[name] for name in there.keys() - {"pressure", "gap", "_counted"}}


def _filled(known: dict[str, Any], file: IO[bytes]) -> ContactResult:
    """Return a contact with its maps again."""
    import numpy as np

    from roughcontact.contact.result import ContactResult

    file.seek(0)
    return ContactResult(**known, pressure=np.load(file), gap=np.load(file))


def _conductance(request: Request, contacts: Contacts) -> Conductance:
    from roughcontact.joint.conductance import OF, conductance

    contacts.require_map(OF)
    found = conductance(
        contacts.under(request.loads),
        *request.conductors(),
        film=request["film"] or 0.0,
        thermal_film=request["thermal-film"] or 0.0,
    )
    coarser = contacts.coarser(found.largest)
    return found if coarser is None else found.beside(coarser)


def _law(request: Request, contacts: Contacts) -> InterfaceLaw:
    from roughcontact.joint.law import OF
    from roughcontact.surface.partition import partition

    contacts.require_map(OF)
    maps = list(contacts.each())
    found = _law_of(request, maps)
    if not request["quarters"]:
        return found
    parts = [one.of(part) for one in maps for part in partition(one.maps[0], 2, request["level"])]
    return replace(found, parts=_law_of(request, parts))


def _law_of(request: Request, maps: Sequence[Contacts]) -> InterfaceLaw:
    """Return the law of some maps; where they flow, with the branch of unloading."""
    from roughcontact.contact.unloading import indented_surface
    from roughcontact.joint.law import interface_law

    left: list[Contacts] = []
    flowed: list[bool] = []

    def loading() -> Iterator[ContactResult]:
        for one in maps:
            # The first is that under the largest load.
            for number, result in enumerate(one.under(request.loads)):
                if number == 0:
                    left.append(one.of(indented_surface(result)))
                    flowed.append(result.saturated_fraction > 0)
                yield result

    def unloading() -> Iterator[ContactResult]:
        # What flowed does so no more up to the largest load: elastic, whatever the ceiling was.
        elastic = replace(request, values={**request.values, "ceiling": None})
        for one in left if any(flowed) else ():
            yield from replace(one, request=elastic).under(request.loads)

    body, counter_body = request.conductors()
    both = body.conductivity is not None and counter_body.conductivity is not None
    return interface_law(
        loading(),
        unloading(),
        body=body if both else None,
        counter_body=counter_body if both else None,
        thermal_film=request["thermal-film"] or 0.0,
    )


ASKED: dict[str, Callable[[Request, Contacts], Joint]] = {
    CONDUCTANCE: _conductance,
    LAW: _law,
    **{task.name: task.run for task in TASKS if task.run is not None},
}
"""What each task on a joint asks of its contacts."""
