"""Exceptions and checks of arguments; messages state problem, value and remedy.

An error is data: the argument, its value, and a sentence that refers to other arguments by
`ArgumentRef`. Each interface (Python, an option, a key of a project file, a web form) has its
spelling of arguments; `str` returns the spelling of Python.
"""

from __future__ import annotations

import ast
import json
import math
import re
import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import zip_longest
from numbers import Integral, Real


@dataclass(frozen=True)
class ArgumentRef:
    """Reference to an argument of the public API within a sentence."""

    name: str  # As Python spells it: `"max_iterations"`
    value: object = None  # Value that the sentence recommends or mentions

    def __str__(self) -> str:
        """Return the argument in Python syntax: ``precision="single"``."""
        if self.value is None:
            return self.name
        value = f'"{self.value}"' if isinstance(self.value, str) else repr(self.value)
        return f"{self.name}={value}"

    def __format__(self, spec: str) -> str:
        """Return the marker by which `split_message` finds the argument in an f-string."""
        return f"\0{json.dumps([self.name, self.value])}\0"


_MAX_VALUE, _MAX_PATH = 80, 300
"""Maximum length of a value in a message, and of one with the separators of a path."""

# A quoted text; an apostrophe follows a letter and begins none.
_QUOTED = re.compile(r"""(?<!\w)(['"])(?:\\.|[^\\])*?\1(?!\w)""", re.DOTALL)
_LONG_WORD = re.compile(rf"\S{{{_MAX_VALUE + 1},}}")


def shorten_value(value: object) -> str:
    """Return a value as text, cut in the middle if it is long."""
    text = str(value)
    limit = _MAX_PATH if "/" in text or "\\" in text else _MAX_VALUE
    if len(text) <= limit:
        return text
    return f"{text[: limit // 2]}…{text[1 + limit // 2 - limit :]}"


def shorten_message(text: str) -> str:
    """Return a message in which long quoted texts and words are cut; see `shorten_value`."""
    for values in (_QUOTED, _LONG_WORD):
        text = values.sub(lambda match: shorten_value(match[0]), text)
    return text


Part = str | ArgumentRef
_MARK = re.compile(r"\x00(\[[^\x00]*\])\x00")

_SPELLED = re.compile(r'\b([a-z_]+)=("[^"]*"|True|False|-?[\d.]+(?:e[+-]?\d+)?)')
"""Argument with a value, in Python syntax."""

Spell = Callable[[ArgumentRef], str]
"""Function that returns the spelling of an argument in one interface."""


def read_message(text: str) -> tuple[Part, ...]:
    """Return the parts of a message in Python syntax; arguments without a value stay text."""
    pieces = _SPELLED.split(text)
    names, values = pieces[1::3], map(ast.literal_eval, pieces[2::3])
    arguments = [ArgumentRef(name, value) for name, value in zip(names, values, strict=True)]
    return tuple(
        part for pair in zip_longest(pieces[::3], arguments, fillvalue="") for part in pair if part
    )


def split_message(*parts: Part) -> tuple[Part, ...]:
    """Return the parts of a message; each argument within an f-string becomes a part."""
    pieces: list[Part] = []
    for part in parts:
        if isinstance(part, ArgumentRef):
            pieces.append(part)
            continue
        for number, piece in enumerate(_MARK.split(part)):
            if number % 2:
                pieces.append(ArgumentRef(*json.loads(piece)))
            elif piece:
                pieces.append(piece)
    return tuple(pieces)


def render_message(parts: tuple[Part, ...], spell: Spell = str) -> str:
    """Return a sentence in the terms of one interface."""
    return "".join(part if isinstance(part, str) else spell(part) for part in parts)


class Sentence(str):
    """Text with Python names of arguments that retains its `ArgumentRef` parts."""

    parts: tuple[Part, ...]  # Same message, to be rendered for another interface

    def __new__(cls, *parts: Part) -> Sentence:
        """Render the parts with Python names of arguments."""
        parts = split_message(*parts)
        text = super().__new__(cls, render_message(parts))
        text.parts = parts
        return text


def message_parts(text: str) -> tuple[Part, ...]:
    """Return the parts of a `Sentence`, or any other text as one part."""
    return text.parts if isinstance(text, Sentence) else (text,)


