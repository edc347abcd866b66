"""What one run is asked for, checked as far as it can be without its files."""

from __future__ import annotations

import glob
import math
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact import units
from roughcontact.errors import InputError, Mention
from roughcontact.request import options as shared, outputs, parsing, rule
from roughcontact.request.option import PICTURES, Option
from roughcontact.request.parsing import about
from roughcontact.request.task import Given, Reading, Task

if TYPE_CHECKING:
    from roughcontact.material import hardening
    from roughcontact.material.material import Material


@dataclass(frozen=True)
class Request(Reading):
    """One run: what was asked for, checked as far as it can be without its files.

    ``request[S_FILTER]`` is the value of an option: that given, or else its default. What serves
    several tasks asks by ``request.get(FOLDER)`` for an option that only some of them have.

    Parameters
    ----------
    task : Task
        What is asked of the maps.
    file : Path or None
        The measured map; without it, a nominal body on ``points``.
    given : Mapping
        The options that were given, as text, to repeat the run.
    values : Mapping
        Their values.
    files : tuple of Path
        Maps to compare that belong to no group.
    names : Mapping
        What the user calls files that lie elsewhere or have another name there, by path as text.
    """

    task: Task
    file: Path | None
    given: Given
    values: Mapping[str, Any]
    files: tuple[Path, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without looking at any file."""
        self._check_maps()
        self.bodies()
        rule.check((*shared.RULES, *self.task.rules), self)
        self.task.check(self)
        for option, path in self._written:
            outputs.check_suffix(path, option)

    @classmethod
    def from_text(
        cls, task: Task, file: Path | None, given: Given, files: tuple[Path, ...] = ()
    ) -> Request:
        """Return the request that options in words describe.

        Raises
        ------
        InputError
            If a value cannot be used, or values do not go together; it carries the argument.
        """
        return cls(task, file, dict(given), task.parsed(given), files)

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        maps = [path for paths in self.groups.values() for path in paths]
        single = (self.file, self.get(shared.COUNTER_SURFACE))
        return [*(path for path in single if path is not None), *maps]

    @property
    def groups(self) -> dict[str, list[Path]]:
        """The files to compare by the names of their groups; empty of those that have none."""
        found: dict[str, list[Path]] = {"": list(self.files)} if self.files else {}
        for name, words in self.get(shared.GROUP) or ():
            found.setdefault(name, []).extend(path for word in words for path in matching(word))
        return found

    @property
    def aligned(self) -> bool:
        """Whether the maps have to be brought to one grid."""
        return any(map(self.is_given, shared.MOVES))

    @property
    def load(self) -> tuple[Any, str]:
        """The load in the form in which it is given, None where there is none, and its argument."""
        option = shared.LOAD if self.get(shared.HERTZ) is None else shared.HERTZ
        return self.get(option), option.argument

    @property
    def command(self) -> str:
        """The command that repeats the run."""
        files = [*([] if self.file is None else [self.file]), *self.files]
        words = ["roughcontact", self.task.name, *map(str, files)]
        for name, value in self.given.items():
            for text in value if isinstance(value, list) else [value]:
                words += [f"--{name}"] if text is True else [f"--{name}", str(text)]
        return shlex.join(self.names.get(word, word) for word in words)

    def solver(self, *options: Option[Any]) -> dict[str, Any]:
        """Return those options of the solver that were given; the models have own defaults."""
        return {one.argument: self.get(one) for one in options if one.name in self.values}

    def bodies(self) -> tuple[Material, Material]:
        """Return the materials of both bodies; the counter-body is rigid if nothing is said."""
        from roughcontact.material.material import RIGID, Material

        body = self._material(shared.BODY_CONSTANTS)
        hardening = self.get(shared.HARDENING)
        if hardening is not None:
            body = _hardened(body, self[shared.YIELD_STRENGTH], hardening)
        strength = self[shared.COUNTER_YIELD_STRENGTH]
        if not any(map(self.is_given, shared.COUNTER_CONSTANTS[:-1])):
            rigid = Material(RIGID.young, 0.0, strength, RIGID.name) if strength else RIGID
            return body, rigid
        return body, self._material(shared.COUNTER_CONSTANTS)

    def require_yield(self, asked: Mention) -> None:
        """Raise `InputError` unless one of the bodies can yield."""
        if all(body.yield_strength is None for body in self.bodies()):
            raise InputError(
                asked, " needs a ", Mention("yield_strength"),
                " such as '1 GPa', or a ", Mention("material"),
                " that has one: otherwise nothing can yield",
            )  # fmt: skip

    @property
    def _written(self) -> list[tuple[Option[Any], Path]]:
        """The files that options name, but for those of several figures."""
        return [
            (option, path)
            for option in self.task.options
            if option.suffixes
            for path in (self[option] if option.many else (self[option],))
            if isinstance(path, Path)
        ]

    @property
    def outputs(self) -> tuple[Path, ...]:
        """Files for the result itself."""
        others = (shared.REPORT, *(option for option, _ in self.task.writes))
        return tuple(
            path
            for option, path in self._written
            if option not in others and option.suffixes != PICTURES
        )

    def figures(self) -> Iterator[tuple[str, str, Path]]:
        """Yield option, figure (empty: the only one) and file of what is to be drawn."""
        for option in self.task.options:
            value = self[option] if option.suffixes == PICTURES else None
            if isinstance(value, Path):
                yield option.name, "", value
            elif value is not None and self.task.figures is not None:
                files = outputs.figure_files(value, self.task.figures(self))
                yield from ((option.name, name, path) for name, path in files.items())

    @property
    def places(self) -> tuple[tuple[str, Path], ...]:
        """The files that are written, each with the argument that asks for it, in their order."""
        files = [(one.name, path) for one, path in self._written if one.suffixes != PICTURES]
        return (*files, *((option, path) for option, _, path in self.figures()))

    def check_places(self) -> None:
        """Refuse outputs that cannot be written, or would replace an input."""
        for argument, path in self.places:
            outputs.check_place(path, argument, self.inputs)

    def _check_maps(self) -> None:
        nominal = all(
            self.get(option) is not None for option in (shared.BODY, shared.POINTS, shared.SIZE)
        )
        measured = self.file is not None or bool(self.groups)
        if self.task.needs_map and not measured and not nominal:
            raise InputError(
                f"is missing, see roughcontact {self.task.name} --help; or give ", Mention("body"),
                ", ", Mention("points"), " and ", Mention("size"),
                " for a nominal body without roughness", argument="file",
            )  # fmt: skip
        if self.get(shared.OVERRIDE_SIZE) and (not measured or self[shared.SIZE] is None):
            raise InputError(
                "needs a ", Mention("file"), " and a ", Mention("size"), argument="override_size"
            )
        if measured and self.get(shared.POINTS) is not None:
            raise InputError(
                "goes with a nominal ", Mention("body"), " without ", Mention("file"), "; see ",
                Mention("pixel"), argument="points",
            )  # fmt: skip

    def _material(self, options: tuple[Option[Any], ...]) -> Material:
        """Return the material of a body, from its options."""
        from roughcontact.material.material import Material

        material, *constants = options
        known, under = self[material], material.argument.removesuffix("material")
        values = {one.argument.removeprefix(under): self[one] for one in constants}
        given = {name: value for name, value in values.items() if value is not None}
        if "yield_strength" in given:
            # The law of hardening of the catalogue starts at the yield strength of the catalogue.
            given["hardening"] = None
        for option, example in zip(constants, ("210 GPa", "0.3"), strict=False):
            if known is None and self[option] is None:
                raise InputError(
                    "is needed, such as ", Mention(option.argument, example), "; or ",
                    Mention(material.argument), " with a name of the catalogue",
                    argument=option.argument,
                )  # fmt: skip
        try:
            return Material(**values) if known is None else replace(known, **given)
        except InputError as error:
            if error.argument is not None:
                error.argument = f"{under}{error.argument}"
            raise


def _hardened(material: Material, given: float | None, asked: parsing.Hardening) -> Material:
    """Return a material that hardens; ``given`` is the yield strength that was asked for."""
    from roughcontact.material import hardening

    law: hardening.Isotropic
    if asked.law == "swift":
        law = _swift(given, asked.constants)
    elif material.yield_strength is None:
        name = asked.law or "kinematic"
        raise InputError(
            f"{name} needs a ", Mention("yield_strength"), " to start from", argument="hardening"
        )
    elif asked.law == "linear":
        law = hardening.Linear(material.yield_strength, asked.constants[0])
    else:
        law = hardening.Perfect(material.yield_strength)
    if asked.kinematic is None:
        return replace(material, yield_strength=None, hardening=law)
    with_back = hardening.Kinematic(law, asked.kinematic)
    return replace(material, yield_strength=None, hardening=with_back)


def _swift(given: float | None, constants: tuple[float, ...]) -> hardening.Swift:
    """Return Swift's law; ``given`` is the yield strength that was asked for."""
    from roughcontact.material.hardening import Swift

    try:
        swift = Swift(*constants)
    except InputError as error:
        raise about("hardening", error) from None
    if given is not None and not math.isclose(given, swift.initial, rel_tol=1e-3):
        first, other = (units.engineering(value, "Pa") for value in (swift.initial, given))
        raise InputError(
            f"starts at a yield strength of {first}, but ", Mention("yield_strength"),
            f" is {other}; leave ", Mention("yield_strength"), " out", argument="hardening",
        )  # fmt: skip
    return swift


def matching(word: str) -> list[Path]:
    """Return the files that a word with wildcards fits, or the one that it names."""
    path = Path(word)
    if not any(sign in word for sign in "*?[") or path.exists():
        return [path]
    return sorted(Path(found) for found in glob.glob(word)) or [path]
