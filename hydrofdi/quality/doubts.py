"""Words of verdicts on runs: doubts, failures, and their remedies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.drive import is_whole
from hydrofdi.config.shown_values import shown_value
from hydrofdi.transforms.configuration import WaveletConfig
from hydrofdi.transforms.undecimated import undecimated_rms

SETTLED_CHANGE = 1e-3
"""Periods agree where no detail's RMS differs by more than this share. It moves a δ by 0.2 points at most."""

LEAST_DETAIL = 1e-9
"""A detail's RMS below this share of the supply pressure is rounding and counts as this much."""


@dataclass(frozen=True)
class Settling:
    """How a record settles.

    Attributes
    ----------
    change : float
        Largest relative change of the RMS of a detail from the last but one period to the last [-]; NaN where
        the record does not contain two whole periods.
    start : int or None
        First sample of the whole periods that agree with the last one, of which there are two at least; None
        if there are none.
    """

    change: float
    start: int | None


UNKNOWN = Settling(math.nan, None)

_WAVELET = WaveletConfig()


def settled_start(run: RunParameters, n_period: int, settled_from: float, n_discarded: int) -> int:
    """First sample of the settled periods that an analysis may take; the record's end where two are not left.

    Parameters
    ----------
    n_period : int
        Samples of a period.
    settled_from : float
        Start of all settled periods [s]; NaN if there are none.
    n_discarded : int
        Samples that the analysis leaves out.
    """
    record = run.record
    if math.isnan(settled_from):
        return record.n_sample
    first = max(round(settled_from * record.sampling_frequency), n_discarded)
    # Whole periods, counted from the end of the record.
    n_whole = (record.n_sample - first) // n_period
    return record.n_sample - n_whole * n_period if n_whole > 1 else record.n_sample


def how_records_settle(runs: Sequence[RunParameters], pressure: NDArray[np.float64]) -> list[Settling]:
    """How the details of each run settle.

    Each period is taken as a circle, so that a drift from its start to its end shows as well. Periods are
    counted from the end of the record. The details are those of the paper's wavelet, whatever a record is
    analysed with.

    Parameters
    ----------
    pressure : ndarray, shape (n_run, n_time)
        Chamber-1 pressure as it really is [Pa].
    """
    settlings = [UNKNOWN] * len(runs)
    together: dict[int, list[int]] = {}
    for row, run in enumerate(runs):
        n_period = samples_per_period(run)
        if n_period is not None and pressure.shape[1] >= 2 * n_period:
            together.setdefault(n_period, []).append(row)
    for n_period, rows in together.items():
        n_whole = pressure.shape[1] // n_period
        periods = pressure[rows, -n_whole * n_period :].reshape(len(rows), n_whole, n_period)
        for row, rms in zip(rows, undecimated_rms(periods, _WAVELET).detail, strict=True):
            settlings[row] = _settling(
                rms, LEAST_DETAIL * runs[row].supply.pressure, n_period, pressure.shape[1]
            )
    return settlings


def samples_per_period(run: RunParameters) -> int | None:
    """Samples of a period of all that acts on the actuator; None if there is none, or no whole number."""
    samples = run.input.period * run.record.sampling_frequency
    return round(samples) if run.is_periodic and is_whole(samples) else None


def _settling(rms: NDArray[np.float64], least: float, n_period: int, n_sample: int) -> Settling:
    """Settling from the RMS of details of each whole period, shape (n_whole, n_level)."""
    rms, n_whole = np.maximum(rms, least), len(rms)
    changes = np.abs(rms / rms[-1] - 1.0).max(axis=1)
    # Negated, so that NaN counts as unsettled.
    unsettled = np.flatnonzero(~(changes <= SETTLED_CHANGE))
    first = int(unsettled[-1]) + 1 if unsettled.size else 0
    # At least two periods agree: the last one always does with itself.
    start = n_sample - (n_whole - first) * n_period if first < n_whole - 1 else None
    return Settling(float(changes[-2]), start)


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


_RETRY = "a sweep with retry_failed computes it again"

REMEDIES = {
    "diverged": "shorten record.step; 'hydrofdi check' names the longest step that is stable",
    "stroke_exceeded": (
        "lower input.amplitude or input.period, correct actuator.stroke or actuator.chamber_volume, or set"
        " actuator.end_stops: elastic"
    ),
    "unreachable_leakage": "lower leakage.internal_flow; 'hydrofdi calibrate' shows what a flow takes",
    "timeout": f"raise limits.time_per_job, or shorten record.duration; {_RETRY}",
    "killed": f"take fewer workers if memory ran out; {_RETRY}",
    "error": f"'hydrofdi why' shows the traceback; {_RETRY}",
}
"""Status of a run that failed → what to do about it, without a full stop, with the keys to set."""


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
