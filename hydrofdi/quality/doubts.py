"""Doubts about simulated records, one list: what decides each, its words and its remedy; and failures."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.config.shown_values import shown_value
from hydrofdi.quality.measures import SETTLED_CHANGE

if TYPE_CHECKING:
    from hydrofdi.simulation.balances import Trajectory

Array = NDArray[np.float64]

STILL = 1e-9
"""A record whose P_1 varies by less than this share of the supply stands still: what varies is rounding."""

UNUSUAL = 0.9
"""No machine has a parameter that misses its usual range by more than this share: by a factor of ten."""

_MACHINE = ("actuator", "fluid", "supply", "valve", "friction")
"""Sections that describe a machine."""

_USUAL_DAMPING_RATIO = 0.02
"""That of the nominal actuator of the paper; real ones have 0.05 to 0.4."""


class Simulated(NamedTuple):
    """What is known of simulated records: runs, what really happened, what the sensors show of it, how much
    the details change from the last but one period to the last, and damping ratios of the hydraulic modes.
    """

    runs: Sequence[RunParameters]
    trajectory: Trajectory
    measured: Trajectory
    settling_changes: Array
    damping_ratios: Array


def _cavitating_share(known: Simulated) -> Array:
    """Share of the samples with a chamber pressure at or below the vapour limit [-]."""
    vapour = np.array([run.fluid.vapour_pressure for run in known.runs])[:, None]
    found = known.trajectory
    below = (found.chamber_1_pressure <= vapour) | (found.chamber_2_pressure <= vapour)
    return np.asarray(np.mean(below, axis=1))


def _above_supply_share(known: Simulated) -> Array:
    """Share of the samples with a chamber pressure above the supply [-]."""
    found = known.trajectory
    supply = (1.0 + 1e-9) * found.valve_supply_pressure  # at rest, a pressure is the supply
    above = (found.chamber_1_pressure > supply) | (found.chamber_2_pressure > supply)
    return np.asarray(np.mean(above, axis=1))


def _clipped_share(known: Simulated) -> Array:
    """Share of the samples of P_1 at an end of its sensor's range, or on the converter's level there [-]."""
    shares = []
    for run, shown in zip(known.runs, known.measured.chamber_1_pressure, strict=True):
        sensor = run.pressure_1_sensor
        lowest = -math.inf if sensor.lowest is None else sensor.lowest
        highest = math.inf if sensor.highest is None else sensor.highest
        # The level at an end may differ from the end by rounding.
        slack = 0.5 * sensor.resolution
        shares.append(float(np.mean((shown <= lowest + slack) | (shown >= highest - slack))))
    return np.array(shares)


def _pressure_variation(known: Simulated) -> Array:
    """Largest less least P_1, over the supply [-]."""
    supply = np.array([run.supply.pressure for run in known.runs])
    return np.asarray(np.ptp(known.trajectory.chamber_1_pressure, axis=1) / supply)


def _unusual_share(known: Simulated) -> Array:
    """By how much a parameter or the damping ratio of the mode misses its usual range: 1 less its ratio to
    the nearest end, or the inverse [-].
    """
    shares = []
    for run, damping_ratio in zip(known.runs, known.damping_ratios.tolist(), strict=True):
        share = max(0.0, 1.0 - damping_ratio / _USUAL_DAMPING_RATIO)
        for section, field, low, high in _usual_ranges():
            value = getattr(getattr(run, section), field)
            # Zero means that a part is absent.
            if isinstance(value, float) and value:
                size = abs(value)
                share = max(share, 1.0 - size / low if low else 0.0, 1.0 - high / size)
        shares.append(share)
    return np.array(shares)


@lru_cache(maxsize=1)
def _usual_ranges() -> list[tuple[str, str, float, float]]:
    """Section, field, and lowest and highest usual size of what describes a machine; what may be zero has no
    lowest."""
    ranges = []
    for name in parameter_names():
        (section, field), quantity = name.split("."), parameter_quantity(name)
        if section in _MACHINE and quantity is not None and quantity.usual is not None:
            low, high = quantity.usual_range
            ranges.append((section, field, low if quantity.above == 0.0 else 0.0, high))
    return ranges


@dataclass(frozen=True)
class Doubt:
    """A reason to read a run with care.

    Attributes
    ----------
    word : str
        Its name in a verdict.
    number : str
        The variable of result files that decides it.
    measure : callable
        Simulated records → their numbers, shape (n_run,).
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
    measure: Callable[[Simulated], Array]
    applies: Callable[[float], bool]
    mark: str
    meaning: str
    remedy: str


