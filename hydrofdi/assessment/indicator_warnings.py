"""Indicators that will have no numbers, or that assume another machine than the simulated one."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import isclose

import numpy as np

from hydrofdi.assessment.step_limits import Distinct
from hydrofdi.config.analysis import IndicatorChoice
from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.request import parameter_names
from hydrofdi.config.shown_values import shown_parameter
from hydrofdi.indicators.plant_constants import plant_constants
from hydrofdi.records import RecordBatch
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.readable import typeset
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period

_PLANT = ("actuator", "fluid", "valve")
"""Sections whose parameters have the names of the constants."""

MOST_RECORDS = 200
"""Kinds of records that are looked at; sweeps have few, and a drawn period would make one for each run."""


def indicator_warnings(distinct: Distinct, choice: IndicatorChoice) -> list[str]:
    """A sentence on each indicator that cannot measure the records of some runs, and why.

    Parameters
    ----------
    distinct : callable
        Gives one run for each combination of sections that occurs, such as ``Runs.distinct``.
    choice : IndicatorChoice
        The indicators of the experiment.
    """
    records = dict.fromkeys(
        (
            run.n_kept,
            run.record.sampling_frequency,
            drive_period(run.input, run.load.random_force),
            run.wavelet,
        )
        for run in distinct("input", "load", "record", "analysis", "wavelet")
    )
    sentences: list[str] = []
    for n_kept, frequency, period, wavelet in islice(records, MOST_RECORDS):
        signals = dict.fromkeys(SIGNAL_OF_CHANNEL, np.broadcast_to(0.0, (1, n_kept)))
        batch = RecordBatch(signals, frequency, ("",), drive_period=period)
        obstacles = {label: each.obstacle(batch) for label, each in choice.made(wavelet).items()}
        sentences += [f"{label} will have no results: {text}" for label, text in obstacles.items() if text]
    return list(dict.fromkeys(sentences))


def other_machine_warnings(experiment: ExperimentConfig) -> list[str]:
    """A sentence on each indicator whose constants of the plant are not those of the nominal machine."""
    made = experiment.indicator_choice.made(experiment.wavelet)
    texts = {label: ", ".join(_differing(experiment, each.options)) for label, each in made.items()}
    labels: dict[str, list[str]] = {}
    for label, text in texts.items():
        labels.setdefault(text, []).append(label)
    return [
        f"{', '.join(of)}: the options describe another machine: {text}; a YAML alias such as *area keeps the"
        " value of the file in which it stands"
        for text, of in labels.items()
        if text
    ]


def _differing(experiment: ExperimentConfig, options: Section) -> Iterator[str]:
    """Constants of an indicator that differ from the parameters of the same meaning."""
    nominal = experiment.nominal_parameters
    for constant, parameter in _parameters(options).items():
        assumed, simulated = getattr(options, constant), nominal.value(parameter)
        if simulated is not None and not isclose(assumed, simulated, rel_tol=1e-3):
            shown = shown_parameter(parameter, [assumed, simulated])
            unit = "" if shown.unit == "1" else f" {typeset(shown.unit)}"
            yield f"{constant} {shown.text(assumed)}{unit}, but {parameter} {shown.text(simulated)}{unit}"


def _parameters(options: Section) -> dict[str, str]:
    """Constant of the plant → parameter of the same meaning."""
    known = {*parameter_names()}
    own = {name: [f"{section}.{name}" for section in _PLANT] for name in plant_constants(options)}
    own |= {name: ["supply.pressure"] for name in own if name == "supply_pressure"}
    return {name: place for name, places in own.items() for place in places if place in known}
