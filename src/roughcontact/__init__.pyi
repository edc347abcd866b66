"""What `roughcontact` offers: the one list, which is read at run time as well."""

from . import (
    measure as measure,
    mpi as mpi,
    plots as plots,
    results as results,
    theory as theory,
)
from .contact.load_case import (
    HertzPressure as HertzPressure,
    LineLoad as LineLoad,
    NominalPressure as NominalPressure,
)
from .contact.result import ContactResult as ContactResult
from .contact.solve import solve as solve
from .contact.subsurface_stress import (
    first_yield_load as first_yield_load,
    subsurface_stress as subsurface_stress,
)
from .elastoplastic.ceiling_comparison import compare_models as compare_models
from .elastoplastic.result import ElastoplasticResult as ElastoplasticResult, PathPoint as PathPoint
from .elastoplastic.rolling import (
    roll as roll,
    shakedown_load as shakedown_load,
)
from .elastoplastic.solve import solve_elastoplastic as solve_elastoplastic
from .errors import (
    CapacityError as CapacityError,
    ConvergenceError as ConvergenceError,
    FormatError as FormatError,
    InputError as InputError,
    InsufficientMemoryError as InsufficientMemoryError,
    RoughcontactError as RoughcontactError,
)
from .formats.read import read_result as read_result, read_surface as read_surface
from .joint.conductance import conductance as conductance
from .joint.estimate import estimate as estimate
from .joint.interface_law import interface_law as interface_law
from .joint.leakage import leakage as leakage
from .joint.tangential import tangential as tangential
from .material import catalog as catalog, hardening as hardening, hardness as hardness
from .material.material import (
    RIGID as RIGID,
    Conductor as Conductor,
    Layer as Layer,
    Material as Material,
    contact_modulus as contact_modulus,
)
from .solvers.progress import (
    Progress as Progress,
    Step as Step,
)
from .studies.comparison import compare as compare
from .studies.load_curve import sweep as sweep
from .studies.load_history import (
    Stage as Stage,
    history as history,
    indented_surface as indented_surface,
)
from .studies.load_search import find_load as find_load
from .studies.resolution_study import resolution_study as resolution_study
from .studies.sampling_study import sampling_study as sampling_study
from .surface.generation import generate as generate
from .surface.nominal_bodies import cylinder as cylinder, sphere as sphere
from .surface.placement import partition as partition
from .surface.provenance import Provenance as Provenance
from .surface.random_surfaces import reference_map as reference_map, self_affine as self_affine
from .surface.surface import Surface as Surface

__version__: str
__all__: list[str]