DOUBTS = {
    doubt.word: doubt
    for doubt in (
        Doubt(
            "cavitating", "cavitating_share", _cavitating_share, lambda share: share > 0.0, "C",
            "a chamber is at or below the vapour limit in up to {} % of the samples",
            "lower input.amplitude or load.constant_force, or raise supply.return_pressure",
        ),
        Doubt(
            "above_supply", "above_supply_share", _above_supply_share, lambda share: share > 0.0, "A",
            "a chamber is above the supply in up to {} % of the samples",
            "lower input.amplitude or actuator.mass, or raise supply.pressure",
        ),
        Doubt(
            "unsettled", "settling_change", lambda known: known.settling_changes,
            lambda change: change > SETTLED_CHANGE, "U",
            "the RMS of a detail of P_1 changes by up to {} % from the last but one period to the last",
            "lengthen record.duration by some periods; analysis.discard then leaves out the first ones",
        ),
        Doubt(
            "clipped", "clipped_share", _clipped_share, lambda share: share > 0.0, "R",
            "the sensor of P_1 is at an end of its range in up to {} % of the samples",
            "widen pressure_1_sensor.lowest and pressure_1_sensor.highest",
        ),
        Doubt(
            "still", "pressure_variation", _pressure_variation, lambda variation: variation < STILL, "S",
            "P_1 varies by no more than {} % of the supply, which is rounding",
            "raise input.amplitude, or control.amplitude in closed loop, until the valve opens",
        ),
        Doubt(
            "unusual", "unusual_share", _unusual_share, lambda share: share > UNUSUAL, "M",
            "a parameter of the machine or the damping ratio of its hydraulic mode misses its usual range"
            " by up to {} %",
            "check the units of the parameters, friction.viscous and the clearances of the valve",
        ),
    )
}  # fmt: skip
"""Word → doubt, in the order of a verdict."""

SOUND = "ok"
"""The verdict on a run that ended well without any doubt."""


def assess_runs(known: Simulated) -> dict[str, NDArray[Any]]:
    """Verdicts on runs and the numbers behind them; those that failed have NaN for numbers.

    Returns
    -------
    dict of str to ndarray, shape (n_run,)
        ``verdict``: the status of a run that failed; else ``ok``, or the words of its `DOUBTS`, joined by
        commas. And the number of each doubt.
    """
    numbers = {doubt.number: doubt.measure(known) for doubt in DOUBTS.values()}
    verdict = np.array([outcome.status for outcome in known.trajectory.outcomes], dtype=object)
    for row, outcome in enumerate(known.trajectory.outcomes):
        if outcome.is_ok:
            words = [word for word, doubt in DOUBTS.items() if doubt.applies(numbers[doubt.number][row])]
            verdict[row] = ", ".join(words) or SOUND
        else:
            for values in numbers.values():
                values[row] = np.nan
    return {"verdict": verdict} | numbers


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
    "plant_failed": "the parameters are outside what the FMU can do; 'hydrofdi why' shows what it told",
    "timeout": f"raise limits.time_per_job, or shorten record.duration; {_RETRY}",
    "killed": f"take fewer workers if memory ran out; an FMU may have crashed; {_RETRY}",
    "error": f"'hydrofdi why' shows the traceback; {_RETRY}",
}
"""Status of a run that failed → what to do about it, without a full stop, with the keys to set."""


def remedy_lines(counts: Mapping[str, int]) -> list[str]:
    """A line on each doubt and each failure that has a remedy: number of runs, its word, and the remedy."""
    remedies = {word: doubt.remedy for word, doubt in DOUBTS.items()} | REMEDIES
    return [f"{count:,} {word}: {remedies[word]}" for word, count in counts.items() if word in remedies]


_MUCH = 0.1
"""Share of the samples at the limit from which on the limit decides the motion."""

_SLACK = 1e-3
"""Relative distance from the limit that still counts as being there."""


def saturation_warning(run: RunParameters, voltage: NDArray[np.float64]) -> str:
    """A sentence if the controller is at its limit for much of a record; else empty.

    Parameters
    ----------
    voltage : ndarray, shape (n_time,)
        Input voltage [V].
    """
    limit = run.control.voltage_limit
    share = float(np.mean(np.abs(voltage) >= (1.0 - _SLACK) * limit))
    if not run.control.is_closed or share < _MUCH:
        return ""
    return (
        f"the controller is at control.voltage_limit = {shown_value('control.voltage_limit', limit)} in"
        f" {100.0 * share:.0f} % of the samples; set it to the range of your valve, or lower"
        " control.amplitude or control.proportional_gain"
    )
