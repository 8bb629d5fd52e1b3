"""One simulated run, for scripts and notebooks."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrofdi.api.experiments import Experiment, experiment_of
from hydrofdi.api.notebook import shown
from hydrofdi.api.places import path_of
from hydrofdi.api.stored import library_versions
from hydrofdi.config import ExperimentConfig, RunSpec, RunTable, expand_runs
from hydrofdi.config.shown_values import shown_in
from hydrofdi.config.study.detection import DetectionConfig
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.report.run_summary import RunSummary, run_record, summarize_run
from hydrofdi.report.table import Table, library
from hydrofdi.simulation import record_identity, run_identity
from hydrofdi.store import Columns, HeldResults, write_experiment
from hydrofdi.store.files import require_replaceable
from hydrofdi.store.layout.names import NO_BASELINE, TIME

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from hydrofdi.records import Channel, RecordSource


class Run:
    """One simulated actuator; `hydrofdi.simulate` makes it.

    Attributes
    ----------
    experiment : ExperimentConfig
        What was asked for, in SI.
    spec : RunSpec
    columns : dict
        Name of a variable → its values with one row, in SI.
    """

    def __init__(self, experiment: ExperimentConfig, spec: RunSpec, columns: Columns) -> None:
        self.experiment, self.spec, self.columns = experiment, spec, columns

    @cached_property
    def summary(self) -> RunSummary:
        """The features of the run in words and numbers, as the command prints them."""
        return summarize_run(self.spec, self.columns)

    @property
    def title(self) -> str:
        """The run in a few words."""
        with shown_in(self.experiment.units):
            return self.summary.title

    @property
    def run_id(self) -> str:
        """Identity: a hash of what determines the run."""
        return self.summary.run_id

    @property
    def status(self) -> str:
        """``ok``, or how the run failed."""
        return self.summary.status

    @property
    def message(self) -> str:
        """A sentence on a run that failed; else empty."""
        return self.summary.message

    @property
    def verdict(self) -> str:
        """How far the numbers can be believed; ``ok`` where nothing speaks against it."""
        return self.summary.verdict

    @cached_property
    def features(self) -> dict[str, float]:
        """Name → number in SI, such as ``mean_internal_leakage_flow`` [m³/s] and ``dwt.d2`` [Pa]."""
        return {
            name: float(values[0])
            for name, values in self.columns.items()
            if values.shape == (1,) and values.dtype.kind == "f"
        }

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """A sentence on each setting that is strange, without effect, or too fast for the step."""
        from hydrofdi.api.step_limits import step_warnings
        from hydrofdi.config.idle_parameters import idle_parameters
        from hydrofdi.config.plausibility import unusual_values

        doubts = unusual_values(self.experiment, with_sweep=False) + idle_parameters(self.experiment)
        return (*doubts, *step_warnings(lambda *_: [self.spec.request]), *self.saturation)

    @property
    def saturation(self) -> list[str]:
        """A sentence if the controller is at its voltage limit for much of the record."""
        from hydrofdi.quality.saturation import saturation_warning

        voltages = self.columns.get("input_voltage")
        if voltages is None or self.status != "ok":
            return []
        sentence = saturation_warning(self.spec.parameters, voltages[0])
        return [sentence] if sentence else []

    def to_xarray(self) -> xarray.Dataset:
        """Signals over time and all features, with units and long names as attributes.

        Raises
        ------
        ReportError
            xarray is not installed.
        """
        from hydrofdi.api.labelled import run_dataset, run_variables

        told = {"title": self.title, "run_id": self.run_id, "status": self.status}
        told |= {"verdict": self.verdict} | ({"message": self.message} if self.message else {})
        return run_dataset(run_variables(self.experiment), self.columns, told)

    def to_pandas(self) -> pandas.DataFrame:
        """Signals in SI, shape (n_time, n_signal), titles such as ``time [s]``, ``chamber_1_pressure [Pa]``.

        Raises
        ------
        ReportError
            pandas or xarray is not installed.
        """
        signals = {name: each for name, each in self.to_xarray().variables.items() if each.dims == ("time",)}
        units = {
            name: each.attrs["units"].replace("m3", "m³").replace(" s-1", "/s")
            for name, each in signals.items()
        }
        columns = {f"{name} [{units[name]}]": each.to_numpy() for name, each in signals.items()}
        frame: pandas.DataFrame = library("pandas").DataFrame(columns)
        return frame[["time [s]", *frame.columns.drop("time [s]")]]

    def record_source(self, channels: Collection[Channel]) -> RecordSource:
        """The run as a record, so that `hydrofdi.measure` and others take it as it is."""
        from hydrofdi.api.records.columns import Column, Held
        from hydrofdi.api.records.held import records_of
        from hydrofdi.store.records import SIGNAL_OF_CHANNEL

        held = self.columns
        columns = [
            Column(channel.value, held[signal][0], channel.unit)
            for channel, signal in SIGNAL_OF_CHANNEL.items()
            if channel in channels and signal in held
        ]
        time = Column("time", held[TIME], "s")
        records = records_of(Held(self.title, columns, time, [self.run_id]), None, None, None)
        return replace(records, is_simulated=True)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi simulate --json`` prints."""
        return run_record(self.summary)

    def plot(self) -> Figure:
        """The signals over time; `Figure.savefig` writes them."""
        from hydrofdi.report.figures import draw_signals

        return shown(draw_signals(self.columns, self.experiment.wavelet, self.title))

    def write(self, path: str | PathLike[str]) -> None:
        """Store the run as an experiment file (HDF5). A healthy one is its own baseline, others have none.

        Raises
        ------
        StoreError
            The file cannot be written, or something else stands there.
        """
        require_replaceable(path_of(path))
        alone = _alone(self.experiment)
        whole = expand_runs(alone)
        fixed, matched = (
            np.where(rows[:1] == 0, 0, NO_BASELINE) for rows in (whole.fixed_baseline, whole.matched_baseline)
        )
        table = RunTable(whole.runs[:1], {}, 1, fixed, matched, np.array([NO_BASELINE]))
        write_experiment(path_of(path), alone, table, HeldResults(self.columns), library_versions())

    def __repr__(self) -> str:
        return repr(self._table())

    def _repr_html_(self) -> str:
        return self._table()._repr_html_()

    def _table(self) -> Table:
        warnings = tuple(f"warning: {warning}" for warning in self.warnings)
        return replace(self.summary.table, title=self.title, notes=warnings)


