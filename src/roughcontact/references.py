"""References of the package: the table ``references.toml`` and its formats."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from roughcontact._tools.files import require_suffix, write_atomically

STORED = Path(__file__).with_name("references.toml")

_MAX_AUTHORS = 2  # Before "et al."
_OTHERS = "others"  # As in BibTeX


@dataclass(frozen=True)
class Reference:
    """A paper, book or standard."""

    key: str  # BibTeX key: first family name and year, or the number of a standard
    authors: tuple[str, ...]  # "Family, I. J."
    year: int | None  # Year of publication
    title: str  # Title; of a standard, after its number
    where: str = ""  # Journal
    volume: str = ""  # Volume of the journal
    pages: str = ""  # Pages in the journal
    doi: str = ""  # DOI without the address of the resolver
    note: str = ""  # Remark on the entry

    @property
    def short(self) -> str:
        """Citation in a text, such as ``"Polonsky and Keer 1999"``."""
        names = [author.partition(",")[0] for author in self.authors]
        if not names:
            return self.title.partition(",")[0]
        if len(names) > _MAX_AUTHORS or names[-1] == _OTHERS:
            return f"{names[0]} et al. {self.year}"
        return f"{' and '.join(names)} {self.year}"

    @property
    def text(self) -> str:
        """Entry of a list of references, in one line."""
        *maximum, last = self.authors or ("",)
        names = f"{', '.join(maximum)} and {last}" if maximum else last
        names = names.replace(f" and {_OTHERS}", " et al.")
        first = f"{names} ({self.year})" if names else ""
        place = " ".join(part for part in (self.where, self.volume) if part)
        where = ", ".join(part for part in (place, self.pages) if part)
        doi = f"doi:{self.doi}" if self.doi else ""
        parts = (first, self._dated_title, where, doi, self.note)
        return ". ".join(part.rstrip(".") for part in parts if part) + "."

    @property
    def _dated_title(self) -> str:
        """Title; without authors, with the year after the number of the standard."""
        if self.authors or not self.year:
            return self.title
        number, comma, rest = self.title.partition(",")
        year = f":{self.year}" if number.startswith("ISO ") else f" ({self.year})"
        return f"{number}{year}{comma}{rest}"

    @property
    def _publisher(self) -> str:
        """Publisher in place of the authors of a standard: the first word of its title."""
        return "{" + self.title.split()[0] + "}" if self.year else ""

    @property
    def bibtex(self) -> str:
        """Entry of a BibTeX file."""
        kind = "article" if self.volume else "book" if self.where else "misc"
        fields = {
            "author": " and ".join(self.authors) or self._publisher,
            "title": "{" + self.title + "}",
            "journal" if kind == "article" else "publisher": self.where,
            "volume": self.volume,
            "pages": self.pages.replace("–", "--"),
            "year": str(self.year or ""),
            "doi": self.doi,
            "note": self.note,
        }
        text = [f"  {name} = {{{value}}}" for name, value in fields.items() if value]
        return f"@{kind}{{{self.key},\n" + ",\n".join(text) + "\n}"


@dataclass(frozen=True)
class References:
    """Cited works and their uses."""

    uses: tuple[tuple[str, tuple[Reference, ...]], ...]

    def __iter__(self) -> Iterator[Reference]:
        """Yield each work once, in the order of first use."""
        return iter(dict.fromkeys(work for _, works in self.uses for work in works))

    def __len__(self) -> int:
        """Return the number of works."""
        return len(list(iter(self)))

    def __add__(self, other: References) -> References:
        """Return the union of both; shared works keep their first position."""
        uses = dict(self.uses)
        for purpose, works in other.uses:
            uses[purpose] = tuple(dict.fromkeys((*uses.get(purpose, ()), *works)))
        return References(tuple(uses.items()))

    def __repr__(self) -> str:
        """Return the text."""
        return self.text

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(self.text)

    @property
    def text(self) -> str:
        """List of references: a paragraph for each use, a line for each work."""
        return "\n\n".join(
            "\n".join((f"{purpose[:1].upper()}{purpose[1:]}", *(f"  {w.text}" for w in works)))
            for purpose, works in self.uses
        )

    @property
    def bibtex(self) -> str:
        """Text of a BibTeX file."""
        return "\n\n".join(work.bibtex for work in self) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the references to a file."""
        require_suffix(path, ".bib", ".txt")
        bib = Path(path).suffix.lower() == ".bib"
        write_atomically(path, self.bibtex if bib else self.text + "\n")


NO_REFERENCES = References(())
"""Empty references."""


@cache
def all_references() -> dict[str, Reference]:
    """Return all works cited by the package or its theory page, by key."""
    stored = tomllib.loads(STORED.read_text(encoding="utf-8"))
    return {
        key: Reference(key, **{"year": None, **row, "authors": tuple(row.get("authors", ()))})
        for key, row in stored.items()
    }


def make_use(purpose: str, *keys: str) -> tuple[str, tuple[Reference, ...]]:
    """Return one entry of ``References.uses``."""
    known = all_references()
    return purpose, tuple(known[key] for key in keys)
