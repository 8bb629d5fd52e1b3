"""Checks of a stream: the accepted samples are in order, and pieces have no gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import findings as words
from hydrofdi.records.streams.beginning import Beginning
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.findings import Finding, Kind
from hydrofdi.records.streams.order import FARTHEST, Order, put_in_order

_GAP = 1.5
"""Longest step that is not a gap [sampling periods]."""
_STEPS = 10
"""Number of successive gaps that mean another rate."""
_PATIENCE, _FEWEST = 60.0, 10
"""The clock was set back if all samples are earlier for this duration [s], and for this number of samples."""
_N_KIND = 6


class EvenStream:
    """Checks a stream sample by sample; the results do not depend on the chunks.

    It drops samples that are not later than the last accepted one, or have no time stamp within 1e11 s of
    zero. A step of more than 1.5 periods is a gap; smaller irregularities are tolerated. A minute of only
    earlier samples means that the clock was set back; the stream then begins anew.

    Parameters
    ----------
    sampling_frequency : float
        Expected [Hz].
    channels : sequence of Channel
        Channels of the pieces; others are ignored.
    """

    def __init__(self, sampling_frequency: float, channels: Sequence[Channel]) -> None:
        self.channels = tuple(channels)
        self._period = 1.0 / sampling_frequency
        self._patience = max(_FEWEST, round(_PATIENCE * sampling_frequency))
        self._beginning = Beginning(self.channels, self._patience)

    def start(self) -> State:
        """The state before the first sample: its size never changes."""
        false, none = np.array(False), np.array(0)
        return {
            "last": np.array(-np.inf), "n_earlier": none, "n_gap": none, "said": np.full(_N_KIND, np.nan),
            "is_silent": false, "may_repeat": false, **self._beginning.start(),
        }  # fmt: skip

    def resumed(self, state: State, *, may_repeat: bool = True) -> State:
        """A stored state that continues: samples that are sent again are not reported.

        Parameters
        ----------
        state : State
        may_repeat : bool
            Whether the whole stream may be sent again, of any length. It is recognised by its first minute.
            Otherwise a minute of earlier samples means that the clock was set back.
        """
        return {
            **state, **self._beginning.resumed(state), "n_earlier": np.array(0),
            "is_silent": np.array(True), "may_repeat": np.array(may_repeat),
        }  # fmt: skip

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Chunk], list[Finding]]:
        """The state after a chunk, the accepted samples, and the findings."""
        if not chunk.n_time:
            return state, [], []
        beginning = self._beginning.step(state, chunk)
        if self._is_sound(state, chunk.time):
            after = {**self.start(), "said": state["said"], "last": np.array(chunk.time[-1]), **beginning}
            return after, [Chunk(chunk.time, _rows(chunk, self.channels))], []
        return self._checked({**state, **beginning}, chunk)

    def _is_sound(self, state: State, time: Array) -> bool:
        """Whether a chunk continues without any irregularity, as nearly all chunks do."""
        longest = _GAP * self._period
        if not 0.0 < float(time[0]) - float(state["last"]) <= longest or not np.all(time[1:] > time[:-1]):
            return False
        return bool(time[-1] <= FARTHEST and (time[1:] - time[:-1]).max(initial=0.0) <= longest)

    def _checked(self, state: State, chunk: Chunk) -> tuple[State, list[Chunk], list[Finding]]:
        comes_again = bool(state["may_repeat"]) and self._beginning.comes_again(state)
        last, n_earlier = float(state["last"]), int(state["n_earlier"])
        order = put_in_order(chunk.time, last, n_earlier, self._patience, comes_again)
        accepted = np.flatnonzero(order.is_accepted)
        is_gap = order.stamps[accepted] - order.before[accepted] > _GAP * self._period
        anew = accepted[is_gap | order.is_set_back[accepted]]
        n_gaps = _in_a_row(is_gap & np.isfinite(order.before[accepted]), int(state["n_gap"]))
        loud = int(accepted[0]) if accepted.size else chunk.n_time
        loud = loud if state["is_silent"] else 0
        found, said = self._findings(state, order, accepted, n_gaps, loud, chunk.unread)
        after = {
            **state, "last": order.last, "n_earlier": order.n_earlier, "said": said,
            "n_gap": n_gaps[-1] if accepted.size else state["n_gap"],
            "is_silent": state["is_silent"] and not accepted.size,
            "may_repeat": state["may_repeat"] and not accepted.size,
        }  # fmt: skip
        pieces = _pieces_of(chunk, self.channels, accepted, anew)
        return {name: np.array(value) for name, value in after.items()}, pieces, found

    def _findings(
        self,
        state: State,
        order: Order,
        accepted: NDArray[np.intp],
        n_gaps: NDArray[np.intp],
        loud: int,
        unread: Mapping[int, str],
    ) -> tuple[list[Finding], list[float]]:
        """The findings from the sample `loud` on, in order, and the last instant of each kind."""
        is_finite = np.isfinite(order.stamps)
        is_same = is_finite & ~order.is_accepted & ~order.is_earlier
        kinds = (
            Kind("gap", accepted[(n_gaps > 0) & (n_gaps < _STEPS)], words.gap),
            Kind("rate_changed", accepted[n_gaps >= _STEPS], self._rate_changed),
            Kind("duplicate", np.flatnonzero(is_same), words.duplicate),
            Kind("time_ran_back", np.flatnonzero(order.is_earlier), words.time_ran_back),
            Kind("time_ran_back", np.flatnonzero(order.is_set_back), words.set_back, is_always_news=True),
            Kind("malformed", np.flatnonzero(~is_finite), words.malformed, texts=unread),
        )
        found: list[tuple[int, Finding]] = []
        said: list[float] = []
        for kind, before in zip(kinds, state["said"].tolist(), strict=True):
            is_sent_again = kind.name != "malformed" or bool(state["may_repeat"])
            new, latest = kind.since(loud if is_sent_again else 0).findings(order, before)
            found += new
            said.append(latest)
        return [finding for _, finding in sorted(found, key=itemgetter(0))], said

    def _rate_changed(self, stamp: float, before: float) -> str:
        return f"samples come every {stamp - before:.4g} s instead of every {self._period:.4g} s"


def _in_a_row(is_gap: NDArray[np.bool_], n_before: int) -> NDArray[np.intp]:
    """Number of successive gaps up to each sample; 0 if there is no gap before it."""
    counts = n_before + np.cumsum(is_gap)
    in_a_row: NDArray[np.intp] = counts - np.maximum.accumulate(np.where(is_gap, 0, counts))
    return in_a_row


def _pieces_of(
    chunk: Chunk, channels: Sequence[Channel], accepted: NDArray[np.intp], anew: NDArray[np.intp]
) -> list[Chunk]:
    """The samples of a chunk at `accepted`; those at `anew` do not continue the sample before."""
    if not accepted.size:
        return []
    time, rows = chunk.time, _rows(chunk, channels)
    if accepted.size < chunk.n_time:
        time, rows = time[accepted], {channel: row[accepted] for channel, row in rows.items()}
    firsts = np.searchsorted(accepted, anew)
    bounds = np.union1d(firsts, [0, accepted.size]).astype(np.intp).tolist()
    begins = set(firsts.tolist())
    return [
        Chunk(
            time[first:stop],
            {channel: row[first:stop] for channel, row in rows.items()},
            begins_anew=first in begins,
        )
        for first, stop in pairwise(bounds)
    ]


def _rows(chunk: Chunk, channels: Sequence[Channel]) -> dict[Channel, Array]:
    rows = {channel: chunk.channels.get(channel) for channel in channels}
    return {channel: np.full(chunk.n_time, np.nan) if row is None else row for channel, row in rows.items()}
