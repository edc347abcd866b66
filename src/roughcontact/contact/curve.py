"""Load curves: what a contact gives at one load after the other, and what simple laws say."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.loads import GivenLoad
from roughcontact.errors import InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material
from roughcontact.result import Result
from roughcontact.surface.provenance import Provenance
from roughcontact.theory import persson

Array = NDArray[np.float64]

LOW_LOAD = 0.05
"""Contact fraction up to which the area is taken as proportional to the load."""

LOW_SATURATION = 0.1
"""Saturated part of the contact area up to which it is taken for that of an elastic contact."""


@dataclass(frozen=True)
class LoadStep:
    """The scalars of one solved load.

    Parameters
    ----------
    load : float
        W [N].
    approach : float
        ω [m].
    contact_area : float
        Real contact area [m²]: the pixels with pressure.
    corrected_contact_area : float
        The same without the excess of its rim; see `ContactResult.corrected_contact_area` [m²].
    saturated_area : float
        Area at the ceiling [m²].
    max_pressure : float
        Largest pressure [Pa].
    mean_gap : float
        Mean open gap [m].
    stiffness : float
        dW/dω [N/m] as the load grows; see `contact.stiffness.stiffness`.
    unloading_stiffness : float
        The same as the load begins to fall [N/m]; see `contact.stiffness.unloading_stiffness`.
    spots : int
        Number of contact spots.
    mean_spot_area, largest_spot_area : float
        Of the contact spots [m²].
    certificate, load_error : float
        How exactly the step is solved.
    convolutions : int
        On the full grid.
    seconds : float
        Wall time of the solve.
    ceiling : float
        Largest pressure allowed [Pa]; NaN without one, or where it differs from pixel to pixel.
    """

    load: float
    approach: float
    contact_area: float
    corrected_contact_area: float
    saturated_area: float
    max_pressure: float
    mean_gap: float
    stiffness: float
    unloading_stiffness: float
    spots: int
    mean_spot_area: float
    largest_spot_area: float
    certificate: float
    load_error: float
    convolutions: int
    seconds: float
    ceiling: float = math.nan


_FIELDS = tuple(field.name for field in fields(LoadStep))


@dataclass(frozen=True, eq=False, repr=False)
class LoadCurve(Result):
    """Contact against load, and what the simple laws say about it.

    Parameters
    ----------
    steps : tuple of LoadStep
        The solved loads, ascending.
    control : {"load", "approach"}
        Which of the two was given.
    nominal_area : float
        Area of the whole map [m²].
    contact_modulus : float
        E* [Pa].
    rms_gradient : float
        h′ of the gap at first touch.
    ceiling : float, ndarray of shape (ny, nx), "recommended" or None
        Largest pressure allowed [Pa]; where each load has its own, the steps hold it.
    boundary : Boundary
        What lies beyond the edges of the map.
    origins : tuple of Provenance
        Where the maps came from and what was done to them, the counter-body's last.
    softer : Material or None
        The body with the smaller ceiling; None where no strength is known.
    found : tuple of Caution
        What the contacts under these loads give cause for.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    is_profile : bool
        Whether the bodies are profiles: loads are per length [N/m], areas lengths [m].
    given : tuple of GivenLoad
        The loads in the form in which they were given, those that were no forces.
    """

    steps: tuple[LoadStep, ...]
    control: str
    nominal_area: float
    contact_modulus: float
    rms_gradient: float
    ceiling: float | NDArray[np.float64] | str | None
    boundary: Boundary
    origins: tuple[Provenance, ...]
    softer: Material | None = None
    found: tuple[Caution, ...] = ()
    remarks: tuple[Caution, ...] = ()
    is_profile: bool = False
    given: tuple[GivenLoad, ...] = ()

    @property
    def source(self) -> str:
        """Where the map came from."""
        return self.origins[0].source

    @property
    def preparation(self) -> tuple[str, ...]:
        """What was done to it, one sentence each."""
        return self.origins[0].steps

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        return ordered([*self.found, *self.remarks])

    def column(self, name: str) -> Array:
        """Return one field of all steps, shape (n,); see `LoadStep` for names and units."""
        if name not in _FIELDS:
            raise InputError(
                f"must be one of {', '.join(_FIELDS)}, got {name!r}", argument="name", value=name
            )
        return np.array([getattr(step, name) for step in self.steps], dtype=float)

    @property
    def constriction_length(self) -> Array:
        """Length 2 (dW/dω)/E* of the whole contact, its saturated pixels included [m], shape (n,).

        Divided by the sum of the resistivities of the two bodies it is the electrical conductance
        of the contact, and likewise the thermal one (Barber 2003, doi:10.1098/rspa.2002.1038); a
        circle of radius a has 4 a, elastic or saturated: metal that has flowed conducts.
        """
        return 2 * self.column("unloading_stiffness") / self.contact_modulus

    @cached_property
    def low_loads(self) -> NDArray[np.bool_]:
        """Which loads touch no more than a twentieth of the map and hardly saturate, shape (n,)."""
        area, load = self.column("corrected_contact_area"), self.column("load")
        low: NDArray[np.bool_] = (
            (area <= LOW_LOAD * self.nominal_area)
            & (self.column("saturated_area") <= LOW_SATURATION * area)
            & (load > 0)
        )
        return low

    @cached_property
    def low_load_slope(self) -> float:
        """κ of A = κ W/(E* h′), where no more than a twentieth of the map touches.

        Least squares through the origin on the corrected contact area of the `low_loads`, at which
        no more than a tenth of it is saturated; without any, the secant from the origin to the
        smallest load, which is that of no theory. NaN without load. Theory: √(2π) = 2.5 (Bush,
        Gibson and Thomas 1975), √(8/π) = 1.6 (Persson 2001); boundary elements: 1.8 to 2.3 (Hyun
        et al. 2004). It means something where there are many spots.
        """
        area, load = self.column("corrected_contact_area"), self.column("load")
        taken = self.low_loads
        if not taken.any():
            if not (load > 0).any():
                return math.nan
            taken = load == load[load > 0].min()
        slope = float(area[taken] @ load[taken] / (load[taken] @ load[taken]))
        return slope * self.contact_modulus * self.rms_gradient

    @property
    def persson(self) -> tuple[Array, Array]:
        """Contact and saturated area by Persson's theory [m²], each of shape (n,).

        With a ceiling that differs from pixel to pixel its mean is taken. NaN where the mean
        pressure exceeds the ceiling.
        """
        ceiling = self.ceiling
        fixed = None if ceiling is None or isinstance(ceiling, str) else float(np.mean(ceiling))
        pairs = []
        for step in self.steps:
            mean = step.load / self.nominal_area
            limit = step.ceiling if isinstance(ceiling, str) else fixed
            if mean == 0 or (limit is not None and mean > limit):
                pairs.append((0.0, 0.0) if mean == 0 else (math.nan, math.nan))
            else:
                pairs.append(
                    persson.persson_fractions(mean, self.contact_modulus, self.rms_gradient, limit)
                )
        table = np.array(pairs).reshape(-1, 2) * self.nominal_area
        return table[:, 0], table[:, 1]
