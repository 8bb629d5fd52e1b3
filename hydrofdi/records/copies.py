"""Records that repeat another: exactly, or rounded, scaled, or shifted by a few samples."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hydrofdi.records import Array, Channel, RecordBatch

_COMMANDS = (Channel.INPUT_VOLTAGE, Channel.SPOOL_POSITION)
_MOST, _FEWEST, _PLACES = 1024, 64, 7
"""Most and fewest samples of a record that are compared, and among how many places they are chosen."""
_LARGEST = 1e100
"""Largest value that can be squared."""
_LAGS = 4
"""Most samples by which a copy is shifted."""
_LIKE = 0.995
"""Least correlation of the first channel of records that are compared digit by digit."""
_FINE, _COARSER, _VARIED = 1e4, 4.0, 20.0
"""Digits in the range of a channel, or ratio of two digits, at which other records never agree to a digit;
digits in the range of a channel that tells anything."""


@dataclass(frozen=True)
class Sketch:
    """What tells whether a record is a copy: a digest of all samples, and some samples of each channel.

    Commands are alike in other records, too; channels in SI, shape (n_time,), with a digest alone none.
    """

    digest: bytes
    channels: Mapping[Channel, Array] = field(default_factory=dict)

    @cached_property
    def digits(self) -> dict[Channel, float]:
        """Least difference of the values of each channel."""
        return {channel: _digit(values) for channel, values in self.channels.items()}


def _digit(values: Array) -> float:
    """Least difference of values of one decade: numbers with nine digits have the coarsest in the largest."""
    distinct = np.unique(np.abs(values[values != 0.0]))
    steps, decades = np.diff(distinct), np.floor(np.log10(distinct))
    is_in = decades[1:] == decades[:-1]
    kinds = (steps[is_in & (decades[1:] == decade)] for decade in np.unique(decades))
    return max(
        (float(kind.min()) for kind in kinds if kind.size > steps.size / 8), default=float(np.ptp(values))
    )


def sketch_of(batch: RecordBatch, row: int, *, is_near: bool = True) -> Sketch:
    """The sketch of a record; if not `is_near`, it equals exact copies only."""
    digest = hashlib.blake2b(digest_size=16)
    for channel in sorted(batch.channels):
        digest.update(channel.encode())
        digest.update(batch[channel][row].tobytes())
    # a power of two, because a copy may lack some samples
    n_time = min(_MOST, 2 ** int(np.log2(max(1.0, 0.9 * batch.n_time))))
    samples = {each: batch[each][row] for each in batch.channels if each not in _COMMANDS} if is_near else {}
    kept = {each: rows for each, rows in samples.items() if np.abs(rows).max() < _LARGEST}
    if n_time < _FEWEST or not kept:
        return Sketch(digest.digest())
    starts = np.linspace(0, batch.n_time - n_time, _PLACES).astype(int).tolist()
    first = kept[_first(kept)]
    spreads = [float(np.std(first[n : n + n_time])) for n in starts]
    start = next(n for n, spread in zip(starts, spreads, strict=True) if spread >= 0.5 * max(spreads))
    parts = {each: rows[start : start + n_time].copy() for each, rows in kept.items()}
    return Sketch(digest.digest(), {each: part for each, part in parts.items() if np.ptp(part) > 0.0})


def _first(channels: Mapping[Channel, Any]) -> Channel:
    return next(channel for channel in Channel if channel in channels)


class Copies:
    """Records that were seen, and which of them another one repeats."""

    def __init__(self) -> None:
        self._seen: dict[bytes, int] = {}
        self._sketches: list[Sketch] = []
        self._alike: dict[Any, tuple[list[int], list[Array]]] = defaultdict(lambda: ([], []))

    def known(self, sketch: Sketch) -> int | None:
        """Number of the first record that this one repeats; None if there is none."""
        if (same := self._seen.get(sketch.digest)) is not None or not sketch.channels:
            return same
        _, shifted = _shapes(sketch)
        numbers, cores = self._alike[_kind(sketch)]
        for first in range(0, len(numbers), _MOST):
            fits = np.max(np.array(cores[first : first + _MOST]) @ shifted.T, axis=1)
            for index in (first + np.flatnonzero(fits > _LIKE)).tolist():
                if _repeats(self._sketches[numbers[index]], sketch):
                    return numbers[index]
        return None

    def find(self, sketch: Sketch) -> int | None:
        """The same; a record that repeats none is remembered under the next number."""
        found = self.known(sketch)
        if found is None:
            self._seen[sketch.digest] = number = len(self._sketches)
            self._sketches.append(sketch)
            if sketch.channels:
                numbers, cores = self._alike[_kind(sketch)]
                numbers.append(number)
                cores.append(_shapes(sketch)[0])
        return found


def _kind(sketch: Sketch) -> tuple[int, frozenset[Channel]]:
    return next(iter(sketch.channels.values())).size, frozenset(sketch.channels)


def _shapes(sketch: Sketch) -> tuple[Array, Array]:
    """Middle of the samples of the first channel, and as many at each lag, with mean 0 and norm 1."""
    samples = sketch.channels[_first(sketch.channels)]
    all_lags = np.lib.stride_tricks.sliding_window_view(samples, samples.size - 2 * _LAGS)
    shifted = all_lags - all_lags.mean(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        shifted = (shifted / np.linalg.norm(shifted, axis=1, keepdims=True)).astype(np.float32)
    return shifted[_LAGS], shifted


def _repeats(one: Sketch, other: Sketch) -> bool:
    """Whether all channels of two records are alike to the last digit, up to a scale, at one lag."""
    return any(
        all(grades := [_agree(one, other, channel, lag) for channel in one.channels]) and max(grades) > 1
        for lag in range(2 * _LAGS + 1)
    )


def _agree(one: Sketch, other: Sketch, channel: Channel, lag: int) -> int:
    """2 if a channel of two records agrees, 1 if it has too few digits to tell, else 0."""
    x = one.channels[channel][_LAGS:-_LAGS]
    y = other.channels[channel][lag : lag + x.size]
    about_x, about_y = x - x.mean(), y - y.mean()
    slope = float(about_x @ about_y) / (float(about_x @ about_x) or 1.0)
    fine, coarse = sorted((abs(slope) * one.digits[channel], other.digits[channel]))
    n_digit = float(np.ptp(y)) / coarse
    # of two logs of one coarse converter a copy is exact; of fine ones, or of another rounding, to a digit
    is_rounded = n_digit > _FINE or coarse > _COARSER * fine
    allowed = 0.6 * (fine + coarse) if is_rounded else 0.1 * coarse
    is_telling = n_digit > _VARIED and slope > 0.0
    rest = float(np.max(np.abs(about_y - slope * about_x)))
    return 2 if is_telling and rest <= allowed else 0 if is_telling or rest > 1.5 * coarse else 1


def pairs(repeats: Sequence[str], most: int = 5) -> str:
    """Sentences about some copies for a message."""
    return "; ".join(repeats[:most]) + "; …" * (len(repeats) > most)
