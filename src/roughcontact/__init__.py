"""Contact of measured rough surfaces: pressure, real contact area, saturated area and gap."""

from roughcontact._version import __version__
from roughcontact.archive import load_result, save_result
from roughcontact.comparison import ModelComparison, compare_models
from roughcontact.contact import solve
from roughcontact.elastoplastic import ElastoplasticResult, solve_elastoplastic
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    FormatError,
    InputError,
    InsufficientMemoryError,
    RoughcontactError,
)
from roughcontact.formats import read_surface
from roughcontact.generate import reference_map, self_affine
from roughcontact.history import LoadHistory, Stage, load_history
from roughcontact.loading import LoadCurve, load_curve
from roughcontact.material import RIGID, Material, contact_modulus
from roughcontact.result import ContactResult
from roughcontact.solver import Step
from roughcontact.study import ResolutionStudy, resolution_study
from roughcontact.subsurface import StressResult, subsurface_stress, yield_onset
from roughcontact.surface import Provenance, Surface

__all__ = [
    "RIGID",
    "CapacityError",
    "ContactResult",
    "ConvergenceError",
    "ElastoplasticResult",
    "FormatError",
    "InputError",
    "InsufficientMemoryError",
    "LoadCurve",
    "LoadHistory",
    "Material",
    "ModelComparison",
    "Provenance",
    "ResolutionStudy",
    "RoughcontactError",
    "Stage",
    "Step",
    "StressResult",
    "Surface",
    "__version__",
    "compare_models",
    "contact_modulus",
    "load_curve",
    "load_history",
    "load_result",
    "read_surface",
    "reference_map",
    "resolution_study",
    "save_result",
    "self_affine",
    "solve",
    "solve_elastoplastic",
    "subsurface_stress",
    "yield_onset",
]
