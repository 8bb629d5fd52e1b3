"""Natural frequency and damping ratio from the pressure ringing after each step of the drive.

A matrix pencil over all pieces of a record gives initial values; least squares refine them in each piece. The
model of a piece is a polynomial plus c_1 exp(s_1 t) + c_2 exp(s_2 t), where s_1 and s_2 are the complex or
real roots of s² + a s + b.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.catalogue import transients
from hydrofdi.indicators.contract import Output, SingleChannelIndicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

_LONGEST_PENCIL = 24


def common_motion(pieces: Array, group: NDArray[np.intp]) -> tuple[Array, Array]:
    """Coefficients a and b of the characteristic polynomial s² + a s + b that the pieces of a group share.

    `pieces` (n_piece, n_time) are detrended, `group` (n_piece,) ascends. The unit of time is the length of a
    piece.
    """
    n_time = pieces.shape[1]
    first = np.flatnonzero(np.diff(group, prepend=-1))
    products = _pencil_products(pieces, first, min(n_time // 3, _LONGEST_PENCIL))
    # One group that is not finite could fail the decomposition of all; its result means nothing.
    products[~np.isfinite(products).all(axis=(1, 2))] = np.eye(products.shape[1])
    # Shift invariance of the two-dimensional signal space: its step over one sample has the poles as roots.
    space = np.linalg.eigh(products)[1][:, :, -2:]
    last = space[:, -1]
    step = space[:, :-1].transpose(0, 2, 1) @ space[:, 1:]
    # Least squares: without its last row u the space has the products I − u uᵀ (inverse: Sherman, Morrison).
    left = np.sum(last[:, :, None] * step, axis=1) / (1.0 - np.sum(np.square(last), axis=1))[:, None]
    step = step + last[:, :, None] * left[:, None, :]
    # Roots of the characteristic polynomial of the step, a 2 × 2 matrix; complex if the motion swings.
    half = 0.5 * (step[:, 0, 0] + step[:, 1, 1])
    split = half**2 - step[:, 0, 0] * step[:, 1, 1] + step[:, 0, 1] * step[:, 1, 0]
    roots = half[:, None] + np.sqrt(split[:, None] + 0j) * np.array([1.0, -1.0])
    # From per sample to per piece.
    rates = np.log(roots) * n_time
    of_piece = np.cumsum(np.diff(group, prepend=-1) != 0) - 1
    # Sum and product of the roots; noise can make the product negative.
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


_MOST_ITERATIONS = 10
_SETTLED = 1e-7
"""Relative change at which the iteration has converged: the next change would be its square."""
_LEAST_SPLIT = 1e-3
"""Lower limit of abs((s_1 − s_2)/2)², time in windows; closer roots are moved this far apart."""
_RIDGE = 1e-13


@dataclass(frozen=True)
class FreeMotion:
    """Least-squares estimates of each piece; all of shape (n_piece,).

    Frequency √b/2π [Hz] and its standard deviation if the residuals are white; damping ratio a/(2√b), at
    least 1 if the roots are real, and its deviation; fraction of the detrended energy that the motion
    explains.
    """

    frequency: Array
    frequency_deviation: Array
    damping_ratio: Array
    damping_deviation: Array
    explained: Array


def fit_free_motion(
    pieces: Array, group: NDArray[np.intp], sampling_frequency: float, degree: int
) -> FreeMotion:
    """Fit a second-order motion plus a polynomial of a degree to each piece (n_piece, n_time).

    n_time is at least degree + 8. Pieces of a group (n_piece,), which ascends, share initial values. A piece
    that is only a polynomial gives meaningless results.
    """
    n_time = pieces.shape[1]
    trend = transients.orthonormal_polynomials(n_time, degree)
    rest = transients.less_polynomials(pieces, trend)
    power = np.sum(np.square(rest), axis=1)
    a, b = common_motion(rest, group)
    left, covariance = np.empty(a.size), np.empty((a.size, 2, 2))
    moving = np.arange(a.size)
    for _ in range(_MOST_ITERATIONS):
        change, left[moving], covariance[moving] = _improvement(a[moving], b[moving], rest[moving], trend)
        a[moving], b[moving], is_moving = _moved(a[moving], b[moving], change)
        moving = moving[is_moving]
    left += power
    # Degrees of freedom: samples less degree + 1 of the trend, and four of the motion.
    covariance *= (np.maximum(left, 0.0) / (n_time - degree - 5))[:, None, None]
    return _in_frequency(a, b, covariance, 1.0 - left / power, sampling_frequency / n_time)


def _improvement(a: Array, b: Array, rest: Array, trend: Array) -> tuple[Array, Array, Array]:
    """Gauss-Newton step for a and b, reduction of the sum of squares, and inverse normal matrix."""
    products, with_rest = _products(a, b, rest, trend)
    motion, slopes = _slopes(a, b, products, with_rest)
    normal = slopes @ products @ slopes.transpose(0, 2, 1)
    size = np.sqrt(np.diagonal(normal, axis1=1, axis2=2))
    sizes = size[:, :, None] * size[:, None, :]
    # Scaled to a unit diagonal, so that the ridge is relative.
    inverse = np.linalg.inv(normal / sizes + _RIDGE * np.eye(4)) / sizes
    left = with_rest - _times(products, motion)
    change = _times(inverse, _times(slopes, left))
    # mᵀPm − 2 mᵀw as −mᵀ(w + (w − Pm)).
    return change[:, 2:], -np.sum(motion * (with_rest + left), axis=1), inverse[:, 2:, 2:]


def _moved(a: Array, b: Array, change: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """a and b after a change, limited to the neighbourhood, and whether the change is still large."""
    by_a, by_b = np.abs(change[:, 0]) / np.sqrt(b), np.abs(change[:, 1]) / b
    # A step changes a by 3 √b and b by 0.9 b at most, so that b stays positive.
    share = 1.0 / np.maximum(1.0, np.maximum(by_a / 3.0, by_b / 0.9))
    return a + share * change[:, 0], b + share * change[:, 1], np.maximum(by_a, by_b) > _SETTLED


def _products(a: Array, b: Array, rest: Array, trend: Array) -> tuple[Array, Array]:
    """Inner products of detrended C, S, tC, tS (n_piece, 4, 4), and with the residual (n_piece, 4).

    C and S are the motions exp(−a t/2) cosh(r t) and exp(−a t/2) sinh(r t)/r with r² = a²/4 − b.
    """
    n_time = rest.shape[1]
    # Complex, for swinging and creeping motions alike.
    root = np.sqrt(_split(a, b) + 0j)
    one, other = (_powers(np.exp((sign * root - 0.5 * a) / n_time), n_time) for sign in (1.0, -1.0))
    base = np.empty((a.size, 4, n_time))
    base[:, 0] = 0.5 * (one + other).real
    base[:, 1] = ((one - other) / (2.0 * root[:, None])).real
    base[:, 2:] = base[:, :2] * (np.arange(n_time) / n_time)
    # The trend is taken from the products instead of from the motions.
    along = base @ trend.T
    return base @ base.transpose(0, 2, 1) - along @ along.transpose(0, 2, 1), _times(base, rest)


def _slopes(a: Array, b: Array, products: Array, with_rest: Array) -> tuple[Array, Array]:
    """Best motion (n_piece, 4), and its derivatives by c_1, c_2, a and b, in terms of C, S, tC, tS."""
    # Basis C, S, tC, tS: amplitudes c_1, c_2 of C and S by Cramer's rule, then the chain rule by a and b.
    determinant = products[:, 0, 0] * products[:, 1, 1] - products[:, 0, 1] ** 2
    motion = np.zeros_like(with_rest)
    motion[:, 0] = products[:, 1, 1] * with_rest[:, 0] - products[:, 0, 1] * with_rest[:, 1]
    motion[:, 1] = products[:, 0, 0] * with_rest[:, 1] - products[:, 0, 1] * with_rest[:, 0]
    motion /= determinant[:, None]
    over_split = np.zeros_like(with_rest)
    over_split[:, 2] = motion[:, 1] / (2.0 * _split(a, b))
    over_split[:, 1] = -over_split[:, 2]
    over_split[:, 3] = 0.5 * motion[:, 0]
    slopes = np.zeros_like(products)
    slopes[:, 0, 0] = slopes[:, 1, 1] = 1.0
    slopes[:, 2, 2:] = -0.5 * motion[:, :2]
    slopes[:, 2] += 0.5 * a[:, None] * over_split
    slopes[:, 3] = -over_split
    return motion, slopes


def _split(a: Array, b: Array) -> Array:
    split = 0.25 * a**2 - b
    return np.copysign(np.maximum(np.abs(split), _LEAST_SPLIT), split)


def _powers(base: NDArray[np.complex128], n_power: int) -> NDArray[np.complex128]:
    """Rows 1, z, z², …, computed by doubling."""
    powers = np.ones((base.size, n_power), dtype=complex)
    known, factor = 1, base[:, None]
    while known < n_power:
        more = min(known, n_power - known)
        powers[:, known : known + more] = powers[:, :more] * factor
        known, factor = known + more, factor * factor
    return powers


def _in_frequency(a: Array, b: Array, covariance: Array, explained: Array, windows: float) -> FreeMotion:
    """Frequency [Hz] and damping ratio from a and b; `windows` converts from windows to seconds [1/s]."""
    root = np.sqrt(b)
    frequency, damping_ratio = root * windows / (2.0 * np.pi), a / (2.0 * root)
    # By the slopes f/(2b) of f, and 1/(2√b) and −ζ/(2b) of ζ = a/(2√b).
    frequency_variance = covariance[:, 1, 1] * (0.5 * frequency / b) ** 2
    over_a, over_b = 0.5 / root, -0.5 * damping_ratio / b
    damping_variance = (
        over_a**2 * covariance[:, 0, 0]
        + 2.0 * over_a * over_b * covariance[:, 0, 1]
        + over_b**2 * covariance[:, 1, 1]
    )
    return FreeMotion(
        frequency, np.sqrt(frequency_variance), damping_ratio, np.sqrt(damping_variance), explained
    )


def _times(matrices: Array, vectors: Array) -> Array:
    """Product of each matrix (n, k, l) and vector (n, l)."""
    product: Array = np.matmul(matrices, vectors[:, :, None])[:, :, 0]
    return product


_LEAST_SAMPLES = 24


class RingDownOptions(transients.SteppedChannelOptions):
    """Options of `RingDown`."""

    less: Channel | None = None
    """Channel to subtract, such as ``chamber_2_pressure``: the difference scatters less."""

    delay: Annotated[float, SI("s", least=0)] = 10e-3
    """Time excluded after a step [s], while the valve moves."""

    window: Annotated[float, SI("s", above=0)] = 0.2
    """Time analysed after each step [s]."""

    trend_degree: Annotated[int, Field(strict=True, ge=0, le=6)] = 2
    """Degree of the polynomial trend of the pressure."""

    largest_damping: Annotated[float, SI("1", above=0, most=1)] = 0.7
    """Largest damping ratio that counts as ringing [-]; above it there is no resonance."""

    least_explained: Annotated[float, SI("1", least=0, most=1)] = 0.5
    """Fraction of the energy of the detrended pressure that the ringing must explain [-]; white noise gives
    less than 0.2."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The pressures, and the input voltage if ``steps`` needs it."""
        return super().channels | (set() if self.less is None else {self.less})


