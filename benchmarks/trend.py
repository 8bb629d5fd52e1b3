"""Coverage of the intervals of `hydrofdi trend`, and false trends of healthy machines.

    PYTHONPATH=. python benchmarks/trend.py [--repeats 200]

Coverage is that of 95 % intervals of histories in which a trend is found at 1 %; those in which a limit is
not reached within the length of the history count as covered if the interval is open.
"""

from __future__ import annotations

import argparse

import numpy as np

from hydrofdi.evaluation.change_point import ChangePointModel, inliers
from hydrofdi.evaluation.scores import Estimate
from tests.evaluation import wear

RATE, CONFIDENCE, LENGTHS = 0.01, 0.95, (40, 90)
"""False-alarm rate, confidence, and lengths of histories [days]."""


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--repeats", type=int, default=200)
    repeats = parser.parse_args().repeats
    print("healthy machine | days | trends stated at 1 % | at 5 %")
    for name, noise in wear.NOISES.items():
        for n_day in LENGTHS:
            p_values = np.array([
                _model_of(wear.spread(np.random.default_rng(seed), n_day, *noise))[2]
                for seed in range(repeats)
            ])  # fmt: skip
            shares = (f"{np.mean(p_values <= rate):.1%}" for rate in (RATE, 5.0 * RATE))
            print(name, n_day, *shares, sep=" | ", flush=True)
    print("\nwear | spread | days | found | onset covered | its median width [days] | limit covered | closed")
    for law in wear.LAWS:
        for noise in [*wear.NOISES][:3]:
            for n_day in LENGTHS:
                print(law, noise, n_day, *_coverage(law, noise, n_day, repeats), sep=" | ", flush=True)


def _model_of(scores: np.ndarray) -> tuple[ChangePointModel, np.ndarray, float]:
    is_in = inliers(scores)
    model = ChangePointModel(np.flatnonzero(is_in).astype(float))
    return model, scores[is_in], model.p_value(scores[is_in], 199)


def _coverage(law: str, noise: str, n_day: int, repeats: int) -> tuple[str, ...]:
    widths, n_onset, n_limit, n_closed = list[float](), 0, 0, 0
    for seed in range(repeats):
        truth = wear.worn(seed, n_day, law, noise)
        model, scores, p_value = _model_of(truth.scores)
        if p_value > RATE:
            continue
        draws = model.draws(scores)
        onset, reached = (
            Estimate.of(each, CONFIDENCE, draws.spacing) for each in (draws.onset, draws.reached(truth.limit))
        )
        widths.append(onset.high - onset.low)
        n_onset += onset.low <= truth.onset <= onset.high
        n_limit += reached.low <= truth.reached <= reached.high
        n_closed += np.isfinite(reached.high)
    n_found = len(widths)
    shares = [f"{each / max(n_found, 1):.1%}" for each in (n_onset, n_limit, n_closed)]
    return f"{n_found / repeats:.0%}", shares[0], f"{np.median(widths):.0f}", *shares[1:]


if __name__ == "__main__":
    main()
