"""Report of a generated surface: requested and actual parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from roughcontact.cautions import Caution, CautionTag, as_note, sort_cautions
from roughcontact.errors import ArgumentRef
from roughcontact.report import inputs
from roughcontact.report.kind import Headline
from roughcontact.surface.generation import PARAMETER_TOLERANCE, Parameter, compare_parameters
from roughcontact.surface.surface import Surface
from roughcontact.units import format_change, format_engineering, format_lengths

HEADS = ("parameter", "requested", "map", "difference")

_HURST = "Hurst exponent"


def parameter_rows(surface: Surface) -> list[tuple[str, str, str, str]]:
    """Return the requested and the actual parameters of a generated map."""
    return [
        (
            _name(item),
            _value_text(item.name, item.requested),
            _value_text(item.name, item.measured),
            _deviation_text(item),
        )
        for item in compare_parameters(surface)
    ]


def generation_headline(surface: Surface) -> Headline:
    """Return the headline of a generated map."""
    created = surface.provenance.origin
    assert created is not None
    ny, nx = surface.shape
    waves = [
        format_engineering(created.found[f"{name}_wavelength"], "m")
        for name in ("cutoff", "rolloff")
    ]
    grid = f"{ny} × {nx} points, {format_lengths(surface.size)}, waves {' to '.join(waves)}"
    missed = [_name(item) for item in compare_parameters(surface) if not item.met]
    return Headline(
        f"Generated map, {grid}, seed {created.arguments['seed']}",
        f"The map differs in {', '.join(missed)}." if missed else "The map has what was requested.",
        HEADS,
        parameter_rows(surface),
        (),
    )


def missed_notes(surface: Surface) -> tuple[Caution, ...]:
    """Return the notes on missed parameters and on a narrow spectrum."""
    created = surface.provenance.origin
    assert created is not None
    missed = [item for item in compare_parameters(surface) if not item.met]
    reasons = [_missed_reason(item, surface, created.found) for item in missed]
    return sort_cautions([*reasons, *_narrow(created.found)])


def record(surface: Surface) -> dict[str, Any]:
    """Return grid, parameters and notes of a generated map as a record, in SI units."""
    created = surface.provenance.origin
    assert created is not None
    return {
        "shape": list(surface.shape),
        "pixel": list(surface.pixel),
        "seed": created.arguments["seed"],
        "rolloff_wavelength": created.found["rolloff_wavelength"],
        "cutoff_wavelength": created.found["cutoff_wavelength"],
        "parameters": [
            {"name": item.name, "asked": item.requested, "found": item.measured, "met": item.met}
            for item in compare_parameters(surface)
        ],
        "reasons": [caution.text for caution in missed_notes(surface)],
        "roughness": {name: created.found.get(name) for name in inputs.ROUGHNESS},
    }


def _name(item: Parameter) -> str:
    return _HURST if item.name == "hurst" else item.name


def _value_text(name: str, value: float) -> str:
    if math.isnan(value):
        return "not determined"
    if name in inputs.ROUGHNESS and inputs.ROUGHNESS[name][0] == "m":
        return format_engineering(value, "m")
    # A skewness near 0 is rounded to its tolerance.
    digits = round(value, 3) if abs(value) < PARAMETER_TOLERANCE / 2 else value
    return f"{digits + 0.0:.3g}".replace("-", "−")


# Relative differences below this are shown as rounding.
_MIN_VISIBLE_CHANGE = 5e-4


def _deviation_text(item: Parameter) -> str:
    if math.isnan(item.missed):
        return ""
    if item.name == "Ssk":
        by = round(item.measured - item.requested, 3)
        return f"{by:+.3f}".replace("-", "−") if by else "0"
    return format_change(item.missed) if abs(item.missed) >= _MIN_VISIBLE_CHANGE else "below 0.05 %"


# Ratio of longest to shortest wavelength below which a spectrum is narrow.
_NARROW = 4.0


def _narrow(result: Mapping[str, Any]) -> Iterator[Caution]:
    """Yield the note on a narrow spectrum."""
    short, long = (result[f"{name}_wavelength"] for name in ("cutoff", "rolloff"))
    if long < _NARROW * short * (1 - 1e-9):
        ends = f"{format_engineering(short, 'm', 3)} to {format_engineering(long, 'm', 3)}"
        yield as_note(
            CautionTag.NARROW_SPECTRUM,
            f"Spectrum spans only a factor of {long / short:.2g} ({ends}). Use more "
            f"{ArgumentRef('points')}.",
            span=long / short,
        )


def _missed_reason(item: Parameter, surface: Surface, result: Mapping[str, Any]) -> Caution:
    """Return the note on a missed parameter."""
    size, seed, cutoff = ArgumentRef("size"), ArgumentRef("rng"), ArgumentRef("cutoff_wavelength")
    said = (
        f"{_name(item)} is {_value_text(item.name, item.measured)}, requested "
        f"{_value_text(item.name, item.requested)}: "
    )
    if item.name == "Str" and math.isnan(item.measured):
        maximum = result.get("Str_max", math.nan)
        text = (
            f"Str is at most {maximum:.2g}: correlation along the lay exceeds half the map. Use a "
            f"larger {size}."
        )
    elif item.name in ("Sal", "Str"):
        hills = math.prod(side / result["rolloff_wavelength"] for side in surface.size)
        fit = f"only {max(hills, 1):.0f} correlation areas fit"
        text = f"{said}{fit}. Use a larger {size} or another {seed}."
    elif item.name in ("Ssk", "Sku"):
        text = f"{said}not reachable. Use a shorter {cutoff} or larger {size}."
    else:
        text = f"{said}the spectrum of this grid comes no closer."
    return as_note(CautionTag.GENERATE_MISSED, text, missed=item.missed)
