"""Request of a run, checked as far as possible without reading its files."""

from __future__ import annotations

import glob
import math
import pkgutil
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact import units
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options as shared, outputs, parsing
from roughcontact.request.options import PICTURES, Option, check_rules
from roughcontact.request.outputs import Say
from roughcontact.request.parsing import as_argument_error
from roughcontact.request.task import Given, OptionValues, Subtasks, Task

if TYPE_CHECKING:
    from roughcontact.contact.load_case import GivenLoad
    from roughcontact.contact.pair import Pair
    from roughcontact.material import hardening
    from roughcontact.material.material import Material
    from roughcontact.surface.surface import Surface


@dataclass(frozen=True)
class Request(OptionValues):
    """Request of a run: its options, checked as far as possible without its files."""

    task: Task  # Analysis of the maps
    file: Path | None  # File of the measured map
    specified: Given  # Given options as text, to repeat the run
    files: tuple[Path, ...] = ()  # Files of maps without a group
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise the errors of a request that can be found without reading a file."""
        self._check_maps()
        _ = self.bodies
        check_rules((*shared.RULES, *self.task.rules), self)
        self.task.check(self)
        for option, path in self._written:
            outputs.check_suffix(path, option)

    @classmethod
    def from_text(
        cls, task: Task, file: Path | None, specified: Given, files: tuple[Path, ...] = ()
    ) -> Request:
        """Return the request for options given as text."""
        return cls(task, task.parse_options(specified), file, dict(specified), files)

    @property
    def inputs(self) -> list[Path]:
        """Input files."""
        maps = [path for paths in self.groups.values() for path in paths]
        single = (self.file, self.get(shared.COUNTER_SURFACE))
        counter_maps = self.get(shared.COUNTER_MAPS) or ()
        return [*(path for path in single if path is not None), *maps, *counter_maps]

    @property
    def read_files(self) -> list[Path]:
        """Input files, and the other files that options name."""
        texts = (
            (option, text)
            for option in self.task.options
            for value in [self.specified.get(option.name, [])]
            for text in (value if isinstance(value, list) else [value])
            if isinstance(text, str)
        )
        named = (Path(name) for option, text in texts for name in option.files_in(text))
        return list(dict.fromkeys((*self.inputs, *named)))

    @property
    def groups(self) -> dict[str, list[Path]]:
        """Files to compare, by group; the name of files without a group is empty."""
        result: dict[str, list[Path]] = {"": list(self.files)} if self.files else {}
        for name, words in self.get(shared.GROUP) or ():
            result.setdefault(name, []).extend(path for word in words for path in match_files(word))
        return result

    @property
    def aligned(self) -> bool:
        """Whether the maps have to be resampled on a common grid."""
        return any(map(self.is_given, shared.MOVES))

    @property
    def command(self) -> str:
        """Command that repeats the run."""
        files = [*([] if self.file is None else [self.file]), *self.files]
        words = ["roughcontact", self.task.name, *map(str, files)]
        for name, value in self.specified.items():
            for text in value if isinstance(value, list) else [value]:
                words += self.task.by_name[name].words(text) if text is not False else []
        return shlex.join(self.names.get(word, word) for word in words)

    def solver(self, *options: Option[Any]) -> dict[str, Any]:
        """Return the given options of the solver; each model has separate defaults."""
        listed = [item for item in options or shared.SOLVER if item is not shared.DEVICE]
        return {item.argument: self.get(item) for item in listed if item.name in self.values}

    @cached_property
    def bodies(self) -> tuple[Material, Material]:
        """Materials of both bodies; by default the counter-body is rigid."""
        from roughcontact.material.material import RIGID, Material

        body = self._material(shared.BODY_CONSTANTS)
        hardening = self.get(shared.HARDENING)
        if hardening is not None:
            body = _hardening_material(body, self[shared.YIELD_STRENGTH], hardening)
        strength = self[shared.COUNTER_YIELD_STRENGTH]
        if not any(map(self.is_given, shared.COUNTER_CONSTANTS[:-1])):
            other = Material(RIGID.young, 0.0, strength, RIGID.name) if strength else RIGID
        else:
            other = self._material(shared.COUNTER_CONSTANTS)
        layers = (self.get(option) or () for option in shared.COATINGS)
        body, other = (
            replace(bare, coating=coating) if coating else bare
            for bare, coating in zip((body, other), layers, strict=True)
        )
        return body, other

    def require_yield(self, requested: ArgumentRef) -> None:
        """Raise `InputError` unless at least one body has a yield strength."""
        if all(body.yield_strength is None for body in self.bodies):
            raise InputError(
                requested,
                " needs a ",
                ArgumentRef("yield_strength"),
                " such as '1 GPa', or a ",
                ArgumentRef("material"),
                " that has one: otherwise nothing can yield",
            )

    @property
    def _written(self) -> list[tuple[Option[Any], Path]]:
        """Output files given by options, except sets of figures."""
        return [
            (option, path)
            for option in self.task.options
            if option.suffixes
            for path in (self[option] if option.many else (self[option],))
            if isinstance(path, Path)
        ]

    @property
    def outputs(self) -> tuple[Path, ...]:
        """Output files of the result itself."""
        others = (shared.REPORT, *(option for option, _ in self.task.writes))
        return tuple(
            path
            for option, path in self._written
            if option not in others and option.suffixes != PICTURES
        )

    def figures(self) -> Iterator[tuple[str, str, Path]]:
        """Yield option, name (empty for a single figure) and file of the requested figures."""
        for option in self.task.options:
            value = self[option] if option.suffixes == PICTURES else None
            if isinstance(value, Path):
                yield option.name, "", value
            elif value is not None and self.task.figures is not None:
                table = pkgutil.resolve_name(f"roughcontact.{self.task.figures(self)}")
                files = outputs.figure_files(value, filter(None, (entry.name for entry in table)))
                yield from ((option.name, name, path) for name, path in files.items())

    @property
    def places(self) -> tuple[tuple[str, Path], ...]:
        """Output files with their arguments, in order."""
        files = [(item.name, path) for item, path in self._written if item.suffixes != PICTURES]
        return (*files, *((option, path) for option, _, path in self.figures()))

    def check_places(self) -> None:
        """Raise `InputError` for outputs that cannot be written or would replace an input."""
        for argument, path in self.places:
            outputs.check_place(path, argument, self.read_files)

    def _check_maps(self) -> None:
        nominal = all(
            self.get(option) is not None for option in (shared.BODY, shared.POINTS, shared.SIZE)
        )
        measured = self.file is not None or bool(self.groups)
        if self.task.needs_map and not measured and not nominal:
            raise InputError(
                f"is missing, see roughcontact {self.task.name} --help; or give "
                f"{ArgumentRef('body')}, {ArgumentRef('points')} and {ArgumentRef('size')} for a "
                "nominal body without roughness",
                argument="file",
            )
        if self.get(shared.OVERRIDE_SIZE) and (not measured or self[shared.SIZE] is None):
            raise InputError(
                f"needs a {ArgumentRef('file')} and a {ArgumentRef('size')}",
                argument="override_size",
            )
        if measured and self.get(shared.POINTS) is not None:
            raise InputError(
                f"needs a nominal {ArgumentRef('body')} without {ArgumentRef('file')}; see "
                f"{ArgumentRef('pixel')}",
                argument="points",
            )

    def _material(self, options: tuple[Option[Any], ...]) -> Material:
        """Return the material of a body from its options."""
        from roughcontact.material.material import Material

        material, *constants = options
        known, under = self[material], material.argument.removesuffix("material")
        values = {item.argument.removeprefix(under): self[item] for item in constants}
        specified = {name: value for name, value in values.items() if value is not None}
        if "yield_strength" in specified:
            # The hardening law of the catalog starts at the yield strength of the catalog.
            specified["hardening"] = None
        for option, example in zip(constants, ("210 GPa", "0.3"), strict=False):
            if known is None and self[option] is None:
                raise InputError(
                    f"is needed, such as {ArgumentRef(option.argument, example)}; or "
                    f"{ArgumentRef(material.argument)} with a name of the catalog",
                    argument=option.argument,
                )
        try:
            return Material(**values) if known is None else replace(known, **specified)
        except InputError as error:
            if error.argument is not None:
                error.argument = f"{under}{error.argument}"
            raise

    # --- Arguments of a solve ---

    def arguments(self, maps: Sequence[Surface]) -> dict[str, Any]:
        """Return the common arguments of `contact.solve` and similar functions, without load."""
        material, counter_material = self.bodies
        return {
            "material": material,
            "counter_material": counter_material,
            "counter_surface": maps[1] if len(maps) > 1 else None,
            "ceiling": self.get(shared.CEILING),
            "boundary": self[shared.BOUNDARY],
            **self.solver(),
        }

    def pair(self, maps: Sequence[Surface]) -> Pair:
        """Return the pair of bodies in contact."""
        from roughcontact.contact.pair import Pair

        material, counter_material = self.bodies
        counter = maps[1] if len(maps) > 1 else None
        return Pair(maps[0], material, counter, counter_material, self._boundary)

    def force(self, pair: Pair, load: Any, argument: str = "load") -> tuple[Any, GivenLoad | None]:
        """Return the force of a load on the bodies, and its given form."""
        from roughcontact.contact import load_case

        if pair.is_profile and isinstance(load, float):
            raise InputError(
                "is a force, and the file holds a profile: give a load per length such as "
                "'600 N/mm'",
                argument=argument,
            )
        return load_case.resolve_force(load, pair, argument)

    @property
    def _boundary(self) -> Boundary:
        return Boundary(self[shared.BOUNDARY])

    # --- Required memory, checked before maps are created ---

    def require_prepared(self, shape: tuple[int, int]) -> None:
        """Raise `InsufficientMemoryError` unless preparation and analysis of a map fit."""
        from roughcontact.surface.grid import PREPARED, require_memory

        grid = self.cropped_points(shape)
        require_memory(grid, PREPARED, "preparing a map")
        # If the grid depends on heights or sides, it is known only after the map is read.
        if self[shared.MISSING] == "crop" or self[shared.PIXEL] is not None or self.aligned:
            return
        self.require_memory(grid)

    def require_memory(self, shape: tuple[int, int]) -> None:
        """Raise `InsufficientMemoryError` unless the analysis on a grid fits."""
        if self.task.memory is None:
            held = self.task.held
            if isinstance(held, str):
                held = pkgutil.resolve_name(f"roughcontact.{held}")
            self.require_contact(shape, held)
        else:
            self.task.memory(self, shape)
        if self.get(shared.REPORT) is not None:
            from roughcontact.surface.grid import CORRELATED_ARRAYS, require_memory

            # In addition to the bodies: pressure, gap, and roughness parameters.
            require_memory(shape, self._map_count + 2 + CORRELATED_ARRAYS, "the report on a map")

    def require_contact(self, shape: tuple[int, int], held: int = 0) -> None:
        """Raise `InsufficientMemoryError` unless a contact and ``held`` further maps fit."""
        from roughcontact.contact.memory import MemoryNeed

        precision = str(self.get(shared.PRECISION) or "double")
        MemoryNeed(shape, self._boundary, precision, self._map_count + held).require()

    def require_volume(self, shape: tuple[int, int]) -> None:
        """Raise `InsufficientMemoryError` unless the volume model fits."""
        from roughcontact.elastoplastic import problem

        precision = str(self.get(shared.PRECISION) or "single")
        problem.require_memory(
            shape, problem.MIN_LAYERS, boundary=self._boundary, precision=precision
        )

    @property
    def _map_count(self) -> int:
        drawn = self.get(shared.COUNTER_MAPS) or ()
        count = len(drawn) + self[shared.DRAWS] if drawn else 0
        return 1 + count + any(map(self.is_given, (shared.COUNTER_SURFACE, shared.COUNTER_BODY)))

    def cropped_points(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the number of points of a map after cropping."""
        crop = self[shared.CROP]
        if crop is None:
            return shape
        rows, columns = (len(range(points)[part]) for part, points in zip(crop, shape, strict=True))
        return rows, columns

    # --- Subtasks, which can be solved separately, in any order, on any machine ---

    def subtask_ids(self) -> tuple[str, ...]:
        """Return the identifiers of the subtasks; empty if there is only one."""
        result = self._pieces.names(self) if self.task.pieces else ()
        return result if len(result) > 1 else ()

    def subtask_inputs(self, word: str) -> tuple[Path, ...]:
        """Return the input files of a subtask; with an empty ``word``, of the final merge."""
        file = self._pieces.file_of(self, word) if word else None
        return () if file is None else (file,)

    def solve_subtask(self, word: str, say: Say, look: Callable[[Any], None]) -> Any:
        """Return the result of a subtask, an item of ``known`` in `request.run.run_request`."""
        from roughcontact.halfspace.gpu import use_device

        with use_device(self.get(shared.DEVICE)):
            return self._pieces.solve(self, word, say, look)

    @property
    def _pieces(self) -> Subtasks:
        assert self.task.pieces is not None
        return self.task.pieces


