"""Rules shared by several scores; each record is computed independently."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.standardisation import Standardisation


@dataclass(frozen=True, eq=False)
class LinearRule:
    """Weighted sum of the standardised features.

    Attributes
    ----------
    standardised : Standardisation
    weights : ndarray, shape (n_kept,)
    offset : float
    """

    standardised: Standardisation
    weights: Array
    offset: float

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return self.offset + row_products(self.standardised(values), self.weights[:, None])[:, 0]


def row_products(rows: Array, matrix: Array) -> Array:
    """`rows` @ `matrix`, bit-identical per row: in BLAS the order of sums depends on the number of rows.

    Parameters
    ----------
    rows : ndarray, shape (n_record, n_feature)
        Contiguous.
    matrix : ndarray, shape (n_feature, n_column)
    """
    return np.stack([np.sum(rows * column, axis=1) for column in matrix.T], axis=1)
