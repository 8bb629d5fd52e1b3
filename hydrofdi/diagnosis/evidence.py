"""Probabilities of faults from how a record differs from a healthy history.

The signature z of a healthy record follows a multivariate Student distribution about the centre of the
history (Gelman et al., Bayesian Data Analysis, 2013, section 3.6). A fault of size s shifts it by s G b, with
the gain matrix G of the estimates, and an error of the model that is a share of the shift in any direction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hydrofdi.diagnosis.balance import CAUSES
from hydrofdi.diagnosis.history import History, signatures
from hydrofdi.diagnosis.hypotheses import HEALTHY, NONE, REPAIRS, SENSORS, Hypothesis, hypotheses
from hydrofdi.evaluation.scores import comparable
from hydrofdi.indicators.balancing import P1, P2, X
from hydrofdi.records import Array, Channel, RecordBatch

PRIOR_HEALTHY, PRIOR_NONE = 0.9, 0.05
"""Probability that nothing is wrong before the record is seen; share of a fault without a hypothesis in the
rest, which the other hypotheses divide equally."""

NAMED = 0.01
"""Least probability of a fault that is named."""

_SIZES = np.logspace(-1.5, 1.5, 25)
"""Sizes over the usual one, all equally probable."""

_SIZE = 0.85
"""Error of a size over the error of its direction: sizes of leaks were 0.5 to 1.4 of the true ones on twelve
machines of real-rig."""

_MISFIT = 0.1
"""Deviation of the logarithm of the misfit that every fault may add."""

_FREE = 30.0
"""Deviation of a quantity that a fault changes by an unknown amount, over its healthy one."""

_SCALES = np.logspace(np.log10(1.5), 3.0, 16)
"""Scatter of a record with an unknown fault, over the healthy one."""

_STRANGE = 0.1
"""Largest probability that nothing is wrong with a record that is unlike the rest of its history."""

_MOST_SEEN = 10.0
"""Size over the usual one from which on half of the faults must be seen: a leak of 30 % of the flow."""

_MISSED, _FORMS = 1.645, 0.25
"""Deviation by which a fault that would just be seen may seem smaller than it is, and share of its forms
that may be seen less."""

_TOLD_APART = 2.0 * np.log(20.0)
"""Squared distance at which one fault is expected to be twenty times as likely as the other."""


@dataclass(frozen=True)
class Finding:
    """A hypothesis after a record was seen.

    Attributes
    ----------
    name, title, unit, advice : str
    probability, low, high : float
        With its range if the healthy scatter is as small or large as its 95 % interval allows.
    size, size_low, size_high : float
        Estimate of the size and its 95 % interval, in `unit`; NaN if it has none.
    visible : float
        Size from which on most of its forms would be seen, in `unit`; infinite if no size would, NaN if it
        has none.
    looks_like : tuple of str
        Other faults that the sensors would not tell from it at this size; of none of these, the nearest one.
    told_by : mapping of str to str
        Such a fault → what to measure to tell it apart; missing if nothing that is known does.
    """

    name: str
    title: str
    unit: str
    advice: str
    probability: float
    low: float
    high: float
    size: float = float("nan")
    size_low: float = float("nan")
    size_high: float = float("nan")
    visible: float = float("nan")
    looks_like: tuple[str, ...] = ()
    told_by: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Shift:
    """Whitened difference from the centre, shift per size of each direction, and ln det of the scatter."""

    difference: Array
    directions: Array
    log_determinant: float


class Judge:
    """States probabilities of faults of records with one history."""

    def __init__(self, history: History) -> None:
        self.history = history
        self.hypotheses = hypotheses(history)
        n_other = len(self.hypotheses) + len(REPAIRS)
        self._log_prior = float(np.log((1.0 - PRIOR_HEALTHY) * (1.0 - PRIOR_NONE) / n_other))

    def stranger(self) -> tuple[int, Judge, Finding] | None:
        """The record of the history that differs most, what the others judge it to be, and these; None if it
        is like them."""
        seen, *_ = self.history.seen
        white, _ = self._whitened(self.history.scatter, seen - self.history.centre)
        row = int(np.argmax(comparable(np.sum(white**2, axis=1))))
        others = Judge(self.history.without(row))
        findings = others.judge(*(each[row] for each in self.history.seen))
        chance = next((each.probability for each in findings if each.name == HEALTHY), 1.0)
        return None if chance > _STRANGE else (row, others, findings[0])

    def findings(self, record: RecordBatch) -> list[Finding]:
        """Findings on one record, the most probable first; none if no fault could be seen."""
        history = self.history
        (own,), estimates = signatures(history.balance, record, history.variance)
        gain, covariance = estimates.gains[0], estimates.covariances[0]
        findings = self.judge(own, gain, covariance)
        if not findings or findings[0].name == HEALTHY:
            return findings
        # A recording that is wired wrongly is undone exactly; only then is it worth the time.
        repaired = {
            name: signatures(history.balance, each, history.variance)[0][0]
            for name, each in self._repaired(record)
        }
        return self.judge(own, gain, covariance, repaired)

    def _repaired(self, record: RecordBatch) -> Iterator[tuple[str, RecordBatch]]:
        """The record as it would be without each fault of the recording."""
        balance, channels = self.history.balance, record.channels
        drive = Channel.SPOOL_POSITION if balance.options.spool == "measured" else Channel.INPUT_VOLTAGE
        if balance.both:
            changed = {P1: channels[P2], P2: channels[P1]}
            yield "swapped_pressures", replace(record, channels={**channels, **changed})
        yield "wrong_sign_u", replace(record, channels={**channels, drive: -channels[drive]})
        if balance.options.position_zero == "centre":
            yield "wrong_sign_x", replace(record, channels={**channels, X: -channels[X]})

    def judge(
        self, signature: Array, gain: Array, covariance: Array, repaired: Mapping[str, Array] | None = None
    ) -> list[Finding]:
        """Findings, the most probable first; none if most faults could not be seen at any size.

        Parameters
        ----------
        signature : ndarray, shape (n_name,)
            That of the record.
        gain, covariance : ndarray, shape (N, N)
            Gain matrix and covariance of its estimates.
        repaired : mapping of str to ndarray, optional
            Name in `REPAIRS` → signature of the repaired record.
        """
        if not np.all(np.isfinite(signature)):
            return []
        difference = signature - self.history.centre
        scatter = self.history.scatter_of(gain, covariance)
        shifts = {
            each.name: [
                self._shift(difference, scatter, gain, each, is_free=is_free)
                for is_free in ((False, True) if each.free else (False,))
            ]
            for each in self.hypotheses
        }
        healthy = self._whitened(scatter, difference[None])
        others = {
            name: self._whitened(scatter, (each - self.history.centre)[None])
            for name, each in (repaired or {}).items()
        }
        visible = {
            each.name: self._visible(shifts[each.name][0], each, healthy[1]) for each in self.hypotheses
        }
        if np.median([visible[each.name] / each.usual for each in self.hypotheses]) > _MOST_SEEN:
            return []
        seen = {name: shifts[name] for name, size in visible.items() if np.isfinite(size)}
        chances = [self._probabilities(seen, healthy, others, factor) for factor in self._factors()]
        best = chances[0]
        # Rounded, so that the order is the same on all processors.
        order = sorted(best, key=lambda name: -comparable(best[name]))
        found = [self._finding(name, chances, shifts, scatter, gain) for name in order]
        return [replace(each, visible=visible.get(each.name, each.visible)) for each in found]

    def _factors(self) -> tuple[float, float, float]:
        """Factors on the scatter: as estimated, and the ends of its 95 % interval."""
        from scipy.stats import chi2

        dof = self.history.dof
        low, high = (float(dof / chi2.ppf(share, dof)) for share in (0.975, 0.025))
        return 1.0, low, high

    def _shift(
        self, difference: Array, scatter: Array, gain: Array, hypothesis: Hypothesis, *, is_free: bool = True
    ) -> _Shift:
        # All hypotheses share the scatter of the caller.
        scatter = scatter.copy()
        for name in hypothesis.free if is_free else ():
            if name in self.history.names:
                place = self.history.names.index(name)
                scatter[place, place] *= 1.0 + _FREE**2
        scatter[-1, -1] += _MISFIT**2
        # Causes of the balance are seen through its estimate, forces and pressure directly.
        own, rest = np.split(hypothesis.directions, [len(CAUSES)], axis=1)
        moved = np.hstack((own @ gain.T, rest))
        white, log_determinant = self._whitened(scatter, np.vstack((difference, moved)))
        return _Shift(white[0], white[1:], log_determinant)

    def _whitened(self, scatter: Array, rows: Array) -> tuple[Array, float]:
        factor = np.linalg.cholesky(scatter)
        return np.linalg.solve(factor, rows.T).T, 2.0 * float(np.sum(np.log(np.diag(factor))))

    def _log_density(self, squares: Array, log_determinant: Array | float) -> Array:
        """Logarithm of a Student density, up to a constant."""
        dof, size = self.history.dof, len(self.history.names)
        return np.asarray(-0.5 * log_determinant - 0.5 * (dof + size) * np.log1p(squares / dof))

    def _probabilities(
        self,
        shifts: Mapping[str, Sequence[_Shift]],
        healthy: tuple[Array, float],
        others: Mapping[str, tuple[Array, float]],
        factor: float,
    ) -> dict[str, float]:
        """Name → probability, if the scatter is `factor` times the one of the history."""
        size = len(self.history.names)
        square = float(np.sum(healthy[0] ** 2)) / factor
        nothing = float(self._log_density(np.array(square), healthy[1]))
        logs = {HEALTHY: nothing + np.log(PRIOR_HEALTHY)}
        spread = _SCALES**2
        # A wider scatter adds to ln det once for each quantity.
        wide = self._log_density(square / spread, healthy[1] + size * np.log(spread))
        logs[NONE] = _log_mean(wide) + np.log((1.0 - PRIOR_HEALTHY) * PRIOR_NONE)
        for hypothesis in self.hypotheses:
            # What could not be seen at any size looks as if nothing were wrong.
            own = shifts.get(hypothesis.name, ())
            densities = [self._density(each, hypothesis, factor) for each in own] or [nothing]
            logs[hypothesis.name] = _log_mean(np.array(densities)) + self._log_prior
        for name, (white, log_determinant) in others.items():
            found = float(self._log_density(np.array(np.sum(white**2) / factor), log_determinant))
            logs[name] = found + self._log_prior
        top = max(logs.values())
        # Over the most probable one, as densities themselves may underflow.
        weights = {name: float(np.exp(value - top)) for name, value in logs.items()}
        total = sum(weights.values())
        return {name: weight / total for name, weight in weights.items()}

    def _visible(self, shift: _Shift, hypothesis: Hypothesis, log_determinant: float) -> float:
        """Size from which on this fault is more probable than that nothing is wrong; infinite if none is."""
        count, lengths = len(self.history.names), np.sqrt(np.sum(shift.directions**2, axis=1))
        length = float(np.quantile(lengths, _FORMS))
        least = np.inf
        for size in hypothesis.usual * _SIZES[::-1]:
            # The direction errs; the last coordinate stands for the scatter beside it.
            along = max(size * length / (1.0 + hypothesis.error) - _MISSED, 0.0)
            beside = np.array([along, np.sqrt(count)])
            seen = _Shift(beside, np.array([[length, 0.0]]), shift.log_determinant)
            healthy = float(self._log_density(along**2 + count, log_determinant)) + np.log(PRIOR_HEALTHY)
            if self._density(seen, hypothesis, 1.0) + self._log_prior < healthy:
                break
            least = size
        return float(least)

    def _density(self, shift: _Shift, hypothesis: Hypothesis, factor: float) -> float:
        """Logarithm of the mean density over sizes and directions."""
        count, sizes = len(self.history.names), hypothesis.usual * _SIZES[:, None]
        moved = sizes**2 * np.sum(shift.directions**2, axis=1)
        # abs(d − s v)² for all sizes and directions at once.
        left = np.sum(shift.difference**2) - 2.0 * sizes * (shift.directions @ shift.difference) + moved
        # The true shift differs from the model's by a share of it, in any direction.
        wider = 1.0 + hypothesis.error**2 * moved / factor / count
        determinant = shift.log_determinant + count * np.log(wider)
        return _log_mean(self._log_density(left / factor / wider, determinant))

    def _finding(
        self,
        name: str,
        chances: Sequence[Mapping[str, float]],
        shifts: Mapping[str, Sequence[_Shift]],
        scatter: Array,
        gain: Array,
    ) -> Finding:
        found = [each[name] for each in chances]
        range_of: dict[str, Any] = {"probability": found[0], "low": min(found), "high": max(found)}
        if name not in shifts:
            title = {HEALTHY: "nothing is wrong", NONE: "none of these"}.get(name) or REPAIRS[name]
            advice = "compare the description of the channels with the wiring" if name in REPAIRS else ""
            alike = (max(shifts, key=lambda each: _cosine(shifts[each][-1])),) if name == NONE else ()
            return Finding(name, title, "", advice, **range_of, looks_like=alike)
        hypothesis = next(each for each in self.hypotheses if each.name == name)
        shift = shifts[name][-1]
        moved = np.sum(shift.directions**2, axis=1)
        # Least squares along each direction; sizes are not negative.
        sizes = np.maximum(shift.directions @ shift.difference, 0.0) / moved
        # The direction that takes most from the squared distance.
        best = int(np.argmax(sizes**2 * moved))
        size = float(sizes[best])
        if hypothesis.usual * _SIZES[-1] * np.sqrt(moved[best]) < 1.0:
            # Not even the largest size moves the record by its deviation.
            return Finding(name, hypothesis.title, hypothesis.unit, hypothesis.advice, **range_of)
        deviation = float(np.hypot(1.0 / np.sqrt(moved[best]), _SIZE * hypothesis.error * size))
        is_named = found[0] >= NAMED
        looks_like, told_by = self._confusable(hypothesis, best, size if is_named else 0.0, scatter, gain)
        return Finding(
            name,
            hypothesis.title,
            hypothesis.unit,
            hypothesis.advice,
            **range_of,
            size=size,
            size_low=max(0.0, size - 1.96 * deviation),
            size_high=size + 1.96 * deviation,
            looks_like=looks_like,
            told_by=told_by,
        )

    def _confusable(
        self, hypothesis: Hypothesis, best: int, size: float, scatter: Array, gain: Array
    ) -> tuple[tuple[str, ...], dict[str, str]]:
        """Faults of which some size looks like this one, and what would tell them apart."""
        alike, told, nothing = list[str](), dict[str, str](), np.zeros(len(self.history.names))
        for other in self.hypotheses if size > 0.0 else ():
            if other.name == hypothesis.name:
                continue
            # Both may move what either may move by an unknown amount.
            together = np.vstack((hypothesis.directions[[best]], other.directions))
            both = replace(other, directions=together, free=(*hypothesis.free, *other.free))
            mine, *rest = self._shift(nothing, scatter, gain, both).directions
            mine, rows = size * mine, np.array(rest)
            factors = np.maximum(rows @ mine, 0.0) / np.sum(rows**2, axis=1)
            left = np.sum((mine - factors[:, None] * rows) ** 2, axis=1)
            place = int(np.argmin(left))
            if factors[place] == 0.0 or left[place] >= _TOLD_APART:
                continue
            alike.append(other.name)
            change = size * hypothesis.directions[best] - factors[place] * other.directions[place]
            sensor = self._telling(change, float(left[place]))
            if sensor:
                told[other.name] = sensor
        return tuple(alike), told

    def _telling(self, change: Array, known: float) -> str:
        """The sensor that tells a change of the true quantities best; empty if none does."""
        scales = np.concatenate((self.history.balance.scales, np.ones(len(change) - len(CAUSES))))
        best, found = known, ""
        for sensor, errors in SENSORS.items():
            square = known
            for name, error in errors.items():
                if name in self.history.causes:
                    place = self.history.causes.index(name)
                    square += float(change[place] * scales[place] / error) ** 2
            if comparable(square) > comparable(max(best, _TOLD_APART)):
                best, found = square, sensor
        return found


def _cosine(shift: _Shift) -> float:
    """Cosine of the angle between a difference and the nearest direction of a fault."""
    lengths = np.linalg.norm(shift.directions, axis=1) * np.linalg.norm(shift.difference)
    return float(comparable(np.max(shift.directions @ shift.difference / np.maximum(lengths, 1e-30))))


def _log_mean(logs: Array) -> float:
    """Logarithm of the mean of exponentials."""
    top = float(np.max(logs))
    # Without the largest exponent no exponential overflows.
    return top + float(np.log(np.mean(np.exp(logs - top))))
