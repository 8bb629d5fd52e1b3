"""A stream that is checked: what is left is in order, finite in time, and without gaps inside of a piece."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams.chunk import Chunk, State
from hydrofdi.records.streams.findings import Finding, findings_of, seconds

_GAP = 1.5
"""Sampling periods; a longer step is a gap."""
_KINDS = ("gap", "duplicate", "time_ran_back", "malformed")


@dataclass(frozen=True)
class Piece:
    """Consecutive samples of a stream that were accepted, without a gap.

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        [s]
    channels : mapping of Channel to ndarray, shape (n_time,)
        All channels that were asked for, in SI; NaN where a sample is missing.
    begins_anew : bool
        Whether it does not continue the piece before: it is the first one, or a gap came before.
    """

    time: Array
    channels: Mapping[Channel, Array]
    begins_anew: bool


class EvenStream:
    """Checks a stream sample by sample; what it says does not depend on the chunks.

    A sample that is not later than the one before is dropped, so is one without a finite time stamp. A step
    of more than 1.5 periods is a gap; smaller irregularities are tolerated.

    Parameters
    ----------
    sampling_frequency : float
        Expected [Hz].
    channels : sequence of Channel
        What pieces have; others are passed over.
    """

    def __init__(self, sampling_frequency: float, channels: Sequence[Channel]) -> None:
        self.sampling_frequency = sampling_frequency
        self.channels = tuple(channels)

    def start(self) -> State:
        """The state before the first sample."""
        said = np.full(len(_KINDS), np.nan)
        return {"last": np.array(-np.inf), "is_resumed": np.array(False), "said": said}

    def resumed(self, state: State) -> State:
        """A stored state: samples that come again are dropped in silence until the stream is past them."""
        return {**state, "is_resumed": np.array(True)}

    def step(self, state: State, chunk: Chunk) -> tuple[State, list[Piece], list[Finding]]:
        """The state behind a chunk, the samples that were accepted, and what is wrong."""
        if not chunk.n_time:
            return state, [], []
        time = np.asarray(chunk.time, dtype=np.float64)
        finite = np.isfinite(time)
        stamps = np.where(finite, time, -np.inf)
        latest = np.maximum.accumulate(np.concatenate([state["last"][None], stamps]))
        before = latest[:-1]
        accepted = np.flatnonzero(stamps > before)
        gaps = accepted[_steps(stamps, before, accepted) > _GAP / self.sampling_frequency]
        silent = self._silent(state, accepted, time.size)
        pieces = self._pieces(time, chunk, accepted, gaps)
        occurrences = {
            "gap": gaps[np.isfinite(before[gaps])],
            "duplicate": np.flatnonzero(finite & (stamps == before)),
            "time_ran_back": np.flatnonzero(finite & (stamps < before)),
            "malformed": np.flatnonzero(~finite),
        }
        occurrences = {kind: places[places >= silent] for kind, places in occurrences.items()}
        said, findings = _say(occurrences, stamps, before, state["said"])
        is_resumed = state["is_resumed"] & (accepted.size == 0)
        return {"last": latest[-1], "is_resumed": is_resumed, "said": said}, pieces, findings

    def _silent(self, state: State, accepted: NDArray[np.intp], n_time: int) -> int:
        """Samples at the start of a chunk about which nothing is said."""
        if not state["is_resumed"]:
            return 0
        return int(accepted[0]) if accepted.size else n_time

    def _pieces(
        self, time: Array, chunk: Chunk, accepted: NDArray[np.intp], gaps: NDArray[np.intp]
    ) -> list[Piece]:
        """Accepted samples, divided at gaps."""
        if not accepted.size:
            return []
        missing = np.full(time.size, np.nan)
        rows = {channel: chunk.channels.get(channel, missing) for channel in self.channels}
        if accepted.size < time.size:
            time, rows = time[accepted], {channel: row[accepted] for channel, row in rows.items()}
        firsts = np.searchsorted(accepted, gaps)
        bounds = np.unique(np.concatenate([[0], firsts, [accepted.size]]))
        begins = np.isin(bounds[:-1], firsts)
        return [
            Piece(time[first:stop], {channel: row[first:stop] for channel, row in rows.items()}, bool(anew))
            for first, stop, anew in zip(bounds[:-1], bounds[1:], begins, strict=True)
        ]


def _steps(stamps: Array, before: Array, accepted: NDArray[np.intp]) -> Array:
    steps: Array = stamps[accepted] - before[accepted]
    return steps


def _say(
    occurrences: Mapping[str, NDArray[np.intp]], stamps: Array, before: Array, said: Array
) -> tuple[Array, list[Finding]]:
    said = said.copy()
    findings: list[Finding] = []
    for row, (kind, places) in enumerate(occurrences.items()):
        if not places.size:
            continue
        instants = (stamps if kind == "gap" else before)[places]

        def text(n: int, kind: str = kind, places: NDArray[np.intp] = places) -> str:
            return _text(kind, float(stamps[places[n]]), float(before[places[n]]))

        findings += findings_of(kind, instants, float(said[row]), text)
        said[row] = instants[-1]
    return said, findings


def _text(kind: str, stamp: float, before: float) -> str:
    if kind == "gap":
        return f"no samples for {seconds(stamp - before)} after {seconds(before)}"
    if kind == "duplicate":
        return f"the sample at {seconds(stamp)} came twice and was dropped"
    if kind == "time_ran_back":
        return f"a sample at {seconds(stamp)} came after the one at {seconds(before)} and was dropped"
    where = f"after {seconds(before)} " if np.isfinite(before) else ""
    return f"a sample {where}has no finite time stamp and was dropped"
