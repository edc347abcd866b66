"""What one run is asked for, checked as far as it can be without its files."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact import units
from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.request import outputs
from roughcontact.request.options import OPTIONS
from roughcontact.request.outputs import FIGURES, Say

if TYPE_CHECKING:
    from roughcontact.material.material import Material
    from roughcontact.surface.nominal import Body
    from roughcontact.surface.surface import Surface

Given = Mapping[str, str | bool | list[str]]


@dataclass(frozen=True)
class Request:
    """One contact to solve: what was asked for, checked as far as it can be without its files.

    Parameters
    ----------
    file : Path or None
        The measured map; without it, a nominal body on ``points``.
    given : Mapping
        The options that were given, as text, to repeat the run.

    sweeps : bool
        Whether its loads or approaches are given elsewhere.

    The other fields are the values of `OPTIONS`, under their names with underscores.
    """

    file: Path | None
    given: Given = field(default_factory=dict)
    format: str | None = None
    channel: str | None = None
    unit: str | None = None
    size: str | None = None
    tip_radius: float | None = None
    points: tuple[int, int] | None = None
    crop: tuple[slice, slice] | None = None
    outliers: float | None = None
    level: str = "plane"
    form: tuple[str, int | None] | None = None
    holes: str = "error"
    s_filter: float | None = None
    l_filter: float | None = None
    pixel: float | None = None
    rotate: int = 0
    load: float | None = None
    approach: float | None = None
    load_point: tuple[float, float] | None = None
    material: Material | None = None
    young: float | None = None
    poisson: float | None = None
    yield_strength: float | None = None
    counter_material: Material | None = None
    counter_young: float | None = None
    counter_poisson: float | None = None
    counter_yield_strength: float | None = None
    body: Body | None = None
    counter_body: Body | None = None
    counter_surface: Path | None = None
    align: bool = False
    offset: tuple[float, float] | None = None
    angle: float | None = None
    mirror: bool = False
    ceiling: str | float | None = "auto"
    model: str = "ceiling"
    increments: int | None = None
    unload: bool = False
    hardening: tuple[str, tuple[float, ...]] | None = None
    boundary: str = "free"
    tolerance: float | None = None
    max_iterations: int = 500
    precision: str = "double"
    study: bool = False
    output: tuple[Path, ...] = ()
    folder: Path | None = None
    report: Path | None = None
    figures: str | None = None
    sweeps: bool = False

    def __post_init__(self) -> None:
        """Refuse what can be seen to be wrong without looking at any file."""
        if self.file is None and (self.body is None or self.points is None or self.size is None):
            raise InputError(
                "FILE is missing, see roughcontact solve --help; or give --body, --points and "
                "--size for a nominal body without roughness"
            )
        if self.file is not None and self.points is not None:
            raise InputError("--points goes with a nominal --body without FILE; see --pixel")
        if self.counter_surface is None and self._aligned:
            raise InputError("--align, --offset, --angle and --mirror need a --counter-surface")
        self.bodies()
        if (self.load is None) == (self.approach is None) and not self.sweeps:
            raise InputError(
                "give either --load or --approach, and only one of them, such as --load '1 N'"
            )
        if self.model == "volume":
            self._check_volume()
        else:
            for name in ("increments", "unload", "folder"):
                if name in self.given:
                    raise InputError(f"--{name} needs --model volume")
        if self.load_point is not None and (self.load is None or self.study):
            raise InputError("--load-point needs --load, and goes without --study")
        kind = export.Kind.VOLUME if self.model == "volume" else export.Kind.CONTACT
        for path in self.output:
            outputs.check_suffix(path, "--output", export.suffixes(kind))
        if self.report is not None:
            outputs.check_suffix(self.report, "--report", (".html",))

    def check_places(self) -> None:
        """Refuse outputs that cannot be written, or would replace an input."""
        figures = outputs.figure_files(self.figures, FIGURES[self.model]).values()
        for option, path in (
            *(("--output", path) for path in self.output),
            *(("--report", path) for path in (self.report,) if path is not None),
            *(("--figures", path) for path in figures),
        ):
            outputs.check_place(path, option)
            for other in self.inputs:
                if path.exists() and other.exists() and path.samefile(other):
                    raise InputError(f"{option} '{path}' is an input file; give another name")

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        return [path for path in (self.file, self.counter_surface) if path is not None]

    def bodies(self) -> tuple[Material, Material]:
        """Return the materials of both bodies; the second is rigid if nothing is said of it."""
        from roughcontact.material.material import RIGID, Material

        first = _material("", self.material, self.young, self.poisson, self.yield_strength)
        if self.hardening is not None:
            first = _hardened(first, self.yield_strength, *self.hardening)
        given = (self.counter_young, self.counter_poisson, self.counter_yield_strength)
        if self.counter_material is None and given[:2] == (None, None):
            strength = self.counter_yield_strength
            rigid = Material(RIGID.young, 0.0, strength, RIGID.name) if strength else RIGID
            return first, rigid
        return first, _material("counter-", self.counter_material, *given)

    def _check_volume(self) -> None:
        given = {
            "--approach": self.approach is not None,
            "--load-point": self.load_point is not None,
            "--ceiling": self.ceiling != "auto",
            "--study": self.study,
        }
        for option, used in given.items():
            if used:
                raise InputError(f"{option} goes with --model ceiling, not with volume")
        if self.increments is not None and self.increments < 1:
            raise InputError(f"--increments must be at least 1, got {self.increments}")
        if all(body.yield_strength is None for body in self.bodies()):
            raise InputError(
                "--model volume needs a --yield-strength such as '1 GPa', or a --material that has "
                "one: otherwise nothing can yield"
            )

    @property
    def moments(self) -> tuple[float, float] | None:
        """Moments (y, x) about the middle of the map that a tilt has to balance [N m]."""
        if self.load_point is None or self.load is None:
            return None
        return self.load * self.load_point[0], self.load * self.load_point[1]

    @property
    def _aligned(self) -> bool:
        given = self.offset is not None or self.angle is not None
        return self.align or self.mirror or given

    def surfaces(self, say: Say) -> list[Surface]:
        """Read and prepare the map, and that of the counter-body if there is one."""
        from roughcontact.formats import read
        from roughcontact.surface import nominal as bodies

        maps = []
        for path in self.inputs:
            say(f"reading {path.name}")
            surface = read.read_surface(path, self.format, self.channel, self.unit, self.size)
            maps.append(self._prepared(surface, path))
        if self.file is None:
            maps.insert(0, self._nominal())
        elif self.body is not None:
            maps[0] = _formed(maps[0], self.body)
        if self._aligned:
            say("aligning the maps")
            place = self.offset or (0.0, 0.0), self.angle or 0.0, self.mirror
            first, second = bodies.matched(maps[0], maps[1], *place)
            # What one of them does not cover the other cannot touch.
            maps = [first.masked(), second.masked()]
        if self.counter_body is not None:
            if len(maps) == 2:
                maps[1] = _formed(maps[1], self.counter_body)
            else:
                maps.append(self.counter_body(shape=maps[0].shape, pixel=maps[0].pixel))
        return maps

    def problem(self, maps: Sequence[Surface]) -> dict[str, Any]:
        """Return the arguments that `solve` and its relatives share, but for load or approach."""
        first, second = self.bodies()
        return {
            "material": first,
            "counter_material": second,
            "counter_surface": maps[1] if len(maps) > 1 else None,
            "ceiling": self.ceiling,
            "boundary": self.boundary,
            "tolerance": self.tolerance,
            "precision": self.precision,
        }

    def resolution_notes(self, maps: Sequence[Surface]) -> tuple[str, ...]:
        """Return what limits the lateral resolution of the prepared maps, each in one sentence."""
        measured = [surface for surface in maps if surface.provenance.instrument]
        notes = (surface.resolution_notes(self.tip_radius) for surface in measured)
        return tuple(dict.fromkeys(note for found in notes for note in found))

    def command(self, name: str) -> str:
        """Return the command that repeats the run."""
        import shlex

        words = ["roughcontact", name, *([] if self.file is None else [str(self.file)])]
        for option, value in self.given.items():
            for text in value if isinstance(value, list) else [value]:
                words += [f"--{option}"] if text is True else [f"--{option}", str(text)]
        return shlex.join(words)

    def _nominal(self) -> Surface:
        from roughcontact.formats.scale import pixel_of

        assert self.body is not None
        assert self.points is not None
        pixel = pixel_of(self.size, self.points)
        return self.body(shape=self.points, pixel=pixel)

    def _prepared(self, surface: Surface, path: Path) -> Surface:
        # Points go first, then form, then waves: each step sees what the one before has cleaned.
        if self.crop is not None:
            rows, columns = (
                (part.start or 0, points if part.stop is None else part.stop)
                for part, points in zip(self.crop, surface.shape, strict=True)
            )
            surface = surface.cropped(rows, columns)
        if self.outliers is not None:
            surface = surface.without_outliers(self.outliers)
        if self.holes == "crop" and surface.missing:
            surface = surface.largest_rectangle()
        if self.level != "none":
            surface = surface.leveled(self.level)
        if self.form is not None:
            surface = surface.without_form(*self.form)
        if surface.missing and self.holes == "error":
            raise InputError(
                f"{path.name} has {surface.missing} missing points; choose --holes fill (smooth "
                "interpolation), --holes mask (they never touch) or --holes crop (the largest "
                "rectangle without them), or cut them away with --crop"
            )
        surface = surface.filled() if self.holes == "fill" else surface.masked()
        if self.s_filter is not None or self.l_filter is not None:
            surface = surface.filtered(self.s_filter, self.l_filter)
        if self.pixel is not None:
            surface = surface.resampled(pixel=(self.pixel, self.pixel), method="spline")
        return surface.rotated(self.rotate) if self.rotate % 360 else surface


def from_text(
    file: Path | None,
    given: Given,
    name: Callable[[str], str] = lambda key: f"--{key}",
    sweeps: bool = False,
) -> Request:
    """Return the request that options in words describe.

    Parameters
    ----------
    file : Path or None
        The measured map.
    given : Mapping
        Text by the names in `OPTIONS`; ``True`` for a flag, a list for what may come again.
    name : callable
        What an error message calls an option.
    sweeps : bool
        Whether loads or approaches are given elsewhere.

    Returns
    -------
    Request
        The request, checked.

    Raises
    ------
    InputError
        If a value cannot be used, or values do not go together.
    """
    values: dict[str, Any] = {}
    for key, value in given.items():
        parse = OPTIONS[key].parse
        if isinstance(value, list):
            parsed: Any = tuple(parse(text, name(key)) for text in value)
        else:
            parsed = value if isinstance(value, bool) else parse(value, name(key))
        values[key.replace("-", "_")] = parsed
    return Request(file=file, given=dict(given), sweeps=sweeps, **values)


def _material(
    prefix: str,
    known: Material | None,
    young: float | None,
    poisson: float | None,
    yield_strength: float | None,
) -> Material:
    from roughcontact.material.material import Material

    try:
        if known is not None:
            return replace(
                known,
                young=known.young if young is None else young,
                poisson=known.poisson if poisson is None else poisson,
                yield_strength=known.yield_strength if yield_strength is None else yield_strength,
            )
        if young is None or poisson is None:
            missing = f"--{prefix}young" if young is None else f"--{prefix}poisson"
            example = "'210 GPa'" if young is None else "0.3"
            raise InputError(
                f"{missing} is needed, such as {missing} {example}; or --{prefix}material with a "
                "name of the catalogue"
            )
        return Material(young, poisson, yield_strength)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith("--") else f"--{prefix}{text}") from None


def _hardened(
    material: Material, given: float | None, law: str, constants: tuple[float, ...]
) -> Material:
    """Return a material that hardens; ``given`` is the yield strength that was asked for."""
    from roughcontact.material import hardening as plasticity

    if law == "swift":
        try:
            swift = plasticity.Swift(*constants)
        except InputError as error:
            raise InputError(f"--hardening: {error}") from None
        if given is not None and not math.isclose(given, swift.initial, rel_tol=1e-3):
            first, other = (units.engineering(value, "Pa") for value in (swift.initial, given))
            raise InputError(
                f"--hardening starts at a yield strength of {first}, but --yield-strength is "
                f"{other}; leave --yield-strength out"
            )
        return replace(material, yield_strength=None, hardening=swift)
    if material.yield_strength is None:
        raise InputError("--hardening linear needs a --yield-strength to start from")
    linear = plasticity.Linear(material.yield_strength, constants[0])
    return replace(material, hardening=linear)


def _formed(surface: Surface, body: Body) -> Surface:
    return surface.with_form(body(shape=surface.shape, pixel=surface.pixel))
