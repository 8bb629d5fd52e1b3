"""Polynomial trends of pieces of a signal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def orthonormal_polynomials(n_time: int, degree: int) -> Array:
    """Polynomials up to a degree, orthonormal on the sample grid, shape (degree + 1, n_time)."""
    powers = np.vander(np.linspace(-1.0, 1.0, n_time), degree + 1, increasing=True)
    return np.ascontiguousarray(np.linalg.qr(powers)[0].T)


def less_polynomials(pieces: Array, polynomials: Array) -> Array:
    """Pieces of a signal minus their least-squares trend.

    Parameters
    ----------
    pieces : ndarray, shape (n_piece, n_time)
        Contiguous, so that the bits of a piece do not depend on the other pieces.
    polynomials : ndarray, shape (n_polynomial, n_time)
        Orthonormal.
    """
    for polynomial in polynomials:
        pieces = pieces - np.sum(pieces * polynomial, axis=1)[:, None] * polynomial
    return pieces
