"""Check the pages that were built: every link inside leads somewhere, and the search finds its words.

python docs/built.py docs/_build/html
"""

from __future__ import annotations

import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# What somebody looks for, and a page that has to be among what is found.
LOOKED_FOR = {
    "hardness": "howto/materials",
    "abaqus": "howto/law",
    "roller": "howto/roller",
    "tamaas": "others",
    "ceiling": "assumptions",
}


class _Page(HTMLParser):
    """The links of a page, and the places that links may lead to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.places: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value is None:
                continue
            if name in ("href", "src"):
                self.links.append(value)
            if name == "id" or (tag == "a" and name == "name"):
                self.places.add(value)


def _parse_page(path: Path) -> _Page:
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def find_dead_links(folder: Path) -> list[str]:
    """Return the links that lead nowhere, and roles that are shown as they are typed.

    Parameters
    ----------
    folder : Path
        Where the pages were built.

    Returns
    -------
    list of str
        In words.
    """
    pages = {path.resolve(): _parse_page(path) for path in folder.rglob("*.html")}
    faults = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc or (not parts.path and not parts.fragment):
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                faults.append(f"{path.relative_to(folder.resolve())}: {link} does not exist")
            elif (
                target in pages
                and parts.fragment
                and unquote(parts.fragment) not in pages[target].places
            ):
                faults.append(f"{path.relative_to(folder.resolve())}: no place {link}")
        if mark := re.search(r"\{[\w:]+\}`[^`<]*`", path.read_text(encoding="utf-8")):
            faults.append(
                f"{path.relative_to(folder.resolve())}: {mark[0]} is shown as it is typed"
            )
    return faults


def search_pages(folder: Path, word: str) -> set[str]:
    """Return the pages that the search of the built documentation lists for a word.

    Parameters
    ----------
    folder : Path
        Where the pages were built.
    word : str
        What is looked for.

    Returns
    -------
    set of str
        Names of pages, without suffix.
    """
    from sphinx.search.en import SearchEnglish

    index = json.loads(
        re.sub(
            r"^Search.setIndex\((.*)\)\s*$",
            r"\1",
            (folder / "searchindex.js").read_text(encoding="utf-8"),
            flags=re.DOTALL,
        )
    )
    stem = SearchEnglish({}).stem(word.lower())
    numbers: set[int] = set()
    for terms in (index["terms"], index["titleterms"]):
        of_word = terms.get(stem, [])
        numbers |= set(of_word if isinstance(of_word, list) else [of_word])
    return {index["docnames"][number] for number in numbers}


def main(folder: Path) -> int:
    """Name what is wrong; exit status 1 if anything is."""
    faults = find_dead_links(folder)
    for word, page in LOOKED_FOR.items():
        if page not in search_pages(folder, word):
            faults.append(f"the search for {word!r} does not find {page}")
    print("".join(f"{line}\n" for line in faults), end="")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
