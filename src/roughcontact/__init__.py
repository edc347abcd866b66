"""Contact of measured rough surfaces: pressure, real contact area, saturated area and gap."""

from roughcontact._version import __version__
from roughcontact.contact.archive import save_result
from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.first_yield import yield_onset
from roughcontact.contact.history import LoadHistory, Stage
from roughcontact.contact.load_curve import load_curve
from roughcontact.contact.load_history import load_history
from roughcontact.contact.resolution_study import resolution_study
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import solve
from roughcontact.contact.stress import StressResult
from roughcontact.contact.study import ResolutionStudy
from roughcontact.contact.subsurface import subsurface_stress
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    FormatError,
    InputError,
    InsufficientMemoryError,
    RoughcontactError,
)
from roughcontact.formats.read import read_surface
from roughcontact.material.hardening import Linear, Perfect, Swift, Tabulated
from roughcontact.material.material import RIGID, Material, contact_modulus
from roughcontact.solvers.progress import Progress, Step
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.surface.synthetic import reference_map, self_affine
from roughcontact.volume.archive import load_elastoplastic, load_result
from roughcontact.volume.comparison import ModelComparison, compare_models
from roughcontact.volume.result import ElastoplasticResult
from roughcontact.volume.solve import solve_elastoplastic

__all__ = [
    "RIGID",
    "CapacityError",
    "ContactResult",
    "ConvergenceError",
    "ElastoplasticResult",
    "FormatError",
    "InputError",
    "InsufficientMemoryError",
    "Linear",
    "LoadCurve",
    "LoadHistory",
    "Material",
    "ModelComparison",
    "Perfect",
    "Progress",
    "Provenance",
    "ResolutionStudy",
    "RoughcontactError",
    "Stage",
    "Step",
    "StressResult",
    "Surface",
    "Swift",
    "Tabulated",
    "__version__",
    "compare_models",
    "contact_modulus",
    "load_curve",
    "load_elastoplastic",
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
