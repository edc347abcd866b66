"""Files for contributors, citations and installation name existing files and one version."""

from __future__ import annotations

import datetime
import importlib.util
import json
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

import roughcontact as rc
from paths import ROOT

GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
DATE = datetime.date(2026, 12, 1)


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"scripts_{name}", ROOT / f"scripts/{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def release() -> ModuleType:
    return script("release")


@pytest.fixture
def checkout(release: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files that a release changes, with something unreleased."""
    for path in (release.VERSION, release.CHANGES, *release.CITED):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        text = (ROOT / path).read_text(encoding="utf-8")
        if path == release.CHANGES:
            text = text.replace("## Unreleased\n", "## Unreleased\n\n### Added\n\n- More.\n", 1)
        (tmp_path / path).write_text(text, encoding="utf-8")
    monkeypatch.setattr(release, "ROOT", tmp_path)
    return tmp_path


def test_paths_in_contributing_guide_exist() -> None:
    named = set(re.findall(r"`([\w./]+/[\w.]*)`|\]\(([\w./]+)\)", GUIDE))
    paths = {one or other for one, other in named}
    assert len(paths) > 15
    assert [path for path in sorted(paths) if not (ROOT / path).exists()] == []


def test_table_of_additions_has_eight_rows() -> None:
    table = GUIDE.partition("## To add something")[2].partition("\n## ")[0]
    assert len(re.findall(r"^\| (?!to add|---)", table, re.MULTILINE)) == 8


def test_commands_in_contributing_guide_exist() -> None:
    for command in re.findall(
        r"python ((?:benchmarks|calibration|tests/fuzz|scripts)/\w+\.py)", GUIDE
    ):
        assert (ROOT / command).exists(), command
    assert (ROOT / ".ci/run").exists()


def test_version_is_the_same_everywhere(release: ModuleType) -> None:
    assert release.version_of((ROOT / release.VERSION).read_text("utf-8")) == rc.__version__
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {rc.__version__}\n" in cited
    assert json.loads((ROOT / "codemeta.json").read_text("utf-8"))["version"] == rc.__version__


def test_citation_has_license_and_description_of_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    meta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    assert f"\nlicense: {project['license']}\n" in cited
    names = [author["name"] for author in project["authors"]]
    assert names == [author["name"] for author in meta["author"]]
    assert all(f"  - name: {name}\n" in cited for name in names)
    assert meta["license"].endswith(project["license"])
    assert meta["description"] == project["description"]
    assert meta["keywords"] == project["keywords"]
    assert all(f"  - {word}\n" in cited for word in project["keywords"])


def test_a_release_changes_version_changelog_and_citation(
    release: ModuleType, checkout: Path
) -> None:
    texts = release.changed_texts(checkout, "99.1.0", DATE)
    assert release.version_of(texts[release.VERSION]) == "99.1.0"
    assert "\nversion: 99.1.0\n" in texts[Path("CITATION.cff")]
    assert json.loads(texts[Path("codemeta.json")])["version"] == "99.1.0"
    changes = texts[release.CHANGES]
    assert "## Unreleased\n\n## 99.1.0 - 2026-12-01\n\n### Added\n" in changes
    # The previous content is kept.
    before = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert changes.replace("\n## 99.1.0 - 2026-12-01\n", "") == before


@pytest.mark.parametrize(
    ("version", "words"),
    [("0.0.1", "already; give"), (rc.__version__, "already"), ("1.0", "three"), ("v2.0.0", "v2")],
)
def test_invalid_or_earlier_version_is_rejected(
    release: ModuleType, version: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert release.main([version, "--dry-run"]) == 2
    assert words in capsys.readouterr().err


def test_release_without_changes_raises_error(release: ModuleType) -> None:
    with pytest.raises(release.RefusedError, match="nothing under 'Unreleased'"):
        release.cut_changelog("# Changelog\n\n## Unreleased\n\n## 0.1.0\n\n- One.\n", "0.2.0", DATE)


def test_dry_run_prints_steps_and_changes_nothing(
    release: ModuleType, checkout: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (checkout / "CHANGELOG.md").read_bytes()
    assert release.main(["99.1.0", "--dry-run"]) == 0
    output = capsys.readouterr().out
    assert "would write CHANGELOG.md" in output
    assert "would commit 'Release 99.1.0' and tag it v99.1.0" in output
    assert (checkout / "CHANGELOG.md").read_bytes() == before


def test_missing_and_extra_files_of_packages_are_reported() -> None:
    packages = script("packages")
    whole = packages.expected_names(ROOT)
    assert {"roughcontact/py.typed", "roughcontact/__init__.pyi"} <= whole
    assert any(name.endswith(".html.j2") for name in whole)
    archive = {f"x/src/{name}" for name in whole} | {f"x/{name}" for name in packages.WITH_SOURCE}
    about = {"roughcontact-0.1.0.dist-info/METADATA"}
    assert packages.name_errors(whole | about, archive, ROOT) == []
    wheel = (whole - {"roughcontact/py.typed"}) | {"tests/conftest.py"}
    assert packages.name_errors(wheel, archive - {"x/README.md"}, ROOT) == [
        "the wheel lacks roughcontact/py.typed",
        "the wheel holds tests/conftest.py",
        "the source package lacks README.md",
    ]


def test_public_ci_runs_every_version_on_every_system() -> None:
    text = (ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8")
    for name in ("ubuntu", "macos", "windows", '"3.11"', '"3.12"', '"3.13"', '"3.14"'):
        assert name in text


def test_paper_cites_its_references_and_measured_times() -> None:
    from roughcontact.references import all_references

    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8")
    listed = (ROOT / "paper/paper.bib").read_text(encoding="utf-8")
    cited = set(re.findall(r"@([A-Z]\w+\d{4})", text))
    assert cited == set(re.findall(r"^@\w+\{(\w+),$", listed, re.MULTILINE))
    known = all_references()
    assert all(known[key].bibtex in listed for key in cited & set(known))
    measured = (ROOT / "docs/evidence/performance.md").read_text(encoding="utf-8")
    for case, program, shown in (
        ("rough-1024-ceiling", "contactmechanics", "947 s"),
        ("rough-1024-elastic", "contactmechanics", "36.5 s"),
        ("rough-1024-elastic", "tamaas", "30.3 s"),
    ):
        assert f"| {case} | {program} | {shown} |" in measured
        assert shown in text
    for case, seconds in (("1024-ceiling", "0.51"), ("1024-elastic", "0.59")):
        found = re.search(rf"\| rough-{case} \| roughcontact \| ([\d.]+) s", measured)
        assert found is not None
        assert f"{float(found[1]):.2f}" == seconds
        assert f"{seconds} s here" in text
