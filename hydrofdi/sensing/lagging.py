"""Signals with lags, evaluated at every step of the solver and then sampled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.sensing.channels import CHANNELS, CLOCK, random_generator
from hydrofdi.sensing.dynamics import LagLanes
from hydrofdi.sensing.sampling import Clocks, sampling_instants
from hydrofdi.simulation.inputs import SignalByName


class LaggedRuns:
    """Lags of several runs in parallel: reads their signals at every solver step and samples the outputs.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        Runs with the same ``run`` section.

    Attributes
    ----------
    samples : dict of Channel to ndarray, shape (n_run, n_time)
        Samples of the channels that have a lag in any run, in the units of their signals.
    """

    def __init__(self, runs: Sequence[RunParameters]) -> None:
        lags = {channel: [channel.lags(run) for run in runs] for channel in CHANNELS}
        self._lanes = {channel: LagLanes(of_runs) for channel, of_runs in lags.items() if any(of_runs)}
        self._clocks = _clocks(runs)
        self.samples = {channel: np.zeros((len(runs), runs[0].record.n_sample)) for channel in self._lanes}

    def __call__(self, first_step: int, signal: SignalByName) -> None:
        """Process the signals of consecutive steps, starting at step `first_step`."""
        for channel, samples in self.samples.items():
            values = np.array(signal(channel.signal)[:, : len(samples)], order="C")
            self._lanes[channel].advance(values)
            self._clocks.sample(values, first_step, samples)


def _clocks(runs: Sequence[RunParameters]) -> Clocks:
    record = runs[0].record
    time = np.arange(record.n_sample) / record.sampling_frequency
    deviations = np.zeros((len(runs), record.n_sample))
    for lane, parameters in enumerate(runs):
        if jitter := parameters.measurement.jitter:
            deviations[lane] = sampling_instants(time, jitter, random_generator(parameters, CLOCK)) - time
    return Clocks(record, deviations)
