"""Verdicts on runs: doubts in one list, with what applies, the words and the remedy of each; and failures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SETTLED_CHANGE = 1e-3
"""Periods agree where no detail's RMS differs by more than this share. It moves a δ by 0.2 points at most."""

STILL = 1e-9
"""A record whose P_1 varies by less than this share of the supply stands still: what varies is rounding."""

UNUSUAL = 0.9
"""No machine has a parameter that misses its usual range by more than this share: by a factor of ten."""


@dataclass(frozen=True)
class Doubt:
    """A reason to read a run with care.

    Attributes
    ----------
    word : str
        Its name in a verdict.
    number : str
        The variable of result files that decides it.
    applies : callable
        Number → whether the doubt is there; false for NaN.
    mark : str
        What stands at rows of tables.
    meaning : str
        A sentence with a place for the number in percent.
    remedy : str
        What to do about it: a sentence without its full stop, with the keys to set.
    """

    word: str
    number: str
    applies: Callable[[float], bool]
    mark: str
    meaning: str
    remedy: str


DOUBTS = {
    doubt.word: doubt
    for doubt in (
        Doubt(
            "cavitating", "cavitating_share", lambda share: share > 0.0, "C",
            "a chamber is at or below the vapour limit in up to {} % of the samples",
            "lower input.amplitude or load.constant_force, or raise supply.return_pressure",
        ),
        Doubt(
            "above_supply", "above_supply_share", lambda share: share > 0.0, "A",
            "a chamber is above the supply in up to {} % of the samples",
            "lower input.amplitude or actuator.mass, or raise supply.pressure",
        ),
        Doubt(
            "unsettled", "settling_change", lambda change: change > SETTLED_CHANGE, "U",
            "the RMS of a detail of P_1 changes by up to {} % from the last but one period to the last",
            "lengthen record.duration by some periods; analysis.discard then leaves out the first ones",
        ),
        Doubt(
            "clipped", "clipped_share", lambda share: share > 0.0, "R",
            "the sensor of P_1 is at an end of its range in up to {} % of the samples",
            "widen pressure_1_sensor.lowest and pressure_1_sensor.highest",
        ),
        Doubt(
            "still", "pressure_variation", lambda variation: variation < STILL, "S",
            "P_1 varies by no more than {} % of the supply, which is rounding",
            "raise input.amplitude, or control.amplitude in closed loop, until the valve opens",
        ),
        Doubt(
            "unusual", "unusual_share", lambda share: share > UNUSUAL, "M",
            "a parameter of the machine or the damping ratio of its hydraulic mode misses its usual range"
            " by up to {} %",
            "check the units of the parameters, friction.viscous and the clearances of the valve",
        ),
    )
}  # fmt: skip
"""Word → doubt, in the order of a verdict."""


def verdicts_of(statuses: Sequence[str], numbers: Mapping[str, NDArray[np.float64]]) -> list[str]:
    """The status of each run that failed; else ``ok``, or the words of its `DOUBTS`, joined by commas.

    Parameters
    ----------
    numbers : mapping of str to ndarray, shape (n_run,)
        The number of each doubt.
    """
    verdicts = []
    for row, status in enumerate(statuses):
        words = [word for word, doubt in DOUBTS.items() if doubt.applies(numbers[doubt.number][row])]
        verdicts.append(", ".join(words) or status if status == "ok" else status)
    return verdicts


def doubts_of(verdict: str) -> tuple[Doubt, ...]:
    """The doubts that a verdict names; none for the status of a run that failed."""
    return tuple(DOUBTS[word] for word in verdict.split(", ") if word in DOUBTS)


def doubt_counts(verdicts: Iterable[str]) -> dict[str, int]:
    """Word of a doubt → number of the verdicts that name it."""
    return dict(Counter(doubt.word for verdict in verdicts for doubt in doubts_of(verdict)))


_RETRY = "a sweep with retry_failed computes it again"

REMEDIES = {
    "diverged": "shorten record.step; 'hydrofdi check' names the longest step that is stable",
    "stroke_exceeded": (
        "lower input.amplitude or input.period, correct actuator.stroke or actuator.chamber_volume, or set"
        " actuator.end_stops: elastic"
    ),
    "unreachable_leakage": "lower leakage.internal_flow; 'hydrofdi calibrate' shows what a flow takes",
    "plant_failed": "see what the FMU told; check its parameters, its licence, and record.step",
    "timeout": f"raise limits.time_per_job, or shorten record.duration; {_RETRY}",
    "killed": f"an FMU crashed, or memory ran out: take fewer workers then; {_RETRY}",
    "error": f"'hydrofdi why' shows the traceback; {_RETRY}",
}
"""Status of a run that failed → what to do about it, without a full stop, with the keys to set."""


def remedy_lines(counts: Mapping[str, int]) -> list[str]:
    """A line on each doubt and each failure that has a remedy: number of runs, its word, and the remedy."""
    remedies = {word: doubt.remedy for word, doubt in DOUBTS.items()} | REMEDIES
    return [f"{count:,} {word}: {remedies[word]}" for word, count in counts.items() if word in remedies]
