"""Plausible values of channels."""

from __future__ import annotations

from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.columns import is_counts
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.settings.quantities import SI


def plausible_range(channel: Channel, config: ChannelConfig) -> tuple[float, float] | None:
    """Lowest and highest plausible value in SI, or in counts; None if none are given.

    Raises
    ------
    ValueError
        The values have another dimension, or the lowest is not below the highest.
    """
    if config.range is None:
        return None
    unit = "1" if is_counts(config.unit) else channel.unit
    low, high = (SI(unit).parse(value) if isinstance(value, str) else float(value) for value in config.range)
    if not low < high:
        raise ValueError(f"the first value must be below the second; found {low:g} and {high:g}")
    return low, high
