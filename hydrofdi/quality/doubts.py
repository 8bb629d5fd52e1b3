"""Doubts about the numbers of a run: the words of a verdict, in one place."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from hydrofdi.quality.settling import SETTLED_CHANGE

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
        The number that decides it: a field of `RunQuality`, and the variable of result files.
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

SOUND = "ok"
"""The verdict on a run that ended well without any doubt."""


def doubts_of(verdict: str) -> tuple[Doubt, ...]:
    """The doubts that a verdict names; none for the status of a run that failed."""
    return tuple(DOUBTS[word] for word in verdict.split(", ") if word in DOUBTS)


def doubt_counts(verdicts: Iterable[str]) -> dict[str, int]:
    """Word of a doubt → number of the verdicts that name it."""
    return dict(Counter(doubt.word for verdict in verdicts for doubt in doubts_of(verdict)))


def doubt_lines(counts: Mapping[str, int]) -> list[str]:
    """A line on each doubt: number of runs, its word, and the remedy."""
    return [f"{count:,} {word}: {DOUBTS[word].remedy}" for word, count in counts.items()]
