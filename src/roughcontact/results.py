"""Classes of results and of their progress, for type hints and ``isinstance``."""

from roughcontact.analyses.compare.model import Comparison as Comparison
from roughcontact.analyses.compare.sampling import SamplingStudy as SamplingStudy
from roughcontact.analyses.conductance.model import Conductance as Conductance
from roughcontact.analyses.estimate.model import Estimate as Estimate
from roughcontact.analyses.find.model import LoadSearch as LoadSearch
from roughcontact.analyses.history.model import LoadHistory as LoadHistory
from roughcontact.analyses.law.model import InterfaceLaw as InterfaceLaw
from roughcontact.analyses.leak.model import Leakage as Leakage
from roughcontact.analyses.roll.model import RollingResult as RollingResult
from roughcontact.analyses.stress.model import StressResult as StressResult
from roughcontact.analyses.sweep.model import LoadCurve as LoadCurve
from roughcontact.analyses.tangential.model import Tangential as Tangential
from roughcontact.analyses.wear.model import Wear as Wear
from roughcontact.elastoplastic.ceiling_comparison import ModelComparison as ModelComparison
from roughcontact.solvers.progress import Progress as Progress, Step as Step
from roughcontact.uncertainty.intervals import Uncertainty as Uncertainty
from roughcontact.uncertainty.resolution import ResolutionStudy as ResolutionStudy
