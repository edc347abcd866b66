"""The literature behind the program: one table, and how its entries are written.

The entries were compared with public bibliographies, where some DOIs and pages could not be found,
and of Boucly 2007, Grigoriu 1984, Hyun 2004 and Nélias 2006 nothing; an entry without a DOI is not
known to have none.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roughcontact.files import require_suffix, write

_MOST_NAMES = 2  # before "et al."
_OTHERS = "others"  # as BibTeX has it


@dataclass(frozen=True)
class Reference:
    """A paper, book or standard.

    Parameters
    ----------
    key : str
        Of BibTeX: first family name and year, or the number of a standard.
    authors : tuple of str
        ``"Family, I. N."``; empty for a standard, or where they are not known.
    year : int or None
        Of publication.
    title : str
        Of the work, a standard's with its number before it.
    where : str
        Journal; of a book its publisher; empty for a standard.
    volume, pages : str
        In the journal; pages may be one number. Empty for books and standards.
    doi : str
        Without the address before it; empty where it is not confirmed.
    note : str
        What a reader has to know of the entry itself.
    """

    key: str
    authors: tuple[str, ...]
    year: int | None
    title: str
    where: str = ""
    volume: str = ""
    pages: str = ""
    doi: str = ""
    note: str = ""

    @property
    def short(self) -> str:
        """As a text cites it, such as ``"Polonsky and Keer 1999"``."""
        names = [author.partition(",")[0] for author in self.authors]
        if not names:
            return self.title.partition(",")[0]
        if len(names) > _MOST_NAMES or names[-1] == _OTHERS:
            return f"{names[0]} et al. {self.year}"
        return f"{' and '.join(names)} {self.year}"

    @property
    def text(self) -> str:
        """As a list of references holds it, in one line."""
        *most, last = self.authors or ("",)
        names = f"{', '.join(most)} and {last}" if most else last
        names = names.replace(f" and {_OTHERS}", " et al.")
        first = f"{names} ({self.year})" if names else ""
        place = " ".join(part for part in (self.where, self.volume) if part)
        where = ", ".join(part for part in (place, self.pages) if part)
        doi = f"doi:{self.doi}" if self.doi else ""
        parts = (first, self._dated_title, where, doi, self.note)
        return ". ".join(part.rstrip(".") for part in parts if part) + "."

    @property
    def _dated_title(self) -> str:
        """The title; with the year after its number where no author has it before him."""
        if self.authors or not self.year:
            return self.title
        number, comma, rest = self.title.partition(",")
        year = f":{self.year}" if number.startswith("ISO ") else f" ({self.year})"
        return f"{number}{year}{comma}{rest}"

    @property
    def _publisher(self) -> str:
        """Who stands for the authors of a standard: the first word of its title."""
        return "{" + self.title.split()[0] + "}" if self.year else ""

    @property
    def bibtex(self) -> str:
        """The entry of a BibTeX file."""
        kind = "article" if self.volume else "book" if self.where else "misc"
        fields = {
            "author": " and ".join(self.authors) or self._publisher,
            "title": "{" + self.title + "}",
            "journal" if kind == "article" else "publisher": self.where,
            "volume": self.volume,
            "pages": self.pages.replace("–", "--"),
            "year": str(self.year or ""),
            "doi": self.doi,
            "note": self.note,
        }
        told = [f"  {name} = {{{value}}}" for name, value in fields.items() if value]
        return f"@{kind}{{{self.key},\n" + ",\n".join(told) + "\n}"


@dataclass(frozen=True)
class References:
    """What is cited, and for what.

    Parameters
    ----------
    uses : tuple of (str, tuple of Reference)
        What they are cited for, such as ``"ceiling of the pressure"``, and the works.
    """

    uses: tuple[tuple[str, tuple[Reference, ...]], ...]

    def __iter__(self) -> Iterator[Reference]:
        """Give each work once, in the order of first use."""
        return iter(dict.fromkeys(work for _, works in self.uses for work in works))

    def __len__(self) -> int:
        """Return how many works there are."""
        return len(list(iter(self)))

    def __add__(self, other: References) -> References:
        """Return both; what they share keeps its first place."""
        uses = dict(self.uses)
        for purpose, works in other.uses:
            uses[purpose] = tuple(dict.fromkeys((*uses.get(purpose, ()), *works)))
        return References(tuple(uses.items()))

    def __repr__(self) -> str:
        """Return the text."""
        return self.text

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(self.text)

    @property
    def text(self) -> str:
        """A paragraph for each use, a line for each work."""
        return "\n\n".join(
            "\n".join((f"{purpose[:1].upper()}{purpose[1:]}", *(f"  {w.text}" for w in works)))
            for purpose, works in self.uses
        )

    @property
    def bibtex(self) -> str:
        """The text of a BibTeX file."""
        return "\n\n".join(work.bibtex for work in self) + "\n"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write them to a file.

        Parameters
        ----------
        path : str or path
            ``.bib`` for BibTeX, ``.txt`` for text; it appears only once it is complete.

        Raises
        ------
        InputError
            If the suffix is another one.
        OSError
            If the file cannot be written.
        """
        require_suffix(path, ".bib", ".txt")
        bib = Path(path).suffix.lower() == ".bib"
        write(path, self.bibtex if bib else self.text + "\n")


