"""All names of 0.2 that work until 0.4, with their replacements."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import TYPE_CHECKING, Any

Warn = Callable[[str], object]

NAMES = {
    "catalogue": "catalog",
    "Comparison": "results.Comparison",
    "Conductance": "results.Conductance",
    "Estimate": "results.Estimate",
    "FoundLoad": "analyses.find.model.LoadAnswer",
    "FoundLoads": "results.LoadSearch",
    "InterfaceLaw": "results.InterfaceLaw",
    "Kinematic": "hardening.Kinematic",
    "Leakage": "results.Leakage",
    "Linear": "hardening.Linear",
    "load_curve": "sweep",
    "load_elastoplastic": "read_result",
    "load_history": "history",
    "load_result": "read_result",
    "load_rolling": "read_result",
    "LoadCurve": "results.LoadCurve",
    "LoadHistory": "results.LoadHistory",
    "LoadSearch": "results.LoadSearch",
    "ModelComparison": "results.ModelComparison",
    "Perfect": "hardening.Perfect",
    "ResolutionStudy": "results.ResolutionStudy",
    "Rolling": "results.RollingResult",
    "RollingResult": "results.RollingResult",
    "sampling_error": "sampling_study",
    "SamplingStudy": "results.SamplingStudy",
    "save_result": "contact.archive.save_result",
    "StressResult": "results.StressResult",
    "Swift": "hardening.Swift",
    "Tabulated": "hardening.Tabulated",
    "yield_onset": "first_yield_load",
}
"""Names of the package: old name to new name or module."""

ARGUMENTS = {
    "compare": {"first_pressure": "preload_pressure"},
    "conductance": {
        "body": "conductor",
        "counter_body": "counter_conductor",
        "film": "electrical_film",
    },
    "contact_modulus": {"first": "material", "second": "counter_material"},
    "generate": {"seed": "rng"},
    "find_load": {"contact": "contact_fraction", "saturated": "saturated_fraction"},
    "interface_law": {"body": "conductor", "counter_body": "counter_conductor"},
    "first_yield_load": {"start": "initial_load"},
    "leakage": {"direction": "flow_axis"},
    "reference_map": {"rng_seed": "rng"},
    "roll": {
        "way": "travel",
        "to_and_fro": "reciprocating",
        "each": "on_step",
        "centered": "start_at_center",
    },
    "shakedown_load": {"within": "rel_tol"},
    "solve": {"start": "initial_guess"},
    "solve_elastoplastic": {"each": "on_step"},
    "subsurface_stress": {"body": "in_body"},
}
"""Arguments of a function: old name to new name."""

ATTRIBUTES = {
    "above": "bracket_high",
    "answer": "outcome_text",
    "at_odds": "tabor_ratio",
    "below": "bracket_low",
    "beside": "with_coarser_grid",
    "centre_of_pressure": "center_of_pressure",
    "corrected_contact_area": "perimeter_corrected_area",
    "film_ratio": "gap_ratio",
    "first_pressure": "preload_pressure",
    "flow": "strain_added",
    "flowed": "yielded",
    "found": "messages",
    "gain": "strain_net",
    "given": "specified_load",
    "least_strain": "strain_threshold",
    "place": "max_von_mises_at",
    "pull": "traction",
    "recommended": "calibration",
    "remarks": "extra_cautions",
    "shaken_down": "is_elastic_now",
    "smooth": "hertz",
    "to_and_fro": "reciprocating",
    "travelled": "has_moved",
    "unsealed": "without_checksums",
}
"""Attributes of results, materials and path points: old name to new name."""


class RenamedAttributes:
    """Base class of classes with renamed attributes."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return the attribute that replaced an old one, with a warning."""
            new = ATTRIBUTES.get(name)
            if new is None or not (hasattr(type(self), new) or new in vars(self)):
                # Raises the error of a property, or `AttributeError`.
                return object.__getattribute__(self, name)
            _warn_renamed(f"{type(self).__name__}.{name} is {new} now")
            return getattr(self, new)


OPTIONS = {
    "compare": {"first-load": "preload"},
    "conductance": {"film": "electrical-film"},
    "find": {"contact": "contact-fraction", "saturated": "saturated-fraction"},
    "history": {"residual": "indented-surface"},
    "leak": {"direction": "flow-axis"},
    "roll": {"way": "travel", "to-and-fro": "reciprocating"},
    "stress": {"onset": "first-yield", "which": "in-body"},
    "": {"holes": "missing"},
}
"""Options of a command, or of all commands, and of project files: old to new name."""

VALUES = {"ceiling": {"recommended": "calibrated"}, "model": {"volume": "elastoplastic"}}
"""Values of an argument or option: old value to new value."""


def current_argument(function: str, name: str) -> str:
    """Return the present name of an argument."""
    new = ARGUMENTS.get(function, {}).get(name, name)
    if new != name:
        _warn_renamed(f"{function}({name}=) is {function}({new}=) now")
    return new


def current_option(command: str, name: str, warn: Warn | None = None) -> str:
    """Return the present name of an option or of a key of a project file."""
    new = (OPTIONS[""] | OPTIONS.get(command, {})).get(name, name)
    if new != name:
        (warn or _warn_renamed)(f"'{name}' is '{new}' now")
    return new


def current_value(name: str, value: Any, warn: Warn | None = None) -> Any:
    """Return the present value of an argument or option."""
    new = VALUES.get(name, {}).get(value) if isinstance(value, str) else None
    if new is not None:
        (warn or _warn_renamed)(f"'{name} {value}' is '{name} {new}' now")
    return value if new is None else new


def current_command_line(arguments: Iterable[str], warn: Warn) -> list[str]:
    """Return the arguments of a command line under their new names."""
    command, option, result = "", "", []
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if name.startswith("--"):
            option = current_option(command, name[2:], warn)
            result.append(f"--{option}{equals}{current_value(option, value, warn)}")
            continue
        command = command or argument
        result.append(current_value(option, argument, warn))
        option = ""
    return result


def _warn_renamed(text: str) -> None:
    """Warn of an old name, at the line outside of the package that uses it."""
    frame, level = sys._getframe(), 1
    # The number of frames of the package differs between versions of Python.
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "roughcontact":
        frame, level = frame.f_back, level + 1
    warnings.warn(f"{text}; the old name works until 0.4", DeprecationWarning, stacklevel=level)


def resolve_renamed(name: str) -> Any:
    """Return the object of an old name, or raise `AttributeError` for an unknown name."""
    if name not in NAMES:
        raise AttributeError(f"module 'roughcontact' has no attribute {name!r}")
    new = NAMES[name]
    _warn_renamed(f"roughcontact.{name} is roughcontact.{new} now")
    package = import_module("roughcontact")
    first, _, rest = new.partition(".")
    if not rest or first in package.__dir__():
        value: Any = package
        for part in new.split("."):
            value = getattr(value, part)
        return value
    module, _, attribute = new.rpartition(".")
    return getattr(import_module(f"roughcontact.{module}"), attribute)


# Environment variables with the number of processes of an MPI run (MPICH, Open MPI, PMIx).
_MPI_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")


def reject_mpi_run() -> None:
    """Raise `InputError` if ``mpiexec`` started this process together with others."""
    if any(os.environ.get(name, "1") not in ("", "1") for name in _MPI_SIZES):
        from roughcontact.errors import InputError

        raise InputError(
            "mpiexec started several processes, each of which would do all of the work: start a "
            "single one, which uses all cores"
        )
