"""The works that results cite are those of the theory page, and the ones that were used."""

from __future__ import annotations

import pkgutil
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.analyses.compare.sampling import SamplingStudy
from roughcontact.analyses.history.model import history as load_history
from roughcontact.analyses.leak.model import leakage
from roughcontact.analyses.tasks import PRESENTATIONS
from roughcontact.contact.series import StepResult
from roughcontact.formats.read import FORMATS
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Kinematic, Swift
from roughcontact.references import Reference, References, all_references, make_use
from roughcontact.report import citations
from roughcontact.report.presentation import Presentation, presentation_of
from roughcontact.result import Displayable, Result
from roughcontact.results import Uncertainty
from roughcontact.surface import nominal_bodies
from roughcontact.surface.provenance import Operation, Provenance

REFERENCES = all_references()
PAGE = ROOT / "docs" / "theory.md"
STEEL = rc.Material(210e9, 0.3, 1e9, name="steel")


def halves() -> tuple[str, str]:
    """Return the theory page before its list of sources, in one line, and the list."""
    body, _, listed = PAGE.read_text(encoding="utf-8").partition("## Sources")
    return re.sub(r"\s+", " ", body), listed


def rough(boundary: str = "free", **options: object) -> rc.ContactResult:
    heights, pixel = rc.reference_map(32)
    chosen = {"load": 1.0, "material": STEEL, "boundary": boundary, **options}
    return rc.solve(rc.Surface(heights, pixel), **chosen)  # type: ignore[arg-type]


def keys(works: References) -> set[str]:
    return {work.key for work in works}


def first_name(work: Reference) -> str:
    return work.authors[0].partition(",")[0] if work.authors else work.short


# --- the table and the theory page ----------------------------------------------------------------


def test_the_list_of_the_theory_page_is_the_table() -> None:
    listed = [line for line in halves()[1].splitlines() if line.startswith("- ")]
    assert listed == [f"- {work.text}" for work in REFERENCES.values()]


def test_the_theory_page_cites_every_work_of_the_table() -> None:
    body = halves()[0]
    for work in REFERENCES.values():
        pattern = rf"{first_name(work)}[^;:]{{0,60}}?\b{work.year}" if work.authors else work.short
        assert re.search(pattern, body), f"docs/theory.md does not cite {work.short}"


def test_every_work_that_the_theory_page_cites_is_in_the_table() -> None:
    body = halves()[0]
    for year in re.finditer(r"(?<![\d./])(?:18|19|20)\d\d(?!\w)", body):
        before = body[max(0, year.start() - 80) : year.start()]
        known = [w for w in REFERENCES.values() if w.year == int(year[0])]
        assert any(first_name(work) in before for work in known), f"{before[-40:]}{year[0]}"
    for number in re.findall(r"ISO \d+(?:-\d+)?", body):
        assert number.replace(" ", "") in REFERENCES, number


def test_every_cited_name_is_in_table() -> None:
    folder = Path(citations.__file__).parent
    paths = [*folder.glob("*.py"), *folder.with_name("analyses").rglob("*.py")]
    text = "".join(path.read_text(encoding="utf-8") for path in paths)
    named = set(re.findall(r'"([A-Z][A-Za-z]+\d{4}|ISO\d+(?:-\d+)?|DLMF|EngineeringModel)"', text))
    named |= {key for boundary in Boundary for key in boundary.works}
    assert named <= set(REFERENCES)
    # Works of the theory page alone: closed forms that no result uses.
    closed = {"Westergaard1939", "JohnsonGreenwood1985", "ISO18265"}
    assert set(REFERENCES) - named == closed


# --- how they are written -------------------------------------------------------------------------


def test_paper_is_formatted_as_text_and_bibtex() -> None:
    work = REFERENCES["Polonsky1999"]
    assert work.short == "Polonsky and Keer 1999"
    assert work.text == (
        "Polonsky, I. A. and Keer, L. M. (1999). A numerical method for solving rough contact "
        "problems based on the multi-level multi-summation and conjugate gradient techniques. "
        "Wear 231, 206–219. doi:10.1016/S0043-1648(99)00113-1."
    )
    assert work.bibtex.splitlines()[0] == "@article{Polonsky1999,"
    assert "  author = {Polonsky, I. A. and Keer, L. M.}," in work.bibtex
    assert "  pages = {206--219}," in work.bibtex


def test_references_are_saved_by_suffix(tmp_path: Path) -> None:
    found = References(
        (make_use("one", "Tabor1951", "Johnson1985"), make_use("two", "Johnson1985"))
    )
    found.save(tmp_path / "works.bib")
    found.save(tmp_path / "works.txt")
    assert (tmp_path / "works.bib").read_text(encoding="utf-8") == found.bibtex
    assert (tmp_path / "works.txt").read_text(encoding="utf-8") == f"{found!r}\n"
    assert found.text.startswith("One\n  Tabor, D. (1951). The Hardness of Metals.")
    assert len(found) == 2
    with pytest.raises(rc.InputError, match=r"\.bib"):
        found.save(tmp_path / "works.ris")