class RoughcontactError(Exception):
    """Base of every error that this package raises on purpose.

    Parameters
    ----------
    *parts : str or ArgumentRef
        Parts of the sentence; if ``argument`` is given, without the name of the argument.
    argument : str, optional
        The argument that cannot be used, as Python spells it.
    value : object, optional
        Value of the argument.
    """

    def __init__(self, *parts: Part, argument: str | None = None, value: object = None) -> None:
        self.parts = tuple(
            part if isinstance(part, ArgumentRef) else shorten_message(part)
            for part in split_message(*parts)
        )
        super().__init__(*self.parts)
        self.argument = argument
        self.value = value

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the error with its attributes."""
        # With two bases in C, the constructor found first may belong to the base that cannot
        # create it.
        return (Exception.__new__, (type(self), *self.args), self.__dict__)

    @property
    def sentence(self) -> tuple[Part, ...]:
        """Parts of the whole message, for use within another message."""
        return (
            self.parts if self.argument is None else (ArgumentRef(self.argument), " ", *self.parts)
        )

    def message_for(self, spell: Spell = str) -> str:
        """Return the message for one interface; see `render_message`."""
        return render_message(self.sentence, spell)

    def __str__(self) -> str:
        """Return the message in terms of Python."""
        return self.message_for()


class InputError(RoughcontactError, ValueError):
    """An argument, a quantity or the content of a file cannot be used."""


class FormatError(InputError):
    """A file is missing, unreadable, truncated or of another type than expected."""


class CapacityError(InputError):
    """The requested load or approach has no solution."""


class OtherRunError(InputError):
    """The folder contains load steps of another run."""


class InsufficientMemoryError(RoughcontactError, MemoryError):
    """The problem needs more memory than the machine has."""


class ConvergenceError(RoughcontactError, RuntimeError):
    """The solver stopped above its tolerance.

    Attributes
    ----------
    result : ContactResult or ElastoplasticResult
        The best result found; its ``status`` gives the reason why the solver stopped.
    """

    def __init__(self, message: str, result: object) -> None:
        super().__init__(*message_parts(message))
        self.result = result


def short_repr(value: object) -> str:
    """Return a short representation of an argument; long integers are abbreviated."""
    return " ".join(_SHORT_REPR.repr(value).split())


class _ShortRepr(reprlib.Repr):
    def repr_int(self, x: int, level: int) -> str:
        """Return an integer as text, or its number of digits if it is long."""
        if abs(x) < 10**18:
            return str(x)
        return f"a whole number of {int(math.log10(abs(x))) + 1} digits"

    def repr_instance(self, x: object, level: int) -> str:
        """Return the representation of any other object, or its class if that is too long."""
        text = super().repr_instance(x, level)
        return type(x).__name__ if self.fillvalue in text else text


_SHORT_REPR = _ShortRepr()
_SHORT_REPR.maxstring = _SHORT_REPR.maxother = _MAX_VALUE
_SHORT_REPR.fillvalue = "…"


def input_error(argument: str, value: object, wanted: str) -> InputError:
    """Return the `InputError` of an argument, with expected and actual value."""
    return InputError(f"{wanted}, got {short_repr(value)}", argument=argument, value=value)


def require_positive(**values: float) -> None:
    """Raise `InputError` unless all values, by argument, are positive and finite."""
    for name, value in values.items():
        if not isinstance(value, Real) or not 0 < value < math.inf:
            raise input_error(name, value, "must be positive and finite")


def require_count(minimum: int, maximum: int, **values: object) -> None:
    """Raise `InputError` unless all values, by argument, are integers in range."""
    for name, value in values.items():
        if not isinstance(value, Integral) or not minimum <= int(value) <= maximum:
            raise input_error(name, value, f"must be a whole number from {minimum} to {maximum}")


def require_choice(known: tuple[str, ...], **values: object) -> None:
    """Raise `InputError` unless all values, by argument, are known choices."""
    for name, value in values.items():
        if not isinstance(value, str) or value not in known:
            choices = " or ".join(repr(choice) for choice in known)
            raise input_error(name, value, f"must be {choices}")


def require_pixel(pixel: tuple[float, float]) -> None:
    """Raise `InputError` unless both edges of a pixel are positive and finite."""
    if len(pixel) != 2 or not all(0 < edge < math.inf for edge in pixel):
        raise input_error("pixel", pixel, "must be positive and finite (dy, dx) [m]")
