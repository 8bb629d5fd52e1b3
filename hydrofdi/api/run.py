"""One simulated run, for scripts and notebooks."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunSpec
from hydrofdi.config.loading import Experiment, load_experiment
from hydrofdi.config.request import full_name, meant, parameter_names
from hydrofdi.config.values import ParameterAnswer, shown_in, shown_value
from hydrofdi.errors import UnknownNameError
from hydrofdi.execution.single import compute_run, store_run
from hydrofdi.records.data_sheet import StatedMachine
from hydrofdi.settings.arguments import names_of, path_of
from hydrofdi.settings.messages import nearest, shown_quantity
from hydrofdi.settings.quantities import Quantity
from hydrofdi.store import names
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL
from hydrofdi.store.files import require_replaceable
from hydrofdi.store.shards import Columns
from hydrofdi.tables.answer import Piece
from hydrofdi.tables.table import Column, Table, library, plain

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from hydrofdi.api.settings import Settings
    from hydrofdi.records import Channel, RecordSource


_PER = re.compile(r" ([A-Za-z]+)-(?:1(?![\d.]))?")
_EXPONENT = re.compile(r"(?<=[A-Za-z])(-?[\d.]+)")
"""A divisor, and an exponent, in a unit of a file: ``m3 s-1``."""
_RESIDUALS = ("settling_change", "volume_residual", "energy_residual")


class Parameters(dict[str, Any]):
    """Full name → value in SI; symbols and short names are understood."""

    def __missing__(self, name: str) -> Any:
        if (full := full_name(name)) not in self:
            raise UnknownNameError(f"no parameter {name!r}{meant(name)}")
        return self[full]


class Run(ParameterAnswer):
    """One simulated actuator; `hydrofdi.simulate` makes it.

    Its signals and features are attributes and items, such as ``run.P1`` and ``run["dwt.d2"]``.

    Attributes
    ----------
    experiment : ExperimentConfig
        What was asked for, in SI.
    spec : RunSpec
    columns : dict
        Name of a variable → its values with one row, in SI.
    run_id : str
        Identity: a hash of what determines the run.
    status, message : str
        ``ok``, or how the run failed, and a sentence on it.
    verdict : str
        How far the numbers can be believed; ``ok`` where nothing speaks against it.
    """

    def __init__(self, experiment: ExperimentConfig, spec: RunSpec, columns: Columns) -> None:
        self.experiment, self.spec, self.columns = experiment, spec, columns
        texts = (names.RUN_ID, names.STATUS, names.MESSAGE, names.VERDICT)
        self.run_id, self.status, self.message, self.verdict = (str(columns[each][0]) for each in texts)

    @property
    def title(self) -> str:
        """The run in a few words."""
        with shown_in(self.experiment.units):
            plant = self.spec.parameters.plant
            flow, leakage = self.features[names.MEAN_LEAKAGE_FLOW].to("L/min"), ""
            if not self.features[names.LEAKAGE_COEFFICIENT] and plant.takes_leakage:
                leakage = "sealed"
            elif not math.isnan(flow):
                leakage = f"{flow:.3g} L/min"
            modulus = shown_value("fluid.bulk_modulus", self.spec.parameters.fluid.bulk_modulus)
            failed = "" if self.status == "ok" else f", {self.status}"
            machine = plant.name if plant.fmu else ""
            oil = f"EBM {modulus}" if plant.takes("fluid.bulk_modulus") else ""
            return ", ".join(filter(None, (machine, oil, leakage))) + failed

    @cached_property
    def parameters(self) -> Parameters:
        """Name of a parameter → its value in SI."""
        return Parameters({name: self.spec.request.shown_value(name) for name in parameter_names()})

    @property
    def detail_rms(self) -> NDArray[np.float64]:
        """RMS of the detail coefficients d1, d2, … of the chamber-1 pressure, shape (n_level,) [Pa]."""
        rms: NDArray[np.float64] = self.columns[names.DETAIL_RMS][0]
        return rms

    @cached_property
    def features(self) -> dict[str, Quantity]:
        """Name → number in SI, such as ``mean_internal_leakage_flow`` [m³/s]; `Quantity.to` converts it."""
        units = {each.name: _EXPONENT.sub(r"^\1", _PER.sub(r"/\1", each.units)) for each in self._variables}
        return {
            name: Quantity.of(values[0], units.get(name, ""))
            for name, values in self.columns.items()
            if values.shape == (1,) and values.dtype.kind == "f"
        }

    @cached_property
    def signals(self) -> dict[str, NDArray[np.float64]]:
        """Name or symbol → samples, shape (n_time,), in SI: ``time`` [s], ``chamber_1_pressure`` [Pa]."""
        held = {name: self.columns[name][0] for name in names.SIGNALS if name in self.columns}
        if not held:
            return {}
        symbols = {each.symbol: held[name] for each, name in SIGNAL_OF_CHANNEL.items() if name in held}
        return {names.TIME: self.columns[names.TIME], **held, "t": self.columns[names.TIME], **symbols}

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the samples, shape (n_time,) [s]."""
        return self.signals[names.TIME]

    def __getitem__(self, name: str) -> Any:
        """A signal, shape (n_time,), or a feature, by its name or symbol, in SI."""
        found = {**self.signals, **self.features}
        if name not in found:
            raise UnknownNameError(f"no signal or feature {name!r}{nearest(str(name), [*found])}")
        return found[name]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in dir(self):
            raise AttributeError(f"Run has no attribute {name!r}", name=name, obj=self)
        return self[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.signals, *filter(str.isidentifier, self.features)]

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.signals, *self.features]

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """A sentence on each setting that is strange, without effect, or too fast for the step."""
        from hydrofdi.execution.checks import likely_mistakes, saturation

        doubts = likely_mistakes(self.experiment, lambda *_: [self.spec.request], with_sweep=False)
        voltages = self.columns.get("input_voltage")
        if voltages is not None and self.status == "ok":
            doubts += saturation(self.spec.parameters, voltages[0])
        return tuple(doubts)

    def to_xarray(self) -> xarray.Dataset:
        """Signals over time and all features, with units and long names as attributes.

        Raises
        ------
        ReportError
            xarray is not installed.
        """
        attributes = {"title": self.title, "run_id": self.run_id, "status": self.status}
        attributes |= {"verdict": self.verdict} | ({"message": self.message} if self.message else {})
        content = {
            each.name: (
                each.dimensions[1:],
                self.columns[each.name][0],
                {"units": each.units, "long_name": each.long_name},
            )
            for each in self._variables
        }
        dataset: xarray.Dataset = library("xarray").Dataset(content, attrs=attributes)
        about_time = {"units": "s", "long_name": "time"}
        coordinates: dict[str, Any] = {names.TIME: (names.TIME, self.time, about_time)}
        if names.LEVEL in dataset.sizes:
            levels = np.arange(1, dataset.sizes[names.LEVEL] + 1)
            about_levels = {"long_name": "level of the wavelet transform"}
            coordinates[names.LEVEL] = (names.LEVEL, levels, about_levels)
        return dataset.assign_coords(coordinates)

    def to_pandas(self) -> pandas.DataFrame:
        """Signals in SI, shape (n_time, n_signal), titles such as ``time [s]``, ``chamber_1_pressure [Pa]``.

        Raises
        ------
        ReportError
            pandas is not installed.
        """
        columns = {"time [s]": self.time}
        for each in self._variables:
            if each.dimensions[1:] == (names.TIME,):
                unit = each.units.replace("m3", "m³").replace(" s-1", "/s")
                columns[f"{each.name} [{unit}]"] = self.columns[each.name][0]
        frame: pandas.DataFrame = library("pandas").DataFrame(columns)
        return frame

    @cached_property
    def _variables(self) -> list[names.Variable]:
        """Its numbers and signals as experiment files have them."""
        measured = self.experiment.indicator_choice.made(self.experiment.wavelet)
        stored = names.stored_variables("all", phases=self.experiment.wavelet.phase == "all")
        known = {each.name: each for each in (*stored, *names.output_variables([measured]), *names.BY_LEVEL)}
        return [each for each in known.values() if each.name in self.columns and not each.is_text]

    def record_source(self, channels: Collection[Channel]) -> RecordSource:
        """The run as a record, so that `hydrofdi.measure` and others take it as it is."""
        from hydrofdi.records.memory import held, records_of

        samples = {
            f"{channel} [{channel.unit}]": self.columns[signal][0]
            for channel, signal in SIGNAL_OF_CHANNEL.items()
            if channel in channels and signal in self.columns
        }
        found = replace(held(samples | {"time [s]": self.time}), place=self.title, record_ids=[self.run_id])
        source, sheet = records_of(found, None, None, None), self.experiment.data_sheet
        machine = StatedMachine.model_construct({*sheet}, **sheet)
        return replace(source, config=source.config.model_copy(update={"actuator": machine}))

    @property
    def table(self) -> Table:
        """Each feature as files name it, and its value with a unit, for people."""
        plant, lead = self.spec.parameters.plant, [("run", self.run_id), ("status", self.status)]
        lead.append(("verdict", self.verdict))
        known = {each.name: each.long_name for each in self._variables if each.name in self.features}
        if plant.fmu is not None:  # its coefficient has a unit of its own
            del known[names.LEAKAGE_COEFFICIENT]
            if plant.leakage.coefficient is not None:
                number = f"{self.features[names.LEAKAGE_COEFFICIENT]:.4g}"
                lead.append((f"leakage, {plant.leakage.coefficient}", number))
        shown = [
            (f"{name}, {title}" if "." in name else title, shown_quantity(value, value.unit or "1"))
            for name, title in known.items()
            if math.isfinite(value := self.features[name])
        ]
        features, values = zip(*lead, *shown, strict=True)
        named = Column("feature", features, is_text=True)
        return Table((named, Column("value", values, is_text=True)), title=self.title)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi simulate --json`` prints."""
        number, columns = self.features, self.columns
        mean, *external = (
            number[name].to("L/min") for name in (names.MEAN_LEAKAGE_FLOW, *names.EXTERNAL_LEAKAGE_FLOWS)
        )
        record: dict[str, Any] = plain({
            "run_id": self.run_id,
            "status": self.status,
            "message": self.message,
            "parameters": self.spec.request.shown_sections(),
            "mean_internal_leakage_L_per_min": mean,
            "internal_leakage_coefficient": number[names.LEAKAGE_COEFFICIENT],
            "detail_rms_Pa": columns[names.DETAIL_RMS][0],
            "approximation_rms_Pa": columns[names.APPROXIMATION_RMS][0],
            "mean_external_leakage_L_per_min": external,
            "verdict": self.verdict,
            "residuals": {name: number[name] for name in _RESIDUALS},
            "extremes": {each.name: number[each.name] for each in names.EXTREMES},
            "hydraulic_mode_Hz": number[names.MODE_FREQUENCY],
            "hydraulic_mode_damping_ratio": number[names.MODE_DAMPING_RATIO],
        })  # fmt: skip
        return record

    def plot(self, channels: str | Sequence[str] = (), start: float = 0.0) -> Figure:
        """The signals over time; `Figure.savefig` writes them.

        Parameters
        ----------
        channels : str or sequence of str
            Names or symbols, such as ``["P1", "x"]``; by default those that tell most.
        start : float
            First instant that is shown [s].

        Raises
        ------
        UnknownNameError
            The run has no such signal.
        ReportError
            Its signals are not stored.
        """
        from hydrofdi.report.figures.signals import draw_signals

        symbols = {channel.symbol: name for channel, name in SIGNAL_OF_CHANNEL.items()}
        wanted = [symbols.get(name, name) for name in names_of("channels", channels, "names of signals")]
        for name in wanted:
            if name not in self.signals or name == names.TIME:
                raise UnknownNameError(f"no signal {name!r}{nearest(name, [*self.signals])}")
        panels = tuple(each for each in self._variables if each.name in wanted)
        return draw_signals(self.columns, self.experiment.wavelet, self.title, panels, start)

    def save(self, path: str | PathLike[str]) -> None:
        """Store the run as an experiment file (HDF5). A healthy one is its own baseline, others have none.

        Raises
        ------
        StoreError
            The file cannot be written, or something else stands there.
        """
        require_replaceable(path_of(path))
        store_run(path_of(path), self.experiment, self.columns)

    def __bool__(self) -> bool:
        return self.status == "ok"

    def parts(self) -> list[Piece]:
        """The features."""
        return [self.table]

    def asides(self) -> Iterator[str]:
        """Warnings, and what to do about a failure or a doubt."""
        from hydrofdi.store.verdicts import REMEDIES, doubts_of

        yield from (f"warning: {warning}" for warning in self.warnings)
        if not self:
            yield f"the run failed: {self.status}: {self.message}; {REMEDIES[self.status]}"
        else:
            yield from (f"{doubt.word}: {doubt.remedy}" for doubt in doubts_of(self.verdict))

    @property
    def units(self) -> Mapping[str, str]:  # type: ignore[override]
        """Dotted parameter → the unit that the experiment is written in."""
        return self.experiment.units


def simulate(
    experiment: Experiment | None = None,
    /,
    *,
    out: str | PathLike[str] | None = None,
    **settings: Unpack[Settings],
) -> Run:
    """Simulate one actuator, as ``hydrofdi simulate`` does.

    Parameters
    ----------
    experiment : path, mapping or ExperimentConfig, optional
        YAML file, or what would stand in one; without it, the nominal actuator. Of a sweep,
        only its nominal run is simulated.
    out : path, optional
        Store the run in this experiment file (HDF5); `Run.save` does it later.
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
    >>> run.title
    'EBM 689 MPa, 0.2 L/min'
    >>> round(run.mean_internal_leakage_flow.to("L/min"), 3)
    0.2
    >>> run.time.shape == run.P1.shape == run["chamber_1_pressure"].shape
    True
    >>> hydrofdi.simulate(bulk_modulos="689 MPa")
    Traceback (most recent call last):
    hydrofdi.errors.ConfigError: bulk_modulos: unknown key; did you mean 'fluid.bulk_modulus'?
    """
    loaded = load_experiment(experiment, settings)
    if out is not None:
        require_replaceable(path_of(out))
    run = Run(loaded, *compute_run(loaded))
    if out is not None:
        run.save(out)
    return run
