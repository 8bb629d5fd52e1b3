"""Sampling of a record: its frequency, and irregularities of its instants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import INFERRED_SAMPLING, Array
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.settings.counting import counted

Key = TypeVar("Key")

_GAP = 1.75
"""Longest step between samples without a gap, in median steps."""
_DIGITS = 9
_REMEDY = "; give 'sampling_frequency' in place of 'time'"
_FEWER = 0.99
_MOST_SAMPLES = 2**28


@dataclass(frozen=True)
class Sampling:
    """Even sampling.

    Attributes
    ----------
    frequency : float
        [Hz].
    start : float
        Instant of the first sample [s].
    """

    frequency: float
    start: float = 0.0


def counts_samples(values: Array) -> bool:
    """Whether a column rises by one from sample to sample: a counter, if it has no unit."""
    return values.size > 1 and bool(np.all(np.diff(values) == 1.0))


def given_sampling(config: MeasuredConfig) -> tuple[Sampling, tuple[Issue, ...]]:
    """The sampling that a description states."""
    assert config.sampling_frequency is not None
    sampling = Sampling(config.sampling_frequency)
    if config.sampling_frequency_is == "given":
        return sampling, ()
    text = f"the sampling frequency of {sampling.frequency:g} Hz is inferred, not documented"
    return sampling, (Issue(text, kind=INFERRED_SAMPLING),)


def sampling_of_times(times: Array, config: MeasuredConfig) -> tuple[Sampling, tuple[Issue, ...]]:
    """The sampling of instants, and remarks on gaps and uneven steps.

    Parameters
    ----------
    times : ndarray, shape (n_time,)
        [s].
    config : MeasuredConfig

    Raises
    ------
    RejectionError
        Some are missing, or they do not increase.
    """
    steps = np.diff(times)
    if not np.all(np.isfinite(times)):
        raise RejectionError(
            "time", f"{np.count_nonzero(~np.isfinite(times))} sampling instants are missing{_REMEDY}"
        )
    if np.any(steps < 0.0):
        row = int(np.flatnonzero(steps < 0.0)[0]) + 2
        raise RejectionError("time", f"the rows are not in order of time at sample {row}; sort them")
    if np.any(steps == 0.0):
        row = int(np.flatnonzero(steps == 0.0)[0]) + 2
        raise RejectionError("time", f"time does not increase at sample {row}{_REMEDY}")
    typical = float(np.median(steps))
    step = typical if np.any(steps > _GAP * typical) else (times[-1] - times[0]) / (times.size - 1)
    frequency = float(f"{1.0 / step:.{_DIGITS}g}")
    if not 0.0 < frequency < np.inf:
        raise RejectionError("time", f"time goes from {times[0]:g} s to {times[-1]:g} s")
    return Sampling(frequency, float(times[0])), tuple(_unevenness(times, steps, config))


def _unevenness(times: Array, steps: Array, config: MeasuredConfig) -> list[Issue]:
    typical = float(np.median(steps))
    gaps = int(np.count_nonzero(steps > _GAP * typical))
    asked = "" if config.resample is None else f"; interpolated at {config.resample:g} Hz"
    if gaps:
        longest = float(steps.max())
        text = f"{counted(gaps, 'gap')} in time, the longest {longest:.3g} s{asked}"
        return [Issue(text, kind="gap", is_unusable=config.resample is None)]
    even = np.linspace(times[0], times[-1], times.size)
    deviation = float(np.max(np.abs(times - even))) / typical
    if deviation <= config.limits.uneven:
        return []
    text = f"sampling is uneven: up to {deviation:.0%} of a step from even{asked}"
    return [Issue(text, kind="uneven")]


def folding(sampling: Sampling, frequency: float) -> tuple[Issue, ...]:
    """A remark if resampling reduces the sampling frequency."""
    if frequency > _FEWER * sampling.frequency:
        return ()
    text = (
        f"resampled from {sampling.frequency:g} Hz to {frequency:g} Hz without a filter:"
        f" frequencies above {frequency / 2:g} Hz are aliased"
    )
    return (Issue(text, kind="folded"),)


def resampled(
    channels: dict[Key, Array], times: Array, frequency: float
) -> tuple[dict[Key, Array], Sampling]:
    """Channels interpolated linearly at even instants.

    Raises
    ------
    RejectionError
        There would be too many samples.
    """
    n_time = int(np.floor((times[-1] - times[0]) * frequency * (1.0 + 1e-12))) + 1
    if n_time > _MOST_SAMPLES:
        raise RejectionError("long", f"would have {counted(n_time, 'sample')} at {frequency:g} Hz")
    instants = times[0] + np.arange(n_time) / frequency
    return (
        {key: np.interp(instants, times, samples) for key, samples in channels.items()},
        Sampling(frequency, float(times[0])),
    )
