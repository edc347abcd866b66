"""What `roughcontact` offers: the one list, which is read at run time as well."""

from . import (
    plots as plots,
    theory as theory,
)
from .contact.archive import save_result as save_result
from .contact.compare import compare as compare
from .contact.compared import Comparison as Comparison
from .contact.curve import LoadCurve as LoadCurve
from .contact.find import find_load as find_load
from .contact.first_yield import yield_onset as yield_onset
from .contact.found import (
    FoundLoad as FoundLoad,
    FoundLoads as FoundLoads,
)
from .contact.history import (
    LoadHistory as LoadHistory,
    Stage as Stage,
)
from .contact.load_curve import load_curve as load_curve
from .contact.load_history import load_history as load_history
from .contact.loads import (
    HertzPressure as HertzPressure,
    LineLoad as LineLoad,
    NominalPressure as NominalPressure,
)
from .contact.resolution_study import resolution_study as resolution_study
from .contact.result import ContactResult as ContactResult
from .contact.sampling import (
    SamplingStudy as SamplingStudy,
    sampling_error as sampling_error,
)
from .contact.slab import (
    Slab as Slab,
    slab_rows as slab_rows,
)
from .contact.solve import solve as solve
from .contact.stress import StressResult as StressResult
from .contact.study import ResolutionStudy as ResolutionStudy
from .contact.subsurface import subsurface_stress as subsurface_stress
from .contact.unloading import indented_surface as indented_surface
from .errors import (
    CapacityError as CapacityError,
    ConvergenceError as ConvergenceError,
    FormatError as FormatError,
    InputError as InputError,
    InsufficientMemoryError as InsufficientMemoryError,
    RoughcontactError as RoughcontactError,
)
from .formats.read import read_surface as read_surface
from .formats.slabs import read_slab as read_slab
from .joint.conductance import (
    Conductance as Conductance,
    conductance as conductance,
)
from .joint.estimate import (
    Estimate as Estimate,
    estimate as estimate,
)
from .joint.interface import InterfaceLaw as InterfaceLaw
from .joint.law import interface_law as interface_law
from .joint.leakage import (
    Leakage as Leakage,
    leakage as leakage,
)
from .material import (
    catalogue as catalogue,
    hardness as hardness,
)
from .material.conductor import Conductor as Conductor
from .material.hardening import (
    Kinematic as Kinematic,
    Linear as Linear,
    Perfect as Perfect,
    Swift as Swift,
    Tabulated as Tabulated,
)
from .material.material import (
    RIGID as RIGID,
    Material as Material,
    contact_modulus as contact_modulus,
)
from .solvers.progress import (
    Progress as Progress,
    Step as Step,
)
from .surface.generation import generate as generate
from .surface.partition import partition as partition
from .surface.provenance import Provenance as Provenance
from .surface.surface import Surface as Surface
from .surface.synthetic import (
    reference_map as reference_map,
    self_affine as self_affine,
)
from .volume.archive import (
    load_elastoplastic as load_elastoplastic,
    load_result as load_result,
)
from .volume.comparison import (
    ModelComparison as ModelComparison,
    compare_models as compare_models,
)
from .volume.passes_archive import load_rolling as load_rolling
from .volume.path import PathPoint as PathPoint
from .volume.result import ElastoplasticResult as ElastoplasticResult
from .volume.rolling import (
    Rolling as Rolling,
    roll as roll,
    shakedown_load as shakedown_load,
)
from .volume.solve import solve_elastoplastic as solve_elastoplastic

__version__: str
__all__: list[str]
