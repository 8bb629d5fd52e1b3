"""Resampled healthy operation: records drawn and concatenated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray


def members(groups: Sequence[str] | None, n_stream: int) -> list[NDArray[np.intp]]:
    """Positions of the streams of each group; a stream without a group (``""``) is its own group."""
    given = ("",) * n_stream if groups is None else groups
    names = [name or f"\0{stream}" for stream, name in enumerate(given)]
    _, places = np.unique(np.asarray(names), return_inverse=True)
    return [np.flatnonzero(places == group) for group in range(int(places.max(initial=-1)) + 1)]


def operations(groups: list[NDArray[np.intp]], n_draw: int, seed: int) -> Iterator[NDArray[np.intp]]:
    """Draw whole streams to be concatenated: block bootstrap with the streams of a group as blocks.

    Künsch, Annals of Statistics 17 (1989) 1217, with blocks given by records; balanced as in Davison, Hinkley
    and Schechtman, Biometrika 73 (1986) 555: over all draws each group occurs equally often.

    Parameters
    ----------
    groups : list of ndarray of int
        Positions of the streams of each group.
    n_draw : int
    seed : int

    Yields
    ------
    ndarray of int, shape (n_drawn,)
        Positions of streams; their number equals that of all streams if groups have equal size.
    """
    order = np.random.default_rng(seed).permutation(np.tile(np.arange(len(groups)), n_draw))
    for drawn in order.reshape(n_draw, len(groups)):
        yield np.concatenate([groups[group] for group in drawn])
