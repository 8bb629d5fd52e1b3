"""Windows that are stuck, clipped, or unlike the training data of a detector."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from hydrofdi.detectors.trained.file import ChannelRange, DetectorFile
from hydrofdi.detectors.trained.ranges import ChannelFacts, channel_facts
from hydrofdi.detectors.trained.wording import readable, score_text
from hydrofdi.errors import Issue
from hydrofdi.records import Channel, RecordBatch

_FAR = 10.0
"""Healthy spreads in the distance from which a score on the side without an alarm is novel."""

_QUANTITIES = {
    "low": "1 % quantile",
    "high": "99 % quantile",
    "activity": "RMS difference between adjacent samples",
}


def findings(records: RecordBatch, ranges: Mapping[Channel, ChannelRange]) -> list[Issue | None]:
    """Fault of each window: stuck, clipped, novel, or None.

    Parameters
    ----------
    records : RecordBatch
        Windows as records.
    ranges : mapping of Channel to ChannelRange
        Healthy ranges.
    """
    facts = {channel: channel_facts(records[channel]) for channel in ranges if channel in records.channels}
    return [_finding(row, facts, ranges) for row in range(records.n_record)]


def not_positive(file: DetectorFile, doubts: Sequence[Issue]) -> Issue | None:
    """Why a window is novel: a quantity is not positive, but is so in all healthy windows."""
    for doubt in doubts:
        if doubt.kind == "not_positive" and doubt.where in file.positive:
            return Issue(doubt.message, kind="novel")
    return None


def wrong_side(file: DetectorFile, score: float) -> Issue | None:
    """Why a score is novel: a leak moves it to one side, and it is far out on the other.

    Far is twice as far from the healthy median as all healthy scores, and ten healthy spreads more.
    """
    limits, healthy = file.limits, file.healthy
    if healthy.range is None or (limits.low is None) == (limits.high is None):
        return None
    lowest, highest = healthy.range
    width, distance, side = highest - healthy.centre, score - healthy.centre, "above"
    if limits.low is None:
        width, distance, side = healthy.centre - lowest, -distance, "below"
    if distance <= 2.0 * width + _FAR * healthy.spread:
        return None
    return Issue(
        f"the score, {score_text(score, file)}, is far {side} all healthy scores"
        f" ({score_text(lowest, file)} to {score_text(highest, file)}):"
        " are two channels swapped, or is a sign wrong?",
        kind="novel",
    )


def _finding(
    row: int, facts: Mapping[Channel, ChannelFacts], ranges: Mapping[Channel, ChannelRange]
) -> Issue | None:
    for kind, found in (("stuck", _stuck), ("clipped", _clipped), ("novel", _novel)):
        texts = [text for channel in facts for text in found(row, channel, facts[channel], ranges[channel])]
        if texts:
            more = f" (and {len(texts) - 1} more)" if len(texts) > 1 else ""
            return Issue(texts[0] + more, kind=kind)
    return None


def _stuck(row: int, channel: Channel, facts: ChannelFacts, healthy: ChannelRange) -> Iterator[str]:
    if facts.lowest[row] == facts.highest[row] and healthy.at_end < 1.0:
        yield f"{channel} is constant, but varies in healthy windows"


def _clipped(row: int, channel: Channel, facts: ChannelFacts, healthy: ChannelRange) -> Iterator[str]:
    share = float(facts.at_end[row])
    if share > healthy.at_end:
        at_high = facts.is_at_high[row]
        end, value = ("highest", facts.highest) if at_high else ("lowest", facts.lowest)
        yield (
            f"{share:.1%} of {channel} are at its {end} value, {readable(float(value[row]), channel.unit)};"
            f" healthy windows allow {healthy.at_end:.1%}"
        )


def _novel(row: int, channel: Channel, facts: ChannelFacts, healthy: ChannelRange) -> Iterator[str]:
    for name, quantity in _QUANTITIES.items():
        value, (low, high) = float(getattr(facts, name)[row]), getattr(healthy, name)
        if not low <= value <= high:
            yield (
                f"the {quantity} of {channel} is {readable(value, channel.unit)}; healthy windows allow"
                f" {readable(low, channel.unit)} to {readable(high, channel.unit)}"
            )
