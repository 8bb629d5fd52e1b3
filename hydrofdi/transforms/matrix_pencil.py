"""The two strongest exponentials that pieces of a signal have in common.

Hua and Sarkar, IEEE Trans. Acoust., Speech, Signal Process. 38 (1990) 814.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LONGEST_PENCIL = 24


def common_motion(pieces: Array, group: NDArray[np.intp]) -> tuple[Array, Array]:
    """Coefficients a and b of the characteristic polynomial s² + a s + b that the pieces of a group share.

    Parameters
    ----------
    pieces : ndarray, shape (n_piece, n_time)
        Detrended.
    group : ndarray of int, shape (n_piece,)
        Ascending.

    Returns
    -------
    a, b : ndarray, shape (n_piece,)
        Equal within a group; the unit of time is the length of a piece.
    """
    n_time = pieces.shape[1]
    first = np.flatnonzero(np.diff(group, prepend=-1))
    products = _pencil_products(pieces, first, min(n_time // 3, _LONGEST_PENCIL))
    products[~np.isfinite(products).all(axis=(1, 2))] = np.eye(products.shape[1])
    space = np.linalg.eigh(products)[1][:, :, -2:]
    last = space[:, -1]
    step = space[:, :-1].transpose(0, 2, 1) @ space[:, 1:]
    left = np.sum(last[:, :, None] * step, axis=1) / (1.0 - np.sum(np.square(last), axis=1))[:, None]
    step = step + last[:, :, None] * left[:, None, :]
    half = 0.5 * (step[:, 0, 0] + step[:, 1, 1])
    split = half**2 - step[:, 0, 0] * step[:, 1, 1] + step[:, 0, 1] * step[:, 1, 0]
    roots = half[:, None] + np.sqrt(split[:, None] + 0j) * np.array([1.0, -1.0])
    rates = np.log(roots) * n_time
    of_piece = np.cumsum(np.diff(group, prepend=-1) != 0) - 1
    a, b = -rates.sum(axis=1).real, np.abs(rates.prod(axis=1).real)
    return a[of_piece], b[of_piece]


def _pencil_products(pieces: Array, first: NDArray[np.intp], length: int) -> Array:
    """Gram matrices of the Hankel matrices, summed over each group: (n_group, length + 1, length + 1).

    Along a diagonal, each entry follows from the previous one: drop its first term and add one.
    """
    n_row = pieces.shape[1] - length
    ahead = np.lib.stride_tricks.sliding_window_view(pieces[:, : length + n_row], n_row, axis=1)
    edge = np.add.reduceat(np.sum(ahead * pieces[:, None, :n_row], axis=2), first, axis=0)
    heads, tails = pieces[:, :length], pieces[:, n_row : n_row + length]
    change = np.add.reduceat(
        tails[:, :, None] * tails[:, None, :] - heads[:, :, None] * heads[:, None, :], first, axis=0
    )
    products = np.empty((first.size, length + 1, length + 1))
    products[:, 0] = products[:, :, 0] = edge
    for row in range(length):
        products[:, row + 1, 1:] = products[:, row, :-1] + change[:, row]
    return products
