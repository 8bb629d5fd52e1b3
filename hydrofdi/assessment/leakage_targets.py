"""What a mean leakage flow means: as an orifice, as a laminar gap, and as a share of the piston's flow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.assessment.selection import computed_rows
from hydrofdi.config import ExperimentConfig, expand_runs
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.execution import InProcessEngine, Job, leakage_coefficients


@dataclass(frozen=True)
class LeakageTarget:
    """A mean leakage flow and the coefficients that cause it.

    Attributes
    ----------
    flow : float
        Mean of abs(q_il) [m³/s].
    coefficient : float
        K_i of the orifice law [m^3.5/kg^0.5].
    laminar_coefficient : float
        Mean of abs(q_il) over the mean of abs(P_1 − P_2) [m³/(s·Pa)].
    piston_share : float
        Mean of abs(q_il) over the mean of A abs(v_p) [-].
    """

    flow: float
    coefficient: float
    laminar_coefficient: float
    piston_share: float


def calibrate_flows(experiment: ExperimentConfig, flows: Sequence[float]) -> list[LeakageTarget]:
    """Solve several mean leakage flows [m³/s] at once, under the experiment's baseline conditions.

    Raises
    ------
    ConfigError
        A flow cannot be reached.
    """
    sweep = SweepConfig(grid={"leakage.internal_flow": list(dict.fromkeys(flows))})
    table = expand_runs(experiment.model_copy(update={"sweep": sweep}))
    runs = table.runs[: table.n_swept]
    coefficients = leakage_coefficients(runs, InProcessEngine(), {})
    conditions = [run.calibration or run.parameters for run in runs]
    jobs = [Job(str(k), run, coefficients[k]) for k, run in enumerate(conditions)]
    targets = []
    for job, row in zip(jobs, computed_rows(jobs), strict=True):
        mean = float(row["mean_internal_leakage_flow"])
        difference = np.mean(np.abs(row["chamber_1_pressure"] - row["chamber_2_pressure"]))
        piston = job.parameters.actuator.piston_area * np.mean(np.abs(row["piston_velocity"]))
        targets.append(
            LeakageTarget(mean, job.leakage_coefficient, float(mean / difference), float(mean / piston))
        )
    return targets
