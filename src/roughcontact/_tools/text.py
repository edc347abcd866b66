"""Names and other text from files: one line, or a cell of a table."""

from __future__ import annotations

# First characters of a cell that spreadsheets evaluate as a formula.
_FORMULA = ("=", "+", "-", "@")


def replace_unprintable(text: str, exceptions: str = "", replacement: str = " ") -> str:
    """Return text without control characters and line separators, except for ``exceptions``."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in exceptions else replacement for c in text)


def join_words(text: str) -> str:
    """Return text as one line of words with single blanks."""
    return " ".join(replace_unprintable(text).split())


def table_cell(text: str) -> str:
    """Return a text as the content of a cell that is no formula."""
    plain = replace_unprintable(text)
    return f"'{plain}" if plain.lstrip().startswith(_FORMULA) else plain


def csv_cell(text: str) -> str:
    """Return a text as a cell of a CSV file that is no formula and has no separator."""
    plain = table_cell(text)
    return f'"{plain.replace(chr(34), chr(34) * 2)}"' if "," in plain or '"' in plain else plain