class RingDown(SingleChannelIndicator[RingDownOptions]):
    """Natural frequency and damping ratio of the pressure after the steps of the drive."""

    name = "ring_down"
    version = 1
    source = "Hua and Sarkar, IEEE Trans. Acoust., Speech, Signal Process. (1990): matrix pencil"
    equation = "P = polynomial + Re(c exp(s t)) by least squares; s = 2π f_h (−ζ + i √(1 − ζ²))"
    absence = "no step of the drive is followed by a full window in which the pressure moves"
    Options = RingDownOptions

    outputs = (
        Output("frequency", "Hz", "natural frequency f_h"),
        Output.quality("frequency_error", "Hz", "standard error of f_h from the spread over the steps"),
        Output.quality(
            "frequency_formal_error", "Hz", "standard error of f_h from the residuals of the fits"
        ),
        Output("damping_ratio", "1", "damping ratio ζ", direction=Direction.RISING),
        Output.quality("damping_ratio_error", "1", "standard error of ζ from the spread over the steps"),
        Output.quality(
            "damping_ratio_formal_error", "1", "standard error of ζ from the residuals of the fits"
        ),
        Output.quality("steps", "1", "number of steps that ring"),
        Output("overdamped", "1", "fraction of steps that do not ring", direction=Direction.RISING),
    )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the steps cannot be found, or if a window has too few samples."""
        return self.options.obstacle(records, _LEAST_SAMPLES)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); frequencies in Hz, the others dimensionless."""
        signal = self.signal(records)
        if self.options.less is not None:
            signal = signal - records[self.options.less]
        steps, pieces = self._pieces(records, signal)
        frequency = records.sampling_frequency
        motion = fit_free_motion(pieces, steps.record, frequency, self.options.trend_degree)
        return _summary(motion, steps, records.n_record, self._is_ringing(motion))

    def _pieces(self, records: RecordBatch, signal: Array) -> tuple[transients.Steps, Array]:
        """Steps that have a full window of finite, varying pressure, and the pressure in it."""
        steps = self.options.steps_of(records, signal)
        pieces = steps.windows(signal, *self.options.window_samples(records.sampling_frequency))
        moves = np.isfinite(pieces).all(axis=1) & (np.ptp(pieces, axis=1) > 1e-9 * np.abs(pieces).max(axis=1))
        return steps.where(moves), pieces[moves]

    def _is_ringing(self, motion: FreeMotion) -> NDArray[np.bool_]:
        """Whether an oscillation with at least one period explains a piece."""
        damped = motion.frequency * np.sqrt(np.maximum(1.0 - motion.damping_ratio**2, 0.0))
        rings: NDArray[np.bool_] = damped * self.options.window >= 1.0
        rings &= motion.damping_ratio <= self.options.largest_damping
        return rings & (motion.explained >= self.options.least_explained)


def _summary(
    motion: FreeMotion, steps: transients.Steps, n_record: int, rings: NDArray[np.bool_]
) -> dict[str, Array]:
    ringing = steps.where(rings)
    n_step, n_ringing = steps.counts(n_record), ringing.counts(n_record).astype(float)
    values = {"steps": np.where(n_step > 0, n_ringing, np.nan), "overdamped": 1.0 - n_ringing / n_step}
    found = {
        "frequency": (motion.frequency[rings], motion.frequency_deviation[rings]),
        "damping_ratio": (motion.damping_ratio[rings], motion.damping_deviation[rings]),
    }
    for name, (of_steps, deviation) in found.items():
        values[name], spread = ringing.spread(of_steps, n_record)
        values[f"{name}_error"] = np.sqrt(spread / ((n_ringing - 1.0) * n_ringing))
        values[f"{name}_formal_error"] = np.sqrt(ringing.sums(np.square(deviation), n_record)) / n_ringing
    return values
