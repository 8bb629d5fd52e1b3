"""Coverage of the stated false-alarm intervals of trained detectors.

    PYTHONPATH=. python benchmarks/stated_rates.py [--repeats 400]

Scores are normal; those of a record (first-order autoregression) or of a group (a common component) are
dependent. The true rate is that of a new window of a new record or group.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.stats import norm

from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from tests.detectors.trained.healthy import Records, autoregressive, grouped

Draw = Callable[[np.random.Generator], np.ndarray]

RECORDS = ((1, 400, 0.5), (1, 400, 0.9), (20, 20, 0.5), (20, 20, 0.9))
GROUPS = ((2, 200, 0.2), (3, 130, 0.2), (10, 40, 0.2), (10, 40, 0.5), (30, 40, 0.2), (30, 40, 0.5))
"""Number of groups, windows per group, and their correlation."""


def main() -> None:
    """Print the coverage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeats", type=int, default=400)
    repeats = parser.parse_args().repeats
    print("healthy windows | design rate | coverage of the interval | mean true rate | median upper limit")
    for n, n_window, correlation in RECORDS:
        draw: Draw = partial(autoregressive, shape=(n, n_window), correlation=correlation)
        _print(f"{n} records of {n_window}, {correlation}", draw, 0, 0.05, repeats)
    for n, n_window, correlation in GROUPS:
        draw = partial(grouped, n_group=n, n_window=n_window, correlation=correlation)
        for rate in (0.05, 0.01) if n == 30 else (0.05,):
            _print(f"{n} groups of {n_window}, {correlation}", draw, n, rate, repeats)


def _print(name: str, draw: Draw, n_group: int, rate: float, repeats: int) -> None:
    print(name, f"{rate:.0%}", *_share(draw, n_group, rate, repeats), sep=" | ", flush=True)


def _share(draw: Draw, n_group: int, rate: float, repeats: int) -> tuple[str, str, str]:
    settings = {
        "indicator": "pressure_statistics", "output": "mean", "direction": "rising",
        "false_alarm_rate": rate, "window": {"duration": 1.0},
    }  # fmt: skip
    config, groups = DetectorConfig.model_validate(settings), [f"unit {number}" for number in range(n_group)]
    held, rates, ends = 0, [], []
    for seed in range(repeats):
        records = Records(draw(np.random.default_rng(seed)), groups)
        limits = Detector.fit(records, config).file.limits
        rates.append(float(norm.sf(limits.high)))
        ends.append(limits.interval[1])
        held += limits.interval[0] <= rates[-1] <= limits.interval[1]
    return f"{held / repeats:.1%}", f"{np.mean(rates):.2%}", f"{np.median(ends):.1%}"


if __name__ == "__main__":
    main()
