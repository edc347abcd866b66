"""Whether wheel and source package hold what they must, and nothing else.

python scripts/packages.py FOLDER     # with one .whl and one .tar.gz in it
"""

from __future__ import annotations

import argparse
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
# What a source package needs beside the package for its tests and its documentation.
WITH_SOURCE = (
    "tests/conftest.py",
    "docs/conf.py",
    "benchmarks/same.py",
    "scripts/release.py",
    "reference/problems.json",
    "README.md",
    "CHANGELOG.md",
    "LICENSE",
    "CITATION.cff",
)


def expected_names(root: Path) -> set[str]:
    """Return what the package holds in the tree, by its path in a wheel."""
    source = root / "src"
    return {
        path.relative_to(source).as_posix()
        for path in (source / "roughcontact").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def name_errors(wheel: set[str], archive: set[str], root: Path) -> list[str]:
    """Return what is wrong with the names in a wheel and in a source package, a line each."""
    wanted = expected_names(root)
    own = {name for name in wheel if ".dist-info/" not in name}
    found = [f"the wheel lacks {name}" for name in sorted(wanted - own)]
    found += [f"the wheel holds {name}" for name in sorted(own - wanted)]
    within = {name.partition("/")[2] for name in archive}
    wanted = {f"src/{name}" for name in wanted} | set(WITH_SOURCE)
    found += [f"the source package lacks {name}" for name in sorted(wanted - within)]
    return found


def main() -> int:
    """Print what is wrong; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    (wheel,), (archive,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as packed, tarfile.open(archive) as source:
        found = name_errors(set(packed.namelist()), set(source.getnames()), ROOT)
        count = len(packed.namelist())
    print("\n".join(found) or f"{wheel.name}: {count} files; {archive.name} holds them too")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
