"""Commands and tasks: the analyses of the command line and of project files."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from roughcontact.errors import ArgumentRef, shorten_value
from roughcontact.request.options import Option, Rule

T = TypeVar("T")

# Command-line forms of Python functions.
_FUNCTIONS = {
    "rc.resolution_study": "--study",
    "result.uncertainty": "--uncertainty",
    "rc.solve_elastoplastic": "solve … --model elastoplastic",
    "rc.solve_elastoplastic, then unload": "solve --model elastoplastic --unload",
    "surface.filled()": "--missing fill",
    "depth": "depth, an argument in Python",
    "to_pandas()": "--verbose",
}

Given = Mapping[str, str | bool | list[str]]
"""Options as text, by name: True for a flag, a list for an option that may be repeated."""


# Largest number of known names in a message.
_MAX_KNOWN = 50


def unknown_name(noun: str, name: str, known: Sequence[str]) -> str:
    """Return the message on an unknown name, with the most similar known one."""
    close = get_close_matches(name, known, n=1)
    meant = f"did you mean {close[0]}? Known" if close else "known"
    rest = len(known) - _MAX_KNOWN
    more = f" and {rest} more" if rest > 0 else ""
    return (
        f"unknown {noun} {shorten_value(name)}; {meant} are {', '.join(known[:_MAX_KNOWN])}{more}"
    )


@dataclass(frozen=True, eq=False)
class Command:
    """Command of the command line."""

    name: str  # Name on the command line
    help: str  # Summary, details and an example
    options: tuple[Option[Any], ...]  # Options, in the order of the help
    short_help: str = ""  # Names of the main options, at the top of the help
    reads_map: bool = False  # Whether the command reads a map
    example: str = ""  # Example of a call, if not in the help

    @cached_property
    def by_name(self) -> Mapping[str, Option[Any]]:
        """Options of the command, by name."""
        return {option.name: option for option in self.options}

    def option_of_argument(self, argument: str) -> Option[Any] | None:
        """Return the option of an argument, None if there is none."""
        for option in self.options:
            if argument == option.argument or argument in option.arguments:
                return option
        return None

    def parse_options(self, specified: Given) -> dict[str, Any]:
        """Return the values of options given as text, by name."""
        values: dict[str, Any] = {}
        for name, value in specified.items():
            option = self.by_name[name]
            if isinstance(value, bool):
                values[name] = value
            elif option.many:
                texts = [value] if isinstance(value, str) else value
                values[name] = tuple(option.parse(text, option.argument) for text in texts)
            else:
                values[name] = option.parse(str(value), option.argument)
        return values

    def parse_values(self, specified: Given) -> OptionValues:
        """Return the parsed options for options given as text."""
        return OptionValues(self, self.parse_options(specified))

    def spell_argument(self, mention: ArgumentRef) -> str:
        """Return an argument in the syntax of the command line."""
        if mention.name == "file" and self.reads_map:
            return "FILE"
        option = self.option_of_argument(mention.name)
        if option is None:
            return _FUNCTIONS.get(mention.name, str(mention))
        value = mention.value
        is_bare = value is None or value is True
        return shlex.join(option.words(is_bare or option.text(value)))


@dataclass(frozen=True)
class OptionValues:
    """Values of the options of a command: ``self[VISCOSITY]``."""

    task: Command
    values: Mapping[str, Any]  # Values of the given options

    def __getitem__(self, option: Option[T]) -> T:
        """Return the value of an option; raise `KeyError` unless the task has the option."""
        if self.task.by_name.get(option.name) is not option:
            raise KeyError(option.name)
        return self.values.get(option.name, option.default)

    def get(self, option: Option[T]) -> T | None:
        """Return the value of the task's option of the same name, None if there is none."""
        own = self.task.by_name.get(option.name)
        return None if own is None else self.values.get(own.name, own.default)

    def require(self, option: Option[T | None]) -> T:
        """Return the value of an option that the rules require."""
        value = self[option]
        assert value is not None
        return value

    def is_given(self, option: Option[Any]) -> bool:
        """Return whether the task's option of the same name differs from its default."""
        own = self.task.by_name.get(option.name)
        return own is not None and bool(self[own] != own.default)


@dataclass(frozen=True, eq=False)
class Analysis:
    """Analysis of a task in the app."""

    name: str  # Title
    about: str  # Result in one sentence
    options: tuple[Option[Any], ...] = ()  # Arguments in addition to the contact
    initial: tuple[tuple[Option[Any], str | bool], ...] = ()  # Initial values
    fixed: tuple[tuple[Option[Any], str | bool], ...] = ()
    folded: tuple[Option[Any], ...] = ()  # Rarely used arguments
    is_command: bool = False  # Whether the app shows its command, as it takes minutes


@dataclass(frozen=True)
class Subtasks:
    """Subtasks of a request, which can be solved separately."""

    names: Callable[[Any], tuple[str, ...]]  # `names(request)` returns the identifiers
    solve: Callable[..., Any]  # `solve(request, word, say, look)` returns the result of one
    file_of: Callable[[Any, str], Path | None]  # `file_of(request, word)` returns its map


def _numbers(outcome: Any) -> dict[str, Any]:
    return outcome.result.summary()


def _accept_all(_: Any) -> None:
    """Accept every request."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Task(Command):
    """Analysis of maps, as a command."""

    run: Callable[[Any, Any], Any]  # `run(request, work)` returns the `Outcome`
    rules: tuple[Rule, ...] = ()  # Rules between its options
    check: Callable[[Any], object] = _accept_all
    record: Callable[[Any], dict[str, Any]] = _numbers
    last: Callable[[Any], dict[str, Any]] | None = None
    held: int | str = 0  # Maps in memory in addition to the contact, or place of their number
    memory: Callable[[Any, tuple[int, int]], object] | None = None
    writes: tuple[tuple[Option[Any], Callable[[Any, Path], object]], ...] = ()
    figures: Callable[[Any], str] | None = None  # `figures(request)` returns the place of a table
    questions: tuple[Analysis, ...] = ()  # Analyses in the app
    maps: tuple[str, ...] = ("file",)
    needs_map: bool = True  # Whether a map or a nominal body is required
    shares_contacts: bool = False  # Whether its contacts may be cached for other tasks
    in_projects: bool = True  # Whether project files may contain it
    uncoated: str = ""  # Why it takes no coatings, if it solves contacts without them
    pieces: Subtasks | None = None  # Subtasks, if any
    reads_map: bool = True
    presentations: Mapping[str, str] = field(default_factory=dict)  # By class of results

    @property
    def many_maps(self) -> bool:
        """Whether the task accepts several maps."""
        return "files" in self.maps

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the task by reference to its module."""
        return _task_of, (self.run,)


def _task_of(run: Any) -> Any:
    # A `lambda` cannot be loaded in another process.
    return sys.modules[run.__module__].TASK
