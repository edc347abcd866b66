"""Result of a contact problem, with its inputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._version import __version__
from roughcontact.cautions import Caution
from roughcontact.contact import spots, spots as area
from roughcontact.contact.load_case import GivenLoad
from roughcontact.contact.nominal_hertz import SmoothContact, solve_smooth
from roughcontact.contact.pair import Pair
from roughcontact.contact.spots import Spots, Totals
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material
from roughcontact.result import Result, presentation
from roughcontact.solvers.progress import Tell
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity

CALIBRATED = "calibrated"
"""Values of ``ceiling`` for which `roughcontact.solve` determines the ceiling."""

BRACKET, COATING, BASE = "bracket", "coating", "base"
"""Keywords of ceilings of a coated body: of both solves, of its coating, of its base."""

MIN_SHOWN_CHANGE = 0.02
"""Relative change of areas or gap from which results also show the calibrated ceiling."""


@dataclass(frozen=True)
class CalibratedCeiling:
    """Ceiling that gives the contact area of an elastoplastic body."""

    load_ratio: float
    slope: float  # Contact radius over radius of that sphere, a/R
    flow_stress: float  # Yield strength at the strain 0.15 a/R [Pa]
    first_yield: float  # Hertz peak pressure at first yield for this flow stress [Pa]
    ceiling: float  # Calibrated ceiling [Pa]
    factor: float  # Ceiling over the yield strength before any plastic strain


@dataclass(frozen=True)
class Calibrated:
    """The same contact under the calibrated ceiling, or the ceiling of a body's base."""

    ceiling: float  # Other ceiling [Pa]
    factor: float  # Factor of the `CalibratedCeiling`; NaN for a coated body
    load_ratio: float  # Load ratio of the `CalibratedCeiling`; NaN for a coated body
    load: float  # Load [N]
    approach: float  # Approach of the bodies [m]
    control: str  # Which of the two was given
    contact_area: float  # Contact area [m²]
    contact_fraction: float  # Contact area over the area of the map
    saturated_fraction: float  # Saturated area over the area of the map
    mean_gap: float  # Mean open gap [m]
    change: float  # Largest relative change of contact area, saturated area and mean gap
    certificate: float  # Certificate ε
    convolutions: int  # Number of convolutions
    max_indentation: float = math.nan  # Largest residual indentation [m]

    @property
    def is_of_base(self) -> bool:
        """Whether it is the ceiling of the base of a coated body."""
        return math.isnan(self.factor)

    @property
    def differs(self) -> bool:
        """Whether the change is large enough to be shown."""
        return self.change > MIN_SHOWN_CHANGE

    def summary(self) -> dict[str, Any]:
        """Return the record by name, in SI units, ready for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class CalibrationRecord:
    """Record of a calibrated ceiling, and the results with the default ceiling."""

    load: float  # Load at which the spots were evaluated [N]
    load_ratio: float  # Load ratio of the `CalibratedCeiling` used
    factor: float  # Factor of the `CalibratedCeiling` used
    mismatch: float  # Relative change of the ceiling by one more solve; NaN if not calibrated
    solves: int  # Number of solves, the first with three yield strengths
    usual_ceiling: float  # Three yield strengths [Pa]
    usual_contact_area: float  # Contact area with it [m²]
    usual_approach: float  # Approach with it [m]
    usual_indentation: float  # Largest residual indentation with it [m]

    def summary(self) -> dict[str, float]:
        """Return the record by name, in SI units, ready for JSON."""
        return asdict(self)


class Regime(StrEnum):
    """Regime between elastic and fully plastic."""

    BELOW_FIRST_YIELD = "below first yield"
    YIELDING_BELOW = "yielding below the surface"
    SATURATED = "saturated at the surface"
    BEYOND_CEILING = "elastic pressure beyond three yield strengths"
    BEYOND_HARDNESS = "elastic pressure beyond the hardness"
    UNKNOWN = "unknown (no yield strength given)"


def regime_of(pair: Pair, max_pressure: float, saturated: bool) -> Regime:
    """Return the regime of a contact; see `ContactResult.regime`."""
    if saturated:
        return Regime.SATURATED
    softer, first = pair.softer, pair.first_to_yield
    if softer is None or softer.ceiling is None:
        return Regime.UNKNOWN
    if max_pressure > softer.ceiling:
        return Regime.BEYOND_HARDNESS if softer.yield_strength is None else Regime.BEYOND_CEILING
    if first is not None and max_pressure >= (pair.yields_at(first) or 0):
        return Regime.YIELDING_BELOW
    return Regime.UNKNOWN if softer.yield_strength is None else Regime.BELOW_FIRST_YIELD


@dataclass(frozen=True, eq=False, repr=False)
class ContactResult(Result):
    """Pressure and gap of a solved contact, with all inputs.

    Maps are read-only, ``[y, x]``, in SI units; NaN marks missing points of the gap.

    Parameters
    ----------
    pair : Pair
        Bodies in contact.
    ceiling : float, ndarray of shape (ny, nx), or None
        Largest pressure allowed [Pa]; ``None`` for a purely elastic contact.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    tolerance : float
        Certificate limit.
    control : {"load", "approach"}
        Which of the two was given.
    load : float
        Normal load W [N]: given, or the integral of the pressure.
    approach : float
        Approach ω [m], from the first touch; the mean displacement of a periodic body is zero by
        definition, and if the map is periodic along one axis, a uniform line load along it causes
        no displacement at a distance of the longer side of the map. For bodies that tilt, the
        approach of the map center from first contact without tilt.
    pressure : ndarray, shape (ny, nx)
        Contact pressure [Pa].
    gap : ndarray, shape (ny, nx)
        Displacement plus initial gap plus tilt minus approach [m]. Negative where the pressure is
        at the ceiling: the overlap that flows plastically.
    certificate : float
        ε = ‖p - clip(p - g/K₀₀, 0, ceiling)‖₂ / ‖p‖₂ of this pressure and gap.
    load_error : float
        ``|ΔxΔy Σp - W| / W``; zero under approach control.
    status : str
        ``"converged"``, or why the solver stopped.
    iterations, convolutions : int
        Steps, and applications of the displacement operator, on the finest grid; without the
        smaller transforms of the preconditioner, with those on a part of the map.
    seconds : float
        Wall time of the solve.
    version : str
        Version of the program.
    tilt : (float, float)
        Slopes (y, x) that the tilt adds to the gap: the angles [rad] by which the counter-body is
        rotated away from the surface, so that a positive one opens the gap towards larger y or x.
        The rotation is about the map center, where ``approach`` is measured.
    moments : (float, float) or None
        Moments (W y, W x) of the load about the map center that were given [N·m]; ``None``
        where the bodies do not tilt.
    without_checksums : bool
        Whether it was read from a file without checksums, in which damage is not detected.
    calibration : CalibrationRecord or None
        Record of the calibration, for a calibrated ceiling.
    extra_cautions : tuple of Caution
        Cautions from the measurement of the maps or a study of the resolution; ``cautions`` adds
        those of the result.
    specified_load : GivenLoad or None
        Load in its given form, if that is not a force.
    calibrated : Calibrated or None
        The same contact under the calibrated ceiling, if computed.
    measurement : Uncertainty or None
        Intervals that include the instrument, if computed by `uncertainty`.
    fluid_load : float
        Load that the pressure of a fluid between the bodies carries, in addition to ``load`` [N].
    """

    pair: Pair
    ceiling: float | NDArray[np.float64] | None
    precision: str
    tolerance: float
    control: str
    load: float
    approach: float
    pressure: NDArray[np.float64]
    gap: NDArray[np.float64]
    certificate: float = 0.0
    load_error: float = 0.0
    status: str = "converged"
    iterations: int = 0
    convolutions: int = 0
    seconds: float = 0.0
    version: str = __version__
    tilt: tuple[float, float] = (0.0, 0.0)
    moments: tuple[float, float] | None = None
    without_checksums: bool = False
    calibration: CalibrationRecord | None = None
    extra_cautions: tuple[Caution, ...] = ()
    specified_load: GivenLoad | None = None
    calibrated: Calibrated | None = None
    measurement: Any = None
    fluid_load: float = 0.0

    def __post_init__(self) -> None:
        """Make the maps read-only."""
        self.pressure.flags.writeable = False
        self.gap.flags.writeable = False

    @cached_property
    def totals(self) -> Totals:
        """Numbers over all pixels of the map."""
        return area.count_totals(self.boundary, self.pressure, self.gap, self.ceiling)

    @property
    def total_load(self) -> float:
        """Load of the bodies [N]: of the contact pressure and of the fluid in the contact."""
        return self.load + self.fluid_load

    @property
    def converged(self) -> bool:
        """Whether certificate, load and moments are within their limits."""
        return self.status == "converged"

    @property
    def surface(self) -> Surface:
        """Map of the rough body."""
        return self.pair.surface

    @property
    def counter_surface(self) -> Surface | None:
        """Second measured or nominal body; ``None`` for a flat one."""
        return self.pair.counter_surface

    @property
    def material(self) -> Material:
        """Material of the rough body."""
        return self.pair.material

    @property
    def counter_material(self) -> Material:
        """Material of the counter-body."""
        return self.pair.counter_material

    @property
    def boundary(self) -> Boundary:
        """Boundary condition; it equals its name as text."""
        return self.pair.boundary

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.pair.contact_modulus

    @property
    def initial_gap(self) -> NDArray[np.float64]:
        """Gap at first touch [m], NaN where missing, shape (ny, nx)."""
        return self.pair.initial_gap

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Pixels with pressure, shape (ny, nx)."""
        return self.pressure > 0

    @property
    def saturated(self) -> NDArray[np.bool_]:
        """Pixels whose pressure is at the ceiling, shape (ny, nx)."""
        if self.ceiling is None:
            return np.zeros(self.pressure.shape, bool)
        return self.pressure >= self.ceiling

    @property
    def residual_indentation(self) -> NDArray[np.float64]:
        """Permanent indentation of saturated pixels in the ceiling model [m], shape (ny, nx)."""
        return np.where(self.saturated, np.maximum(-self.gap, 0), 0.0)

    @property
    def pixel_area(self) -> float:
        """Area of one pixel [m²]."""
        return self.pair.pixel_area

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²], missing points included."""
        return math.prod(self.pair.shape) * self.pixel_area

    @property
    def touchable_area(self) -> float:
        """Area of the valid pixels [m²], which can touch."""
        return self.totals.points * self.pixel_area

    @property
    def contact_area(self) -> float:
        """Real contact area [m²]: the pixels with pressure."""
        return self.totals.contact * self.pixel_area

    @property
    def perimeter_corrected_area(self) -> float:
        """Contact area corrected for the excess of pixels on its elastic rim [m²].

        A - (π - 1 + ln 2)/24 · S, S the length of the rim times the pixel: pixels that the rim
        crosses are too often in contact, as the whole load of a pixel acts at its center. The rim
        of saturated pixels, where pressure does not fall to zero, is not corrected.

        On Hertz contacts of 3, 8 and 20 pixels' radius, averaged over their position on the grid,
        the area of pixels with pressure is 8, 3 and 1 % too large, and this area 2.5, 0.9 and 0.5 %
        too small.

        References
        ----------
        Yastrebov, Anciaux and Molinari 2017, doi:10.1016/j.triboint.2017.04.023
        """
        return max(self.contact_area - area.RIM_EXCESS * self.totals.rims * self.pixel_area, 0.0)

    @property
    def contact_fraction(self) -> float:
        """Contact area over the area of the whole map."""
        return self.contact_area / self.nominal_area

    @property
    def saturated_fraction(self) -> float:
        """Saturated area over the area of the whole map."""
        return self.totals.saturated / math.prod(self.pair.shape)

    @property
    def max_pressure(self) -> float:
        """Largest pressure [Pa]."""
        return self.totals.max_pressure

    @property
    def mean_gap(self) -> float:
        """Mean open gap [m] over the valid points; indented pixels are treated as closed."""
        return self.totals.mean_gap

    @cached_property
    def hertz(self) -> SmoothContact | None:
        """Hertz's contact of the nominal bodies under this load; ``None`` without curvature.

        See `roughcontact.contact.nominal_hertz.solve_smooth`.
        """
        return solve_smooth(self.pair, self.load)

    @cached_property
    def estimate(self) -> Any:
        """Estimate by formulas of nominally flat contact; see `analyses.estimate.model`.

        None where the formulas do not apply, for example if the map is not periodic along both
        axes.
        """
        return presentation().estimate(self)

    @cached_property
    def center_of_pressure(self) -> tuple[float, float]:
        """Point of action of the load: (y, x) from the center of the map [m]; NaN without load."""
        return area.center_of_pressure(self.pressure, self.pair.pixel)

    @property
    def moment_error(self) -> float:
        """``|Σ p y ΔxΔy - W y|`` over load times longer side, the worse of y and x.

        Zero if the bodies do not tilt.
        """
        if self.moments is None:
            return 0.0
        size = max(self.surface.size)
        return max(
            abs(centre - moment / self.load) / size
            for centre, moment in zip(self.center_of_pressure, self.moments, strict=True)
        )

    @property
    def regime(self) -> Regime:
        """Regime of the contact, from elastic to fully plastic; a text.

        First yield is evaluated for each body with its ν and strength, by the peak pressure of a
        sphere, 1.295 exp(0.736 ν) σ_Y, for profiles of a cylinder; it occurs below the surface,
        long before a pixel reaches the ceiling. A body with only a hardness has no first yield; its
        pressure is compared with the hardness.
        """
        return regime_of(self.pair, self.max_pressure, self.saturated_fraction > 0)

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the result, the most severe first."""
        return presentation().contact_cautions(self)

    def spots(self) -> Spots:
        """Return the contact spots: edge-connected pixels with pressure, the largest first."""
        return self._spots

    @cached_property
    def _spots(self) -> Spots:
        return spots.find_spots(self.pressure, self.pair.pixel, self.boundary.periodic_axes)

    def elastic(self) -> ContactResult:
        """Return the solution of the same problem without a ceiling; ``self`` if it has none."""
        return presentation().elastic(self)

    def stiffness(self) -> float:
        """Return the contact stiffness dW/dω [N/m]; see `roughcontact.contact.stiffness`."""
        return presentation().stiffness(self)

    def uncertainty(
        self,
        instrument: Any = None,
        shortest_wave: Quantity | None = None,
        material: Mapping[str, float] | None = None,
        draws: int = 8,
        rng: int | np.random.Generator | None = 0,
        also: Sequence[Any] = (),
        of: str = "map",
        progress: Tell = None,
    ) -> Any:
        """Return the intervals of the quantities, corrected for the instrument of the map.

        Parameters
        ----------
        instrument : Instrument or str, optional
            Instrument that measured the map, or its name in the catalog; see
            `roughcontact.measure`. Without it the intervals include only the grid and the material.
        shortest_wave : float, str or quantity of pint, optional
            Shortest wave of the surface [m], as a finer measurement shows it. Without it, values
            from a quarter of the resolution to the resolution are equally likely on a logarithmic
            scale.
        material : dict, optional
            Relative standard uncertainties: ``"E"`` of the contact modulus, 0.03 by default, and
            ``"yield"`` of the ceiling, 0.05 by default.
        draws : int
            Number of draws of the surface, at least 4.
        rng : int, numpy.random.Generator or None
            Seed of the draws; a generator draws one. Equal seeds give equal intervals.
        also : sequence of Surface or of (Surface, Instrument or str)
            Finer maps of the same surface, in the same orientation, filled and leveled, each with
            its instrument; estimated from the map by default. Their spectra continue that of the
            map.
        of : {"map", "surface"}
            Whether the quantities are of the place of the map, or of a large surface under the same
            nominal pressure, of which the map is a sample; approach and largest pressure are of
            the map. A map without a roll-off is not a sample: a remark says so.
        progress : callable, optional
            Called with a `Progress` after every solve.

        Returns
        -------
        Uncertainty
            Intervals that contain the true value in 95 of 100 cases, and their budget; see
            `roughcontact.uncertainty.measurement`.

        Raises
        ------
        InputError
            If intervals are not available for the map or the contact.
        """
        return presentation().uncertainty(
            self, instrument, shortest_wave, material, draws, rng, also, of, progress
        )
