"""Options of the instrument that measured a map, and the intervals of its contact."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError, input_error
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import parsing
from roughcontact.request.options import BODY, BOUNDARY, LENGTH, NEEDS, Option, Panel, Rule
from roughcontact.request.outcome import OnProgress
from roughcontact.request.parsing import parser
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.surface.instrument import Instrument


@parser("NAME")
def _instrument(text: str, argument: str) -> Instrument:
    """Return an instrument of the catalog or of a type."""
    from roughcontact.surface.instrument import Instrument

    try:
        return Instrument.from_name(text)
    except InputError as error:
        raise parsing.as_argument_error(argument, error) from None


@parser("FILE[=NAME]")
def _map(text: str, argument: str) -> tuple[Path, Instrument | None]:
    """Return the file of a map and its instrument."""
    file, _, name = text.partition("=")
    return Path(file), _instrument(name, argument) if name else None


@parser("LENGTH|FILE")
def _noise(text: str, argument: str) -> float | Path:
    """Return a noise [m], or the file of a second map of the same place."""
    return Path(text) if _noise_file(text) else LENGTH(text, argument)


def _noise_file(text: str) -> list[str]:
    """Return the file of a noise, if it is one."""
    # "../second.x3p" and "2nd.x3p" are files, "1.2 nm" is a length.
    is_length = re.fullmatch(r"\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*[^\s./\\]*\s*", text)
    return [] if is_length else [text]


def _transfer_file(text: str) -> list[str]:
    """Return the file of a measured transfer function of an instrument, if it has one."""
    return re.findall(r"^measured (.+)", text)


@parser("TEXT")
def _uncertainties(text: str, argument: str) -> dict[str, float]:
    """Return the relative standard uncertainties of the material."""
    found = {}
    for part in text.split(","):
        match = re.fullmatch(r"\s*(E|yield)\s+([\d.]+)\s*%\s*", part)
        if match is None:
            raise input_error(argument, text, "must read like 'E 3 %, yield 5 %'")
        found[match[1]] = parsing.number(match[2], argument) / 100
    return found


UNCERTAINTY = Option.flag(
    "uncertainty",
    "Correct for the instrument; give 95 % intervals and their sources.",
    Panel.SOLVER,
)
INSTRUMENT: Option[Any] = Option.value(
    "instrument",
    _instrument,
    'Instrument that measured the map: "CSI 50x", "optical NA 0.55", "optical 1.2 um", '
    '"measured itf.csv", "tip 50 nm".',
    Panel.SOLVER,
    files_in=_transfer_file,
)
NOISE: Option[Any] = Option.value(
    "noise",
    _noise,
    'Noise of one point, "1.2 nm", or a second map of the same place.',
    Panel.SOLVER,
    files_in=_noise_file,
)
SHORTEST_WAVE = Option.value(
    "shortest-wave",
    LENGTH,
    'Shortest wave of the surface, from a finer map: "0.3 um".',
    Panel.SOLVER,
)
MATERIAL_UNCERTAINTY: Option[Any] = Option.value(
    "material-uncertainty",
    _uncertainties,
    'Standard uncertainties; default: "E 3 %, yield 5 %".',
    Panel.SOLVER,
)
ALSO: Option[Any] = Option(
    "also",
    _map,
    'Finer map of the surface, and its instrument: "fine.x3p=CSI 100x"; repeatable.',
    (),
    Panel.SOLVER,
    many=True,
    files_in=lambda text: [text.partition("=")[0], *_transfer_file(text.partition("=")[2])],
)
OPTIONS: tuple[Option[Any], ...] = (
    UNCERTAINTY,
    INSTRUMENT,
    NOISE,
    SHORTEST_WAVE,
    ALSO,
    MATERIAL_UNCERTAINTY,
)
RULES = (
    *(Rule(NEEDS, option, UNCERTAINTY) for option in (INSTRUMENT, MATERIAL_UNCERTAINTY)),
    *(Rule(NEEDS, option, INSTRUMENT) for option in (NOISE, SHORTEST_WAVE, ALSO)),
)


def add_intervals(request: Request, result: ContactResult, look: OnProgress) -> ContactResult:
    """Return a contact with its uncertainty intervals."""
    return replace(result, measurement=result.uncertainty(**how(request), progress=look))


def how(request: Request) -> dict[str, Any]:
    """Return the arguments of the intervals: the instrument and other options."""
    from roughcontact.formats.read import read_surface

    instrument, noise = request[INSTRUMENT], request[NOISE]
    if isinstance(noise, Path):
        first, second = (read_surface(path) for path in (request.inputs[0], noise))
        known = {**vars(instrument), "u_noise": 0.1}
        instrument = type(instrument).from_repeats(first, second, **known)
    elif noise is not None:
        instrument = replace(instrument, noise=noise)
    # A periodic map without a nominal body is a sample of its face.
    is_face = request[BOUNDARY] == Boundary.PERIODIC and not request[BODY]
    also = [(read_surface(path).filled().leveled(), tool) for path, tool in request[ALSO]]
    return {
        "instrument": instrument,
        "shortest_wave": request[SHORTEST_WAVE],
        "material": request[MATERIAL_UNCERTAINTY],
        "also": [item if item[1] else item[0] for item in also],
        "of": "surface" if is_face and instrument is not None else "map",
    }
