"""Scores of records. NaN means that a record cannot be measured; infinite scores are valid."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def measurable(scores: ArrayLike) -> tuple[Array, int]:
    """Scores that are not NaN, and the number of the others.

    Parameters
    ----------
    scores : array_like, shape (n_record,)

    Returns
    -------
    known : ndarray, shape (n_known,)
        In the order given.
    not_measurable : int
    """
    values = np.asarray(scores, dtype=float)
    missing = np.isnan(values)
    return values[~missing], int(missing.sum())


def share_between_0_and_1(name: str, value: float) -> None:
    """Check that a rate, a probability or a confidence lies between 0 and 1.

    Raises
    ------
    ValueError
        It does not.
    """
    if not 0.0 < value < 1.0:
        raise ValueError(f"{name} must be between 0 and 1; found {value}")
