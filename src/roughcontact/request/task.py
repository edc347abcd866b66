"""A task: what a command and a ``task`` of a project file ask for, in one object."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from roughcontact.request.option import Option


class Asked(Protocol):
    """What a task sees of the request that it carries out."""

    @property
    def given(self) -> Mapping[str, Any]:
        """The options as text."""

    @property
    def loads(self) -> Any:
        """Loads or nominal pressures."""

    def __getitem__(self, name: str) -> Any:
        """Return the value of an option."""


@dataclass(frozen=True)
class Question:
    """How the page asks it.

    Parameters
    ----------
    name, about : str
        What is asked, and what one learns.
    options : tuple of str
        What is given besides the contact.
    first : tuple of (str, str or bool)
        Values to begin with.
    """

    name: str
    about: str
    options: tuple[str, ...] = ()
    first: tuple[tuple[str, str | bool], ...] = ()


@dataclass(frozen=True)
class Task:
    """One thing to ask of maps.

    Parameters
    ----------
    name : str
        Of the command.
    help : str
        First sentence, what else there is to say, and an example.
    options : tuple of Option
        That no other task has.
    common : tuple of str
        Options of the help's first screen besides its own.
    run : callable
        ``run(request, contacts)`` returns the result.
    check : callable
        ``check(request)`` refuses what can be seen to be wrong without any file.
    held : int
        Maps that it takes beside the contact.
    question : Question or None
        How the page asks it.
    """

    name: str
    help: str
    options: tuple[Option, ...]
    common: tuple[str, ...]
    run: Callable[[Any, Any], Any]
    check: Callable[[Asked], object] = lambda _: None
    held: int = 0
    question: Question | None = None