NO_REFERENCES = References(())
"""Nothing cited."""

_TRIBOLOGY = "Journal of Tribology"
_ROYAL = "Proceedings of the Royal Society of London A"
_SOLIDS = "Journal of the Mechanics and Physics of Solids"
_PHYS = "Journal of Physics: Condensed Matter"
_HEAT = "International Journal of Heat and Mass Transfer"
_GPS = "Geometrical product specifications (GPS)"
_SURFACE = f"{_GPS} – Surface texture"
_OPTIM = "SIAM Journal on Optimization"
_METRO = "Surface Topography: Metrology and Properties"
_LUBRICATION = "Journal of Lubrication Technology"

_TABLE: tuple[Reference, ...] = (
    Reference(
        "EngineeringModel", (), None,
        "An engineering model for pressure assessment in rough contacts",
        note="The paper whose contact model this program repeats; its authors, year and journal "
        "could not be confirmed",
    ),
    Reference(
        "Almqvist2007", ("Almqvist, A.", "Sahlin, F.", "Larsson, R.", "Glavatskih, S."), 2007,
        "On the dry elasto-plastic contact of nominally flat surfaces",
        "Tribology International", "40", "574–579", "10.1016/j.triboint.2005.11.008",
    ),
    Reference(
        "Almqvist2011", ("Almqvist, A.", "Campañá, C.", "Prodanov, N.", "Persson, B. N. J."), 2011,
        "Interfacial separation between elastic solids with randomly rough surfaces: comparison "
        "between theory and numerical techniques",
        _SOLIDS, "59", "2355–2369", "10.1016/j.jmps.2011.08.004",
    ),
    Reference(
        "Anderson1965", ("Anderson, D. G.",), 1965,
        "Iterative procedures for nonlinear integral equations",
        "Journal of the ACM", "12", "547–560", "10.1145/321296.321305",
    ),
    Reference(
        "Barber2003", ("Barber, J. R.",), 2003,
        "Bounds on the electrical resistance between contacting elastic rough bodies",
        _ROYAL, "459", "53–66", "10.1098/rspa.2002.1038",
    ),
    Reference(
        "Birgin2000", ("Birgin, E. G.", "Martínez, J. M.", "Raydan, M."), 2000,
        "Nonmonotone spectral projected gradient methods on convex sets",
        _OPTIM, "10", "1196–1211", "10.1137/S1052623497330963",
    ),
    Reference(
        "Boucly2007", ("Boucly, V.", "Nélias, D.", "Green, I."), 2007,
        "Modeling of the rolling and sliding contact between two asperities",
        _TRIBOLOGY, "129", "235–245",
    ),
    Reference(
        "Burgdorfer1959", ("Burgdorfer, A.",), 1959,
        "The influence of the molecular mean free path on the performance of hydrodynamic gas "
        "lubricated bearings",
        "Journal of Basic Engineering", "81", "94–98",
    ),
    Reference(
        "Bush1975", ("Bush, A. W.", "Gibson, R. D.", "Thomas, T. R."), 1975,
        "The elastic contact of a rough surface",
        "Wear", "35", "87–111", "10.1016/0043-1648(75)90145-3",
    ),
    Reference(
        "Carlson1995", ("Carlson, B. C.",), 1995,
        "Numerical computation of real or complex elliptic integrals",
        "Numerical Algorithms", "10", "13–26", "10.1007/BF02198293",
    ),
    Reference(
        "Cooper1969", ("Cooper, M. G.", "Mikic, B. B.", "Yovanovich, M. M."), 1969,
        "Thermal contact conductance", _HEAT, "12", "279–300", "10.1016/0017-9310(69)90011-8",
    ),
    Reference(
        "Dapp2012", ("Dapp, W. B.", "Lücke, A.", "Persson, B. N. J.", "Müser, M. H."), 2012,
        "Self-affine elastic contacts: percolation and leakage",
        "Physical Review Letters", "108", "244301", "10.1103/PhysRevLett.108.244301",
    ),
    Reference(
        "DLMF", (), 2010, "NIST Digital Library of Mathematical Functions, https://dlmf.nist.gov"
    ),
    Reference(
        "Frerot2019", ("Frérot, L.", "Bonnet, M.", "Molinari, J.-F.", "Anciaux, G."), 2019,
        "A Fourier-accelerated volume integral method for elastoplastic contact",
        "Computer Methods in Applied Mechanics and Engineering", "351", "951–976",
        "10.1016/j.cma.2019.04.006",
    ),
    Reference(
        "Games1976", ("Games, P. A.", "Howell, J. F."), 1976,
        "Pairwise multiple comparison procedures with unequal n's and/or variances: a Monte Carlo "
        "study",
        "Journal of Educational Statistics", "1", "113–125", "10.3102/10769986001002113",
    ),
    Reference(
        "Gilbert1988", ("Gilbert, E. G.", "Johnson, D. W.", "Keerthi, S. S."), 1988,
        "A fast procedure for computing the distance between complex objects in three-dimensional "
        "space",
        "IEEE Journal on Robotics and Automation", "4", "193–203", "10.1109/56.2083",
    ),
    Reference(
        "Golub1999", ("Golub, G. H.", "Ye, Q."), 1999,
        "Inexact preconditioned conjugate gradient method with inner-outer iteration",
        "SIAM Journal on Scientific Computing", "21", "1305–1320", "10.1137/S1064827597323415",
    ),
    Reference(
        "Green2005", ("Green, I.",), 2005,
        "Poisson ratio effects and critical values in spherical and cylindrical Hertzian contacts",
        "International Journal of Applied Mechanics and Engineering", "10", "451–462",
    ),
    Reference(
        "Greenwood1966", ("Greenwood, J. A.",), 1966,
        "Constriction resistance and the real area of contact",
        "British Journal of Applied Physics", "17", "1621–1632", "10.1088/0508-3443/17/12/310",
    ),
    Reference(
        "Greenwood1970", ("Greenwood, J. A.", "Tripp, J. H."), 1970,
        "The contact of two nominally flat rough surfaces",
        "Proceedings of the Institution of Mechanical Engineers", "185", "625–633",
        "10.1243/PIME_PROC_1970_185_069_02",
    ),
    Reference(
        "Grigoriu1984", ("Grigoriu, M.",), 1984,
        "Crossings of non-Gaussian translation processes",
        "Journal of Engineering Mechanics", "110", "610–620",
        "10.1061/(ASCE)0733-9399(1984)110:4(610)",
    ),
    Reference(
        "Hamilton1983", ("Hamilton, G. M.",), 1983,
        "Explicit equations for the stresses beneath a sliding spherical contact",
        "Proceedings of the Institution of Mechanical Engineers C", "197", "53–59",
        "10.1243/PIME_PROC_1983_197_076_02",
    ),
    Reference(
        "Harris2020", ("Harris, C. R.", _OTHERS), 2020, "Array programming with NumPy",
        "Nature", "585", "357–362", "10.1038/s41586-020-2649-2",
    ),
    Reference(
        "Hintermueller2002", ("Hintermüller, M.", "Ito, K.", "Kunisch, K."), 2002,
        "The primal-dual active set strategy as a semismooth Newton method",
        _OPTIM, "13", "865–888", "10.1137/S1052623401383558",
    ),
    Reference(
        "Holm1967", ("Holm, R.",), 1967, "Electric Contacts, 4th edition", "Springer",
        doi="10.1007/978-3-662-06688-1",
    ),
    Reference(
        "Hyun2004", ("Hyun, S.", "Pei, L.", "Molinari, J.-F.", "Robbins, M. O."), 2004,
        "Finite-element analysis of contact between elastic self-affine surfaces",
        "Physical Review E", "70", "026117", "10.1103/PhysRevE.70.026117",
    ),
    Reference(
        "ISO4287", (), 1997,
        f"ISO 4287, {_SURFACE}: Profile method – Terms, definitions and surface texture parameters",
    ),
    Reference(
        "ISO16610-61", (), 2015,
        f"ISO 16610-61, {_GPS} – Filtration – Part 61: Linear areal filters – Gaussian filters",
    ),
    Reference(
        "ISO18265", (), 2013, "ISO 18265, Metallic materials – Conversion of hardness values"
    ),
    Reference(
        "ISO21920-2", (), 2021,
        f"ISO 21920-2, {_SURFACE}: Profile – Part 2: Terms, definitions and surface texture "
        "parameters",
    ),
    Reference(
        "ISO25178-2", (), 2021,
        f"ISO 25178-2, {_SURFACE}: Areal – Part 2: Terms, definitions and surface texture "
        "parameters",
    ),
    Reference(
        "ISO25178-72", (), 2017,
        f"ISO 25178-72, {_SURFACE}: Areal – Part 72: XML file format x3p",
    ),
    Reference(
        "Jackson2005", ("Jackson, R. L.", "Green, I."), 2005,
        "A finite element study of elasto-plastic hemispherical contact against a rigid flat",
        _TRIBOLOGY, "127", "343–354", "10.1115/1.1866166",
    ),
    Reference(
        "Jacobs2017", ("Jacobs, T. D. B.", "Junge, T.", "Pastewka, L."), 2017,
        "Quantitative characterization of surface topography using spectral analysis",
        _METRO, "5", "013001", "10.1088/2051-672X/aa51f8",
    ),
    Reference(
        "Jacq2002", ("Jacq, C.", "Nélias, D.", "Lormand, G.", "Girodin, D."), 2002,
        "Development of a three-dimensional semi-analytical elastic-plastic contact code",
        _TRIBOLOGY, "124", "653–667", "10.1115/1.1467920",
    ),
    Reference(
        "Johnson1985", ("Johnson, K. L.",), 1985, "Contact Mechanics",
        "Cambridge University Press", doi="10.1017/CBO9781139171731",
    ),
    Reference(
        "JohnsonGreenwood1985", ("Johnson, K. L.", "Greenwood, J. A.", "Higginson, J. G."), 1985,
        "The contact of elastic regular wavy surfaces",
        "International Journal of Mechanical Sciences", "27", "383–396",
        "10.1016/0020-7403(85)90029-3",
    ),
    Reference(
        "JohnsonNL1949", ("Johnson, N. L.",), 1949,
        "Systems of frequency curves generated by methods of translation",
        "Biometrika", "36", "149–176", "10.1093/biomet/36.1-2.149",
    ),
    Reference(
        "Kalker1977", ("Kalker, J. J.",), 1977, "Variational principles of contact elastostatics",
        "Journal of the Institute of Mathematics and its Applications", "20", "199–219",
    ),
    Reference(
        "Liu2002", ("Liu, S.", "Wang, Q."), 2002,
        "Studying contact stress fields caused by surface tractions with a discrete convolution "
        "and fast Fourier transform algorithm",
        _TRIBOLOGY, "124", "36–45", "10.1115/1.1401017",
    ),
    Reference(
        "Love1929", ("Love, A. E. H.",), 1929,
        "The stress produced in a semi-infinite solid by pressure on part of the boundary",
        "Philosophical Transactions of the Royal Society of London A", "228", "377–420",
        "10.1098/rsta.1929.0009",
    ),
    Reference(
        "Love1939", ("Love, A. E. H.",), 1939, "Boussinesq's problem for a rigid cone",
        "Quarterly Journal of Mathematics", "10", "161–175", "10.1093/qmath/os-10.1.161",
    ),
    Reference(
        "Mikic1974", ("Mikic, B. B.",), 1974,
        "Thermal contact conductance; theoretical considerations",
        _HEAT, "17", "205–214", "10.1016/0017-9310(74)90082-9",
    ),
    Reference(
        "More1991", ("Moré, J. J.", "Toraldo, G."), 1991,
        "On the solution of large quadratic programming problems with bound constraints",
        _OPTIM, "1", "93–113", "10.1137/0801008",
    ),
    Reference(
        "Nayak1971", ("Nayak, P. R.",), 1971, "Random process model of rough surfaces",
        _LUBRICATION, "93", "398–407", "10.1115/1.3451608",
    ),
    Reference(
        "Nelias2006", ("Nélias, D.", "Boucly, V.", "Brunet, M."), 2006,
        "Elastic-plastic contact between rough surfaces: proposal for a wear or running-in model",
        _TRIBOLOGY, "128", "236–244", "10.1115/1.2163360",
    ),
    Reference(
        "Nocedal2006", ("Nocedal, J.", "Wright, S. J."), 2006,
        "Numerical Optimization, 2nd edition", "Springer", doi="10.1007/978-0-387-40065-5",
    ),
    Reference(
        "Notay2010", ("Notay, Y.",), 2010, "An aggregation-based algebraic multigrid method",
        "Electronic Transactions on Numerical Analysis", "37", "123–146",
    ),
    Reference(
        "Pardalos1990", ("Pardalos, P. M.", "Kovoor, N."), 1990,
        "An algorithm for a singly constrained class of quadratic programs subject to upper and "
        "lower bounds",
        "Mathematical Programming", "46", "321–328", "10.1007/BF01585748",
    ),
    Reference(
        "Patir1978", ("Patir, N.", "Cheng, H. S."), 1978,
        "An average flow model for determining effects of three-dimensional roughness on partial "
        "hydrodynamic lubrication",
        _LUBRICATION, "100", "12–17", "10.1115/1.3453103",
    ),
    Reference(
        "Persson2001", ("Persson, B. N. J.",), 2001,
        "Theory of rubber friction and contact mechanics",
        "Journal of Chemical Physics", "115", "3840–3861", "10.1063/1.1388626",
    ),
    Reference(
        "Persson2005",
        ("Persson, B. N. J.", "Albohr, O.", "Tartaglino, U.", "Volokitin, A. I.", "Tosatti, E."),
        2005,
        "On the nature of surface roughness with application to contact mechanics, sealing, rubber "
        "friction and adhesion",
        _PHYS, "17", "R1–R62", "10.1088/0953-8984/17/1/R01",
    ),
    Reference(
        "Persson2007", ("Persson, B. N. J.",), 2007,
        "Relation between interfacial separation and load: a general theory of contact mechanics",
        "Physical Review Letters", "99", "125502", "10.1103/PhysRevLett.99.125502",
    ),
    Reference(
        "Persson2008", ("Persson, B. N. J.", "Yang, C."), 2008, "Theory of the leak-rate of seals",
        _PHYS, "20", "315011", "10.1088/0953-8984/20/31/315011",
    ),
    Reference(
        "Polonsky1999", ("Polonsky, I. A.", "Keer, L. M."), 1999,
        "A numerical method for solving rough contact problems based on the multi-level "
        "multi-summation and conjugate gradient techniques",
        "Wear", "231", "206–219", "10.1016/S0043-1648(99)00113-1",
    ),
    Reference(
        "Prager1955", ("Prager, W.",), 1955,
        "The theory of plasticity: a survey of recent achievements",
        "Proceedings of the Institution of Mechanical Engineers", "169", "41–57",
        "10.1243/PIME_PROC_1955_169_015_02",
    ),
    Reference(
        "Rottger2022", ("Röttger, M. C.", _OTHERS), 2022,
        "Contact.engineering – Create, analyze and publish digital surface twins from topography "
        "measurements across many scales",
        _METRO, "10", "035032", "10.1088/2051-672X/ac860a",
    ),
    Reference(
        "Schreiber1996", ("Schreiber, T.", "Schmitz, A."), 1996,
        "Improved surrogate data for nonlinearity tests",
        "Physical Review Letters", "77", "635–638", "10.1103/PhysRevLett.77.635",
    ),
    Reference(
        "Searle1992", ("Searle, S. R.", "Casella, G.", "McCulloch, C. E."), 1992,
        "Variance Components", "Wiley", doi="10.1002/9780470316856",
    ),
    Reference(
        "Simo1998", ("Simo, J. C.", "Hughes, T. J. R."), 1998, "Computational Inelasticity",
        "Springer", doi="10.1007/b98904",
    ),
    Reference(
        "Sneddon1965", ("Sneddon, I. N.",), 1965,
        "The relation between load and penetration in the axisymmetric Boussinesq problem for a "
        "punch of arbitrary profile",
        "International Journal of Engineering Science", "3", "47–57",
        "10.1016/0020-7225(65)90019-4",
    ),
    Reference(
        "Song1993", ("Song, S.", "Yovanovich, M. M.", "Goodman, F. O."), 1993,
        "Thermal gap conductance of conforming surfaces in contact",
        "Journal of Heat Transfer", "115", "533–540", "10.1115/1.2910719",
    ),
    Reference(
        "Stanley1997", ("Stanley, H. M.", "Kato, T."), 1997,
        "An FFT-based method for rough surface contact",
        _TRIBOLOGY, "119", "481–485", "10.1115/1.2833523",
    ),
    Reference(
        "Student1908", ("Student",), 1908, "The probable error of a mean",
        "Biometrika", "6", "1–25", "10.1093/biomet/6.1.1",
    ),
    Reference(
        "Swift1952", ("Swift, H. W.",), 1952, "Plastic instability under plane stress",
        _SOLIDS, "1", "1–18", "10.1016/0022-5096(52)90002-1",
    ),
    Reference("Tabor1951", ("Tabor, D.",), 1951, "The Hardness of Metals", "Clarendon Press"),
    Reference(
        "Vanek1996", ("Vaněk, P.", "Mandel, J.", "Brezina, M."), 1996,
        "Algebraic multigrid by smoothed aggregation for second and fourth order elliptic problems",
        "Computing", "56", "179–196", "10.1007/BF02238511",
    ),
    Reference(
        "Virtanen2020", ("Virtanen, P.", _OTHERS), 2020,
        "SciPy 1.0: fundamental algorithms for scientific computing in Python",
        "Nature Methods", "17", "261–272", "10.1038/s41592-019-0686-2",
    ),
    Reference(
        "Welch1947", ("Welch, B. L.",), 1947,
        "The generalization of ‘Student’s’ problem when several different population variances are "
        "involved",
        "Biometrika", "34", "28–35", "10.1093/biomet/34.1-2.28",
    ),
    Reference(
        "Westergaard1939", ("Westergaard, H. M.",), 1939, "Bearing pressures and cracks",
        "Journal of Applied Mechanics", "6", "A49–A53", "10.1115/1.4008919",
    ),
    Reference(
        "Yang2008", ("Yang, C.", "Persson, B. N. J."), 2008,
        "Contact mechanics: contact area and interfacial separation from small contact to full "
        "contact",
        _PHYS, "20", "215214", "10.1088/0953-8984/20/21/215214",
    ),
    Reference(
        "Yastrebov2017", ("Yastrebov, V. A.", "Anciaux, G.", "Molinari, J.-F."), 2017,
        "On the accurate computation of the true contact-area in mechanical contact of random "
        "rough surfaces",
        "Tribology International", "114", "161–171", "10.1016/j.triboint.2017.04.023",
    ),
)  # fmt: skip

REFERENCES: dict[str, Reference] = {work.key: work for work in _TABLE}
"""Every work that the program or its theory page cites, by its key."""


def cited(purpose: str, *keys: str) -> tuple[str, tuple[Reference, ...]]:
    """Return one entry of ``References.uses``.

    Parameters
    ----------
    purpose : str
        What the works are cited for.
    *keys : str
        Keys of `REFERENCES`.

    Returns
    -------
    (str, tuple of Reference)
        The purpose and the works.
    """
    return purpose, tuple(REFERENCES[key] for key in keys)