def simulate(
    experiment: Experiment | None = None,
    /,
    *,
    out: str | PathLike[str] | None = None,
    **settings: Any,
) -> Run:
    """Simulate one actuator, as ``hydrofdi simulate`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        YAML file, or what would stand in one; without it, the nominal actuator. A sweep is left aside.
    out : path, optional
        Store the run in this experiment file (HDF5); `Run.write` does it later.
    **settings
        Parameters by their names, quantities with a unit or in SI: ``bulk_modulus="689 MPa"``. Where several
        sections have a name, ``pressure_1_sensor__noise="20 kPa"``; a whole section as a mapping.

    Returns
    -------
    Run
        A run that fails has another `status` than ``ok``.

    Raises
    ------
    ConfigError
        With every mistake in the settings.
    StoreError
        The file cannot be written, or something else stands there.

    Examples
    --------
    >>> import hydrofdi
    >>> run = hydrofdi.simulate(bulk_modulus="689 MPa", internal_flow="0.2 L/min", duration="4 s")
    >>> run.summary.title
    'EBM 689 MPa, 0.2 L/min'
    >>> round(run.features["mean_internal_leakage_flow"] * 60e3, 3)
    0.2
    >>> run.to_xarray().chamber_1_pressure.attrs["units"]
    'Pa'
    >>> hydrofdi.simulate(bulk_modulos="689 MPa")
    Traceback (most recent call last):
    hydrofdi.errors.ConfigError: bulk_modulos: unknown key; did you mean 'bulk_modulus'?
    """
    loaded = experiment_of(experiment, settings)
    if out is not None:
        require_replaceable(path_of(out))
    spec = expand_runs(_alone(loaded)).runs[0]
    (coefficient,) = leakage_coefficients([spec], InProcessEngine(), {})
    job = Job.of(spec, run_identity(spec), coefficient, record_identity(spec))
    run = Run(loaded, spec, compute_columns([job]))
    if out is not None:
        run.write(out)
    return run


def _alone(experiment: ExperimentConfig) -> ExperimentConfig:
    """An experiment without what it varies; the one run of a study keeps its signals."""
    alone: dict[str, Any] = {"sweep": SweepConfig(), "ensemble": SweepConfig(), "study": None}
    if experiment.study is not None and experiment.store.signals == "none":
        alone["store"] = experiment.store.model_copy(update={"signals": "all"})
    return experiment.model_copy(update=alone | {"detection": DetectionConfig()})
