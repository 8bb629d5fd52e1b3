"""Scores of records. NaN is the score of a record that cannot be measured; infinite scores are scores."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def measurable(scores: ArrayLike) -> tuple[Array, int]:
    """The scores that are there, and how many are not.

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
    """Check that a rate, a probability or a confidence is one.

    Raises
    ------
    ValueError
        It does not lie between 0 and 1.
    """
    if not 0.0 < value < 1.0:
        raise ValueError(f"{name} must be between 0 and 1; found {value}")
