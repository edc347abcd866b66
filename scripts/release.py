"""Make a release: version, changelog, commit and tag, from one number.

    python scripts/release.py 0.3.0 --dry-run   # shows what would be done, changes nothing
    python scripts/release.py 0.3.0             # does it; nothing is published

The version stands in ``src/roughcontact/_version.py``; the citation files are written from it.
"""

from __future__ import annotations

import argparse
import datetime
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
VERSION = Path("src/roughcontact/_version.py")
CHANGES = Path("CHANGELOG.md")
# Where else the version stands, and how.
CITED = {
    Path("CITATION.cff"): (r"^version: .*$", "version: {version}"),
    Path("codemeta.json"): (r'"version": "[^"]*"', '"version": "{version}"'),
}
_NUMBER = re.compile(r"(\d+)\.(\d+)\.(\d+)")
_HEAD = "## Unreleased\n"


class RefusedError(Exception):
    """A release that cannot be made, in one sentence."""


def version_of(text: str) -> str:
    """Return the version in the text of `VERSION`."""
    found = re.search(r'^__version__ = "([^"]+)"$', text, re.MULTILINE)
    if found is None:
        raise RefusedError(f'{VERSION} names no version; expected __version__ = "..."')
    return found[1]


def cut_changelog(changes: str, version: str, date: datetime.date) -> str:
    """Return the changelog with what is unreleased under a version, and nothing unreleased."""
    before, head, rest = changes.partition(_HEAD)
    section = rest.partition("\n## ")[0]
    if not head or not re.search(r"^- ", section, re.MULTILINE):
        raise RefusedError(f"{CHANGES} has nothing under 'Unreleased'; a release needs changes")
    return f"{before}{_HEAD}\n## {version} - {date.isoformat()}\n{rest}"


def changed_texts(root: Path, version: str, date: datetime.date) -> dict[Path, str]:
    """Return the new texts of the files that a release changes.

    Raises
    ------
    RefusedError
        If the version is no number of three parts above the present one, or nothing has changed.
    """
    texts = {path: (root / path).read_text(encoding="utf-8") for path in (VERSION, CHANGES, *CITED)}
    present = version_of(texts[VERSION])
    wanted, known = (_NUMBER.fullmatch(one) for one in (version, present))
    if wanted is None:
        raise RefusedError(f"a version has three numbers such as 0.2.0, got {version!r}")
    if known is not None and tuple(map(int, wanted.groups())) <= tuple(map(int, known.groups())):
        raise RefusedError(f"the version is {present} already; give a later one than {version}")
    texts[VERSION] = texts[VERSION].replace(f'"{present}"', f'"{version}"')
    texts[CHANGES] = cut_changelog(texts[CHANGES], version, date)
    for path, (pattern, form) in CITED.items():
        text, count = re.subn(
            pattern, form.format(version=version), texts[path], flags=re.MULTILINE
        )
        if count != 1:
            raise RefusedError(f"{path} names its version {count} times; expected once")
        texts[path] = text
    return texts


def _git(*words: str) -> str:
    run = subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True)
    return run.stdout.strip()


def release(version: str, dry: bool) -> None:
    """Make a release, or show what it would be."""
    texts = changed_texts(ROOT, version, datetime.datetime.now(datetime.UTC).date())
    if not dry and _git("status", "--porcelain"):
        raise RefusedError("the working tree has changes; commit or stash them first")
    if not dry and _git("tag", "--list", f"v{version}"):
        raise RefusedError(f"there is a tag v{version} already; give a later version")
    for path, text in texts.items():
        print(f"{'would write' if dry else 'writes'} {path}")
        if not dry:
            (ROOT / path).write_text(text, encoding="utf-8")
    if dry:
        print(f"would commit 'Release {version}' and tag it v{version}")
    else:
        _git("commit", "-am", f"Release {version}")
        _git("tag", "-a", f"v{version}", "-m", f"roughcontact {version}")
    print(f"To publish by .github/workflows/release.yml:\n  git push origin HEAD v{version}")


def main(words: list[str] | None = None) -> int:
    """Make a release; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("version", help="of the release, such as 0.2.0")
    parser.add_argument("--dry-run", action="store_true", help="show it, change nothing")
    options = parser.parse_args(words)
    try:
        release(options.version, options.dry_run)
    except RefusedError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
