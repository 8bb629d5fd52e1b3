"""A change of the level of a series: whether there is one, since when, and how it goes on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, comparable

FEWEST = 12
"""Fewest points of a series."""

AFTER = 4
"""Fewest points after an onset, so that outliers are no change."""

_MOST_ONSETS = 120

_CORRELATIONS, _WHITE = (0.2, 0.4, 0.6, 0.75, 0.85, 0.92, 0.97), (0.0, 0.3, 0.6, 0.9)
"""Correlation from a point to the next, and share of the variance that is not correlated."""

_OUTLYING = 5.0
"""Robust standard deviations of neighbours beyond which a value is an outlier."""

_JUMP = 8.0
"""Robust standard deviations up to which a single error is not taken for a change; a choice between sudden
changes that are missed and jumps of the machine that look like one."""

# Standard deviation of a normal distribution over its median absolute deviation.
_TO_DEVIATION = 1.4826

_SEED = 28


@dataclass(frozen=True)
class GrowthLaw:
    """Growth over the share s of the time from the onset to the last point, 1 at s = 1.

    s^p, or (exp(k s) − 1)/(exp(k) − 1) if k > 0, in which the rate grows with the leak itself.
    """

    name: str
    prior: float
    power: float = 0.0
    pace: float = 0.0


LAWS = (
    GrowthLaw("sudden", 1 / 3),
    GrowthLaw("linear", 1 / 3, power=1.0),
    *(GrowthLaw("accelerating", 1 / 18, power=power) for power in (1.5, 2.0, 3.0)),
    *(GrowthLaw("accelerating", 1 / 18, pace=pace) for pace in (2.0, 4.0, 6.0)),
)
"""Laws of growth, with their probabilities before the data are seen: thirds for their names."""

_POWERS, _PACES = (np.array([getattr(law, name) for law in LAWS]) for name in ("power", "pace"))


def grown(time: Array, onset: Array, law: NDArray[np.int64], last: float) -> Array:
    """Share of the growth until `last`, shape (n_time, n_change)."""
    since, power, pace = time[:, None] - onset, _POWERS[law], _PACES[law]
    share = np.maximum(since, 0.0) / (last - onset)
    with np.errstate(over="ignore", invalid="ignore"):
        # Both forms are computed for all; without a pace the first is 0/0.
        rising = np.where(pace > 0.0, np.expm1(pace * share) / np.expm1(pace), share**power)
    # A sudden change is s^0, which is 1 before the onset as well.
    return np.where(since > 0.0, rising, 0.0)


@dataclass(frozen=True, eq=False)
class Draws:
    """Equally probable courses of the level, each of shape (n_draw,).

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants of the series.
    level, growth : ndarray
        Level before the onset, and its growth until the last point.
    onset, law : ndarray
        Onset, and place in `LAWS`.
    slopes : ndarray, shape (n_draw, n_covariate)
        Change of the level with a covariate.
    deviation : ndarray
        Standard deviation of single points.
    spacing : float
        Half the step from an onset to the next: an instant within the series is known no better.
    """

    time: Array
    level: Array
    growth: Array
    onset: Array
    law: NDArray[np.int64]
    slopes: Array
    deviation: Array
    spacing: float

    def levels(self, time: ArrayLike) -> Array:
        """The level at instants, shape (n_time, n_draw)."""
        share = grown(np.asarray(time, dtype=float), self.onset, self.law, self.time[-1])
        return np.asarray(self.level + self.growth * share)

    @property
    def rate(self) -> Array:
        """Derivative of the level at the last point; 0 after a step."""
        pace = _PACES[self.law]
        with np.errstate(invalid="ignore"):
            # k e^k/(e^k − 1) in a form that cannot overflow.
            slope = np.where(pace > 0.0, -pace / np.expm1(-pace), _POWERS[self.law])
        return np.asarray(self.growth * slope / (self.time[-1] - self.onset))

    def reached(self, limit: float) -> Array:
        """Instant at which the level reaches a limit from the side of the growth.

        −∞ if it was beyond before; +∞ if it does so never, or later than the length of the history after its
        end.
        """
        last, pace, is_sudden = self.time[-1], _PACES[self.law], np.equal(self.law, 0)
        # The side of most draws, so that all face the limit from the same one.
        side = np.sign(np.median(self.growth)) or 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (limit - self.level) / self.growth
            root = np.maximum(share, 0.0) ** (1.0 / _POWERS[self.law])
            reach = np.where(pace > 0.0, np.log1p(np.maximum(share, 0.0) * np.expm1(pace)) / pace, root)
        reach = np.where(is_sudden, np.where(share <= 1.0, 0.0, np.inf), reach)
        at = self.onset + (last - self.onset) * reach
        at = np.where((share >= 0.0) & (at <= 2.0 * last - self.time[0]), at, np.inf)
        return np.where(side * (self.level - limit) >= 0.0, -np.inf, at)


@dataclass(frozen=True, eq=False)
class _Noise:
    """A covariance of the errors, and the base columns in its terms.

    Attributes
    ----------
    root : ndarray, shape (n, n)
        Inverse of the Cholesky factor of the correlation matrix.
    base, triangle : ndarray, shape (n, n_base), (n_base, n_base)
        QR factors of the whitened base columns.
    columns : ndarray, shape (n, n_change)
        Whitened columns of the changes; `across` without their part along the base.
    lengths : ndarray, shape (n_change,)
        Squared lengths of `across`.
    log_weight : float
        Logarithm of prior and determinants.
    """

    cholesky: Array
    root: Array
    base: Array
    triangle: Array
    columns: Array
    across: Array
    lengths: Array
    log_weight: float


class ChangePointModel:
    """Levels that are constant, or grow by A from an onset c to the last of given instants, by a law g.

    y = a + b z + A g((t − c)/(t_n − c)) + e with a covariate z such as temperature. The errors e are the
    spread of the machine from point to point: a first-order autoregression in continuous time plus white
    noise, Cov = σ² ((1 − w) ρ^abs(Δt) + w δ). Priors are flat in a, b, A, log σ and over grids of c, g, ρ and
    w; integrals over coefficients and σ are exact, sums over the grids too (Zellner, An Introduction to
    Bayesian Inference in Econometrics (1971), chapter 3; Hoeting et al., Statistical Science 14 (1999) 382).

    Parameters
    ----------
    time : array_like, shape (n,)
        Increasing [unit of choice]. The correlation refers to the median step.
    covariate : array_like, shape (n,), optional

    Raises
    ------
    NotStatedError
        There are fewer than `FEWEST` points.
    """

    def __init__(self, time: ArrayLike, covariate: ArrayLike | None = None) -> None:
        self.time = np.asarray(time, dtype=float)
        self.n_point = self.time.size
        if self.n_point < FEWEST:
            raise NotStatedError(f"{self.n_point} points are too few for a trend", FEWEST)
        others = [] if covariate is None else [np.asarray(covariate, dtype=float)]
        # Centred, so that a is the level at the mean covariate.
        self.base = np.stack([np.ones(self.n_point), *(own - own.mean() for own in others)], axis=1)
        self.onset, self.law, self._prior = self._changes()
        # Lags in median steps, so that one grid of correlations suits any rate of records.
        self._steps = np.abs(self.time[:, None] - self.time[None]) / np.median(np.diff(self.time))

    def _changes(self) -> tuple[Array, NDArray[np.int64], Array]:
        """Onset, place in `LAWS` and prior of each change; onsets are evenly spread, also over a gap."""
        time, last = self.time, self.n_point - AFTER
        onsets, laws = [], []
        for index, law in enumerate(LAWS):
            # A step needs as many points before it as after it; a growth may begin with the series.
            own = _between(time[AFTER - 1 if law.name == "sudden" else 0 : last + 1])
            onsets.append(own if law.name == "sudden" else np.concatenate([time[:1], own]))
            laws.append(np.full(onsets[-1].size, index))
        priors = [np.full(own.size, law.prior / own.size) for own, law in zip(onsets, LAWS, strict=True)]
        return np.concatenate(onsets), np.concatenate(laws), np.concatenate(priors)

    @cached_property
    def noises(self) -> tuple[_Noise, ...]:
        """All covariances of the grid."""
        columns = grown(self.time, self.onset, self.law, self.time[-1])
        pairs = [(0.0, 0.0), *((rho, white) for rho in _CORRELATIONS for white in _WHITE)]
        return tuple(self._noise(rho, white, columns) for rho, white in pairs)

    def _noise(self, correlation: float, white: float, columns: Array) -> _Noise:
        alike = correlation**self._steps if correlation else np.eye(self.n_point)
        cholesky = np.linalg.cholesky((1.0 - white) * alike + white * np.eye(self.n_point))
        # Columns and values times the root have errors that are independent and equal.
        root = np.linalg.inv(cholesky)
        base, triangle = np.linalg.qr(root @ self.base)
        whitened = root @ columns
        across = whitened - base @ (base.T @ whitened)
        # A change along the base has no length of its own; the floor keeps quotients finite.
        lengths = np.maximum(np.sum(across**2, axis=0), 1e-12)
        # ½ ln det of the correlation and of the normal matrix of the base, from the integral over a and b.
        log_determinants = np.log(np.diag(cholesky)).sum() + np.log(np.abs(np.diag(triangle))).sum()
        prior = 1.0 / len(_CORRELATIONS) / len(_WHITE) if correlation else 1.0 / len(_CORRELATIONS)
        return _Noise(
            cholesky, root, base, triangle, whitened, across, lengths, np.log(prior) - log_determinants
        )

    def evidences(self, values: Array) -> Iterator[tuple[Array, Array]]:
        """For each covariance, log evidences of no change (n_series,), and of each (n_change, n_series).

        Both up to the same constant for all series, whose shape is (n, n_series).
        """
        n_free = self.n_point - self.base.shape[1]
        for noise in self.noises:
            whitened = noise.root @ values
            left = whitened - noise.base @ (noise.base.T @ whitened)
            square = np.sum(left**2, axis=0)
            # Pythagoras: the residual with a change from that without; the floor guards against cancellation.
            rest = np.maximum(square - (noise.across.T @ left) ** 2 / noise.lengths[:, None], 1e-12 * square)
            # The last term is from the integral over A.
            prior = noise.log_weight + np.log(self._prior) - np.log(noise.lengths) / 2.0
            none = noise.log_weight - n_free / 2.0 * np.log(square)
            yield none, prior[:, None] - (n_free - 1) / 2.0 * np.log(rest)

    def bayes_factors(self, values: Array) -> Array:
        """Log of the evidence of a change over that of none, up to a constant, shape (n_series,)."""
        pairs = [(none, _log_sum(some)) for none, some in self.evidences(values)]
        none, some = (np.array(each) for each in zip(*pairs, strict=True))
        return np.asarray(_log_sum(some) - _log_sum(none))

    def p_value(self, values: ArrayLike, n_repeat: int = 499) -> float:
        """Probability of at least this Bayes factor in a series without a change.

        Such series have a correlation drawn from its posterior without a change (posterior predictive check:
        Meng, Annals of Statistics 22 (1994) 1142), so that what is not known of it is allowed for.
        """
        own, random = np.asarray(values, dtype=float)[:, None], np.random.default_rng(_SEED)
        none = np.array([each[0] for each, _ in self.evidences(own)])
        drawn = random.choice(len(self.noises), n_repeat, p=_shares(none))
        healthy = np.empty((self.n_point, n_repeat))
        for index in np.unique(drawn):
            noise, rows = self.noises[index], drawn == index
            left = noise.root @ own[:, 0]
            left -= noise.base @ (noise.base.T @ left)
            spread = _TO_DEVIATION * np.median(np.abs(left - np.median(left)))
            errors = np.clip(left - np.median(left), -_JUMP * spread, _JUMP * spread)
            # Residuals of the series itself are drawn, so that tails that are not normal stay.
            sampled = random.choice(errors - errors.mean(), (self.n_point, int(rows.sum())))
            healthy[:, rows] = noise.cholesky @ sampled
        above = np.sum(self.bayes_factors(healthy) >= self.bayes_factors(own)[0])
        # The series counts as one of the repeats, so that no probability is zero.
        return float((1 + above) / (1 + n_repeat))

    def draws(self, values: ArrayLike, n_draw: int = 4000, *, is_changed: bool = True) -> Draws:
        """Draws from the posterior, with a change or without."""
        own, random = np.asarray(values, dtype=float), np.random.default_rng(_SEED)
        logs = np.array([(none[None], some)[is_changed] for none, some in self.evidences(own[:, None])])
        shares = _shares(logs[:, :, 0])
        picked = random.choice(shares.size, n_draw, p=shares.ravel())
        which, change = np.divmod(picked, shares.shape[1])
        n_free = self.n_point - self.base.shape[1] - is_changed
        base, growth, deviation = np.empty((n_draw, self.base.shape[1])), np.zeros(n_draw), np.empty(n_draw)
        for index in np.unique(which):
            rows, noise = np.flatnonzero(which == index), self.noises[index]
            whitened = noise.root @ own
            along, across = noise.base.T @ whitened, noise.across[:, change[rows]]
            left = whitened - noise.base @ along
            lengths, projected = noise.lengths[change[rows]], across.T @ left
            rest = np.sum(left**2) - (projected**2 / lengths if is_changed else 0.0)
            # Posterior of σ² with a flat prior in log σ: residual sum over a draw of χ².
            sigma = np.sqrt(np.maximum(rest, 0.0) / random.chisquare(n_free, rows.size))
            if is_changed:
                spread = sigma / np.sqrt(lengths) * random.standard_normal(rows.size)
                growth[rows] = projected / lengths + spread
            # The base takes back what of the growth lies along it.
            taken = (noise.base.T @ noise.columns[:, change[rows]]) * growth[rows]
            errors = sigma * random.standard_normal((self.base.shape[1], rows.size))
            base[rows] = np.linalg.solve(noise.triangle, along[:, None] - taken + errors).T
            deviation[rows] = sigma
        spacing = float(np.median(np.diff(self.onset[self.law == 0]))) / 2.0
        onset, law = self.onset[change], self.law[change]
        return Draws(self.time, base[:, 0], growth, onset, law, base[:, 1:], deviation, spacing)


def _between(time: Array) -> Array:
    """Instants between those of points, as far from each other as most points are, shape (n,)."""
    steps = np.diff(time)
    counts = np.maximum(np.round(comparable(steps / np.median(steps))), 1.0).astype(int)
    steps_before = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    instants = np.repeat(time[:-1], counts) + (steps_before + 0.5) * np.repeat(steps / counts, counts)
    n_found = min(_MOST_ONSETS, instants.size)
    return np.asarray(instants[np.linspace(0, instants.size - 1, n_found).round().astype(int)])


def inliers(values: ArrayLike) -> NDArray[np.bool_]:
    """Whether each value is close to the middle ones of its six neighbours, shape (n,).

    A change that lasts for `AFTER` points leaves no outliers. As close as five standard deviations, of which
    the differences from point to point are a measure, here or over all: in a steep growth they are large.
    """
    own = np.asarray(values, dtype=float)
    n_near = 2 * AFTER - 1
    first = np.clip(np.arange(own.size) - AFTER + 1, 0, own.size - n_near)
    neighbours = first[:, None] + np.arange(n_near)
    is_other = neighbours != np.arange(own.size)[:, None]
    others = np.sort(own[neighbours][is_other].reshape(own.size, n_near - 1), axis=1)
    # Distance from the two middle ones of six neighbours; negative between them.
    away = np.maximum(own - others[:, AFTER - 1], others[:, AFTER - 2] - own)
    steps = np.abs(np.diff(own))
    near = np.median(steps[first[:, None] + np.arange(n_near - 1)], axis=1)
    # A step is the difference of two values, hence √2.
    spread = _TO_DEVIATION / np.sqrt(2.0) * np.maximum(near, np.median(steps))
    return np.asarray(away <= _OUTLYING * spread)


def _log_sum(logs: Array) -> Array:
    largest = logs.max(axis=0)
    # Without the largest exponent no exponential overflows.
    return np.asarray(largest + np.log(np.sum(np.exp(logs - largest), axis=0)))


def _shares(logs: Array) -> Array:
    shares = np.exp(logs - logs.max())
    return np.asarray(shares / shares.sum())
