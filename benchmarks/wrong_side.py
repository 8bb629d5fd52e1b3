"""Machines with wrong signs or swapped pressures, and healthy machines that look like these.

    python benchmarks/wrong_side.py [--duration '6 s']

Machines are those of configs/populations/unknown-plant.yaml in closed loop; each gives one window. Each
indicator is trained on 300 of them. First: how many of 1,000 others, and of 200 in each of two shifts, are
novel because of their score or a quantity that is not positive. Then: how many of 250 machines that leak
0.5 L/min are called healthy, as they are and with a mistake in their records. Two seeds each.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import hydrofdi
from hydrofdi.api.sources import Described, open_records
from hydrofdi.records import Array, Channel

CONFIGS = Path(__file__).parent.parent / "configs"

SHIFTS = {"oil 827 MPa": {"fluid.bulk_modulus": "827 MPa"}, "supply 15 MPa": {"supply.pressure": "15 MPa"}}

N_FIRST, N_TEST, N_SHIFT = 2, 1000, 200
"""Machines of the populations that are judged, in this order; the first are not counted."""

SIZES = (N_TEST, *(N_SHIFT for _ in SHIFTS))

LEAK = "0.5 L/min"

P1, P2, X, U = (Channel(name) for name in ("P1", "P2", "x", "u"))

Signals = dict[Channel, Array]

MISTAKES: dict[str, Callable[[Signals], Signals]] = {
    "as they are": lambda of: of,
    "x reversed": lambda of: of | {X: -of[X]},
    "u reversed": lambda of: of | {U: -of[U]},
    "P1, P2 swapped": lambda of: of | {P1: of[P2], P2: of[P1]},
}

DETECTORS: dict[str, dict[str, Any]] = {
    "flow_balance": {"indicator": {"flow_balance": {"spool": "command"}}},
    "weak_rls": {"indicator": {"weak_rls": {"spool": "command"}}},
    "pressure_balance": {"indicator": {"pressure_balance": {"spool": "command"}}},
    "standard deviation of P1": {
        "indicator": "pressure_statistics", "output": "standard_deviation", "direction": "rising",
    },
}  # fmt: skip


def main() -> None:
    """Print the counts: healthy machines that are novel, then leaking machines that are called healthy."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--duration", default="6 s")
    duration = parser.parse_args().duration
    print(f"{'':25} seed", *(f"{title:>15}" for title in ("other machines", *SHIFTS, *MISTAKES)))
    with TemporaryDirectory() as folder:
        for seed in (10, 11):
            learned = written(Path(folder, "learned.yaml"), seed, duration, fit=300, test=2)
            others = written(Path(folder, "others.yaml"), seed + 100, duration, fit=N_FIRST, test=N_TEST)
            leaking = written(Path(folder, "leaking.yaml"), seed + 200, duration, fit=2, test=2)
            leaking.write_text(
                f"{leaking.read_text()}  faults: {{leakage.internal_flow: [{LEAK}], each: {N_SHIFT}}}\n"
            )
            for name, options in DETECTORS.items():
                detector = hydrofdi.train(learned, false_alarm_rate="1 %", **options)
                counts = zip(novel(detector, others), SIZES, strict=True)
                texts = [f"{count} of {size:,}" for count, size in counts]
                texts += called_healthy(detector, leaking)
                print(f"{name:25} {seed:4}", *(f"{text:>15}" for text in texts), flush=True)


def novel(detector: hydrofdi.Detector, others: Path) -> list[int]:
    """Number of windows that are novel in this way: other machines, then each shift."""
    reasons = detector.judge(others).to_pandas()["reason"]
    is_novel = reasons.str.contains("is a sign wrong", na=False).to_numpy()[N_FIRST:]
    return [int(part.sum()) for part in np.split(is_novel, np.cumsum(SIZES)[:-1])]


def called_healthy(detector: hydrofdi.Detector, leaking: Path) -> list[str]:
    """How many leaking machines are called healthy with each mistake."""
    (source,) = open_records(leaking, frozenset({P1, P2, X, U}), Described())
    batches = [
        batch.rows([row for row, label in enumerate(batch.labels) if label.startswith(LEAK)])
        for batch in source.batches(labels=True)
    ]
    signals = {channel: np.vstack([batch[channel] for batch in batches]) for channel in (P1, P2, X, U)}
    texts = []
    for mistaken in MISTAKES.values():
        columns = {channel.value: samples for channel, samples in mistaken(signals).items()}
        found = detector.judge(columns, sampling_frequency=batches[0].sampling_frequency).to_pandas()
        is_healthy = [alarm is not None and not alarm for alarm in found["alarm"]]
        texts.append(f"{sum(is_healthy)} of {len(is_healthy)}")
    return texts


def written(path: Path, seed: int, duration: str, *, fit: int, test: int) -> Path:
    """A study of machines of the population in a file."""
    shifts = "".join(f"\n    {title}: {changes}" for title, changes in SHIFTS.items())
    path.write_text(
        f"extends: [{CONFIGS}/populations/unknown-plant.yaml, {CONFIGS}/motions/closed-loop.yaml]\n"
        "name: wrong_side\n"
        f"record: {{duration: {duration}}}\n"
        "study:\n"
        f"  population: {{seed: {seed}}}\n"
        f"  healthy: {{fit: {fit}, test: {test}, shift: {N_SHIFT}}}\n"
        f"  shifts:{shifts}\n"
    )
    return path


if __name__ == "__main__":
    main()
