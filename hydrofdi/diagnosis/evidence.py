"""How probable a record is under each hypothesis, by how it differs from a healthy history.

The signature z of a healthy record follows a multivariate Student distribution about the centre of the
history (Gelman et al., Bayesian Data Analysis, 2013, section 3.6). A fault of size s shifts it by s G b, with
the gain matrix G of the estimates, and by an error of the model that is a share of this shift: half of it in
any direction, half as changes of the causes would show. A fault without a hypothesis changes a cause that no
hypothesis changes alone, or widens the scatter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hydrofdi.diagnosis.causes import CAUSES, N_CHANGE, NAMES, UNLISTED
from hydrofdi.diagnosis.history import History
from hydrofdi.diagnosis.hypotheses import HEALTHY, NONE, REPAIRS, Hypothesis
from hydrofdi.records import Array

PRIOR_HEALTHY, PRIOR_NONE = 0.9, 0.3
"""Probability that nothing is wrong before the record is seen; share of a fault without a hypothesis in the
rest, which the other hypotheses divide equally."""

SIZES = np.logspace(-1.5, 1.5, 49)
"""Sizes over the usual one, all equally probable."""

_MISFIT = 0.5
"""Deviation of the logarithm of the misfit that a fault may add."""

_FREE = 30.0
"""Deviation of a quantity that a fault changes by an unknown amount, over its healthy one."""

_SCALES = np.logspace(np.log10(1.5), 3.0, 16)
"""Scatter of a record with an unknown fault, over the healthy one."""

_MISSED, _FORMS = 1.645, 0.25
"""Deviation by which a fault that would just be seen may seem smaller than it is, and share of its forms
that may be seen less."""


@dataclass(frozen=True)
class Shift:
    """In coordinates in which scatter and error of the model are diagonal: difference from the centre (n,),
    shift per size of each direction (k, n), shares of the coordinates in an error of the model (n,), and
    ln det of the scatter."""

    difference: Array
    directions: Array
    shares: Array
    log_determinant: float


@dataclass(frozen=True)
class Evidence:
    """What a record shows beside a history: the difference of its signature from the centre, the scatter that
    is expected of it, and the gain matrix of its estimates."""

    history: History
    difference: Array
    scatter: Array
    gain: Array

    @cached_property
    def healthy(self) -> tuple[Array, float]:
        """Whitened difference if nothing is wrong, and ln det of the scatter."""
        return whitened(self.scatter, self.difference[None])

    @staticmethod
    def log_prior(n_hypothesis: int) -> float:
        """Logarithm of the probability of each fault before the record is seen."""
        return float(np.log((1.0 - PRIOR_HEALTHY) * (1.0 - PRIOR_NONE) / (n_hypothesis + len(REPAIRS))))

    def shift(self, hypothesis: Hypothesis, *, is_free: bool = True) -> Shift:
        """What a hypothesis shifts, with or without what it changes by an unknown amount."""
        difference, scatter, gain = self.difference, self.scatter.copy(), self.gain
        for name in hypothesis.free if is_free else ():
            if name in self.history.names:
                place = self.history.names.index(name)
                scatter[place, place] *= 1.0 + _FREE**2
        scatter[-1, -1] += _MISFIT**2
        # Causes of the balance are seen through its estimate, forces and pressure directly.
        own, rest = np.split(hypothesis.directions, [len(CAUSES)], axis=1)
        moved = np.hstack((own @ gain.T, rest))
        changes = np.zeros((N_CHANGE, len(difference)))
        changes[:, : len(gain)] = gain[:, :N_CHANGE].T
        white, log_determinant = whitened(scatter, np.vstack((difference, moved, changes)))
        changes = white[-N_CHANGE:]
        # The machine differs from the model in the directions in which its causes are seen, and in others.
        values, vectors = np.linalg.eigh(changes.T @ changes)
        shares = 0.5 * np.maximum(values, 0.0) / np.sum(values) + 0.5 / len(difference)
        turned = white[: len(moved) + 1] @ vectors
        return Shift(turned[0], turned[1:], shares, log_determinant)

    @cached_property
    def unlisted(self) -> Hypothesis:
        """A fault without a hypothesis that changes one cause alone."""
        causes, deviations = self.history.causes, np.sqrt(np.diag(self.scatter))
        shown = [causes.index(each) for each in UNLISTED if each in causes]
        directions = np.zeros((len(shown), len(causes)))
        for row, place in enumerate(shown):
            # Forces have no scale of their own.
            own = place - len(CAUSES) + len(NAMES)
            directions[row, place] = 1.0 if place < len(CAUSES) else 10.0 * deviations[own]
        return Hypothesis(NONE, "none of these", "", 1.0, np.vstack((directions, -directions)))

    def _log_density(self, squares: Array, log_determinant: Array | float) -> Array:
        """Logarithm of a Student density, up to a constant."""
        dof, size = self.history.dof, len(self.history.names)
        return np.asarray(-0.5 * log_determinant - 0.5 * (dof + size) * np.log1p(squares / dof))

    def probabilities(
        self,
        shifts: Sequence[tuple[Hypothesis, Sequence[Shift]]],
        repaired: Mapping[str, Array],
        factor: float,
    ) -> dict[str, float]:
        """Name → probability, if the scatter is `factor` times the one of the history; `shifts` of each
        hypothesis, none if it could not be seen; `repaired` as for `Judge.judge`."""
        size = len(self.history.names)
        log_prior = self.log_prior(len(shifts))
        white, log_determinant = self.healthy
        square = float(np.sum(white**2)) / factor
        nothing = float(self._log_density(np.array(square), log_determinant))
        logs = {HEALTHY: nothing + np.log(PRIOR_HEALTHY)}
        log_none = float(np.log((1.0 - PRIOR_HEALTHY) * PRIOR_NONE))
        one = self._density(self.shift(self.unlisted), self.unlisted, factor)
        wide = _SCALES**2
        # A wider scatter adds to ln det once for each quantity.
        many = _log_mean(self._log_density(square / wide, log_determinant + size * np.log(wide)))
        logs[NONE] = _log_mean(np.array([one, many])) + log_none
        for hypothesis, own in shifts:
            # What could not be seen at any size looks as if nothing were wrong.
            densities = [self._density(each, hypothesis, factor) for each in own] or [nothing]
            logs[hypothesis.name] = _log_mean(np.array(densities)) + log_prior
        for name, signature in repaired.items():
            white, _ = whitened(self.scatter, (signature - self.history.centre)[None])
            found = float(self._log_density(np.array(np.sum(white**2) / factor), log_determinant))
            logs[name] = found + log_prior
        top = max(logs.values())
        # Over the most probable one, as densities themselves may underflow.
        weights = {name: float(np.exp(value - top)) for name, value in logs.items()}
        total = sum(weights.values())
        return {name: weight / total for name, weight in weights.items()}

    def visible(self, shift: Shift, hypothesis: Hypothesis, n_hypothesis: int) -> float:
        """Size from which on this fault is more probable than that nothing is wrong; infinite if none is."""
        lengths = np.sqrt(np.sum(shift.directions**2, axis=1))
        form = shift.directions[[np.argsort(lengths)[int(_FORMS * len(lengths))]]]
        length, count = max(float(np.linalg.norm(form)), 1e-30), form.size
        least, log_prior = np.inf, self.log_prior(n_hypothesis)
        for size in hypothesis.usual * SIZES[::-1]:
            # The direction errs; beside it, each coordinate scatters by its deviation.
            along = max(size * length / (1.0 + hypothesis.error) - _MISSED, 0.0)
            seen = replace(shift, difference=form[0] / length * along, directions=form)
            healthy = float(self._log_density(along**2 + count, self.healthy[1])) + np.log(PRIOR_HEALTHY)
            if self._density(seen, hypothesis, 1.0, beside=1.0) + log_prior < healthy:
                break
            least = size
        return float(least)

    def _density(self, shift: Shift, hypothesis: Hypothesis, factor: float, beside: float = 0.0) -> float:
        """Logarithm of the mean density over sizes and directions."""
        sizes = (hypothesis.usual * SIZES)[:, None, None]
        left = (shift.difference - sizes * shift.directions) ** 2 + beside
        # The true shift differs from the model's by a share of it.
        moved = sizes**2 * np.sum(shift.directions**2, axis=1)[:, None]
        wider = 1.0 + hypothesis.error**2 * moved * shift.shares / factor
        determinants = shift.log_determinant + np.sum(np.log(wider), axis=2)
        return _log_mean(self._log_density(np.sum(left / wider, axis=2) / factor, determinants))


def whitened(scatter: Array, rows: Array) -> tuple[Array, float]:
    """Rows in coordinates of unit scatter, and ln det of the scatter."""
    factor = np.linalg.cholesky(scatter)
    return np.linalg.solve(factor, rows.T).T, 2.0 * float(np.sum(np.log(np.diag(factor))))


def _log_mean(logs: Array) -> float:
    """Logarithm of the mean of exponentials."""
    top = float(np.max(logs))
    # Without the largest exponent no exponential overflows.
    return top + float(np.log(np.mean(np.exp(logs - top))))
