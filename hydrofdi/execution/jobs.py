"""What is to be computed of one run."""

from __future__ import annotations

from dataclasses import dataclass

from hydrofdi.config import RunParameters, RunSpec
from hydrofdi.config.experiment import DEFAULT_ANALYSIS, Analysis
from hydrofdi.store import StoredRun


@dataclass(frozen=True)
class Job:
    """A run that is ready to be computed.

    Attributes
    ----------
    run_id : str
    parameters : RunParameters
        What its record is made with.
    leakage_coefficient : float
        K_i [m^3.5/kg^0.5]; NaN says that no K_i gives its leakage.
    analysis : Analysis
        What is measured of the record.
    record_id : str
    stored : StoredRun or None
        Where its record is stored with the signals that are measured; None if it is to be simulated.
    """

    run_id: str
    parameters: RunParameters
    leakage_coefficient: float
    analysis: Analysis = DEFAULT_ANALYSIS
    record_id: str = ""
    stored: StoredRun | None = None

    @classmethod
    def of(cls, run: RunSpec, run_id: str, leakage_coefficient: float, record_id: str = "") -> Job:
        """The job of a run."""
        return cls(run_id, run.parameters, leakage_coefficient, run.analysis, record_id)
