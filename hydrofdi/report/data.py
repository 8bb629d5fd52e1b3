"""What a report says of any experiment as numbers, computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from hydrofdi.config.experiment import DWT
from hydrofdi.report.indicators import MeasuredIndicator, measured_indicators
from hydrofdi.report.plane import Plane, plane_of
from hydrofdi.report.responses import ResponseStudy, study_responses
from hydrofdi.report.runs import RunTable, run_table
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names


@dataclass(frozen=True)
class ReportData:
    """The numbers of an experiment that sections, figures and other forms are made from."""

    data: ExperimentData

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.data.experiment.name

    @property
    def path(self) -> Path:
        """The experiment file."""
        return self.data.path

    @cached_property
    def table(self) -> RunTable:
        """Its runs."""
        return run_table(self.data)

    @cached_property
    def indicators(self) -> tuple[MeasuredIndicator, ...]:
        """Indicators beside the details of P_1, if the experiment measures any."""
        return measured_indicators(self.data)

    @cached_property
    def responses(self) -> ResponseStudy:
        """What each feature does over each parameter that varies."""
        return study_responses(self.data, self.indicators)

    @cached_property
    def plane(self) -> Plane | None:
        """The runs over the two parameters that matter most, if they are a grid of them."""
        return plane_of(self.data, self.responses)

    @property
    def has_details(self) -> bool:
        """Whether the experiment measures the wavelet details as configured."""
        return DWT in self.data.experiment.indicators

    @property
    def has_results(self) -> bool:
        """Whether any run has results."""
        return bool(self.table.is_ok.any())

    @property
    def has_baseline(self) -> bool:
        """Whether there is a healthy run that the others are compared with."""
        return bool((self.data.fixed_baseline != names.NO_BASELINE).any())

    @cached_property
    def baselines(self) -> tuple[str, ...]:
        """``fixed`` and ``matched``, without a baseline for which δ is zero or the same as for the other."""
        own, fixed, matched = np.arange(self.data.n_run), self.data.fixed_baseline, self.data.matched_baseline
        tells = {
            "fixed": (fixed != own) & (fixed != names.NO_BASELINE),
            "matched": (matched != own) & (matched != fixed),
        }
        return tuple(name for name, is_other in tells.items() if is_other.any())

    @property
    def no_changes(self) -> str:
        """Why there is no δ, or why it would be zero for every run; empty if there is δ."""
        if not self.has_baseline:
            alone = "it is a single run; 'hydrofdi sweep' adds the healthy ones"
            reason = alone if self.data.n_run == 1 else "the baseline itself leaks"
            return f"There is no healthy run to compare with ({reason}): δ is not known."
        if self.baselines:
            return ""
        return (
            "Each run is its own healthy baseline, because no run leaks and the baseline sets none of the"
            " varied parameters: δ is zero by construction. To see δ, set a varied parameter in the baseline."
        )
