"""Points in the unit cube; quantile functions turn their coordinates into parameter values."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.sweeps.sample import CorrelationConfig
from hydrofdi.evaluation.populations import SECOND

Method = Literal["sobol", "lhs", "random"]


def unit_cube(
    method: Method, count: int, n_axis: int, seed: int | np.random.SeedSequence
) -> NDArray[np.float64]:
    """Points in the unit cube, shape (count, n_axis)."""
    generator = np.random.default_rng(seed)
    if method == "random" or not n_axis:
        return generator.random((count, n_axis))
    from scipy.stats import qmc

    sequence = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the user may choose any count, not only powers of two
        cube: NDArray[np.float64] = sequence(n_axis, rng=generator).random(count)
    return cube


def correlated(
    unit: NDArray[np.float64], names: Sequence[str], correlation: CorrelationConfig | None
) -> NDArray[np.float64]:
    """Points in the unit cube, some of whose coordinates are correlated by a Gaussian copula.

    Parameters
    ----------
    unit : ndarray, shape (n_point, n_axis)
    names : sequence of str, length n_axis
        Parameter of each coordinate.
    correlation : CorrelationConfig or None
    """
    if correlation is None:
        return unit
    from scipy.special import ndtr, ndtri

    axes = [list(names).index(name) for name in correlation.parameters]
    normal = ndtri(np.clip(unit[:, axes], 2.0**-53, 1.0 - 2.0**-53))
    depending = unit.copy()
    depending[:, axes] = ndtr(normal @ np.linalg.cholesky(np.array(correlation.matrix)).T)
    return depending


def saltelli_page(
    page: str, names: Sequence[str], count: int, seed: int | np.random.SeedSequence
) -> NDArray[np.float64]:
    """A page of a design for Sobol indices: Saltelli et al., Computer Physics Communications 181 (2010) 259.

    Parameters
    ----------
    page : str
        ``SECOND`` for the matrix B; a parameter for A with that column from B; any other name for A.
    names : sequence of str, length n_axis
    count : int
    seed : int or SeedSequence
        Must be the same for all pages.

    Returns
    -------
    ndarray, shape (count, n_axis)
    """
    cube = unit_cube("sobol", count, 2 * len(names), seed)
    first, second = cube[:, : len(names)], cube[:, len(names) :]
    if page == SECOND:
        return second
    exchanged = np.array([name == page for name in names], dtype=bool)
    return np.where(exchanged, second, first)
