"""Names as one line of text, in everything that is written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools.text import csv_cell, join_words, replace_unprintable
from roughcontact.analyses.law.formats import LAW_FORMATS
from roughcontact.formats import export
from roughcontact.material import material
from roughcontact.material.material import Conductor, Layer
from roughcontact.surface import provenance
from roughcontact.surface.instrument import Instrument

# All that `str.splitlines` separates, and controls of terminals and of the direction of text.
SEPARATORS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029\0\x1b\x9b\u202e"
PAYLOAD = "PAYLOAD=1"
NAME = "map" + "".join(f"{separator}{PAYLOAD}" for separator in SEPARATORS) + ".nc"

# Formats of numbers, which no program executes.
BINARY = {".npz", ".nc", ".sur", ".x3p"}


def payload_lines(path: Path) -> list[str]:
    """Return the lines of a text file that begin with the payload."""
    text = path.read_bytes().decode("utf-8", "replace")
    assert not set(text) & set(SEPARATORS) - {"\n", "\r"}
    return [line for line in text.splitlines() if line.lstrip("#!*' ").startswith(PAYLOAD)]


def make_surface() -> rc.Surface:
    return rc.Surface(*rc.reference_map(32), rc.Provenance(NAME, NAME, NAME, [NAME]))


def solve_contact(load: float = 1.0) -> rc.ContactResult:
    steel = rc.Material(210e9, 0.3, 1e9, NAME)
    return rc.solve(make_surface(), material=steel, load=load, boundary="periodic")


@pytest.mark.parametrize("suffix", sorted(export.SURFACE.suffixes))
def test_no_name_adds_a_line_to_a_surface(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"map{suffix}"
    make_surface().save(path)
    if suffix not in BINARY and suffix != ".vti":
        assert payload_lines(path) == []


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("suffix", [*sorted(export.CONTACT.suffixes), ".html"])
def test_no_name_adds_a_line_to_a_contact(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"contact{suffix}"
    result = solve_contact()
    result.report(path) if suffix == ".html" else result.save(path)
    if suffix not in BINARY and suffix != ".vti":
        assert payload_lines(path) == []


@pytest.mark.parametrize("suffix", sorted(LAW_FORMATS.suffixes))
@pytest.mark.parametrize("is_read", [False, True])
def test_no_name_adds_a_line_to_a_law(
    suffix: str, is_read: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if is_read:
        # A result file of another program holds the name as it is.
        with monkeypatch.context() as patch:
            for module in (provenance, material):
                patch.setattr(module, "replace_unprintable", lambda text: text.replace("\0", ""))
            for number, load in enumerate((0.5, 1.0)):
                solve_contact(load).save(tmp_path / f"{number}.nc")
        contacts = [rc.read_result(tmp_path / f"{number}.nc") for number in range(2)]
    else:
        contacts = [solve_contact(load) for load in (0.5, 1.0)]
    path = tmp_path / f"law{suffix}"
    rc.interface_law(contacts).save(path)
    if suffix not in BINARY:
        assert payload_lines(path) == []


def test_names_of_all_inputs_are_one_line() -> None:
    named = [
        rc.Material(1e9, 0.3, name=NAME).name,
        Layer(1e9, 0.3, 1e-6, name=NAME).name,
        Conductor(name=NAME).name,
        Instrument(resolution=1e-6, name=NAME).name,
        *make_surface().provenance.steps,
        make_surface().provenance.source,
        make_surface().provenance.with_name(NAME).source,
    ]
    assert all(text.isprintable() for text in named)


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t=", "\r+", " =", "\u2028@"])
def test_a_cell_from_a_name_is_no_formula(start: str) -> None:
    cell = csv_cell(f"{start}cmd|' /C calc'!A0")
    assert cell.strip()[0] == "'"
    assert cell.isprintable()


def test_a_sweep_table_has_no_formula(tmp_path: Path) -> None:
    curve = rc.sweep(make_surface(), material=rc.Material(1e9, 0.3), loads=[1e-3, 2e-3])
    curve.save(tmp_path / "curve.csv")
    curve.save(tmp_path / "curve.json")
    assert json.loads((tmp_path / "curve.json").read_text("utf-8"))["source"].isprintable()
    assert payload_lines(tmp_path / "curve.csv") == []


def test_unprintable_characters_are_blanks() -> None:
    assert replace_unprintable("a\nb\tc", exceptions="\t") == "a b\tc"
    assert replace_unprintable("µm α 表面 é") == "µm α 表面 é"
    assert join_words(" a \n\n b ") == "a b"
    assert np.all([not replace_unprintable(c).strip() for c in SEPARATORS])
