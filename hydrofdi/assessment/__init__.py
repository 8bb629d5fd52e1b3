"""What can be said of an experiment before it is run in earnest, and the leakages that it asks for."""

from hydrofdi.assessment.convergence import Convergence, converge
from hydrofdi.assessment.forewarnings import forewarnings
from hydrofdi.assessment.inspection import Inspection, inspect_experiment
from hydrofdi.assessment.leakage_targets import LeakageTarget, calibrate_flows
from hydrofdi.assessment.step_limits import step_limits

__all__ = [
    "Convergence",
    "Inspection",
    "LeakageTarget",
    "calibrate_flows",
    "converge",
    "forewarnings",
    "inspect_experiment",
    "step_limits",
]
