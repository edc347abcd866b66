"""What functions return: the classes of results, for type hints and ``isinstance``."""

from roughcontact.contact.subsurface_stress import StressResult as StressResult
from roughcontact.elastoplastic.ceiling_comparison import ModelComparison as ModelComparison
from roughcontact.elastoplastic.rolling import RollingResult as RollingResult
from roughcontact.joint.conductance import Conductance as Conductance
from roughcontact.joint.estimate import Estimate as Estimate
from roughcontact.joint.interface_law import InterfaceLaw as InterfaceLaw
from roughcontact.joint.leakage import Leakage as Leakage
from roughcontact.joint.tangential import Tangential as Tangential
from roughcontact.studies.comparison import Comparison as Comparison
from roughcontact.studies.load_curve import LoadCurve as LoadCurve
from roughcontact.studies.load_history import LoadHistory as LoadHistory
from roughcontact.studies.load_search import LoadSearch as LoadSearch
from roughcontact.studies.resolution_study import ResolutionStudy as ResolutionStudy
from roughcontact.studies.sampling_study import SamplingStudy as SamplingStudy
from roughcontact.studies.uncertainty import Uncertainty as Uncertainty
