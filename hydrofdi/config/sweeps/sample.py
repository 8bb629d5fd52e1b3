"""The ``sample`` of a sweep block: points drawn from distributions."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, WithJsonSchema, model_validator

from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import Section

Kind = Literal[
    "uniform", "loguniform", "normal", "truncated_normal", "lognormal", "triangular", "integers", "choice"
]

_ARGUMENTS = {"anyOf": [{"type": "array", "items": {}}, {"type": "string", "pattern": "^\\s*(±|\\+/-|\\+-)"}]}

Distribution = dict[Kind, Annotated[list[Any], WithJsonSchema(_ARGUMENTS)]]
"""Name of a distribution → its arguments, in SI."""


class CorrelationConfig(Section):
    """Parameters that are not drawn independently of each other (Gaussian copula)."""

    parameters: list[str] = Field(min_length=2)
    """Dotted parameters of ``over``; the others stay independent."""

    matrix: list[list[float]]
    """Correlations ρ of the standard normal variables behind the drawn values: one row and one column per
    parameter, ones on the diagonal. Spearman's rank correlation of the drawn values is (6/π) arcsin(ρ/2) for
    all distributions; the linear correlation of normal values is ρ itself."""

    @model_validator(mode="after")
    def _matrix_is_one_of_correlations(self) -> Self:
        size = len(self.parameters)
        if len(set(self.parameters)) < size:
            raise ValueError("names a parameter twice")
        if [len(row) for row in self.matrix] != [size] * size:
            raise ValueError(f"matrix needs {size} rows of {size} numbers, one per parameter")
        matrix = np.array(self.matrix)
        if not np.array_equal(matrix, matrix.T):
            raise ValueError("matrix must be symmetric")
        if not np.array_equal(np.diag(matrix), np.ones(size)):
            raise ValueError("matrix needs ones on its diagonal")
        if not (np.isfinite(matrix).all() and np.linalg.eigvalsh(matrix).min() > 1e-12):
            raise ValueError("matrix must be positive definite: these correlations contradict each other")
        return self


class SampleConfig(Section):
    """Points drawn from distributions."""

    method: Literal["sobol", "lhs", "random"] = "sobol"
    """Scrambled Sobol sequence, Latin hypercube, or independent draws (scipy.stats.qmc, numpy)."""

    count: Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
    """Number of points; a power of two keeps a Sobol sequence balanced."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed; the same seed gives the same points."""

    over: dict[str, Distribution] = Field(min_length=1)
    """Dotted parameter → its distribution: uniform [low, high], loguniform [low, high],
    normal [mean, standard deviation], truncated_normal [mean, standard deviation, low, high] (of the normal
    distribution before truncation), lognormal [median, factor] (the factor is the geometric standard
    deviation, above 1: two thirds of the draws lie from median/factor to median·factor), triangular [low,
    mode, high], integers [low, high] (integers, both ends included), or choice [value, …]. In place of the
    arguments, ``±20 %`` or ``±1 µm`` is a width about the experiment's own value: it sets the ends of uniform
    and triangular, and the standard deviation of normal."""

    correlation: CorrelationConfig | None = None
    """Parameters that are drawn jointly; by default all are independent."""

    @model_validator(mode="after")
    def _correlated_parameters_are_drawn(self) -> Self:
        for name in self.correlation.parameters if self.correlation else ():
            if name not in self.over:
                raise ValueError(f"correlation: {name!r} is not drawn{nearest(name, list(self.over))}")
        return self
