"""Materials of machines, each value with its source.

The values are typical ones of the condition named, not guaranteed ones: heat treatment, size and
supplier move a yield strength by a tenth and more. A value for which no source worth naming was
found is left out. Compilations (MakeItFrom, MatWeb, AZoM) are named as such.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from roughcontact.errors import InputError, shown
from roughcontact.material import hardness
from roughcontact.material.conductor import Conductor
from roughcontact.material.hardening import Swift
from roughcontact.material.material import Material

# Plastic strain of a proof stress, in millionths.
_PROOF = 2000.0


class Value(NamedTuple):
    """A number in SI units and where it was found."""

    value: float
    source: str


class Number(NamedTuple):
    """A hardness as `hardness.parse` reads it, and where it was found."""

    text: str
    source: str


@dataclass(frozen=True)
class Entry:
    """A material of the catalogue.

    Parameters
    ----------
    key : str
        Its name in reports: the European designation where there is one.
    names : tuple of str
        Other names.
    condition : str
        Heat treatment or form that the values belong to.
    young : Value
        Young's modulus E [Pa].
    poisson : Value
        Poisson's ratio ν.
    yield_strength : Value, optional
        Yield strength σ_Y [Pa], 0.2 % proof stress in tension unless the note says otherwise.
    hardness : Number, optional
        Hardness with its scale.
    note : str
        What a user should know.
    resistivity : Value, optional
        Electrical resistivity at room temperature [Ω m]; left out of insulators, too.
    conductivity : Value, optional
        Thermal conductivity at room temperature [W/(m K)].
    exponent : Value, optional
        Hardening exponent n: at a plastic strain e the yield strength is σ_Y (1 + e/0.002)ⁿ.
    caveat : str
        What the material does that no contact here includes, for `Material`.
    """

    key: str
    names: tuple[str, ...]
    condition: str
    young: Value
    poisson: Value
    yield_strength: Value | None = None
    hardness: Number | None = None
    note: str = ""
    resistivity: Value | None = None
    conductivity: Value | None = None
    exponent: Value | None = None
    caveat: str = ""

    @property
    def material(self) -> Material:
        """The constants alone, for a calculation."""
        strength, number = self.yield_strength, self.hardness
        return Material(
            young=self.young.value,
            poisson=self.poisson.value,
            yield_strength=None if strength is None else strength.value,
            name=self.key,
            hardness=None if number is None else hardness.ceiling(number.text),
            hardening=self.hardening,
            caveat=self.caveat,
        )

    @property
    def hardening(self) -> Swift | None:
        """The law of hardening, if its exponent is known."""
        if self.yield_strength is None or self.exponent is None:
            return None
        strength, exponent = self.yield_strength.value, self.exponent.value
        return Swift(strength / _PROOF**exponent, _PROOF, exponent)

    @property
    def conductor(self) -> Conductor:
        """What it conducts, as far as it is known."""
        return Conductor(
            resistivity=None if self.resistivity is None else self.resistivity.value,
            conductivity=None if self.conductivity is None else self.conductivity.value,
            name=self.key,
        )


def entries() -> tuple[Entry, ...]:
    """Return all entries of the catalogue.

    Returns
    -------
    tuple of Entry
        Steels, cast irons, other metals, ceramics, polymers.
    """
    return _ENTRIES


def entry(name: str) -> Entry:
    """Return a material with the sources of its values.

    Parameters
    ----------
    name : str
        Key or another name, such as ``"100Cr6"``, ``"AISI 52100"`` or ``"bearing steel"``;
        case, spaces and punctuation are ignored.

    Returns
    -------
    Entry
        The entry.

    Raises
    ------
    InputError
        If no material has this name; the message gives those with the nearest names.

    Examples
    --------
    >>> entry("aisi 52100").hardness.text
    '746 HV30'
    """
    if not isinstance(name, str):
        raise InputError(f"must be a name, got {shown(name)}", argument="material", value=name)
    found = _index()
    plain = _plain(name)
    if plain in found:
        return found[plain]
    from difflib import get_close_matches

    close = get_close_matches(plain, found, n=3, cutoff=0.5)
    keys = dict.fromkeys(found[match].key for match in close) or [item.key for item in _ENTRIES]
    told = name if len(name) <= 60 else name[:59] + "…"
    raise InputError(
        f"{told!r} is not in the catalogue; "
        f"{'did you mean' if close else 'it holds'} {', '.join(keys)}{'?' if close else ''}",
        argument="material",
        value=name,
    )


def material(name: str) -> Material:
    """Return the constants of a material.

    Parameters
    ----------
    name : str
        As for `entry`.

    Returns
    -------
    Material
        Named by its key; its ``hardness`` is a pressure [Pa].

    Raises
    ------
    InputError
        If no material has this name; the message gives those with the nearest names.

    Examples
    --------
    >>> bearing = material("100Cr6")
    >>> bearing.young, bearing.poisson, round(bearing.hardness / 1e9, 2)
    (210000000000.0, 0.3, 7.89)
    """
    return entry(name).material


def _plain(name: str) -> str:
    return "".join(letter for letter in name.casefold() if letter.isalnum())


def _index() -> dict[str, Entry]:
    return {_plain(name): item for item in _ENTRIES for name in (item.key, *item.names)}


_CALLISTER_E = (
    "Callister and Rethwisch, Materials Science and Engineering (8th ed. 2010), table B.2"
)
_CALLISTER_NU = (
    "Callister and Rethwisch, Materials Science and Engineering (8th ed. 2010), table B.3"
)
_CALLISTER_YIELD = (
    "Callister and Rethwisch, Materials Science and Engineering (8th ed. 2010), table B.4"
)
_LUCEFIN_100CR6 = "Lucefin Group, Technical card 100Cr6 (EN ISO 683-17:1999)"
_LUCEFIN_42CRMO4 = (
    "Lucefin Group, Technical card 42CrMo4 (ISO 683-2:2018), rev. 2024, table of tempering values"
)
_LUCEFIN_H13 = "Lucefin Group, Technical card 1.2344 X40CrMoV5-1, rev. 2013"
_GEARS = "ISO 6336-2, Calculation of load capacity of spur and helical gears, part 2: Z_E = 189.8"
_TYPE_304 = "AISI Type 304 stainless steel, material data sheet (MatWeb)"
_ROLLED_440C = "Rolled Alloys, Data sheet 440C stainless"
_THYROTHERM = "Schmolz + Bickenbach, Thyrotherm 2344 Magnum (AISI H13), Technical data sheet"
_ASC_H13 = "ASC Forgings, H13 hot work tool steel (DIN 1.2344), product data"
_D2 = "AISI D2 cold work tool steel, data sheet, scribd.com/document/231841150"
_AZOM_D2 = "AZoM, D2 tool steel (UNS T30402), azom.com ArticleID 6214"
_AZOM_M2 = "AZoM, M2 molybdenum high speed tool steel (UNS T11302), azom.com ArticleID 6174"
_GJL = "EN 1561:1997, Founding - Grey cast irons, annex A (separately cast 30 mm samples)"
_GJS = "EN 1563:1997, Founding - Spheroidal graphite cast irons"
_RCI = "RCI Industries and Technologies, Phosphor bronze grade IV (CuSn8), product data"
_CUSN12NI2 = "MakeItFrom.com, EN CC484K (CuSn12Ni2-C) tin bronze (compilation)"
_BRONZES = "EN 1982:1998, Copper and copper alloys - Ingots and castings, table 21"
_DURBIN = "Durbin Metals, Data sheet CW614N brass flat bar and profiles (EN 12167:2011)"
_AL6061 = "MatWeb, Aluminum 6061-T6 (typical values of the Aluminum Association)"
_AL7075 = "MatWeb, Aluminum 7075-T6 (typical values of the Aluminum Association)"
_TI64 = "Materials 14 (2021) 658, table 4, extruded rod, doi:10.3390/ma14030658"
_ALUMINA = "Munro, J. Am. Ceram. Soc. 80 (1997) 1919, in NIST Standard Reference Database 150"
_TUBING_316 = "Tubingchina.com, Physical properties of 316 (1.4401) and 316L (1.4404)"
_QINGHE_440C = "Qinghe Steel, 440C stainless steel (1.4125), product data"
_KROMTEL = "Kromtel, Phosphor bronze CuSn8, product data"
_WIELAND = "Wieland-K32 (Cu-ETP, C11000, CW004A), data sheet, scribd.com/document/651533098"
_LILY = "Lily Bearing, Ceramic materials and their properties"
_XYCERA = "XYCera, Zirconia grade Z-100 (ZrO2-Y2O3), product data"
_WC = "MakeItFrom.com, Tungsten carbide (compilation)"
_SILICA = "MakeItFrom.com, Fused silica (compilation)"
_POLYSILICON = "Sharpe, Yuan, Vaidyanathan and Edwards, Proc. IEEE MEMS (1997) 424"

# Exponents that follow from other values of the row: three times the yield strength at a plastic
# strain of 8 % is the hardness.
_TABOR = (
    "derived from yield strength and hardness of this row by the rule of Tabor, The Hardness of "
    "Metals (1951): hardness of 3 flow stresses at a strain of 8 %"
)

_BRITTLE = (
    "Brittle, without a yield strength: the ceiling is the hardness; cracks are not modelled."
)
_CREEPS = "viscoelastic, so that stiffness and strength fall with time and indentations recover"
_VISCOELASTIC = (
    "Viscoelastic: E and σ_Y are those of a test of minutes and fall with time; an indentation "
    "recovers, so that no hardness is given."
)

_ENTRIES = (
    Entry(
        "100Cr6",
        ("AISI 52100", "52100", "1.3505", "SUJ2", "EN31", "GCr15", "bearing steel"),
        "hardened, tempered at 200 °C",
        young=Value(210e9, _LUCEFIN_100CR6),
        poisson=Value(0.30, _LUCEFIN_100CR6),
        yield_strength=Value(
            2034e6,
            "AISI 52100 chrome steel balls, data sheet (295 ksi), scribd.com/document/252517093",
        ),
        hardness=Number("746 HV30", _LUCEFIN_100CR6),
        note="Yield strength and hardness are of two sheets; of the balls only that they are hard.",
        exponent=Value(0.0692, _TABOR),
    ),
    Entry(
        "16MnCr5",
        ("1.7131", "case-hardened steel", "gear steel"),
        "case-hardened; the values are those of the case",
        young=Value(206e9, _GEARS),
        poisson=Value(0.30, _GEARS),
        hardness=Number("60 HRC", "Akrostal, 16HG / 1.7131 / 16MnCr5 (EN 10084): at least 60 HRC"),
        note=(
            "No yield strength of the case was found: the ceiling is the hardness. ISO 6336-5 asks "
            "58 to 64 HRC of the case whichever the steel."
        ),
    ),
    Entry(
        "18CrNiMo7-6",
        ("1.6587", "17CrNiMo6"),
        "case-hardened; the values are those of the case",
        young=Value(206e9, _GEARS),
        poisson=Value(0.30, _GEARS),
        hardness=Number(
            "60 HRC", "Haerterei Hauck, Case hardening: middle of the usual 58 to 62 HRC, any steel"
        ),
        note=(
            "No yield strength of the case was found, and no hardness of this steel alone: the "
            "ceiling is the hardness of cases in general. ISO 6336-5 asks 58 to 64 HRC."
        ),
    ),
    Entry(
        "42CrMo4",
        ("AISI 4140", "4140", "1.7225", "SCM440"),
        "quenched in oil, tempered at 600 °C, 10 mm round",
        young=Value(207e9, f"{_CALLISTER_E}, steel 4140"),
        poisson=Value(0.30, f"{_CALLISTER_NU}, steel 4140"),
        yield_strength=Value(1000e6, _LUCEFIN_42CRMO4),
        hardness=Number("336 HBW", _LUCEFIN_42CRMO4),
        note="Larger sections are weaker: +QT of 16 to 40 mm has at least 750 MPa (EN 10083-3).",
        resistivity=Value(220e-9, "MatWeb, AISI 4140: specimen hardened and tempered, 20 °C"),
        conductivity=Value(42.6, "Meusburger, Material grades, 1.7225: at 20 °C"),
        exponent=Value(0.033, _TABOR),
    ),
    Entry(
        "X5CrNi18-10",
        ("AISI 304", "304", "1.4301", "SUS304"),
        "solution annealed",
        young=Value(193e9, f"{_CALLISTER_E}, stainless alloy 304"),
        poisson=Value(0.29, _TYPE_304),
        yield_strength=Value(215e6, _TYPE_304),
        note=(
            "Its hardness is quoted as 70 HRB, a scale whose conversion does not hold for "
            "austenite."
        ),
        resistivity=Value(720e-9, f"{_TYPE_304}: at 20 °C"),
        conductivity=Value(16.2, f"{_TYPE_304}: 0 to 100 °C"),
        exponent=Value(
            0.2287, f"derived from {_TYPE_304}: tensile strength 505 MPa, by Considère's rule"
        ),
    ),
    Entry(
        "X2CrNiMo17-12-2",
        ("AISI 316L", "316L", "1.4404", "SUS316L"),
        "hot rolled and annealed, 4 mm",
        young=Value(193e9, f"{_CALLISTER_E}, stainless alloy 316"),
        poisson=Value(0.28, "MakeItFrom.com, Annealed 316L stainless steel (compilation)"),
        yield_strength=Value(300e6, "Outokumpu, Forta 316L/4404, typical of hot rolled coil"),
        hardness=Number("170 HBW", "Outokumpu, Forta 316L/4404, typical of hot rolled coil"),
        resistivity=Value(740e-9, f"{_TUBING_316}: alloy 316 at 20 °C"),
        conductivity=Value(14.6, f"{_TUBING_316}: 20 to 100 °C"),
        exponent=Value(0.1816, _TABOR),
    ),
    Entry(
        "X105CrMo17",
        ("AISI 440C", "440C", "1.4125", "SUS440C"),
        "hardened, tempered at 315 °C",
        young=Value(209.6e9, f"{_ROLLED_440C}: 30.4 million psi, dynamic"),
        poisson=Value(0.28, "MakeItFrom.com, Annealed 440C stainless steel (compilation)"),
        yield_strength=Value(1896e6, f"{_ROLLED_440C}: 275 ksi"),
        hardness=Number("56 HRC", _ROLLED_440C),
        resistivity=Value(600e-9, _QINGHE_440C),
        conductivity=Value(24.2, f"{_QINGHE_440C}: at 100 °C"),
        exponent=Value(0.0361, _TABOR),
    ),
    Entry(
        "X40CrMoV5-1",
        ("AISI H13", "H13", "1.2344", "SKD61"),
        "hardened and tempered to 48 HRC (tensile strength 1600 MPa)",
        young=Value(210e9, _LUCEFIN_H13),
        poisson=Value(0.285, f"{_ASC_H13}: middle of 0.27 to 0.30"),
        yield_strength=Value(1380e6, f"{_ASC_H13}: upper end, at a tensile strength of 1590 MPa"),
        hardness=Number("48 HRC", f"{_LUCEFIN_H13}: at a tensile strength of 1640 MPa"),
        resistivity=Value(543e-9, f"{_LUCEFIN_H13}: at 20 °C"),
        conductivity=Value(25.5, f"{_THYROTHERM}: tempered to 46 HRC, at 21 °C"),
        exponent=Value(0.0573, _TABOR),
    ),
    Entry(
        "X153CrMoV12",
        ("AISI D2", "D2", "1.2379", "SKD11"),
        "hardened and tempered to 62 HRC",
        young=Value(210e9, _D2),
        poisson=Value(0.285, f"{_AZOM_D2}: middle of 0.27 to 0.30 (compilation)"),
        yield_strength=Value(2200e6, f"{_D2}: compressive, Rc0.2"),
        hardness=Number("62 HRC", _D2),
        note="The yield strength is the compressive one.",
        exponent=Value(0.048, _TABOR),
    ),
    Entry(
        "HS6-5-2C",
        ("AISI M2", "M2", "1.3343", "SKH51", "high speed steel"),
        "hardened from 1205 °C, tempered twice at 540 °C",
        young=Value(207e9, "Wixsteel, M2 high speed steel bar, product data (30 million psi)"),
        poisson=Value(0.285, f"{_AZOM_M2}: middle of 0.27 to 0.30 (compilation)"),
        hardness=Number("65 HRC", "Eastern Tool Steel, M-2 high speed steel data sheet"),
        note=(
            "No yield strength of this condition was found: the ceiling is the hardness. The 3250 "
            "MPa that are often quoted are compressive and of another temper, at 150 °C."
        ),
    ),
    Entry(
        "EN-GJL-250",
        ("GJL-250", "GG25", "EN-JL1040", "0.6025", "grey cast iron", "gray cast iron"),
        "as cast, pearlitic",
        young=Value(110e9, f"{_GJL}: middle of 103 to 118 GPa"),
        poisson=Value(0.26, _GJL),
        yield_strength=Value(325e6, f"{_GJL}: 0.1 % proof stress in compression"),
        hardness=Number(
            "210 HBW", "SN Castiron, EN-GJL-250 (DIN EN 1561): middle of 190 to 230 HB"
        ),
        note="The yield strength is the compressive one; in tension 165 to 228 MPa.",
        conductivity=Value(46, "MakeItFrom.com, EN-JL 1040 grey cast iron (compilation)"),
        exponent=Value(0.2139, f"{_TABOR}; 719 MPa there, compressive strength 840 MPa ({_GJL})"),
    ),
    Entry(
        "EN-GJS-500-7",
        ("GJS-500-7", "GGG50", "EN-JS1050", "0.7050", "ductile cast iron", "nodular cast iron"),
        "as cast, ferritic-pearlitic",
        young=Value(169e9, _GJS),
        poisson=Value(0.275, f"{_GJS}, informative annex"),
        yield_strength=Value(320e6, f"{_GJS}: least value"),
        hardness=Number("200 HBW", f"{_GJS}: middle of 170 to 230 HB"),
        conductivity=Value(35.2, "Iron-foundry.com, UNI 4544 GS500-7 (EN-GJS-500-7), product data"),
        exponent=Value(0.2056, _TABOR),
    ),
    Entry(
        "Cu-ETP",
        ("CW004A", "C11000", "2.0065", "copper", "electrolytic copper"),
        "strip, temper R240 (half hard)",
        young=Value(115e9, _WIELAND),
        poisson=Value(0.34, _WIELAND),
        yield_strength=Value(180e6, f"{_WIELAND}: least value"),
        hardness=Number("80 HV", f"{_WIELAND}: middle of 65 to 95 HV"),
        resistivity=Value(17.2e-9, f"{_WIELAND}: 58 MS/m"),
        conductivity=Value(390, _WIELAND),
        exponent=Value(0.1209, _TABOR),
    ),
    Entry(
        "CuSn8",
        ("CW453K", "C52100", "2.1030", "phosphor bronze"),
        "strip, half hard",
        young=Value(109e9, f"{_RCI}: cold formed"),
        poisson=Value(0.34, f"{_CUSN12NI2}, as the nearest tin bronze"),
        yield_strength=Value(400e6, f"{_RCI}: least value of temper HB"),
        hardness=Number("175 HV", f"{_RCI}: least value of temper HB"),
        resistivity=Value(133e-9, f"{_KROMTEL}: 7.5 MS/m"),
        conductivity=Value(62, f"{_KROMTEL}; {_RCI}: 67"),
        exponent=Value(0.1167, _TABOR),
    ),
    Entry(
        "CuSn12Ni2-C",
        ("CC484K", "tin bronze", "gear bronze"),
        "centrifugally or continuously cast",
        young=Value(110e9, _CUSN12NI2),
        poisson=Value(0.34, _CUSN12NI2),
        yield_strength=Value(180e6, f"{_BRONZES}: least value; 160 MPa of sand castings"),
        hardness=Number(
            "100 HBW 2.5/62.5",
            f"{_CUSN12NI2}; force index 10 as ISO 6506-1 asks of copper alloys",
        ),
        exponent=Value(0.1694, _TABOR),
    ),
    Entry(
        "CuZn39Pb3",
        ("CW614N", "CZ121", "C38500", "brass", "free-cutting brass"),
        "extruded",
        young=Value(97e9, _DURBIN),
        poisson=Value(0.31, "Dongyuan, Brass (60 to 63 % Cu), product data"),
        yield_strength=Value(220e6, f"{_DURBIN}: lower end of 220 to 350 MPa"),
        note="No hardness of named origin was found for this form.",
        resistivity=Value(62e-9, _DURBIN),
        conductivity=Value(123, _DURBIN),
    ),
    Entry(
        "6061-T6",
        ("EN AW-6061", "AlMg1SiCu", "A96061", "aluminium 6061-T6", "aluminum 6061-T6"),
        "solution treated, artificially aged",
        young=Value(68.9e9, _AL6061),
        poisson=Value(0.33, _AL6061),
        yield_strength=Value(276e6, _AL6061),
        hardness=Number("95 HBW 10/500", _AL6061),
        resistivity=Value(39.9e-9, _AL6061),
        conductivity=Value(167, f"{_AL6061}: at 25 °C"),
    ),
    Entry(
        "7075-T6",
        ("EN AW-7075", "AlZn5.5MgCu", "A97075", "aluminium 7075-T6", "aluminum 7075-T6"),
        "solution treated, artificially aged",
        young=Value(71.7e9, _AL7075),
        poisson=Value(0.33, _AL7075),
        yield_strength=Value(503e6, _AL7075),
        hardness=Number("150 HBW 10/500", _AL7075),
        resistivity=Value(
            52.2e-9,
            "MakeItFrom.com, 7075 aluminum (compilation): 33 % IACS, tempers not told apart",
        ),
        conductivity=Value(
            130, "MakeItFrom.com, 7075 aluminum (compilation): tempers not told apart"
        ),
    ),
    Entry(
        "Ti-6Al-4V",
        ("TiAl6V4", "Ti64", "titanium grade 5", "R56400", "3.7165"),
        "extruded rod, annealed",
        young=Value(108e9, _TI64),
        poisson=Value(0.342, "Aerospace Specification Metals, Ti-6Al-4V annealed, MTP641 (MatWeb)"),
        yield_strength=Value(913e6, f"{_TI64}: mean of two"),
        hardness=Number("349 HV1", _TI64),
        resistivity=Value(
            1.78e-6, "ASM Aerospace Specification Metals, Ti-6Al-4V annealed bar, MTP644 (MatWeb)"
        ),
        conductivity=Value(6.7, "BTI Metals, Ti 6Al-4V ELI, product data: 100 to 300 °C"),
        exponent=Value(0.0804, _TABOR),
    ),
    Entry(
        "WC-6Co",
        ("WC-Co", "tungsten carbide", "cemented carbide", "hardmetal", "K20"),
        "sintered, 6 % cobalt",
        young=Value(630e9, _WC),
        poisson=Value(0.24, _WC),
        hardness=Number(
            "1660 HV", "Materials 15 (2022) 906, ball of WC with 6 % Co, doi:10.3390/ma15030906"
        ),
        note=_BRITTLE,
        conductivity=Value(85, f"{_WC}: binder not told"),
    ),
    Entry(
        "Al2O3",
        ("alumina", "aluminium oxide", "aluminum oxide", "alumina 99.5"),
        "sintered, at least 99.5 % pure and 98 % dense, grains of 5 µm",
        young=Value(416e9, _ALUMINA),
        poisson=Value(0.231, _ALUMINA),
        hardness=Number("1530 HV", f"{_ALUMINA}: 15 GPa"),
        note=_BRITTLE,
        conductivity=Value(35, f"{_LILY}: 99.5 % pure"),
    ),
    Entry(
        "Si3N4",
        ("silicon nitride", "ceramic ball"),
        "gas-pressure sintered, bearing grade",
        young=Value(307.5e9, f"{_LILY}: middle of 300 to 315 GPa"),
        poisson=Value(
            0.26, "ASTM F2094, Silicon nitride bearing balls: middle of 0.23 to 0.29, typical"
        ),
        hardness=Number("1500 HV", f"{_LILY}: middle of 1400 to 1600 HV"),
        note=_BRITTLE,
        conductivity=Value(29, f"{_LILY}: sintered under gas pressure"),
    ),
    Entry(
        "3Y-TZP",
        ("zirconia", "ZrO2", "Y-TZP", "zirconium oxide"),
        "sintered, yttria-stabilised",
        young=Value(200e9, _XYCERA),
        poisson=Value(0.30, _XYCERA),
        hardness=Number("1250 HV1", _XYCERA),
        note=_BRITTLE,
        conductivity=Value(2, f"{_LILY}: ZrO2-Y2O3"),
    ),
    Entry(
        "fused silica",
        ("silica glass", "fused quartz", "SiO2"),
        "glass",
        young=Value(73e9, _SILICA),
        poisson=Value(0.17, _SILICA),
        note="No Vickers hardness of named origin was found: give a ceiling.",
    ),
    Entry(
        "polysilicon",
        ("polycrystalline silicon",),
        "polycrystalline film; single crystals are anisotropic",
        young=Value(169e9, _POLYSILICON),
        poisson=Value(0.22, _POLYSILICON),
        note="No Vickers hardness of named origin was found: give a ceiling.",
    ),
    Entry(
        "PTFE",
        ("Teflon", "polytetrafluoroethylene"),
        "unfilled, 23 °C",
        young=Value(0.475e9, f"{_CALLISTER_E}: middle of 0.40 to 0.55 GPa"),
        poisson=Value(0.46, _CALLISTER_NU),
        yield_strength=Value(14.5e6, f"{_CALLISTER_YIELD}: middle of 13.8 to 15.2 MPa"),
        note=_VISCOELASTIC,
        caveat=_CREEPS,
        conductivity=Value(
            0.25,
            "Springer Handbook of Condensed Matter and Materials Data (2005), table 3.3-13: 0.23 "
            "to 0.26 over temperature",
        ),
    ),
    Entry(
        "PEEK",
        ("polyetheretherketone",),
        "unfilled, 23 °C",
        young=Value(4.0e9, "MakeItFrom.com, PEEK (compilation), unfilled"),
        poisson=Value(0.36, "Kurtz and Devine, Biomaterials 28 (2007) 4845, table of properties"),
        yield_strength=Value(98.3e6, "Polymers 16 (2024) 3007, doi:10.3390/polym16213007"),
        note=_VISCOELASTIC,
        caveat=_CREEPS,
    ),
)
