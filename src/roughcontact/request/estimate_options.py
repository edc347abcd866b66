"""The options of estimates: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact.request import parsing
from roughcontact.request.option import BODIES, ESTIMATE, LENGTH, MAP, OUTPUT, PRESSURE, Option


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, (ESTIMATE,), **more)


OPTIONS = (
    _option(
        "sq", MAP, "LENGTH", 'Root-mean-square height Sq, such as "0.4 um"; this and all below in '
        "place of those of a FILE.", LENGTH, arguments=("Sq",),
    ),
    _option(
        "sdq", MAP, "NUMBER", "Root-mean-square gradient Sdq.", parsing.number, arguments=("Sdq",),
    ),
    _option(
        "sal", MAP, "LENGTH", 'Autocorrelation length Sal, such as "12 um"; without it the gap is '
        "less sure.", LENGTH, arguments=("Sal",),
    ),
    _option(
        "str", MAP, "NUMBER", "Texture aspect ratio Str; default: 1.", parsing.number,
        arguments=("Str",),
    ),
    _option("ssk", MAP, "NUMBER", "Skewness Ssk; default: 0.", parsing.number, arguments=("Ssk",)),
    _option(
        "sku", MAP, "NUMBER", "Kurtosis Sku; default: 3 + 1.5 Ssk², which is 3 of a Gaussian "
        "surface.", parsing.number, arguments=("Sku",),
    ),
    _option(
        "pressure", BODIES, "PRESSURE", 'Load over nominal area, such as "20 MPa".', PRESSURE,
    ),
    _option(
        "ceiling", BODIES, "PRESSURE", 'Largest pressure, such as "3 GPa", or a hardness, such as '
        '"62 HRC"; auto: 3 times the smaller yield strength, or else the hardness; none: purely '
        "elastic; default: auto.", parsing.ceiling, default="auto",
    ),
)  # fmt: skip
"""What `estimate` takes, beside what other commands take as well."""

FILES = (
    _option(
        "output", OUTPUT, "FILE.json", "Write the estimate.", parsing.path, suffixes=(".json",),
    ),
)  # fmt: skip
"""What is written."""