def _hardening_material(
    material: Material, yield_strength: float | None, requested: parsing.Hardening
) -> Material:
    """Return a material with hardening; ``yield_strength`` is as specified."""
    from roughcontact.material import hardening

    law: hardening.Isotropic
    if requested.law == "swift":
        law = _swift_law(yield_strength, requested.constants)
    elif material.yield_strength is None:
        name = requested.law or "kinematic"
        raise InputError(
            f"{name} needs a {ArgumentRef('yield_strength')} to start from", argument="hardening"
        )
    elif requested.law == "linear":
        law = hardening.Linear(material.yield_strength, requested.constants[0])
    else:
        law = hardening.Perfect(material.yield_strength)
    if requested.kinematic is None:
        return replace(material, yield_strength=None, hardening=law)
    with_back = hardening.Kinematic(law, requested.kinematic)
    return replace(material, yield_strength=None, hardening=with_back)


def _swift_law(yield_strength: float | None, constants: tuple[float, ...]) -> hardening.Swift:
    """Return Swift's law; ``yield_strength`` is as specified."""
    from roughcontact.material.hardening import Swift

    try:
        swift = Swift(*constants)
    except InputError as error:
        raise as_argument_error("hardening", error) from None
    if yield_strength is not None and not math.isclose(yield_strength, swift.initial, rel_tol=1e-3):
        first, other = (
            units.format_engineering(value, "Pa") for value in (swift.initial, yield_strength)
        )
        raise InputError(
            f"starts at a yield strength of {first}, but {ArgumentRef('yield_strength')} is "
            f"{other}; leave {ArgumentRef('yield_strength')} out",
            argument="hardening",
        )
    return swift


def match_files(word: str) -> list[Path]:
    """Return the files that match a path with wildcards, or the path itself."""
    path = Path(word)
    if not any(sign in word for sign in "*?[") or path.exists():
        return [path]
    return sorted(Path(result) for result in glob.glob(word)) or [path]
