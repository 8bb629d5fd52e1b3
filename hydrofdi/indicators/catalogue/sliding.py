"""Any other indicator in a sliding window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from hydrofdi.errors import ConfigError
from hydrofdi.indicators.contract import Indicator, Output, RecursiveIndicator, RecursiveOptions, Trace
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI


class SlidingOptions(RecursiveOptions):
    """Options of `Sliding`."""

    of: str = "dwt"
    """Indicator to measure in each window."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of this indicator."""

    output: str = ""
    """Output to follow, such as ``d2``; by default the first one that is a score."""

    window: Annotated[float, SI("s", above=0)] = 2.0
    """Length of the window [s], rounded to whole samples; a window ends every ``interval``."""

    @cached_property
    def made(self) -> Indicator[Any]:
        """The indicator that is measured in the windows."""
        return sound_indicator(self.of, self.options)

    @cached_property
    def followed(self) -> Output:
        """The output that is followed."""
        outputs = {each.name: each for each in self.made.outputs}
        name = self.output or next((each.name for each in self.made.outputs if each.is_score), "")
        if name not in outputs:
            raise ValueError(f"{self.of} has no output {self.output!r}{nearest(self.output, [*outputs])}")
        if outputs[name].dims:
            raise ValueError(f"{name} of {self.of} is an array; a sliding window needs a single number")
        return outputs[name]

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        try:
            assert self.followed
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"]))
            raise ValueError(f"options of {self.of}: {place}: {first['msg']}") from None
        except ConfigError as error:
            raise ValueError(str(error)) from None
        if isinstance(self.made, RecursiveIndicator):
            raise ValueError(f"{self.of} is already recursive and needs no sliding window")
        return self


class Sliding(RecursiveIndicator[SlidingOptions]):
    """An output of another indicator in a sliding window along the record, e.g. wavelets on line."""

    name = "sliding"
    version = 1
    source = "Goharrizi, Sepehri and Wu, Int. J. Fluid Power 11 (2010) 61, for the RMS of d2"
    equation = "s(t) = indicator of the samples from t − window to t"
    caution = (
        "Adjacent windows share samples, so their values are correlated. A decimated transform starts each"
        " window at a different phase unless 'interval' is a multiple of 2^levels samples."
    )
    absence = "no window has a value"
    needs_scale = False
    Options = SlidingOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """Channels of the indicator in the windows."""
        return self.options.made.channels

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """Channels of the indicator in the windows."""
        return self.options.made.optional_channels

    @property
    def estimates(self) -> tuple[Output, ...]:
        """Mean and standard deviation over the windows of a record."""
        followed, window = self.options.followed, f"windows of {self.options.window:g} s"
        return (
            Output(
                followed.name, followed.unit, f"{followed.long_name}, mean over {window}",
                direction=followed.direction,
            ),
            Output.quality(
                f"{followed.name}_spread", followed.unit,
                f"{followed.long_name}, standard deviation over {window}",
            ),
        )  # fmt: skip

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is shorter than a window, or if windows cannot be measured."""
        if records.duration < self.options.window - 1e-9:
            return f"{records.duration:g} s are too few for a window of {self.options.window:g} s"
        first = records.window(0, self._n_window(records.sampling_frequency))
        return super().obstacle(records) or self.options.made.obstacle(first)

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Measure every window that ends at a sample that is due."""
        n_window, seen = self._n_window(records.sampling_frequency), self.channels | self.optional_channels
        samples = {channel: held for channel, held in records.channels.items() if channel in seen}
        numbers = np.full((records.n_record, due.size), np.nan)
        for index in np.flatnonzero(due + 1 >= n_window).tolist():
            stop = due[index] + 1
            window = {channel: held[:, stop - n_window : stop] for channel, held in samples.items()}
            numbers[:, index] = self._measured(replace(records, channels=window, start_time=0.0))
        return {self.options.followed.name: numbers}

    def of_record(self, trace: Trace) -> Mapping[str, Array]:
        """Mean and standard deviation over the windows with a value."""
        name = self.options.followed.name
        known = np.ma.masked_invalid(trace.values[name])
        return {name: known.mean(axis=1).filled(np.nan), f"{name}_spread": known.std(axis=1).filled(np.nan)}

    def _n_window(self, sampling_frequency: float) -> int:
        return max(2, round(self.options.window * sampling_frequency))

    def _measured(self, windows: RecordBatch) -> Array:
        """Value of each window; NaN if a sample is missing."""
        held = {channel: np.ascontiguousarray(samples) for channel, samples in windows.channels.items()}
        with np.errstate(all="ignore"):
            numbers = self.options.made.measure(replace(windows, channels=held))[self.options.followed.name]
        is_whole = np.logical_and.reduce([np.isfinite(samples).all(axis=1) for samples in held.values()])
        return np.where(is_whole & np.isfinite(numbers), numbers, np.nan)