# --- what was used, and nothing else --------------------------------------------------------------


def filtered(heights: np.ndarray, pixel: tuple[float, float], *more: Operation) -> rc.Surface:
    steps = [Operation("filtered", {"s": 1e-6, "l": None}), *more]
    return rc.Surface(heights, pixel, Provenance("a", operations=steps))


def prepared() -> rc.ContactResult:
    form = Provenance("form", operations=[Operation("filled", {}, {"missing": 3})])
    result = rough()
    surface = filtered(*rc.reference_map(32), Operation("with_form", {"form": form}))
    return replace(result, pair=replace(result.pair, surface=surface))


def tilted() -> rc.ContactResult:
    ball = nominal_bodies.ellipsoid(radii=(1e-3, 2e-3), shape=(32, 32), pixel=(1e-6, 1e-6))
    return rc.solve(ball, load=0.1, material=STEEL, moments=(0.0, 0.0))


def curve(surface: rc.Surface | None = None, load: float = 0.1, **options: object) -> Any:
    chosen: dict[str, Any] = {"material": STEEL, **options}
    return rc.sweep(surface or rc.Surface(*rc.reference_map(32)), loads=[load], **chosen)


PROFILE = rc.Surface(-1e-6 * np.linspace(-1, 1, 64)[None, :] ** 2, (1.0, 1e-6))
COPPER = rc.Conductor(resistivity=1.7e-8, conductivity=400.0)
SOFT = rc.Material(210e9, 0.3)
COATED = rc.Material(210e9, 0.3, coating=[rc.Layer(450e9, 0.25, "2 um")])
ELASTIC = {"ceiling": None}


@pytest.mark.parametrize(
    ("build", "cited", "uncited"),
    [
        (
            rough,
            "Love1929 EngineeringModel Almqvist2007 Tabor1951 Polonsky1999 Kalker1977 ISO25178-2 "
            "Yastrebov2017",
            "Stanley1997 Burmister1945 ISO16610-61 Vanek1996",
        ),
        (
            lambda: rough("periodic", **ELASTIC),
            "Stanley1997 Persson2001",
            "Love1929 EngineeringModel Tabor1951",
        ),
        (lambda: rough("periodic-x"), "DLMF", ""),
        (lambda: rough(material=SOFT, **ELASTIC), "", "Jackson2005"),
        (lambda: rough(material=COATED, **ELASTIC), "Burmister1945", ""),
        (
            lambda: rc.solve(PROFILE, load=rc.LineLoad(1e3), material=STEEL),
            "ISO21920-2 Green2005",
            "ISO25178-2 Jackson2005 Yastrebov2017 Love1929",
        ),
        (lambda: curve(PROFILE, 1e3), "ISO21920-2 Green2005", "ISO25178-2 Jackson2005 Bush1975"),
        (prepared, "ISO16610-61 Vanek1996", ""),
        (
            lambda: curve(counter_surface=filtered(np.zeros((32, 32)), rc.reference_map(32)[1])),
            "ISO16610-61",
            "",
        ),
        (curve, "Bush1975 Persson2001 Hyun2004 Barber2003", "ISO16610-61"),
        (lambda: curve(material=SOFT, **ELASTIC), "", "Jackson2005 EngineeringModel"),
        (
            lambda: rc.conductance(rough("periodic"), COPPER, COPPER),
            "Barber2003 Greenwood1966 Mikic1974",
            "",
        ),
        (lambda: leakage(rough("periodic")), "Patir1978 Notay2010 Dapp2012", "Barber2003"),
        (lambda: rough("periodic").estimate, "Persson2001 Yang2008", "Tabor1951"),
        (tilted, "Carlson1995 Nocedal2006 Gilbert1988", "Hamilton1983"),
        (
            lambda: rc.subsurface_stress(tilted(), friction=0.1, depths=[1e-6]),
            "Liu2002 Hamilton1983",
            "",
        ),
    ],
)
def test_results_cite_what_they_used(build: Callable[[], Any], cited: str, uncited: str) -> None:
    found = keys(build().references())
    assert set(cited.split()) <= found
    assert not set(uncited.split()) & found


@pytest.mark.parametrize("boundary", Boundary)
def test_every_boundary_has_its_kernel(boundary: Boundary) -> None:
    assert set(boundary.works) <= keys(rough(boundary).references())


@pytest.mark.parametrize(("name", "norm"), [("x3p", True), ("sur", False), ("npy", None)])
def test_reader_of_file_is_cited(name: str, norm: bool | None) -> None:
    assert name in {known.name for known in FORMATS}
    read = Operation("read_surface", {"path": f"a.{name}"}, {"format": name})
    result = rough()
    surface = replace(result.surface, provenance=Provenance(f"a.{name}", origin=read))
    found = keys(replace(result, pair=replace(result.pair, surface=surface)).references())
    assert ("Rottger2022" in found) == (norm is not None)
    assert ("ISO25178-72" in found) == bool(norm)


