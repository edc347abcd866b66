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
from roughcontact.errors import InputError, Mention, require_count
from roughcontact.request import outputs, parsing
from roughcontact.request.options import (
    CEILING,
    COMPARE,
    CONDUCTANCE,
    ESTIMATE,
    FIND,
    HISTORY,
    LAW,
    ROLL,
    SWEEP,
    VOLUME,
    Given,
    all_names,
    offered,
    parsed,
)
from roughcontact.request.parsing import about
from roughcontact.request.tasks import BY_NAME

if TYPE_CHECKING:
    from roughcontact.material import hardening
    from roughcontact.material.conductor import Conductor
    from roughcontact.material.material import Material

_MOVES = ("align", "offset", "angle", "mirror")


@dataclass(frozen=True)
class Request:
    """One run: what was asked for, checked as far as it can be without its files.

    ``request["s-filter"]`` is the value of an option: that given, or else its default. What serves
    several tasks asks by ``request.get("folder")`` for an option that only some of them have.

    Parameters
    ----------
    task : str
        One of `TASKS`.
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

    task: str
    file: Path | None
    given: Given
    values: Mapping[str, Any]
    files: tuple[Path, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without looking at any file."""
        self._check_maps()
        self.bodies()
        if self.task == SWEEP:
            self._check_sweep()
        elif self.task == HISTORY:
            self._check_history()
        elif self.task == FIND:
            self._check_find()
        elif self.task == COMPARE:
            self._check_compare()
        elif self.task in BY_NAME:
            self._check_loads()
            BY_NAME[self.task].check(self)
        elif self.task == LAW:
            self._check_law()
        elif self.task == CONDUCTANCE:
            self._check_conductance()
        elif "load" in offered(self.task):
            self._check_load()
        if self.task == ROLL:
            self._check_roll()
        self._check_model()
        if self.get("load-point") is not None and (self.load[0] is None or self.get("study")):
            raise InputError(
                "needs ", Mention("load"), ", and goes without ", Mention("study"),
                argument="load_point",
            )  # fmt: skip
        for name, option in offered(self.task).items():
            paths = self[name] if option.many else (self[name],)
            for path in paths:
                if option.suffixes and isinstance(path, Path):
                    outputs.check_suffix(path, option, self.get("model") or CEILING)

    def __getitem__(self, name: str) -> Any:
        """Return the value of an option of the task; `KeyError` if it has none of that name."""
        option = offered(self.task)[name]
        return self.values.get(name, option.default)

    def get(self, name: str) -> Any:
        """Return the value of an option, None if the task does not have it.

        `KeyError` if no task has it.
        """
        if name not in all_names():
            raise KeyError(name)
        return self[name] if name in offered(self.task) else None

    @property
    def kind(self) -> str:
        """The task, or ``"volume"`` for a solve with that model."""
        return VOLUME if self.get("model") == VOLUME else self.task

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        maps = [path for paths in self.groups.values() for path in paths]
        single = (self.file, self.get("counter-surface"))
        return [*(path for path in single if path is not None), *maps]

    @property
    def groups(self) -> dict[str, list[Path]]:
        """The files to compare by the names of their groups, which is empty where they have none.

        In a comparison, the four quarters of a map are a group with the name of its file.
        """
        found: dict[str, list[Path]] = {"": list(self.files)} if self.files else {}
        for name, words in self.get("group") or ():
            found.setdefault(name, []).extend(path for word in words for path in matching(word))
        if self.get("quarters") and self.task == COMPARE:
            return {
                self.names.get(str(path), str(path)): [path]
                for paths in found.values()
                for path in paths
            }
        return found

    @property
    def aligned(self) -> bool:
        """Whether the maps have to be brought to one grid."""
        return any(self.get(name) not in (None, False) for name in _MOVES)

    @property
    def load(self) -> tuple[Any, str]:
        """The load in the form in which it is given, None where there is none, and its argument."""
        argument = "load" if self.get("hertz") is None else "hertz"
        return self.get(argument), argument

    @property
    def loads(self) -> list[Any]:
        """The loads under which a joint is looked at, in the form in which they are given."""
        from roughcontact.contact.load_curve import spaced
        from roughcontact.contact.loads import NominalPressure

        if self.get("load") is not None:
            return list(self["load"])
        return [NominalPressure(p) for p in spaced(self["from"], self["to"], self["steps"])]

    def moments(self, load: float) -> tuple[float, float] | None:
        """Return the moments (y, x) about the middle of the map that a tilt balances [N m]."""
        point = self.get("load-point")
        return None if point is None else (load * point[0], load * point[1])

    @property
    def steps(self) -> tuple[str, list[Any]]:
        """Whether a sweep is over loads or approaches, and which, in the form of its ends."""
        from roughcontact.contact.load_curve import spaced

        (control, first), (_, last) = self["from"], self["to"]
        form = type(first)
        ends = (first, last) if form is float else (first.value, last.value)
        return control, [form(value) for value in spaced(*ends, self["steps"], self["spacing"])]

    @property
    def command(self) -> str:
        """The command that repeats the run."""
        files = [*([] if self.file is None else [self.file]), *self.files]
        words = ["roughcontact", self.task, *map(str, files)]
        for name, value in self.given.items():
            for text in value if isinstance(value, list) else [value]:
                words += [f"--{name}"] if text is True else [f"--{name}", str(text)]
        return shlex.join(self.names.get(word, word) for word in words)

    def solver(self, *names: str) -> dict[str, Any]:
        """Return those options of the solver that were given; the models have own defaults."""
        return {name.replace("-", "_"): self[name] for name in names if name in self.values}

    def bodies(self) -> tuple[Material, Material]:
        """Return the materials of both bodies; the counter-body is rigid if nothing is said."""
        from roughcontact.material.material import RIGID, Material

        body = self._material("")
        if self.get("hardening") is not None:
            body = _hardened(body, self["yield-strength"], self.get("hardening"))
        constants = ("material", "young", "poisson")
        if all(self[f"counter-{name}"] is None for name in constants):
            strength = self["counter-yield-strength"]
            rigid = Material(RIGID.young, 0.0, strength, RIGID.name) if strength else RIGID
            return body, rigid
        return body, self._material("counter-")

    def conductors(self) -> tuple[Conductor, Conductor]:
        """Return what both bodies conduct."""
        return self._conductor(""), self._conductor("counter-")

    def figures(self) -> Iterator[tuple[str, str, Path]]:
        """Yield option, figure (empty: the only one) and file of what is to be drawn."""
        if self.get("figures") is not None:
            names = outputs.figure_names(self.kind)
            for name, path in outputs.figure_files(self.get("figures"), names).items():
                yield "figures", name, path
        if self.get("figure") is not None:
            yield "figure", "", self.get("figure")

    def check_places(self) -> None:
        """Refuse outputs that cannot be written, or would replace an input."""
        for argument, path in self.places:
            outputs.check_place(path, argument, self.inputs)

    @property
    def places(self) -> tuple[tuple[str, Path], ...]:
        """The files that are written, each with the argument that asks for it, in their order."""
        single = [
            (name, self.get(name))
            for name in ("residual", "movie", "report")
            if self.get(name) is not None
        ]
        return (
            *(("output", path) for path in self.outputs),
            *single,
            *((option, path) for option, _, path in self.figures()),
        )

    @property
    def outputs(self) -> tuple[Path, ...]:
        """Files for the result itself."""
        wanted = self["output"]
        return wanted if isinstance(wanted, tuple) else () if wanted is None else (wanted,)

    def _check_maps(self) -> None:
        nominal = all(self.get(name) is not None for name in ("body", "points", "size"))
        measured = self.file is not None or bool(self.groups)
        if not measured and not nominal and self.task != ESTIMATE:
            raise InputError(
                f"is missing, see roughcontact {self.task} --help; or give ", Mention("body"),
                ", ", Mention("points"), " and ", Mention("size"),
                " for a nominal body without roughness", argument="file",
            )  # fmt: skip
        if self["override-size"] and (not measured or self["size"] is None):
            raise InputError(
                "needs a ", Mention("file"), " and a ", Mention("size"), argument="override_size"
            )
        if measured and self.get("points") is not None:
            raise InputError(
                "goes with a nominal ", Mention("body"), " without ", Mention("file"), "; see ",
                Mention("pixel"), argument="points",
            )  # fmt: skip
        if self.get("counter-surface") is None and self.aligned:
            raise InputError(
                Mention("align"), ", ", Mention("offset"), ", ", Mention("angle"), " and ",
                Mention("mirror"), " need a ", Mention("counter_surface"),
            )  # fmt: skip

    def _check_load(self) -> None:
        names = [name for name in ("load", "hertz", "approach") if name in offered(self.task)]
        if sum(self[name] is not None for name in names) != 1:
            *most, last = (Mention(name) for name in names)
            words = [part for mention in most for part in (mention, ", ")]
            raise InputError(
                "give one of ", *words[:-1], " and ", last, ", and no more than one, such as ",
                Mention("load", "1 N"),
            )  # fmt: skip

    def _check_roll(self) -> None:
        if self.get("counter-body") is None and self.get("counter-surface") is None:
            raise InputError(
                "is needed: what passes over the body, such as ",
                Mention("counter_body", "cylinder 5 mm 90 deg"), "; or a ",
                Mention("counter_surface"), argument="counter_body",
            )  # fmt: skip
        self._require_yield(Mention("task", ROLL))
        if not 0 <= self["friction"] < math.inf:
            raise InputError(
                f"must not be negative, got {self.given['friction']!r}", argument="friction"
            )
        if self["folder"] is None and any(path.suffix == ".pvd" for path in self.outputs):
            raise InputError("is needed for .pvd, which holds its steps", argument="folder")

    def _check_sweep(self) -> None:
        for name in ("from", "to"):
            if self[name] is None:
                raise InputError(
                    "is needed: a load such as '1 N' or an approach such as '1 um'", argument=name
                )
        if _forms(self["from"]) != _forms(self["to"]):
            first, last = self.given["from"], self.given["to"]
            raise InputError(
                Mention("from"), " and ", Mention("to"),
                " must both be loads of one form or both approaches, got "
                f"{first!r} and {last!r}",
            )  # fmt: skip
        _ = self.steps

    def _check_history(self) -> None:
        from roughcontact.contact.history import most_passes

        if self["path"] is None:
            raise InputError(
                "is needed: loads in their order, such as '1 N, 0 N, 1 N'", argument="path"
            )
        require_count(1, most_passes(len(self["path"])), passes=self["passes"])

    def _check_find(self) -> None:
        asked = ("contact", "saturated", "approach", "mean_gap", "first_yield")
        if not any(self[name.replace("_", "-")] for name in asked):
            *most, last = (Mention(name) for name in asked)
            words = [part for mention in most for part in (mention, ", ")]
            raise InputError("nothing is asked: give ", *words[:-1], " or ", last)

    def _check_compare(self) -> None:
        if self["load"] is None:
            raise InputError(
                "is needed: a nominal pressure such as '20 MPa', the same for maps of all sizes",
                argument="load",
            )
        maps = sum(map(len, self.groups.values())) or 1
        if self["quarters"] and (self["group"] or self["paired"]):
            raise InputError(
                "makes a group of each map, and goes without ", Mention("group"), " and ",
                Mention("paired"), argument="quarters",
            )  # fmt: skip
        alone = not (self["quarters"] or self["sampling"] or self["first-load"])
        # One that has a file stands for a single map of another.
        if maps < 2 and alone and self.file is None:
            raise InputError(
                "a single map has nothing to be compared with: give a second one, or ",
                Mention("quarters"), " for its four quarters, or ", Mention("sampling"),
                " for the error of its numbers",
            )  # fmt: skip

    def _check_law(self) -> None:
        self._check_pressures()
        for name in ("counter-surface", "counter-body"):
            if len(self.files) > 1 and self[name] is not None:
                raise InputError(
                    "goes with one map; several are pressed by a flat",
                    argument=name.replace("-", "_"),
                )
        if self["thermal-film"] and any(body.conductivity is None for body in self.conductors()):
            raise InputError(
                "needs ", Mention("conductivity"), " and ", Mention("counter_conductivity"),
                argument="thermal_film",
            )  # fmt: skip

    def _check_pressures(self) -> None:
        for name in ("from", "to"):
            if self[name] is None:
                raise InputError("is needed: a nominal pressure such as '20 MPa'", argument=name)
        if not 0 < self["from"] < self["to"]:
            raise InputError(
                "must be positive and below ", Mention("to"), f", got {self.given['from']!r} and "
                f"{self.given['to']!r}", argument="from",
            )  # fmt: skip

    def _check_loads(self) -> None:
        """Refuse what is neither single loads nor a range of nominal pressures."""
        ends = [name for name in ("from", "to") if self[name] is not None]
        if self["load"] is None and not ends:
            raise InputError(
                "is needed, such as '1 N', or several: '1 N, 3 N, 10 N'; or ",
                Mention("from", "1 MPa"), " and ", Mention("to", "100 MPa"), argument="load",
            )  # fmt: skip
        if self["load"] is None:
            self._check_pressures()
        elif ends:
            raise InputError(
                "goes without ", Mention("from"), " and ", Mention("to"), argument="load"
            )

    def _check_conductance(self) -> None:
        self._check_loads()
        bodies = self.conductors()
        kinds = ("resistivity", "conductivity")
        known = [all(getattr(body, kind) is not None for body in bodies) for kind in kinds]
        if not any(known):
            lacking = next(
                f"{under}conductivity" for body, under in zip(bodies, ("", "counter_"), strict=True)
                if body.conductivity is None
            )  # fmt: skip
            named = self[f"{lacking.removesuffix('conductivity').replace('_', '-')}material"]
            known_of = (
                "have them where a source is known" if named is None
                else f"have them where a source is known, which {named.name} lacks"
            )  # fmt: skip
            raise InputError(
                "is needed, such as ", Mention(lacking, "46 W/m/K"), ", or the resistivity of "
                "both bodies; ", Mention("material"), " and ", Mention("counter_material"),
                f" of the catalogue {known_of}", argument=lacking,
            )  # fmt: skip
        for name, kind, there in zip(("film", "thermal-film"), kinds, known, strict=True):
            if self[name] and not there:
                raise InputError(
                    "needs ", Mention(kind), " and ", Mention(f"counter_{kind}"),
                    argument=name.replace("-", "_"),
                )  # fmt: skip

    def _conductor(self, prefix: str) -> Conductor:
        from roughcontact.material import catalogue
        from roughcontact.material.conductor import Conductor

        known = self[f"{prefix}material"]
        found = Conductor() if known is None else catalogue.entry(known.name).conductor
        given = {name: self.get(f"{prefix}{name}") for name in ("resistivity", "conductivity")}
        return replace(found, **{name: value for name, value in given.items() if value is not None})

    def _check_model(self) -> None:
        model = self.get("model") or CEILING
        for name, option in offered(self.task).items():
            if option.model in ("", model) or self[name] == option.default:
                continue
            mention = Mention("model", option.model)
            if model == CEILING:
                raise InputError("needs ", mention, argument=option.argument)
            raise InputError("goes with ", mention, f", not with {model}", argument=option.argument)
        if model == VOLUME:
            self._require_yield(Mention("model", VOLUME))

    def _require_yield(self, asked: Mention) -> None:
        if all(body.yield_strength is None for body in self.bodies()):
            raise InputError(
                asked, " needs a ", Mention("yield_strength"),
                " such as '1 GPa', or a ", Mention("material"),
                " that has one: otherwise nothing can yield",
            )  # fmt: skip

    def _material(self, prefix: str) -> Material:
        from roughcontact.material.material import Material

        known = self[f"{prefix}material"]
        constants = {
            name.replace("-", "_"): self[f"{prefix}{name}"]
            for name in ("young", "poisson", "yield-strength")
        }
        given = {name: value for name, value in constants.items() if value is not None}
        if "yield_strength" in given:
            # The law of hardening of the catalogue starts at the yield strength of the catalogue.
            given["hardening"] = None
        under = prefix.replace("-", "_")
        for name, example in (("young", "210 GPa"), ("poisson", "0.3")):
            if known is None and name not in given:
                raise InputError(
                    "is needed, such as ", Mention(f"{under}{name}", example), "; or ",
                    Mention(f"{under}material"), " with a name of the catalogue",
                    argument=f"{under}{name}",
                )  # fmt: skip
        try:
            return Material(**constants) if known is None else replace(known, **given)
        except InputError as error:
            if error.argument is not None:
                error.argument = f"{under}{error.argument}"
            raise


def _forms(end: tuple[str, Any]) -> tuple[str, type]:
    """Return what an end of a sweep is, and in which form."""
    return end[0], type(end[1])


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


def from_text(task: str, file: Path | None, given: Given, files: tuple[Path, ...] = ()) -> Request:
    """Return the request that options in words describe.

    Parameters
    ----------
    task : str
        One of `TASKS`.
    file : Path or None
        The measured map.
    given : Mapping
        Text by the names of options that the task has; ``True`` for a flag, a list for what may
        be repeated.
    files : tuple of Path
        Maps to compare that belong to no group.

    Returns
    -------
    Request
        The request, checked.

    Raises
    ------
    InputError
        If a value cannot be used, or values do not go together; it carries the argument.
    """
    return Request(task, file, dict(given), parsed(given, task), files)
