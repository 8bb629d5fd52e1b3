"""Coefficients of a Volterra/NARX model fitted to each record."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations_with_replacement
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section

Term = tuple[int, ...]
"""Indices of the lagged values that are multiplied; the empty tuple is the constant term."""


def block_means(samples: Array, length: int) -> Array:
    """Block means of the samples, shape (n_record, n_time // length)."""
    n_block = samples.shape[1] // length
    # A contiguous copy, so that sums run in one order and give the same bits for any layout.
    blocks = np.ascontiguousarray(samples[:, : n_block * length])
    return np.asarray(blocks.reshape(-1, n_block, length).mean(axis=2))


def regressors(given: Array, signal: Array, n_given: int, n_own: int, terms: tuple[Term, ...]) -> Array:
    """Regressors (n_equation, n_term) of one record with lags of the input and of the signal (n_time,)."""
    start = max(n_given, n_own)
    values = [given[start - lag : given.size - lag] for lag in range(1, n_given + 1)]
    values += [signal[start - lag : signal.size - lag] for lag in range(1, n_own + 1)]
    columns = np.ones((signal.size - start, len(terms)))
    for column, term in zip(columns.T, terms, strict=True):
        for index in term:
            column *= values[index]
    return columns


def ridge_regression(columns: Array, target: Array, ridge: float) -> tuple[Array, float]:
    """Coefficients (n_term,) and RMS of the residual; NaN if they are not determined.

    `ridge` weights the squared coefficients relative to the mean squared residual.
    """
    n_equation, n_term = columns.shape
    roots = np.sqrt(ridge * n_equation) * np.eye(n_term)
    if not (np.isfinite(columns).all() and np.isfinite(target).all()):
        return np.full(n_term, np.nan), np.nan
    # Ridge as further equations: normal equations would lose half of the digits.
    padded = np.concatenate((columns, roots)), np.concatenate((target, np.zeros(n_term)))
    coefficients, _, rank, _ = np.linalg.lstsq(*padded, rcond=None)
    if rank < n_term:
        return np.full(n_term, np.nan), np.nan
    return coefficients, float(np.sqrt(np.mean((target - columns @ coefficients) ** 2)))


P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION

_CHANNELS = {"load_pressure": {P1, P2}, "pressure": {P1}, "position_rate": {X}}


class VolterraOptions(Section):
    """Options of `Volterra`."""

    signal: Literal["load_pressure", "pressure", "position_rate"] = "position_rate"
    """Modelled signal: P_1 − P_2, P_1, or the rate of the position."""

    order: Annotated[int, Field(strict=True, ge=1, le=4)] = 2
    """Highest degree of the polynomial."""

    input_lags: Annotated[int, Field(strict=True, ge=1, le=10)] = 1
    """Lagged values of the input voltage."""

    lags: Annotated[int, Field(strict=True, ge=0, le=10)] = 1
    """Lagged values of the signal itself; 0 gives a Volterra series in the input only."""

    decimation: Annotated[int, Field(strict=True, ge=1)] = 100
    """Number of samples that are averaged to one value of the model."""

    input_scale: Annotated[float, SI("V", above=0)] = 2.0
    """Scale of the input voltage [V]."""

    pressure_centre: Annotated[float, SI("Pa", least=0)] = 8.6e6
    """Offset of the pressure [Pa], for ``signal: pressure``."""

    pressure_scale: Annotated[float, SI("Pa", above=0)] = 8.6e6
    """Scale of the pressure [Pa]."""

    rate_scale: Annotated[float, SI("m/s", above=0)] = 0.1
    """Scale of the rate of the position [m/s]."""

    ridge: Annotated[float, SI("1", least=0)] = 1e-6
    """Weight of the squared coefficients relative to the mean square of the model's residual [-]."""


class Volterra(Indicator[VolterraOptions]):
    """Coefficients of a second-order Volterra model with feedback (NARX) of the record."""

    name = "volterra"
    version = 1
    source = (
        "Tan and Sepehri, IEEE Trans. Ind. Electron. 49 (2002) 96; Leontaritis and Billings, Int. J. Control"
        " 41 (1985) 303"
    )
    equation = "y_k = c_0 + Σ c_i z_i + Σ c_ij z_i z_j, z = (u_(k−1) …, y_(k−1) …), by ridge regression"
    caution = (
        "No single coefficient measures leakage, and each also responds to supply and fluid: use their"
        " distance from healthy records (detection.scores, mahalanobis). They depend on the motion."
    )
    absence = "the coefficients are not determined: a missing sample, or an input without motion and no ridge"
    needs_scale = True
    Options = VolterraOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """The input voltage, and the channels of the signal."""
        return frozenset({Channel.INPUT_VOLTAGE} | _CHANNELS[self.options.signal])

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Coefficients, and the RMS of the residual."""
        names = [f"u{lag}" for lag in range(1, self.options.input_lags + 1)]
        names += [f"y{lag}" for lag in range(1, self.options.lags + 1)]
        products = ("·".join(names[index] for index in term) or "1" for term in self._terms)
        return (
            Output(
                "coefficients", "1", f"coefficients of {', '.join(products)}, in scaled quantities",
                dims={"term": len(self._terms)},
            ),
            Output.quality("left", "1", "RMS of the scaled residual of the model"),
        )  # fmt: skip

    @property
    def _terms(self) -> tuple[Term, ...]:
        """All products of lagged values up to the order, sorted by degree."""
        values, degrees = range(self.options.input_lags + self.options.lags), range(self.options.order + 1)
        return tuple(term for degree in degrees for term in combinations_with_replacement(values, degree))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record has fewer than two values per coefficient."""
        n_value = records.n_time // self.options.decimation - max(self.options.input_lags, self.options.lags)
        n_term = len(self._terms)
        if n_value < 2 * n_term:
            return f"{max(n_value, 0)} values are too few for {n_term} coefficients"
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Coefficients of each record, (n_record, n_term), and residual, (n_record,)."""
        options = self.options
        given = block_means(records[Channel.INPUT_VOLTAGE], options.decimation) / options.input_scale
        signal, terms = self._signal(records), self._terms
        coefficients, left = np.empty((records.n_record, len(terms))), np.empty(records.n_record)
        start = max(options.input_lags, options.lags)
        for row in range(records.n_record):
            columns = regressors(given[row], signal[row], options.input_lags, options.lags, terms)
            coefficients[row], left[row] = ridge_regression(columns, signal[row, start:], options.ridge)
        return {"coefficients": coefficients, "left": left}

    def _signal(self, records: RecordBatch) -> Array:
        """The scaled signal to model, shape (n_record, n_value)."""
        options, every = self.options, self.options.decimation
        match options.signal:
            case "load_pressure":
                return block_means(records[P1] - records[P2], every) / options.pressure_scale
            case "pressure":
                return block_means(records[P1] - options.pressure_centre, every) / options.pressure_scale
        position = block_means(records[X], every)
        rate = np.diff(position, axis=1, prepend=position[:, :1]) * records.sampling_frequency / every
        return np.asarray(rate / options.rate_scale)
