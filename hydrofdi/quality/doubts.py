"""What simulated records are worth: how they settle, features of what has settled, and doubts in one list:
what decides each, its words and its remedy; and failures."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi import transforms as undecimated
from hydrofdi.config import RunParameters
from hydrofdi.config.drive import is_whole
from hydrofdi.config.experiment import Analysis
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.config.values import shown_value
from hydrofdi.transforms import WaveletConfig, n_phase, root_mean_square

if TYPE_CHECKING:
    from hydrofdi.simulation.balances import Trajectory

Array = NDArray[np.float64]

SETTLED_CHANGE = 1e-3
"""Periods agree where no detail's RMS differs by more than this share. It moves a δ by 0.2 points at most."""

LEAST_DETAIL = 1e-9
"""A detail's RMS below this share of the supply pressure is rounding and counts as this much."""

_WAVELET = WaveletConfig()


def how_records_settle(runs: Sequence[RunParameters], pressure: Array) -> tuple[Array, Array]:
    """How the details of each run settle.

    Each period is taken as a circle, so that a drift from its start to its end shows as well. Periods are
    counted from the end of the record. The details are those of the paper's wavelet, whatever a record is
    analysed with.

    Parameters
    ----------
    pressure : ndarray, shape (n_run, n_time)
        Chamber-1 pressure as it really is [Pa].

    Returns
    -------
    changes : ndarray, shape (n_run,)
        Largest relative change of the RMS of a detail from the last but one period to the last [-]; NaN where
        the record does not contain two whole periods.
    settled_from : ndarray, shape (n_run,)
        Start of the whole periods that agree with the last one, of which there are two at least [s]; NaN if
        there are none.
    """
    changes, settled_from = np.full((2, len(runs)), np.nan)
    together: dict[int, list[int]] = {}
    n_sample = pressure.shape[1]
    for row, run in enumerate(runs):
        n_period = samples_per_period(run)
        if n_period is not None and n_sample >= 2 * n_period:
            together.setdefault(n_period, []).append(row)
    for n_period, rows in together.items():
        n_whole = n_sample // n_period
        periods = pressure[rows, -n_whole * n_period :].reshape(len(rows), n_whole, n_period)
        for row, rms in zip(rows, undecimated.undecimated_rms(periods, _WAVELET).detail, strict=True):
            rms = np.maximum(rms, LEAST_DETAIL * runs[row].supply.pressure)
            different = np.abs(rms / rms[-1] - 1.0).max(axis=1)
            changes[row] = different[-2]
            # Negated, so that NaN counts as unsettled.
            unsettled = np.flatnonzero(~(different <= SETTLED_CHANGE))
            first = int(unsettled[-1]) + 1 if unsettled.size else 0
            # At least two periods agree: the last one always does with itself.
            if first < n_whole - 1:
                start = n_sample - (n_whole - first) * n_period
                settled_from[row] = start / runs[row].record.sampling_frequency
    return changes, settled_from


def samples_per_period(run: RunParameters) -> int | None:
    """Samples of a period of all that acts on the actuator; None if there is none, or no whole number."""
    samples = run.input.period * run.record.sampling_frequency
    return round(samples) if run.is_periodic and is_whole(samples) else None


def pressure_features(
    runs: Sequence[RunParameters], analysis: Analysis, pressure: Array, settled_from: Array
) -> dict[str, Array]:
    """What is measured of chamber-1 pressures with the knowledge of when they settled.

    The mean is that of what ``analysis.discard`` leaves. Features of the settled record are undecimated and
    free of boundaries: whole periods are taken as a circle; a record without a period is taken from what is
    left out on, less the coefficients that look back beyond that.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
        All with the same duration and sampling frequency.
    analysis : Analysis
        What is left out, and the wavelet.
    pressure : ndarray, shape (n_run, n_time)
        As the sensor shows it [Pa].
    settled_from : ndarray, shape (n_run,)
        Start of the settled periods [s]; NaN if there are none.

    Returns
    -------
    dict
        ``mean_chamber_1_pressure`` (n_run,); ``settled_detail_rms`` and ``settled_approximation_rms``
        (n_run, n_level); where ``wavelet.phase`` is ``all`` also ``settled_phase_detail_rms``
        (n_run, n_phase, n_level). All in Pa; settled ones are NaN for periodic records that have not settled.
    """
    n_run, wavelet, n_sample = len(runs), analysis.wavelet, pressure.shape[1]
    names = "settled_detail_rms", "settled_approximation_rms"
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(names, (wavelet.levels,))
    if wavelet.phase == "all":
        shapes["settled_phase_detail_rms"] = (n_phase(wavelet.levels), wavelet.levels)
    features = {name: np.full((n_run, *shape), np.nan) for name, shape in shapes.items()}
    windows: dict[tuple[int, bool], list[int]] = {}
    for row, (run, settled) in enumerate(zip(runs, settled_from.tolist(), strict=True)):
        n_period, start = samples_per_period(run), analysis.n_discarded
        if n_period is not None:
            # Whole periods, counted from the end of the record, of which there are two at least.
            first = n_sample if math.isnan(settled) else round(settled * run.record.sampling_frequency)
            n_whole = (n_sample - max(first, start)) // n_period
            start = n_sample - n_whole * n_period if n_whole > 1 else n_sample
        windows.setdefault((start, n_period is not None), []).append(row)
    for (start, is_circular), rows in windows.items():
        if start < n_sample:
            part = _settled(wavelet, pressure[rows, start:], start - analysis.n_discarded, is_circular)
            for name, values in part.items():
                features[name][rows] = values
    return {"mean_chamber_1_pressure": np.mean(pressure[:, analysis.n_discarded :], axis=1)} | features


def _settled(
    wavelet: WaveletConfig, records: Array, first_sample: int, is_circular: bool
) -> dict[str, Array]:
    outside = 0 if is_circular else undecimated.boundary_length(wavelet)
    if is_circular:
        rms = undecimated.undecimated_rms(records, wavelet)
        features = {"settled_detail_rms": rms.detail, "settled_approximation_rms": rms.approximation}
    else:
        parts = undecimated.undecimated_coefficients(records, wavelet)
        names = ("settled_detail_rms", "settled_approximation_rms")
        features = {n: root_mean_square(part[..., outside:]) for n, part in zip(names, parts, strict=True)}
    if wavelet.phase == "all":
        details, _ = undecimated.undecimated_coefficients(records, wavelet)
        phases = undecimated.phase_detail_rms(details[..., outside:], first_sample + outside)
        features["settled_phase_detail_rms"] = phases
    return features


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
    signals = known.trajectory
    below = (signals.chamber_1_pressure <= vapour) | (signals.chamber_2_pressure <= vapour)
    return np.asarray(np.mean(below, axis=1))


def _above_supply_share(known: Simulated) -> Array:
    """Share of the samples with a chamber pressure above the supply [-]."""
    signals = known.trajectory
    supply = (1.0 + 1e-9) * signals.valve_supply_pressure  # at rest, a pressure is the supply
    above = (signals.chamber_1_pressure > supply) | (signals.chamber_2_pressure > supply)
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
