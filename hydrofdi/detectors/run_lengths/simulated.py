"""Monte Carlo run lengths of any chart for independent normal scores."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.detectors.charts import Chart

CHUNK = 256


def simulated_run_lengths(
    chart: Chart[Any], limit: float, *, mean: float = 0.0, n_run: int = 1000, most: int = 10**6, seed: int = 0
) -> NDArray[np.int64]:
    """Number of scores until the first alarm, for each of many simulated runs.

    Parameters
    ----------
    chart : Chart
    limit : float
    mean : float
        Mean of the scores [standard deviations].
    n_run : int
    most : int
        Longer runs are truncated to this number.
    seed : int

    Returns
    -------
    ndarray of int, shape (n_run,)
    """
    draw = np.random.default_rng(seed)
    lengths, running, state = np.full(n_run, most), np.arange(n_run), chart.start(n_run)
    for before in range(0, most, CHUNK):
        scores = mean + draw.standard_normal((running.size, min(CHUNK, most - before)))
        state, statistic = chart.step(state, scores)
        is_alarm = statistic >= limit
        ends = is_alarm.any(axis=1)
        lengths[running[ends]] = before + 1 + is_alarm[ends].argmax(axis=1)
        running, state = running[~ends], {name: values[~ends] for name, values in state.items()}
        if not running.size:
            break
    return lengths
