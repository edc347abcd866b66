"""Every sentence of the README has a row in claims.tsv with its tests and page."""

from __future__ import annotations

import ast
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

from paths import ROOT

DOCS = ROOT / "docs"
TABLE = Path(__file__).with_name("claims.tsv")
README = (ROOT / "README.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


class Claim(NamedTuple):
    """A sentence, the tests that check it, and the page that shows it."""

    sentence: str
    tests: list[str]
    page: str


def claims() -> list[Claim]:
    """Return the rows of the table."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()[1:]
    return [
        Claim(sentence, tests.split(), page)
        for sentence, tests, page in (line.split("\t") for line in lines)
    ]


def sentences() -> list[str]:
    """Return the sentences of the README, without its headings, pictures and code."""
    text = re.sub(r"```.*?```|<!--.*?-->", "\n\n", README, flags=re.DOTALL)
    # Items of a list, and links, which lead elsewhere from another folder.
    text = re.sub(r"^- ", "\n", text, flags=re.MULTILINE)
    text = re.sub(r"(?<!!)\[([^\]]+)\]\([^)]+\)", r"\1", text)
    paragraphs = (" ".join(part.split()) for part in re.split(r"\n\s*\n", text))
    return [
        sentence
        for paragraph in paragraphs
        if paragraph and not paragraph.startswith(("#", "!["))
        for sentence in re.split(r"(?<=[.:!?])\s+(?=[A-Z`\[*])", paragraph)
    ]


def test_every_sentence_of_the_readme_is_a_claim() -> None:
    names = {claim.sentence for claim in claims()}
    said = sentences()
    assert len(said) > 10
    assert [sentence for sentence in said if sentence not in names] == []
    assert sorted(names - set(said)) == []


@cache
def functions(name: str) -> set[str]:
    tree = ast.parse((ROOT / name).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_tests_and_pages_of_claims_exist() -> None:
    for claim in claims():
        assert claim.tests, claim.sentence
        for identifier in claim.tests:
            name, _, function = identifier.partition("::")
            assert function in functions(name), claim.sentence
        if claim.page:
            page = DOCS / claim.page
            if page.parent.name == "examples":
                page = DOCS / "gallery" / f"{page.stem}.py"
            assert page.exists(), claim.sentence


def test_omitted_effects_are_explained() -> None:
    page = (DOCS / "assumptions.md").read_text(encoding="utf-8").lower()
    for word in ("friction", "adhesion", "layers", "residual", "hardening"):
        assert word in page


def test_extras_install_stated_packages() -> None:
    extras = PROJECT["optional-dependencies"]
    assert any(entry.startswith("SurfaceTopography") for entry in extras["io"])
    assert any(entry.startswith("ducc0") for entry in extras["fast"])
    assert any(entry.startswith("panel") for entry in extras["desk"])
    assert any(entry.startswith("dask") for entry in extras["cluster"])
    assert any(entry.startswith("torch") for entry in extras["gpu"])
    assert set(extras["all"]) == {"roughcontact[desk,fast,io]"}
    # Packages under the GPL are never needed.
    assert not any(entry.startswith("ducc0") for entry in PROJECT["dependencies"])


def test_test_command_installs_required_packages() -> None:
    command = README.split("<!-- test-command -->")[1].split("<!-- end -->")[0]
    wanted = re.search(r"\.\[([a-z,]+)\]", command)
    assert wanted is not None
    assert "pytest" in command
    extras = PROJECT["optional-dependencies"]
    needed = [entry for name in wanted[1].split(",") for entry in extras[name]]
    for package in ("pytest", "hypothesis"):
        assert any(entry.startswith(package) for entry in needed)


def test_the_licence() -> None:
    assert PROJECT["license"] == "BSD-3-Clause"
    assert "BSD 3-Clause License" in (ROOT / "LICENSE").read_text(encoding="utf-8")
