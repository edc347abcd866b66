"""Outcome of a request, and the context of a task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import RoughcontactError, Sentence, message_parts
from roughcontact.request.options import CEILING, FOLDER, MAX_ITERATIONS
from roughcontact.request.outputs import SavedSteps, Say, UnfinishedError
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress

if TYPE_CHECKING:
    from roughcontact.cautions import Caution
    from roughcontact.contact.result import ContactResult
    from roughcontact.surface.surface import Surface

OnProgress = Callable[[Progress], None]
OnPreview = Callable[["ContactResult"], None]
Solve = Callable[..., "ContactResult"]
"""`contact.solve.solve`, or a function with the same arguments and result."""


def ignore(_: Any) -> None:
    """Do nothing: a callback without effect."""


def solve_uncalibrated(surface: Surface, **options: Any) -> ContactResult:
    """Solve a contact; see `contact.solve.solve`."""
    from roughcontact.contact.solve import solve

    return solve(surface, **options, calibrated=False)


@dataclass(frozen=True, eq=False)
class TaskContext:
    """Context of a running task."""

    request: Request  # Request of the task
    read: Callable[[], Sequence[Surface]]  # Returns the prepared maps
    say: Say  # Called with a short text before every stage
    look: OnProgress  # Called with the `Progress` of the solver
    solve: Solve = solve_uncalibrated  # Solver of contacts, shared by several tasks
    known: Mapping[str, Any] = field(default_factory=dict)
    show: OnPreview = ignore  # Called with the contact before its calibrated ceiling

    @cached_property
    def maps(self) -> Sequence[Surface]:
        """Prepared maps of the bodies in contact."""
        return self.read()

    @property
    def extra_cautions(self) -> tuple[Caution, ...]:
        """Cautions from the measurement."""
        from roughcontact.request.preparation import resolution_cautions

        return resolution_cautions(self.request, self.maps)

    def add_calibrated(self, contact: ContactResult) -> ContactResult:
        """Return a contact with its changes under its second ceiling, the rule of all tasks."""
        from roughcontact.contact.solve import add_calibrated

        if contact.ceiling is None or not contact.converged:
            return contact
        ceiling, iterations = self.request[CEILING], self.request.solver(MAX_ITERATIONS)
        return add_calibrated(contact, ceiling, **iterations, progress=self.look)

    @contextmanager
    def report_saved_steps_on_interrupt(
        self, pattern: str, part: str
    ) -> Iterator[tuple[OnProgress, list[int]]]:
        """Track the saved steps of the folder; on Ctrl-C, report the complete ones."""
        reused: list[int] = []
        last = Progress(1, 0, None)

        def watch(state: Progress) -> None:
            nonlocal last
            last = state
            if state.kept:
                reused.append(state.number)
            self.look(state)

        try:
            yield watch, reused
        except KeyboardInterrupt:
            folder = self.request.get(FOLDER)
            if folder is None:
                raise UnfinishedError(()) from None
            files = sorted(folder.glob(pattern))
            # Some steps have no file, and the last step has not been reported yet.
            number = max(last.number - (not last.kept), len(files))
            raise UnfinishedError(files, SavedSteps(number, last.count, part, folder)) from None


@dataclass(frozen=True)
class Outcome:
    """Outcome of a request."""

    request: Request  # Request of the run
    result: Any  # Result of the task
    contact: ContactResult | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)
    written: tuple[Path, ...] = ()  # Complete files
    failure: RoughcontactError | None = None  # Reason why a file could not be written

    @property
    def extra_results(self) -> dict[str, Any]:
        """Further results in console and report, by their names in the presentation."""
        names = {"study": "study", "first_yield": "onset"}
        return {new: self.extras[name] for name, new in names.items() if name in self.extras}

    @property
    def status(self) -> str:
        """``"converged"``, or the reason why the solver stopped."""
        # A sweep or history raises an error if a step does not converge.
        return getattr(self.result, "status", "converged")

    @property
    def converged(self) -> bool:
        """Whether the solver converged, so that files are written."""
        return self.status == "converged"

    @property
    def reused(self) -> int:
        """Number of load steps reused from an earlier run."""
        return int(self.extras.get("reused", 0))

    @property
    def shortfall(self) -> Sentence:
        """Accuracy reached by a solver that did not converge, and the reason of its stop."""
        reached, result = "", self.contact
        # For the volume model, all listed increments have converged; the status has the rest.
        if result is not None and self.result is result:
            reached = (
                f"certificate {result.certificate:.1e}, tolerance {result.tolerance:.0e}, "
                f"load error {result.load_error:.1e}; "
            )
        return Sentence(f"not converged: {reached}", *message_parts(self.status))

    def record(self) -> dict[str, Any]:
        """Return all values by name, in SI units, ready for JSON."""
        from roughcontact.report.presentation import presentation_of

        record = self.request.task.record(self)
        answer = presentation_of(self.result, **self.extra_results).answer()
        return {"answer": answer, **record, "written": [str(path) for path in self.written]}


def last_contact(outcome: Outcome) -> dict[str, Any]:
    """Return the main values of the contact of an outcome, with keys of `Outcome.record`."""
    assert outcome.contact is not None
    numbers = outcome.contact.summary()
    keys = ("load", "max_pressure", "contact_fraction", "saturated_fraction", "certificate")
    return {key: numbers[key] for key in (*keys, "ceiling")} | {"load": outcome.contact.total_load}