def test_volume_model_cites_its_sources(loaded: rc.ElastoplasticResult) -> None:
    found = keys(loaded.references())
    assert {"Jacq2002", "Frerot2019", "Anderson1965", "Swift1952"} <= found
    assert not {"EngineeringModel", "Prager1955", "Boucly2007"} & found
    body = loaded.bodies[0]
    law = Kinematic(Swift(1240e6, 30, 0.085), 1e9)
    other = replace(body, material=replace(body.material, hardening=law))
    assert {"Prager1955", "Swift1952"} <= keys(replace(loaded, bodies=(other,)).references())
    rolled = rc.results.RollingResult(loaded, ()).references()
    assert "Boucly2007" in keys(rolled)


def test_history_cites_contact_and_other_objects_raise_type_error() -> None:
    result = rough()
    history = load_history(result.surface, [1.0, 0.5], material=STEEL)
    assert keys(history.references()) == keys(history.under_largest.references())
    with pytest.raises(TypeError, match="no kind of results for a str"):
        presentation_of("a text")


@pytest.fixture(scope="module")
def compared() -> rc.results.Comparison:
    heights, pixel = rc.reference_map(64)
    maps = {
        name: [rc.Surface(factor * heights, pixel, Provenance(f"{name}.npy"))] * 2
        for name, factor in (("ground", 1.0), ("lapped", 0.5), ("honed", 0.8))
    }
    return rc.compare(maps, material=STEEL, pressure="50 MPa", steps=1)


def test_every_kind_of_result_has_references(compared: rc.results.Comparison) -> None:
    assert {kind.__name__ for kind in Displayable.__subclasses__()} == {"Result", "Surface"}
    # Tests define other kinds.
    kinds_of_results = {*Result.__subclasses__(), *StepResult.__subclasses__()} - {StepResult}
    own = {kind for kind in kinds_of_results if kind.__module__.startswith("roughcontact")}
    assert PRESENTATIONS.keys() == {kind.__name__ for kind in (*own, rc.Surface)}
    # Studies of resolution and uncertainty belong to a contact, a surface has parameters.
    none = Presentation
    citing = {
        name
        for name, place in PRESENTATIONS.items()
        for kind in [pkgutil.resolve_name(f"roughcontact.{place}")]
        if kind.contact_name or kind.contact is not none.contact or kind.works is not none.works
    }
    assert PRESENTATIONS.keys() - citing == {"ResolutionStudy", "Surface", "Uncertainty"}


def test_curve_cites_sources_of_contacts_and_ceiling() -> None:
    read = Operation("read_surface", {"path": "a.x3p"}, {"format": "x3p"})
    surface = rc.Surface(*rc.reference_map(32), Provenance("a.x3p", origin=read))
    single = rc.solve(surface, load=1.0, material=STEEL, calibrated=False).references()
    both = curve(surface, 1.0), curve(surface, 1.0, ceiling="calibrated")
    assert keys(single) <= keys(both[0].references())
    are_cited = ["calibrated ceiling" in dict(one.references().uses) for one in both]
    assert are_cited == [False, True]


def test_found_load_of_first_yield_cites_stress() -> None:
    heights, pixel = rc.reference_map(32)
    surface = rc.Surface(heights, pixel)
    loose = rc.find_load(surface, material=STEEL, contact_fraction=0.05)
    assert keys(loose.references()) == keys(loose.largest.references())
    yielded = rc.find_load(surface, material=STEEL, first_yield=True)
    assert "stress below the surface" in dict(yielded.references().uses)


@pytest.mark.long
def test_a_comparison_cites_its_intervals(compared: rc.results.Comparison) -> None:
    found = compared.references()
    assert {"Student1908", "Games1976", "Searle1992", "EngineeringModel"} <= keys(found)
    assert "Welch1947" not in keys(found)
    two = replace(compared, groups=compared.groups[:2]).references()
    assert "Welch1947" in keys(two)
    assert "Games1976" not in keys(two)
    pairs = replace(compared, groups=compared.groups[:2], paired=True).references()
    assert not {"Welch1947", "Games1976", "Searle1992"} & keys(pairs)
    alone = replace(compared, groups=compared.groups[:1]).references()
    assert not {"Welch1947", "Games1976", "Searle1992"} & keys(alone)
    study = SamplingStudy(compared.groups[0].samples[0], {})
    assert keys(study.references()) == keys(alone)
    text = presentation_of(compared).render()
    assert "@article" not in text
    assert all(work.text in unescape(text) for work in found if work.authors)


@pytest.mark.parametrize("kind", ["optical", "coherent", "gaussian", "measured", "tip"])
def test_contact_with_intervals_cites_the_transfer_of_its_instrument(kind: str) -> None:
    tool = rc.measure.Instrument.from_transfer([0, 1e6], [1, 0.1])
    if kind != "measured":
        tool = rc.measure.Instrument(kind, resolution=1e-6, tip_radius=1e-6)
    known = Uncertainty((), {}, tool, None, 1e-6, 0, 0, ())
    uses = citations.contact_references(replace(rough(), measurement=known))
    cited = {work.key for _, works in uses for work in works}
    assert ("Villarrubia1997" in cited) == (kind == "tip")
    assert ("Goodman2005" in cited) == (kind != "tip")
