"""Every number with a unit on a page has an origin that can be checked.

It is in an output on its page, which `docs/commands.py` compares, in a table that a script writes,
in the test or the cited work that its sentence names, in a section that names the script that
computes it, or in ``numbers.tsv`` with its origin.
"""

from __future__ import annotations

import ast
import csv
import re
from collections.abc import Iterator, Set
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from paths import ROOT

DOCS = ROOT / "docs"
PAGES = [
    ROOT / "README.md",
    *(
        page
        for folder in ("", "howto", "evidence")
        for page in sorted((DOCS / folder).glob("*.md"))
    ),
]
TABLE = Path(__file__).with_name("numbers.tsv")

_NUMBER = r"\d+(?:[\u202f\u00a0 ,]\d{3})*(?:\.\d+)?"
_UNIT = (
    r"(?:[nµm]?m[²³]?|cm|[GMk]?Pa|bar|[mk]?N(?:/mm)?|%|K|°C|°|[mµ]?s|min|h|[GMk]i?B|kg|[mµ]?Ω|J|Hz)"
)
_SPACE = r"[\u202f\u00a0 \n]"
# "1.3 µm", and lists and ranges whose last number has the unit.
_NUMBERS = rf"{_NUMBER}(?:(?:, | to | and | or | × |–){_NUMBER})*"
QUANTITY = re.compile(rf"(?<![\w.^/])({_NUMBERS}){_SPACE}({_UNIT})(?![\w/·⁻])")
_PLAIN = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# A block between marks is written by the script that computes it.
_MADE = re.compile(r"<!-- ([\w ]+?) -->.*?<!-- (?:end of \1|\1 end|end) -->", re.DOTALL)
_CODE = re.compile(r"^[ ]*```.*?^[ ]*```$", re.DOTALL | re.MULTILINE)
# Author and year.
_CITED = re.compile(r"[A-Z][\w-]+(?:'s \w+| et al\.)? \(?(?:1[89]|20)\d\d\b")
_SCRIPT = re.compile(r"\b((?:benchmarks|calibration|tests)/[\w/]+\.py)(?:::(\w+))?")


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, and the paragraph, item or table row that shows it."""

    number: str
    unit: str
    block: str

    def __str__(self) -> str:
        """Return number and unit."""
        return f"{self.number} {self.unit}"


def values(text: str) -> set[float]:
    """Return the numbers of a text."""
    return {float(found) for found in _PLAIN.findall(re.sub(r"(?<=\d)[, ](?=\d{3}\b)", "", text))}


def is_rounding(number: str, known: Set[float]) -> bool:
    """Return whether a number is one of others, rounded to its digits."""
    text = re.sub(r"[^\d.]", "", number)
    digits = len(text.partition(".")[2])
    return any(round(other, digits) == float(text) for other in known)


def blocks(section: str) -> Iterator[str]:
    """Yield paragraphs, items and table rows of a section without code and link targets."""
    text = _CODE.sub("", _MADE.sub("", section))
    text = re.sub(r"\]\([^)]*\)|\$[^$]*\$", "", text)
    yield from re.split(r"\n\s*\n|\n(?=- |\| )", text)


def quantities(section: str) -> Iterator[Quantity]:
    """Yield the quantities in the prose of a section; names in backquotes stay in their blocks."""
    for block in blocks(section):
        for found in QUANTITY.finditer(re.sub(r"`[^`]*`", "``", block)):
            for number in re.findall(_NUMBER, found[1]):
                yield Quantity(number, found[2], block)


@cache
def source_values(path: str, function: str = "") -> frozenset[float]:
    """Return the numbers of a file, or of a test in it, also in percent."""
    text = (ROOT / path).read_text(encoding="utf-8")
    if function:
        text = next(
            ast.get_source_segment(text, node) or ""
            for node in ast.parse(text).body
            if isinstance(node, ast.FunctionDef) and node.name == function
        )
    numbers = values(text)
    return frozenset(numbers | {round(100 * number, 9) for number in numbers})


def has_origin(quantity: Quantity, section: str, known: Set[float]) -> bool:
    """Return whether output, cited work, named test or named script has the number."""
    if is_rounding(quantity.number, known) or _CITED.search(quantity.block):
        return True
    tests = [found for found in _SCRIPT.finditer(quantity.block) if found[2]]
    if tests:
        return any(is_rounding(quantity.number, source_values(*t.groups())) for t in tests)
    return any((ROOT / found[1]).exists() for found in _SCRIPT.finditer(section))


@cache
def find_unsupported(page: Path) -> list[Quantity]:
    """Return the quantities of a page that nothing on it supports."""
    text = page.read_text(encoding="utf-8")
    known = values("".join(found[0] for form in (_MADE, _CODE) for found in form.finditer(text)))
    return [
        quantity
        for section in re.split(r"^(?=## )", text, flags=re.MULTILINE)
        for quantity in quantities(section)
        if not has_origin(quantity, section, known)
    ]


def read_origins() -> dict[tuple[str, str], str]:
    """Return the origins of the table by page and quantity."""
    with TABLE.open(encoding="utf-8") as stream:
        rows = list(csv.reader(stream, delimiter="\t"))[1:]
    return {(page, quantity): origin for page, quantity, origin in rows}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_numbers_of_page_have_an_origin(page: Path) -> None:
    name = page.relative_to(ROOT).as_posix()
    found = {(name, str(quantity)) for quantity in find_unsupported(page)}
    assert sorted(found - read_origins().keys()) == []


def test_table_lists_only_numbers_of_pages() -> None:
    pages = (page.relative_to(ROOT).as_posix() for page in PAGES)
    found = {
        (name, str(quantity))
        for name, page in zip(pages, PAGES, strict=True)
        for quantity in find_unsupported(page)
    }
    assert sorted(read_origins().keys() - found) == []


def test_listed_files_contain_their_numbers() -> None:
    for (_, quantity), origin in read_origins().items():
        # Other origins are sentences.
        if " " not in origin:
            number = quantity.partition(" ")[0]
            assert is_rounding(number, source_values(origin)), (quantity, origin)


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("A gap of 303 nm.\n", ["303 nm"]),
        ("A gap of 303 nm.\n\n```console\n$ rc\ngap 303.2 nm\n```\n", []),
        ("5 to 9.5 µm and 1,310 µm².\n", ["5 µm", "9.5 µm", "1,310 µm²"]),
        ("It is 8 % high (Johnson 1985).\n", []),
        ("`benchmarks/record.py` takes 4 s.\n\n## Next\n\n7 s.\n", ["7 s"]),
        ("`benchmarks/no_such.py` takes 4 s.\n", ["4 s"]),
    ],
)
def test_number_without_origin_is_found(text: str, missing: list[str], tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    assert list(map(str, find_unsupported(page))) == missing
