"""Generalised Pareto distribution of excesses over a high threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True, eq=False)
class GeneralisedPareto:
    """Distributions P(Y > y) = (1 + ξ y/σ)^(-1/ξ) of excesses: Pickands, Annals of Statistics 3 (1975) 119.

    Attributes
    ----------
    shape : ndarray, shape (...,)
        ξ.
    scale : ndarray, shape (...,)
        σ, in the unit of the scores.
    """

    shape: Array
    scale: Array

    def survival(self, excess: Array) -> Array:
        """P(Y > excess), shape (..., n)."""
        shape, scale = self.shape[..., None], self.scale[..., None]
        safe = _away_from_zero(shape)
        growth = np.maximum(1.0 + safe * excess / scale, 0.0)
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-np.log(growth) / safe))

    def excess(self, survival: Array) -> Array:
        """Excess that is exceeded with probability `survival`, shape (..., n)."""
        shape, scale = self.shape[..., None], self.scale[..., None]
        safe = _away_from_zero(shape)
        return np.asarray(scale * np.expm1(-safe * np.log(survival)) / safe)


def fit_generalised_pareto(excesses: Array) -> GeneralisedPareto:
    """Fit distributions to rows of excesses.

    Method of Zhang and Stephens, Technometrics 51 (2009) 316.

    A likelihood-weighted mean over a grid of ξ/σ: as efficient as maximum likelihood, and always defined.

    Parameters
    ----------
    excesses : ndarray, shape (..., n)
        Ascending along the last axis, with a positive lower quartile.
    """
    n = excesses.shape[-1]
    n_grid = 20 + int(np.sqrt(n))
    quartile = excesses[..., int(n / 4.0 + 0.5) - 1]
    places = 1.0 - np.sqrt(n_grid / (np.arange(1, n_grid + 1) - 0.5))
    ratios = 1.0 / excesses[..., -1, None] + places / (3.0 * quartile[..., None])
    shapes = np.stack([_shape_at(ratio, excesses) for ratio in np.moveaxis(ratios, -1, 0)], axis=-1)
    likelihood = n * (np.log(-ratios / shapes) - shapes - 1.0)
    weights = np.exp(likelihood - likelihood.max(axis=-1, keepdims=True))
    ratio = np.sum(ratios * weights, axis=-1) / weights.sum(axis=-1)
    shape = _shape_at(ratio, excesses)
    return GeneralisedPareto(shape, -shape / ratio)


def anderson_darling(distribution: GeneralisedPareto, excesses: Array) -> Array:
    """Anderson-Darling statistic A², which emphasises the tails.

    Annals of Mathematical Statistics 23 (1952) 193.

    Parameters
    ----------
    distribution : GeneralisedPareto
    excesses : ndarray, shape (..., n)
        Ascending along the last axis.
    """
    n = excesses.shape[-1]
    above = np.clip(distribution.survival(excesses), 1e-300, 1.0 - 1e-16)
    terms = np.log1p(-above) + np.log(above[..., ::-1])
    return np.asarray(-n - np.sum((2.0 * np.arange(1, n + 1) - 1.0) * terms, axis=-1) / n)


def _shape_at(ratio: Array, excesses: Array) -> Array:
    return np.asarray(np.mean(np.log1p(-ratio[..., None] * excesses), axis=-1))


def _away_from_zero(shape: Array) -> Array:
    """Replace ξ = 0 by ±1e-9, which is accurate to nine digits."""
    return np.where(np.abs(shape) < 1e-9, 1e-9, shape)
