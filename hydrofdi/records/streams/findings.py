"""Defects in the samples of a stream."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array
from hydrofdi.records.streams.order import Order

_QUIET = 60.0
"""Time without a kind of finding after which it is reported again [s]."""


@dataclass(frozen=True)
class Finding:
    """One kind of defect, from its first instant in a chunk on.

    The findings that are news, and the sum of `count` over each kind, do not depend on the chunks.

    Attributes
    ----------
    kind : str
        ``gap``, ``rate_changed`` (one gap after another), ``duplicate``, ``time_ran_back`` or ``malformed``
        (unreadable, or no time stamp within 1e11 s of zero).
    time : float or None
        First instant, on the clock of the stream [s]; None before the first sample.
    count : int
        Number of occurrences.
    text : str
        A sentence about the first occurrence.
    is_news : bool
        Whether it did not occur in the minute before; False if it continues.
    """

    kind: str
    time: float | None
    count: int
    text: str
    is_news: bool = True


@dataclass(frozen=True)
class Kind:
    """Occurrences of one kind of defect in a chunk.

    Attributes
    ----------
    name : str
    places : ndarray of int, shape (n_occurrence,)
    text : callable
        Sentence about an occurrence, from its instant and the last accepted instant before it [s].
    is_always_news : bool
        Whether each occurrence is news, even if it soon follows another.
    texts : mapping of int to str
        Place → another sentence.
    """

    name: str
    places: NDArray[np.intp]
    text: Callable[[float, float], str]
    is_always_news: bool = False
    texts: Mapping[int, str] = field(default_factory=dict)

    def since(self, first: int) -> Kind:
        """The occurrences from a sample on."""
        return replace(self, places=self.places[self.places >= first])

    def findings(self, order: Order, said: float) -> tuple[list[tuple[int, Finding]], float]:
        """A finding for what continues and one for each that is news, with places; and the last instant [s].

        Parameters
        ----------
        order : Order
        said : float
            Instant of the last occurrence before the chunk [s]; NaN if there was none.
        """
        if not self.places.size:
            return [], said
        instants = np.maximum(order.before, order.stamps)[self.places]
        return list(self._divided(order, instants, said)), float(instants[-1])

    def _divided(self, order: Order, instants: Array, said: float) -> Iterator[tuple[int, Finding]]:
        previous = np.concatenate([[said], instants[:-1]])
        with np.errstate(invalid="ignore"):
            goes_on = (np.abs(instants - previous) <= _QUIET) | (instants == previous)
        if self.is_always_news:
            goes_on[:] = False
        firsts = np.union1d([0], np.flatnonzero(~goes_on)).astype(np.intp)
        for first, count in zip(firsts, np.diff(firsts, append=instants.size), strict=True):
            time = float(instants[first]) if np.isfinite(instants[first]) else None
            place = int(self.places[first])
            text = self.texts.get(place) or self.text(float(order.stamps[place]), float(order.before[place]))
            yield place, Finding(self.name, time, int(count), text, not bool(goes_on[first]))


def gap(stamp: float, before: float) -> str:
    """Missing samples."""
    return f"no samples for {_seconds(stamp - before)} after {_seconds(before)}"


def duplicate(stamp: float, before: float) -> str:
    """The same instant again."""
    return f"a second sample at {_seconds(stamp)} was dropped"


def time_ran_back(stamp: float, before: float) -> str:
    """An earlier instant."""
    return f"a sample at {_seconds(stamp)} came after one at {_seconds(before)} and was dropped"


def set_back(stamp: float, before: float) -> str:
    """Only earlier instants."""
    return f"the clock was set back from {_seconds(before)}; the stream restarts at {_seconds(stamp)}"


def malformed(stamp: float, before: float) -> str:
    """No valid instant."""
    where = f"after {_seconds(before)} " if np.isfinite(before) else ""
    return f"a sample {where}has no time stamp within 1e11 s of zero and was dropped"


def _seconds(time: float) -> str:
    """An instant or a duration to the microsecond."""
    return f"{time:.6f}".rstrip("0").rstrip(".") + " s"
