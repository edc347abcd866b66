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
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.request import options as shared, outputs, parsing
from roughcontact.request.option import PICTURES, Option, check
from roughcontact.request.parsing import about
from roughcontact.request.task import Given, Reading, Task

if TYPE_CHECKING:
    from roughcontact.material import hardening
    from roughcontact.material.material import Material


@dataclass(frozen=True)
class Request(Reading):
    """One run: what was asked for, checked as far as it can be without its files."""

    task: Task  # What is asked of the maps
    file: Path | None  # The measured map
    specified: Given  # The options that were given, as text, to repeat the run
    values: Mapping[str, Any]  # Their values
    files: tuple[Path, ...] = ()  # Maps to compare that belong to no group
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without looking at any file."""
        self._check_maps()
        self.bodies()
        check((*shared.RULES, *self.task.rules), self)
        self.task.check(self)
        for option, path in self._written:
            outputs.check_suffix(path, option)

    @classmethod
    def from_text(
        cls, task: Task, file: Path | None, specified: Given, files: tuple[Path, ...] = ()
    ) -> Request:
        """Return the request that options in words describe."""
        return cls(task, file, dict(specified), task.parsed(specified), files)

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        maps = [path for paths in self.groups.values() for path in paths]
        single = (self.file, self.get(shared.COUNTER_SURFACE))
        return [*(path for path in single if path is not None), *maps]

    @property
    def groups(self) -> dict[str, list[Path]]:
        """The files to compare by the names of their groups; empty of those that have none."""
        result: dict[str, list[Path]] = {"": list(self.files)} if self.files else {}
        for name, words in self.get(shared.GROUP) or ():
            result.setdefault(name, []).extend(path for word in words for path in matching(word))
        return result

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
        for name, value in self.specified.items():
            for text in value if isinstance(value, list) else [value]:
                words += [f"--{name}"] if text is True else [f"--{name}", str(text)]
        return shlex.join(self.names.get(word, word) for word in words)

    def solver(self, *options: Option[Any]) -> dict[str, Any]:
        """Return those options of the solver that were given; the models have own defaults."""
        return {item.argument: self.get(item) for item in options if item.name in self.values}

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

    def require_yield(self, requested: ArgumentRef) -> None:
        """Raise `InputError` unless one of the bodies can yield."""
        if all(body.yield_strength is None for body in self.bodies()):
            raise InputError(
                requested, " needs a ", ArgumentRef("yield_strength"),
                " such as '1 GPa', or a ", ArgumentRef("material"),
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
        files = [(item.name, path) for item, path in self._written if item.suffixes != PICTURES]
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
                f"is missing, see roughcontact {self.task.name} --help; or give ",
                ArgumentRef("body"),
                ", ",
                ArgumentRef("points"),
                " and ",
                ArgumentRef("size"),
                " for a nominal body without roughness",
                argument="file",
            )
        if self.get(shared.OVERRIDE_SIZE) and (not measured or self[shared.SIZE] is None):
            raise InputError(
                "needs a ",
                ArgumentRef("file"),
                " and a ",
                ArgumentRef("size"),
                argument="override_size",
            )
        if measured and self.get(shared.POINTS) is not None:
            raise InputError(
                "goes with a nominal ",
                ArgumentRef("body"),
                " without ",
                ArgumentRef("file"),
                "; see ",
                ArgumentRef("pixel"),
                argument="points",
            )

    def _material(self, options: tuple[Option[Any], ...]) -> Material:
        """Return the material of a body, from its options."""
        from roughcontact.material.material import Material

        material, *constants = options
        known, under = self[material], material.argument.removesuffix("material")
        values = {item.argument.removeprefix(under): self[item] for item in constants}
        specified = {name: value for name, value in values.items() if value is not None}
        if "yield_strength" in specified:
            # The law of hardening of the catalogue starts at the yield strength of the catalogue.
            specified["hardening"] = None
        for option, example in zip(constants, ("210 GPa", "0.3"), strict=False):
            if known is None and self[option] is None:
                raise InputError(
                    "is needed, such as ", ArgumentRef(option.argument, example), "; or ",
                    ArgumentRef(material.argument), " with a name of the catalog",
                    argument=option.argument,
                )  # fmt: skip
        try:
            return Material(**values) if known is None else replace(known, **specified)
        except InputError as error:
            if error.argument is not None:
                error.argument = f"{under}{error.argument}"
            raise


def _hardened(
    material: Material, yield_strength: float | None, requested: parsing.Hardening
) -> Material:
    """Return a material that hardens; ``yield_strength`` is as specified."""
    from roughcontact.material import hardening

    law: hardening.Isotropic
    if requested.law == "swift":
        law = _swift(yield_strength, requested.constants)
    elif material.yield_strength is None:
        name = requested.law or "kinematic"
        raise InputError(
            f"{name} needs a ",
            ArgumentRef("yield_strength"),
            " to start from",
            argument="hardening",
        )
    elif requested.law == "linear":
        law = hardening.Linear(material.yield_strength, requested.constants[0])
    else:
        law = hardening.Perfect(material.yield_strength)
    if requested.kinematic is None:
        return replace(material, yield_strength=None, hardening=law)
    with_back = hardening.Kinematic(law, requested.kinematic)
    return replace(material, yield_strength=None, hardening=with_back)


def _swift(yield_strength: float | None, constants: tuple[float, ...]) -> hardening.Swift:
    """Return Swift's law; ``yield_strength`` is as specified."""
    from roughcontact.material.hardening import Swift

    try:
        swift = Swift(*constants)
    except InputError as error:
        raise about("hardening", error) from None
    if yield_strength is not None and not math.isclose(yield_strength, swift.initial, rel_tol=1e-3):
        first, other = (units.engineering(value, "Pa") for value in (swift.initial, yield_strength))
        raise InputError(
            f"starts at a yield strength of {first}, but ", ArgumentRef("yield_strength"),
            f" is {other}; leave ", ArgumentRef("yield_strength"), " out", argument="hardening",
        )  # fmt: skip
    return swift


def matching(word: str) -> list[Path]:
    """Return the files that a word with wildcards fits, or the one that it names."""
    path = Path(word)
    if not any(sign in word for sign in "*?[") or path.exists():
        return [path]
    return sorted(Path(result) for result in glob.glob(word)) or [path]
