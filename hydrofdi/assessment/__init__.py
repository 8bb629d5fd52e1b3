"""What can be said of an experiment before it is run in earnest, and the leakages that it asks for."""

from hydrofdi.assessment.convergence import Convergence, converge
from hydrofdi.assessment.indicator_warnings import indicator_warnings, other_machine_warnings
from hydrofdi.assessment.inspection import Inspection, inspect_experiment
from hydrofdi.assessment.leakage_targets import LeakageTarget, calibrate_flows
from hydrofdi.assessment.plan_warnings import plan_warnings
from hydrofdi.assessment.step_limits import step_limits
from hydrofdi.assessment.study_warnings import study_warnings

__all__ = [
    "Convergence",
    "Inspection",
    "LeakageTarget",
    "calibrate_flows",
    "converge",
    "indicator_warnings",
    "inspect_experiment",
    "other_machine_warnings",
    "plan_warnings",
    "step_limits",
    "study_warnings",
]
