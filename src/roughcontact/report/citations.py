"""References of a result: only those of the methods used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from roughcontact.contact.nominal_hertz import ELLIPSE
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.formats import instruments
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.hardening import Hardening, Kinematic, Swift
from roughcontact.references import Reference, make_use
from roughcontact.report.kind import Use
from roughcontact.surface.provenance import Operation, Provenance

Uses = Iterator[Use]

# Preparation and generation steps of a map, by method of `Surface` or function.
_STEPS = {
    "filtered": ("filter of the map", "ISO16610-61"),
    "filled": ("missing points of the map", "Vanek1996"),
    "generate": ("generated surface", "Schreiber1996", "Grigoriu1984", "JohnsonNL1949"),
    "reference_map": ("generated surface", "Persson2005", "Jacobs2017"),
}

CEILING = make_use("ceiling of the pressure", "EngineeringModel", "Almqvist2007", "Tabor1951")
RECOMMENDED = make_use("calibrated ceiling", "Jackson2005", "Pullen1972", "Childs1973")


def contact_references(result: ContactResult) -> Uses:
    """Yield the works of a contact."""
    yield from _elastic(result)
    if result.ceiling is not None:
        yield CEILING
    if result.calibration is not None or result.calibrated is not None:
        yield RECOMMENDED
    if result.hertz is not None:
        ellipse = result.hertz.shape.kind == ELLIPSE
        yield make_use("smooth bodies compared", "Johnson1985", *(["Carlson1995"] * ellipse))
    tool = result.measurement and result.measurement.instrument
    if tool is not None:
        of_kind = ["Goodman2005", "DeGroot2021", "DeGroot2024"]
        if tool.kind == "tip":
            of_kind = ["Villarrubia1997"]
        works = "Wilson2021", "Jacobs2017", "Moisan2011"
        yield make_use("surface behind the map", *works, *of_kind)
    if result.estimate is not None:
        yield make_use("formulas of nominally flat contact", "Persson2001", "Yang2008")


def _elastic(result: ContactResult) -> Uses:
    """Yield the works on the solution of any contact, with or without a ceiling."""
    pair = result.pair
    known = pair.softer is not None and pair.softer.yield_strength is not None
    yield from map_references(pair.origins, pair.is_profile)
    yield from solved_of(result.boundary, pair.is_profile, known)
    if pair.is_coated:
        yield make_use("response of the layers", "Burmister1945")
    if result.moments is not None:
        yield make_use("bodies that tilt", "Nocedal2006", "Gilbert1988")


def map_references(origins: Iterable[Provenance], is_profile: bool) -> Uses:
    """Yield the works on the generation and preparation of maps."""
    for origin in origins:
        yield from _provenance_references(origin)
    if is_profile:
        yield make_use("parameters of the profile", "ISO21920-2", "ISO4287")
    else:
        yield make_use("parameters of the map", "ISO25178-2")


def solved_of(boundary: Boundary, is_profile: bool, yields: bool) -> Uses:
    """Yield the works on kernel and solver; ``yields``: a yield strength is known."""
    # A profile has the kernel of plane strain.
    works = ("Johnson1985",) if is_profile else boundary.works
    yield make_use("response of the half-space", *works)
    yield make_use("principle of minimum", "Kalker1977")
    solver = "Polonsky1999", "Hintermueller2002", "Pardalos1990", "Birgin2000", "More1991"
    yield make_use("solver", *solver, "Golub1999")
    if yields:
        yield make_use("first yield", "Green2005" if is_profile else "Jackson2005")
    if not is_profile:
        yield make_use("perimeter-corrected contact area", "Yastrebov2017")
    yield make_use("arrays, transforms and linear algebra", "Harris2020", "Virtanen2020")


def _provenance_references(provenance: Provenance) -> Uses:
    origin = provenance.origin
    created = () if origin is None else (origin,)
    for step in (*created, *provenance.operations):
        yield from _step_references(step)


def _step_references(step: Operation) -> Uses:
    if step.method in _STEPS:
        yield make_use(*_STEPS[step.method])
    name = step.found.get("format")
    if step.method == "read_surface" and name in instruments.SUFFIXES:
        norm = ("ISO25178-72",) if name == "x3p" else ()
        yield make_use("reader of the file", "Rottger2022", *norm)
    for other in step.arguments.values():
        if isinstance(other, Provenance):
            yield from _provenance_references(other)


def stress_references(boundary: Boundary) -> tuple[str, tuple[Reference, ...]]:
    """Return the works on stress below the surface."""
    free = () if boundary.periodic_axes else ("Love1929", "Liu2002")
    return make_use("stress below the surface", "Johnson1985", *free)


def volume_references(result: ElastoplasticResult) -> Uses:
    """Yield the works of a contact with plasticity of the volume."""
    yield from _elastic(result.solution)
    yield make_use("plasticity of the volume", "Jacq2002", "Nelias2006", "Frerot2019", "Simo1998")
    yield make_use("acceleration of the loop", "Anderson1965")
    if result.has_moved:
        yield make_use("bodies that move", "Boucly2007")
    for body in result.bodies:
        yield from _law_references(body.material.law)


def _law_references(law: Hardening) -> Uses:
    if isinstance(law, Kinematic):
        yield make_use("kinematic hardening", "Prager1955", "Simo1998")
        law = law.isotropic
    if isinstance(law, Swift):
        yield make_use("hardening law", "Swift1952")
