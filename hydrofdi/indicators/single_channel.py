"""Indicators of one channel."""

from __future__ import annotations

from typing import TypeVar

from hydrofdi.indicators.contract import Indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import Section


class ChannelOptions(Section):
    """Options of an indicator of one channel."""

    channel: Channel = Channel.CHAMBER_1_PRESSURE
    """Channel to measure."""


ChosenChannel = TypeVar("ChosenChannel", bound=ChannelOptions)


class SingleChannelIndicator(Indicator[ChosenChannel]):
    """An indicator that needs one channel, which its options name."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The measured channel."""
        return frozenset({self.options.channel})

    @property
    def unit(self) -> str:
        """Unit of the channel."""
        return self.options.channel.unit

    def signal(self, records: RecordBatch) -> Array:
        """Samples of the channel, shape (n_record, n_time)."""
        return records[self.options.channel]
