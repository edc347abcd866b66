"""One word of the command line and of project files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from roughcontact.request import parsing

SOLVE, SWEEP, STRESS, HISTORY, FIND = "solve", "sweep", "stress", "history", "find"
ROLL = "roll"
COMPARE, CONDUCTANCE, LAW, LEAK = "compare", "conductance", "law", "leak"
SINGLE = (SOLVE, SWEEP, STRESS, HISTORY, ROLL, FIND, CONDUCTANCE, LAW, LEAK)
"""Tasks on one contact."""
JOINTS = (CONDUCTANCE, LAW, LEAK)
"""Tasks on what a joint does, of which several may be asked of one contact."""
LOADED = tuple(task for task in JOINTS if task != LAW)
"""Those of them that take single loads, too."""
SEVERAL = (LAW, COMPARE)
"""Tasks that take several maps."""
TASKS = (*SINGLE, COMPARE)
"""What a run can be asked for; each is a command, and a ``task`` of a project file."""
CAPPED = tuple(task for task in TASKS if task != ROLL)
"""Those whose pressure has a ceiling."""
ESTIMATE = "estimate"
PREPARED = (*TASKS, ESTIMATE)
"""Commands that prepare a map and know two bodies."""

MAP, BODIES, SOLVER, OUTPUT = "Map", "Bodies and load", "Solver", "Output"
"""Headings of the help."""

TABLES = (".csv", ".json")
PICTURES = (".png", ".svg", ".pdf")
LENGTH, PRESSURE = (parsing.quantity(name) for name in ("length", "pressure"))


@dataclass(frozen=True)
class Option:
    """One word of the commands that it fits, and of project files.

    Parameters
    ----------
    name : str
        As users write it, without dashes in front.
    panel : str
        Heading under which the help lists it.
    metavar : str
        What is to be given; empty for a flag.
    help : str
        What it does.
    parse : callable
        ``parse(text, argument)`` returns the value; its errors carry the argument.
    fits : tuple of str
        Commands that have it.
    default : object
        Value where nothing is given.
    many : bool
        Whether it may be given several times.
    arguments : tuple of str
        What the public functions call it, where they have names of their own for it.
    suffixes : tuple of str
        Of a file to write: how its name may end.
    prepares : bool
        Whether the prepared maps depend on it; maps are prepared by these options alone.
    model : str
        The only model of ``SOLVE`` that it serves; empty for both.
    """

    name: str
    panel: str
    metavar: str
    help: str
    parse: Callable[[str, str], Any] = parsing.flag
    fits: tuple[str, ...] = TASKS
    default: Any = None
    many: bool = False
    arguments: tuple[str, ...] = ()
    suffixes: tuple[str, ...] = ()
    prepares: bool = False
    model: str = ""

    @property
    def argument(self) -> str:
        """What errors and `Mention` call it."""
        return self.name.replace("-", "_")

    @property
    def is_place(self) -> bool:
        """Whether it names a file or a folder."""
        return self.parse in (parsing.path, parsing.group) or bool(self.suffixes)

    @property
    def is_flag(self) -> bool:
        """Whether it is given without a value."""
        return not self.metavar
