"""Number of healthy machines whose score is novel because it is far out on the side without an alarm.

    python benchmarks/wrong_side.py [--duration '6 s']

Machines are those of configs/populations/unknown-plant.yaml in closed loop; each gives one window. Each
indicator is trained on 300 of them, and judges 1,000 others and 200 in each of two shifts. Two seeds each.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import hydrofdi

CONFIGS = Path(__file__).parent.parent / "configs"

SHIFTS = {
    "oil 827 MPa": {"fluid.bulk_modulus": "827 MPa"},
    "supply 15 MPa": {"supply.pressure": "15 MPa"},
}

N_FIRST, N_TEST, N_SHIFT = 2, 1000, 200
"""Machines of the populations that are judged, in this order; the first are not counted."""

SIZES = (N_TEST, *(N_SHIFT for _ in SHIFTS))

DETECTORS: dict[str, dict[str, Any]] = {
    "flow_balance": {"indicator": {"flow_balance": {"spool": "command"}}},
    "weak_rls": {"indicator": {"weak_rls": {"spool": "command"}}},
    "pressure_balance": {"indicator": {"pressure_balance": {"spool": "command"}}},
    "standard deviation of P1": {
        "indicator": "pressure_statistics", "output": "standard_deviation", "direction": "rising",
    },
}  # fmt: skip


def main() -> None:
    """Print the counts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--duration", default="6 s")
    duration = parser.parse_args().duration
    print(f"{'':25} seed", *(f"{title:>15}" for title in ("other machines", *SHIFTS)))
    with TemporaryDirectory() as folder:
        for seed in (10, 11):
            learned = written(Path(folder, "learned.yaml"), seed, duration, fit=300, test=2)
            others = written(Path(folder, "others.yaml"), seed + 100, duration, fit=N_FIRST, test=N_TEST)
            for name, options in DETECTORS.items():
                counts = far_out(hydrofdi.train(learned, false_alarm_rate="1 %", **options), others)
                texts = [f"{count} of {size:,}" for count, size in zip(counts, SIZES, strict=True)]
                print(f"{name:25} {seed:4}", *(f"{text:>15}" for text in texts), flush=True)


def far_out(detector: hydrofdi.Detector, others: Path) -> list[int]:
    """Number of windows with such a score: other machines, then each shift."""
    reasons = detector.judge(others).to_pandas()["reason"]
    is_far = reasons.str.contains("all healthy scores", na=False).to_numpy()[N_FIRST:]
    return [int(part.sum()) for part in np.split(is_far, np.cumsum(SIZES)[:-1])]


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
