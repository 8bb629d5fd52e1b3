"""What is wrong with the samples of a stream."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hydrofdi.records.batch import Array

_QUIET = 60.0
"""A kind is news again after so long without it [s]."""


@dataclass(frozen=True)
class Finding:
    """One kind of defect, from its first instant in a chunk on.

    Those that are news, and the sum of `count` over each kind, do not depend on the chunks.

    Attributes
    ----------
    kind : str
        ``gap``, ``duplicate``, ``time_ran_back`` or ``malformed`` (a time stamp that is not finite).
    time : float or None
        First instant, on the clock of the stream [s]; None before the first sample.
    count : int
        How often it happened.
    text : str
        The sentence for a person, about the first time.
    is_news : bool
        Whether it did not happen in the minute before; False where it goes on.
    """

    kind: str
    time: float | None
    count: int
    text: str
    is_news: bool = True


def findings_of(kind: str, instants: Array, previous: float, text: Callable[[int], str]) -> Iterator[Finding]:
    """Findings of one kind in a chunk: one for what goes on, and one for each that is news.

    Parameters
    ----------
    kind : str
    instants : ndarray, shape (n_occurrence,)
        On the clock of the stream [s].
    previous : float
        The last instant before the chunk [s]; NaN if it never happened.
    text : callable
        Sentence about an occurrence, by its number.
    """
    if not instants.size:
        return
    away = np.abs(np.diff(np.nan_to_num(instants), prepend=np.nan_to_num(previous)))
    is_news = (away > _QUIET) | ~np.isfinite(np.concatenate([[previous], instants[:-1]]))
    firsts = np.flatnonzero(is_news)
    if not is_news[0]:
        firsts = np.concatenate([[0], firsts])
    for first, count in zip(firsts, np.diff(firsts, append=instants.size), strict=True):
        instant = float(instants[first])
        time = instant if np.isfinite(instant) else None
        yield Finding(kind, time, int(count), text(int(first)), bool(is_news[first]))


def seconds(time: float) -> str:
    """An instant or a duration to the microsecond."""
    return f"{time:.6f}".rstrip("0").rstrip(".") + " s"
