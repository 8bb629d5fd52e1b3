"""Statistics of the samples of a pressure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch


class PressureStatistics(SingleChannelIndicator[ChannelOptions]):
    """Mean, standard deviation, increments, kurtosis, crest factor and peak to peak of a channel."""

    name = "pressure_statistics"
    version = 1
    source = "Dyer and Stewart, J. Mech. Des. 100 (1978) 229: kurtosis for condition monitoring"
    equation = "x = P − mean; s² = mean(x²); kurtosis = mean(x⁴)/s⁴; crest = max abs(x)/s"
    Options = ChannelOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Outputs in the unit of the channel, or dimensionless."""
        return (
            Output("mean", self.unit, "mean"),
            Output("standard_deviation", self.unit, "standard deviation"),
            Output("increments", self.unit, "standard deviation of the differences between adjacent samples"),
            Output("kurtosis", "1", "kurtosis: 3 for a normal distribution, 1 for a square wave"),
            Output("crest_factor", "1", "largest deviation from the mean over the standard deviation"),
            Output("peak_to_peak", self.unit, "largest minus smallest sample"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record has only one sample."""
        return "statistics need at least two samples" if records.n_time < 2 else None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); kurtosis and crest factor are NaN if the signal is constant."""
        signal = self.signal(records)
        moved = signal - signal[:, :1]
        offset = moved.mean(axis=1)
        increments = np.diff(moved, axis=1)
        moved -= offset[:, None]
        square = np.square(moved)
        variance = square.mean(axis=1)
        deviation, low, high = np.sqrt(variance), moved.min(axis=1), moved.max(axis=1)
        increments -= increments.mean(axis=1)[:, None]
        return {
            "mean": signal[:, 0] + offset,
            "standard_deviation": deviation,
            "increments": np.sqrt(np.mean(np.square(increments), axis=1)),
            "kurtosis": np.mean(np.square(square), axis=1) / variance**2,
            "crest_factor": np.maximum(-low, high) / deviation,
            "peak_to_peak": high - low,
        }
