"""Indicators that will have no numbers, whatever comes out of the simulation."""

from __future__ import annotations

from itertools import islice

import numpy as np

from hydrofdi.assessment.step_limits import Distinct
from hydrofdi.config.analysis import IndicatorChoice
from hydrofdi.records import RecordBatch
from hydrofdi.store.records import SIGNAL_OF_CHANNEL, drive_period

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
