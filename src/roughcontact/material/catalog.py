"""Catalog of engineering materials with the sources of values, from ``catalog.toml``.

The values are typical of the named condition and not guaranteed: heat treatment, size and supplier
change a yield strength by a tenth and more.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from roughcontact.errors import ArgumentRef, InputError, input_error
from roughcontact.material import hardness
from roughcontact.material.hardening import Swift
from roughcontact.material.material import Conductor, Layer, Material

STORED = Path(__file__).with_name("catalog.toml")

# Plastic strain of a proof stress, in millionths.
_PROOF = 2000.0
# Materials in the message on an unknown one.
_COMMON = ("100Cr6", "42CrMo4", "C45", "X5CrNi18-10", "EN-GJL-250", "7075-T6", "Ti-6Al-4V", "PEEK")


class Value(NamedTuple):
    """Value in SI units and its source."""

    value: float
    source: str


class Number(NamedTuple):
    """Hardness as text for `hardness.parse`, and its source."""

    text: str
    source: str


@dataclass(frozen=True)
class Entry:
    """Material of the catalog."""

    key: str  # Name in reports: the European designation if there is one
    names: tuple[str, ...]  # Other names
    condition: str  # Heat treatment or form of the material
    young: Value  # Young's modulus E [Pa]
    poisson: Value  # Poisson's ratio ν
    yield_strength: Value | None = None  # [Pa]
    hardness: Number | None = None  # Hardness with its scale
    note: str = ""  # Remark for the user
    resistivity: Value | None = None  # Electrical resistivity at room temperature [Ω m]
    conductivity: Value | None = None  # Thermal conductivity at room temperature [W/(m K)]
    softening_voltage: Value | None = None  # Contact voltage at which spots soften [V]
    melting_voltage: Value | None = None  # Contact voltage at which spots melt [V]
    exponent: Value | None = None
    caveat: str = ""  # Property of the material that no contact includes, for `Material`

    @property
    def material(self) -> Material:
        """Constants for a calculation, without sources."""
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

    def layer(self, thickness: float) -> Layer:
        """Return a layer of the material."""
        bulk = self.material
        return Layer(
            bulk.young,
            bulk.poisson,
            thickness,
            yield_strength=bulk.yield_strength,
            hardness=bulk.hardness,
            name=bulk.name,
        )

    @property
    def hardening(self) -> Swift | None:
        """Hardening law, if yield strength and exponent are known."""
        if self.yield_strength is None or self.exponent is None:
            return None
        strength, exponent = self.yield_strength.value, self.exponent.value
        return Swift(strength / _PROOF**exponent, _PROOF, exponent)

    @property
    def hardening_exponent(self) -> Value | None:
        """Exponent n of σ_Y (1 + e/0.002)ⁿ: ``exponent``, or that of `Material.law`."""
        law = self.material.law if self.yield_strength is not None else None
        if self.exponent is not None or not isinstance(law, Swift):
            return self.exponent
        source = "derived from the hardness: three flow stresses at a strain of 8 % (Tabor 1951)"
        return Value(law.exponent, source)

    @property
    def conductor(self) -> Conductor:
        """Electrical and thermal constants, as far as known."""
        names = ("resistivity", "conductivity", "softening_voltage", "melting_voltage")
        known = {name: value for name in names if (value := getattr(self, name)) is not None}
        return Conductor(name=self.key, **{name: value.value for name, value in known.items()})


@dataclass(frozen=True)
class Film:
    """Coating of the catalog."""

    key: str  # Name in reports
    names: tuple[str, ...]  # Other names
    young: Value  # Young's modulus E [Pa]
    poisson: Value  # Poisson's ratio ν
    hardness: Value | None = None  # [Pa]
    note: str = ""  # Scatter of the values

    def layer(self, thickness: float) -> Layer:
        """Return a layer of the coating."""
        hard = None if self.hardness is None else self.hardness.value
        return Layer(self.young.value, self.poisson.value, thickness, hardness=hard, name=self.key)


@cache
def films() -> tuple[Film, ...]:
    """Return all coatings of the catalog."""
    return read_rows(STORED, "film", Film)


def conductor_of(name: str) -> Conductor:
    """Return the conductivities of a material by its key; none of an unknown one."""
    return next((row.conductor for row in entries() if row.key == name), Conductor())


def layer(name: str, thickness: float) -> Layer:
    """Return a layer of a coating or a material of the catalog."""
    rows: tuple[Film | Entry, ...] = (*films(), *entries())
    # Exact names first: TiN (titanium nitride) is not tin.
    same = [row for row in rows if name in (row.key, *row.names)] or [
        row for row in rows if _plain(name) in map(_plain, (row.key, *row.names))
    ]
    if len(same) != 1:
        known = ", ".join(row.key for row in same or films())
        raise InputError(
            f"{name!r} is ambiguous: {known}; give one of these"
            if same
            else f"{name!r} is not in the catalog of coatings: {known}; give its values, as "
            "'E=350 GPa, nu=0.22, 2 um'"
        )
    return same[0].layer(thickness)


@cache
def entries() -> tuple[Entry, ...]:
    """Return all materials of the catalog."""
    return read_rows(STORED, "material", Entry)


def read_rows(path: Path, table: str, kind: type[Any]) -> tuple[Any, ...]:
    """Return the rows of a table of a catalog."""
    stored = tomllib.loads(path.read_text(encoding="utf-8"))

    def field(name: str, specified: Any) -> Any:
        if isinstance(specified, str):
            return specified.format_map(stored["texts"])
        if name == "names":
            return tuple(specified)
        number, source = specified
        read = Number if isinstance(number, str) else Value
        return read(number, source.format_map(stored["texts"]))

    rows = stored[table]
    return tuple(kind(**{name: field(name, row[name]) for name in row}) for row in rows)


def entry(name: str) -> Entry:
    """Return a material with the sources of its values."""
    if not isinstance(name, str):
        raise input_error("material", name, "must be a name")
    if name in [film.key for film in films()]:
        # TiN (titanium nitride) is not tin.
        raise InputError(
            f"{name!r} is a coating; give it as ",
            ArgumentRef("coating", f"{name} 2 um"),
            argument="material",
            value=name,
        )
    result = {_plain(name): item for item in entries() for name in (item.key, *item.names)}
    plain = _plain(name)
    if plain in result:
        return result[plain]
    close = _similar_names(plain, result)
    keys = dict.fromkeys(result[match].key for match in close) or _COMMON
    text = name if len(name) <= 60 else name[:59] + "…"
    known = ", ".join(keys)
    raise InputError(
        f"{text!r} is not in the catalog; did you mean {known}?"
        if close
        else f"{text!r} is not in the catalog of {len(entries())} materials, such as {known}; give "
        "Young's modulus, Poisson's ratio and yield strength of others",
        argument="material",
        value=name,
    )


def material(name: str) -> Material:
    """Return the constants of a material by its name."""
    return entry(name).material


def _similar_names(plain: str, known: Iterable[str]) -> list[str]:
    """Return up to three similar names of the same kind of material."""
    from difflib import SequenceMatcher, get_close_matches

    # Names of a kind differ in digits: C60 is similar to C45, not to CuSn6. Numbers without
    # letters are classes by their first digits, such as 1.4 of stainless steel.
    def shape(name: str) -> str:
        return "".join("0" if letter.isdigit() else letter for letter in name)

    wanted, head = shape(plain), plain[: len(plain) // 2] if plain.isdigit() else ""
    same_kind = [name for name in known if shape(name) == wanted and name.startswith(head)]
    if not same_kind and not head:
        same_kind = [
            name for name in known if SequenceMatcher(None, shape(name), wanted).ratio() >= 0.75
        ]
    return get_close_matches(plain, same_kind, n=3, cutoff=0.2)


def _plain(name: str) -> str:
    return "".join(letter for letter in name.casefold() if letter.isalnum())
