"""An option: one object, the key by which its value is read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, TypeVar

from roughcontact import units
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

    MAP = "Map"
    HEIGHTS = "Heights"
    TEXTURE = "Texture"
    BODIES = "Bodies and load"
    SOLVER = "Solver"
    ENGINE = "Engine"
    SERVER = "Server"
    OUTPUT = "Output"


@dataclass(frozen=True, eq=False)
class Option(Generic[T_co]):
    """One word of the commands that list it, and of project files.

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
    default : object
        Value where nothing is given.
    label : str
        What the page calls it; by default its name.
    prepares : bool
        Whether the prepared maps depend on it; maps are prepared by these options alone.
    whole_map : bool
        Whether it needs the map whole in one process, and is refused on several ranks.
    many : bool
        Whether it may be given several times; the values, tuples, are joined.
    suffixes : tuple of str
        Of a file to write: how its name may end.
    arguments : tuple of str
        What the public functions call it, where they have names of their own for it.
    """

    name: str
    panel: str
    metavar: str
    help: str
    parse: Callable[[str, str], T_co]
    default: T_co
    label: str = ""
    prepares: bool = False
    whole_map: bool = True
    many: bool = False
    suffixes: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make a label of the name where none is given."""
        object.__setattr__(self, "label", self.label or self.name.replace("-", " ").capitalize())

    @property
    def argument(self) -> str:
        """What errors and `Mention` call it."""
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
