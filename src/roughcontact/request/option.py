"""An option: one object, the key by which its value is read."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum, StrEnum, auto
from typing import Any, Generic, TypeVar

from roughcontact import units
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.request import parsing

T_co = TypeVar("T_co", covariant=True)

TABLES = (".csv", ".json")
PICTURES = (".png", ".svg", ".pdf")
LENGTH, PRESSURE = (parsing.quantity(name) for name in ("length", "pressure"))

_UNITS: dict[Any, str] = {
    parsing.load: "N", parsing.nominal: "Pa", LENGTH: "m", PRESSURE: "Pa", parsing.ceiling: "Pa",
}  # fmt: skip


class Panel(StrEnum):
    """Headings of the help."""

    MAP = "Map and preparation"
    HEIGHTS = "Heights"
    TEXTURE = "Texture"
    BODIES = "Bodies and load"
    SOLVER = "Accuracy"
    ENGINE = "Where to run"
    SERVER = "Server"
    OUTPUT = "Output"


@dataclass(frozen=True, eq=False)
class Option(Generic[T_co]):
    """One word of the commands that list it, and of project files."""

    name: str  # As users write it, without dashes in front
    panel: str  # Heading under which the help lists it
    metavar: str  # What is to be given
    help: str  # What it does
    parse: Callable[[str, str], T_co]  # `parse(text, argument)` returns the value
    default: T_co  # Value where nothing is given
    label: str = ""  # What the page calls it
    prepares: bool = False  # Whether the prepared maps depend on it
    whole_map: bool = True
    many: bool = False  # Whether it may be given several times
    suffixes: tuple[str, ...] = ()  # Of a file to write: how its name may end
    arguments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make a label of the name where none is given."""
        object.__setattr__(self, "label", self.label or self.name.replace("-", " ").capitalize())

    @property
    def argument(self) -> str:
        """What errors and `ArgumentRef` call it."""
        return self.name.replace("-", "_")

    @property
    def is_place(self) -> bool:
        """Whether it names a file or a folder."""
        return self.parse in (parsing.path, parsing.groups) or bool(self.suffixes)

    @property
    def is_written(self) -> bool:
        """Whether it names files or a folder that are written."""
        return self.is_place and self.panel == Panel.OUTPUT

    @property
    def is_flag(self) -> bool:
        """Whether it is given without a value."""
        return not self.metavar

    def text(self, value: object) -> str:
        """Return a value as it would be given."""
        unit = _UNITS.get(self.parse)
        if not isinstance(value, float):
            return str(value)
        return f"{value:g}" if unit is None else units.engineering(value, unit)


def flag(name: str, panel: str, text: str, **more: Any) -> Option[bool]:
    """Return an option without a value."""
    return Option(name, panel, "", text, parsing.flag, False, **more)


def file(
    name: str, metavar: str, text: str, suffixes: tuple[str, ...] = (), **more: Any
) -> Option[Any]:
    """Return an option of one file or folder that is written."""
    return Option(name, Panel.OUTPUT, metavar, text, parsing.path, None, suffixes=suffixes, **more)


def files(name: str, text: str, suffixes: tuple[str, ...], **more: Any) -> Option[Any]:
    """Return an option of files that are written."""
    return Option(
        name, Panel.OUTPUT, "FILE", text, parsing.paths, (), many=True, suffixes=suffixes, **more
    )


# --- What options ask of each other, as data ---


class Demand(Enum):
    """What a rule asks of its options."""

    NEEDED = auto()
    NEEDS = auto()
    EXCLUDES = auto()
    ONE_OF = auto()
    ANY_OF = auto()


NEEDED, NEEDS, EXCLUDES, ONE_OF, ANY_OF = Demand


@dataclass(frozen=True, init=False)
class Rule:
    """What some options ask of each other."""

    demand: Demand  # `NEEDED`: the first is given
    options: tuple[Option[Any], ...]  # Of which it speaks
    value: str = ""  # Of a `NEEDS`: what the other has to be
    text: str = ""  # What to give, or an example of it

    def __init__(self, demand: Demand, *options: Option[Any], **more: str) -> None:
        for name, held in {"demand": demand, "options": options, **more}.items():
            object.__setattr__(self, name, held)


def check(rules: Iterable[Rule], request: Any) -> None:
    """Raise `InputError` for the first rule that a request breaks."""
    for rule in rules:
        first, *others = rule.options
        about = first.argument
        specified = [option for option in rule.options if request.is_given(option)]
        if rule.demand is NEEDED and not specified:
            raise InputError(f"is needed: {rule.text}", argument=about)
        if rule.demand is ONE_OF and len(specified) != 1:
            raise InputError(
                "give one of ", *listed(rule.options, " and "), ", and no more than one, such as ",
                ArgumentRef(about, rule.text),
            )  # fmt: skip
        if rule.demand is ANY_OF and not specified:
            raise InputError("nothing is asked: give ", *listed(rule.options, " or "))
        if rule.demand is NEEDS and rule.value:
            if first in specified and request.get(others[0]) != rule.value:
                needed = ArgumentRef(others[0].argument, rule.value)
                raise InputError("needs ", needed, argument=about)
        elif rule.demand is NEEDS and specified == [first]:
            raise InputError("needs ", *listed(others, " or "), argument=about)
        if rule.demand is EXCLUDES and first in specified and specified != [first]:
            raise InputError("goes without ", *listed(others, " and "), argument=about)


def listed(options: Iterable[Option[Any]], last: str) -> list[Any]:
    """Return mentions of options with commas between them, and a word before the last."""
    mentions: list[Any] = [ArgumentRef(option.argument) for option in options]
    parts = [part for mention in mentions for part in (mention, ", ")][:-1]
    if len(mentions) > 1:
        parts[-2] = last
    return parts
