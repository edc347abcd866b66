"""Results that are computed again from what they hold: the load and the certificate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.memory import Room
from roughcontact.contact.result import ContactResult
from roughcontact.errors import FormatError
from roughcontact.halfspace.fft import Workspace

Array = NDArray[np.float64]

# How far what is computed again may lie from what is stated. On the same machine it has the same
# bits; other libraries and numbers of threads round in another way.
_PART, _LEAST, _DIGITS = 1e-3, 1e-12, 4.0
_GAP = {"double": 1e-12, "single": 1e-5}
_LOAD = 1e-12
# Maps that the comparison takes more than a solve has.
_MAPS = 8


@dataclass(frozen=True)
class Verification:
    """What a result states, and what its pressures and heights say.

    Parameters
    ----------
    load, certificate : float
        As the result states them: load [N], and ε.
    found_load, found_certificate : float
        Of its pressures, on its heights: the load is their sum times the area of a pixel, the
        certificate that of the gap they open with the approach that is stated.
    doubt : float
        What the last digit of displacement and initial gap may change in a certificate.
    gap_error : float
        Largest difference between that gap and the one in the result, over the largest of
        displacement and initial gap.
    load_error : float
        As the result states it, under a given load; else zero.
    precision : str
        Arithmetic of the transforms.
    load_unit : str
        Of the loads; ``"N/m"`` of profiles.
    """

    load: float
    certificate: float
    found_load: float
    found_certificate: float
    doubt: float
    gap_error: float
    load_error: float
    precision: str
    load_unit: str = "N"

    @property
    def differences(self) -> tuple[str, ...]:
        """Which of load, certificate and gap are not what the result states; none of a sound one.

        They are the same to rounding: a certificate within a thousandth, 1e-12 and four times its
        doubt; the gap within 1e-12 of its size, in single precision 1e-5; the load within 1e-12.
        """
        off = abs(self.found_certificate - self.certificate)
        missed = abs(self.found_load - self.load)
        same = {
            "load": missed <= (self.load_error + _LOAD) * self.load,
            "certificate": off <= _PART * self.certificate + _LEAST + _DIGITS * self.doubt,
            "gap": self.gap_error <= _GAP[self.precision],
        }
        return tuple(name for name, agrees in same.items() if not agrees)

    def require(self, name: str) -> None:
        """Raise `FormatError` about a file of some name unless all is as it states."""
        words = {
            "load": f"the load is {self.found_load:.6g} {self.load_unit} instead of "
            f"{self.load:.6g} {self.load_unit}",
            "certificate": f"the certificate is {self.found_certificate:.2g} instead of "
            f"{self.certificate:.2g}",
            "gap": f"the gap differs by {self.gap_error:.1g} of its size",
        }
        if self.differences:
            told = ", ".join(words[what] for what in self.differences)
            raise FormatError(
                f"{name} is not the solution that it claims to be: computed again from its "
                f"pressures and heights, {told}; take a copy of the file, or solve again"
            )


def verify(result: ContactResult, displaced: Array | None = None) -> Verification:
    """Compute load and certificate of a result again, with one application of the operator.

    Parameters
    ----------
    result : ContactResult
        What is to be verified.
    displaced : ndarray, shape (ny, nx), optional
        What plastic strain adds to the gap [m].

    Returns
    -------
    Verification
        What was found beside what is stated.

    Raises
    ------
    InsufficientMemoryError
        If the operator does not fit into the memory that is free.

    Examples
    --------
    >>> import roughcontact as rc
    >>> heights, pixel = rc.reference_map(32)
    >>> result = rc.solve(rc.Surface(heights, pixel), material=rc.Material(210e9, 0.3), load=1.0)
    >>> verify(result).differences
    ()
    """
    initial = _initial_gap(result, displaced)
    opened, unit = _opened(result, initial)
    there = np.isfinite(initial)
    opened, initial, pressure = opened[there], initial[there], result.pressure[there]
    gap = opened - result.approach
    bound: Any = math.inf if result.ceiling is None else result.ceiling
    if isinstance(bound, np.ndarray):
        bound = bound[there]
    reach = pressure - gap / unit
    eps = float(np.finfo(np.float64 if result.precision == "double" else np.float32).eps)
    digit = 0.5 * eps * (np.abs(opened) + np.abs(initial)) / unit
    doubt = np.clip(reach + digit, 0, bound) - np.clip(reach - digit, 0, bound)
    # Bodies apart have nothing to certify.
    size = float(np.linalg.norm(pressure)) or math.inf
    largest = max(float(np.abs(opened - initial).max()), float(np.abs(initial).max()))
    return Verification(
        load=result.load,
        certificate=result.certificate,
        found_load=float(result.pressure.sum()) * result.pixel_area,
        found_certificate=float(np.linalg.norm(pressure - np.clip(reach, 0, bound))) / size,
        doubt=0.5 * float(np.linalg.norm(doubt)) / size,
        gap_error=float(np.abs(gap - result.gap[there]).max()) / (largest or math.inf),
        load_error=result.load_error if result.control == "load" else 0.0,
        precision=result.precision,
        load_unit=result.pair.load_unit,
    )


def _initial_gap(result: ContactResult, displaced: Array | None) -> Array:
    """Return the gap without pressure or approach [m], not finite where nothing ever touches."""
    gap = result.initial_gap
    if displaced is not None:
        gap += displaced
    for axis, slope in enumerate(result.tilt):
        points, edge = gap.shape[axis], result.surface.pixel[axis]
        lever = slope * edge * (np.arange(points) - (points - 1) / 2)
        gap += lever[:, None] if axis == 0 else lever
    return gap


def _opened(result: ContactResult, initial: Array) -> tuple[Array, float]:
    """Return displacement plus initial gap [m], and the displacement of a pixel by itself."""
    pair = result.pair
    Room(pair.shape, pair.boundary, result.precision, _MAPS).require()
    operator = pair.operators(result.precision, Workspace())(pair.shape, (1, 1))
    opened = initial.copy()

    def add(number: int, rows: slice, displacement: NDArray[Any]) -> None:
        opened[rows] += displacement

    index = np.flatnonzero(result.pressure)
    if index.size:
        operator.spread(operator.support(index), result.pressure.ravel()[index], add)
    return opened, operator.self_displacement
