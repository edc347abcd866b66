"""What `roughcontact` offers: the one list, which is read at run time as well."""

from . import measure as measure, plots as plots, results as results, theory as theory
from .analyses.compare.model import compare as compare
from .analyses.compare.sampling import sampling_study as sampling_study
from .analyses.conductance.model import conductance as conductance
from .analyses.estimate.model import estimate as estimate
from .analyses.find.model import find_load as find_load
from .analyses.history.model import (
    Stage as Stage,
    history as history,
    indented_surface as indented_surface,
)
from .analyses.law.model import interface_law as interface_law
from .analyses.leak.model import leakage as leakage
from .analyses.reading import read_result as read_result
from .analyses.roll.model import roll as roll, shakedown_load as shakedown_load
from .analyses.stress.model import (
    first_yield_load as first_yield_load,
    subsurface_stress as subsurface_stress,
)
from .analyses.sweep.model import sweep as sweep
from .analyses.tangential.model import tangential as tangential
from .analyses.wear.model import wear as wear
from .contact.load_case import (
    HertzPressure as HertzPressure,
    LineLoad as LineLoad,
    NominalPressure as NominalPressure,
)
from .contact.result import ContactResult as ContactResult
from .contact.solve import solve as solve
from .elastoplastic.ceiling_comparison import compare_models as compare_models
from .elastoplastic.solve import solve_elastoplastic as solve_elastoplastic
from .elastoplastic.volume_result import (
    ElastoplasticResult as ElastoplasticResult,
    PathPoint as PathPoint,
)
from .errors import (
    CapacityError as CapacityError,
    ConvergenceError as ConvergenceError,
    FormatError as FormatError,
    InputError as InputError,
    InsufficientMemoryError as InsufficientMemoryError,
    RoughcontactError as RoughcontactError,
)
from .formats.read import read_surface as read_surface
from .material import catalog as catalog, hardening as hardening, hardness as hardness
from .material.material import (
    RIGID as RIGID,
    Conductor as Conductor,
    Layer as Layer,
    Material as Material,
    contact_modulus as contact_modulus,
)
from .surface.generation import generate as generate
from .surface.nominal_bodies import cylinder as cylinder, sphere as sphere
from .surface.placement import partition as partition
from .surface.provenance import Provenance as Provenance
from .surface.random_surfaces import reference_map as reference_map, self_affine as self_affine
from .surface.surface import Surface as Surface
from .uncertainty.resolution import resolution_study as resolution_study

__version__: str
__all__: list[str]
