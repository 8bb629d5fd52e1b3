"""What may be wrong with a machine, and how probable a record is if it is.

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

from hydrofdi.diagnosis.balance import CAUSES, EDGES, GAPS, LEAKS, N_PLACE, NAMES, OF_EDGES, PLACE, SCORES
from hydrofdi.diagnosis.history import HealthyMachine
from hydrofdi.records import Array


@dataclass(frozen=True)
class Hypothesis:
    """A fault.

    Attributes
    ----------
    name, title, unit : str
        Name in files, what a person calls it, and the SI unit of its size.
    usual : float
        A usual size.
    directions : ndarray, shape (n_direction, n_cause)
        Change of the true causes per size, over their scales; any of them may be true.
    free : tuple of str
        Quantities that it changes by an amount that is not known.
    advice : str
        What to look at.
    error : float
        Error of its direction, in any direction, over its length.
    """

    name: str
    title: str
    unit: str
    usual: float
    directions: Array
    free: tuple[str, ...] = ()
    advice: str = ""
    error: float = 0.3


HEALTHY, NONE = "healthy", "none_of_these"

_LEAKING = "stop the piston, close the valve and watch whether it drifts; plan to replace the seal"
_OUTSIDE = "look for oil at rod seal, fittings and hoses; a worn return edge of the valve looks the same"
_FRICTION = "look at rod guide, seals and alignment"

_NEEDS = {
    "external_2": "external_2", "bias_P2": "bias_2", "gain_P2": "gain_2", "friction_up": "coulomb",
    "friction_down": "coulomb",
}  # fmt: skip
"""Fault → quantity without which nothing shows it."""


def hypotheses(history: HealthyMachine) -> list[Hypothesis]:
    """All faults that the sensors can show."""
    balance, names = history.balance, history.causes
    options, (first, second) = balance.options, balance.options.areas
    at, supply, flow = options.reference_pressure, options.supply_pressure, 0.03 * balance.flow
    opening, modulus, mean = balance.largest_opening, 1.0 / options.bulk_modulus, history.value("pressure")
    friction, leak = 0.01 * supply * min(first, second), 1.0 / np.sqrt(at)
    places = np.interp(np.linspace(0.0, N_PLACE - 1.0, len(SCORES)), np.arange(N_PLACE), balance.places)
    stroke = (places - places[0]) / (places[-1] - places[0])
    # Flat tops with smooth ends, of any place and some widths; a score is a hole or a gap.
    scores = [
        np.exp(-(((stroke - centre) / half) ** 4))
        for half in (0.06, 0.1, 0.18, 0.3)
        for centre in np.linspace(0.05, 0.95, 13)
    ]
    # Share of one sensor in the mean pressure.
    share = 0.5 if balance.both else 1.0

    def moves(*changes: Mapping[str, float]) -> Array:
        made = np.zeros((len(changes), len(names)))
        for row, change in enumerate(changes):
            for column, name in enumerate(names):
                scale = balance.scales[column] if column < len(CAUSES) else 1.0
                made[row, column] = change.get(name, 0.0) / scale
        return made

    def signs(change: Mapping[str, float]) -> Array:
        return moves(change, {name: -value for name, value in change.items()})

    # Forces per position and speed are over what the sensor shows.
    of_position = {"position_gain": 1.0}
    of_position |= {name: -history.value(name) for name in ("stiffness", "viscous") if name in names}
    # A command that reads too much scales all laps with it; gains of edges are shares of the whole gain.
    of_command = {"flow_gain": 1.0}
    for name in (*OF_EDGES, "gain_by_direction", "gain_by_feeding", "gain_by_chamber"):
        share = history.value(name) * balance.scales[PLACE[name]]
        of_command[name] = -share if name in OF_EDGES else share

    def worn(edge: str, clearance: float) -> dict[str, float]:
        chamber, side = EDGES[edge]
        # Rows of `CONTRASTS` are orthogonal, of length 2, so a quarter of each moves one edge alone.
        parts = {"lap": 1, "offset": side, "lap_by_feeding": chamber * side, "lap_by_chamber": chamber}
        # It also leaks where it is closed: a share of what it feeds more at half the supply pressure.
        leaking = edge.replace("supply ", "feed_").replace("return ", "external_")
        share = clearance * options.flow_gain * options.area_gradient / np.sqrt(0.5 * supply)
        return {name: -0.25 * part for name, part in parts.items()} | {leaking: share}

    def sensor(chamber: int, area: float) -> tuple[Hypothesis, Hypothesis]:
        """Zero and gain of a pressure sensor; the area is positive if the pressure extends."""
        zero = {f"bias_{chamber}": 1.0, "force": area, "pressure": share}
        gain = {f"gain_{chamber}": 1.0, "force": area * mean, "pressure": share * mean}
        name, gauge = f"P{chamber}", f"compare P{chamber} with a gauge"
        return (
            Hypothesis(f"bias_{name}", f"zero of the {name} sensor", "Pa", 0.012 * supply, signs(zero),
                       advice=f"{gauge}, with the pump off"),
            Hypothesis(f"gain_{name}", f"gain of the {name} sensor", "1", 0.02, signs(gain),
                       advice=f"{gauge} under pressure"),
        )  # fmt: skip

    all_ = (
        Hypothesis("seal_orifice", "piston seal (hole)", "m^3/s", flow, moves(dict.fromkeys(LEAKS, leak)),
                   advice=_LEAKING),
        Hypothesis("seal_laminar", "piston seal (gap)", "m^3/s", flow, moves({"laminar": 1.0 / at}),
                   advice=_LEAKING),
        Hypothesis("seal_scored", "scored bore", "m^3/s", flow,
                   moves(*(dict(zip(law, scale * score, strict=True))
                           for law, scale in ((SCORES, leak), (GAPS, 1.0 / at)) for score in scores)),
                   advice="move slowly over the stroke and look where the piston drifts"),
        Hypothesis("external_1", "external leak, chamber 1", "m^3/s", flow, moves({"external_1": 1.0 / at}),
                   ("pressure",), _OUTSIDE),
        Hypothesis("external_2", "external leak, chamber 2", "m^3/s", flow, moves({"external_2": 1.0 / at}),
                   ("pressure",), _OUTSIDE),
        Hypothesis("worn_edge", "worn metering edge", "m", 0.05 * opening,
                   moves(*(worn(edge, share) for edge in EDGES for share in (0.0, 0.3, 1.0))), ("pressure",),
                   "measure the null leakage of the valve"),
        Hypothesis("null_shift", "null shift of the valve", "m", 0.03 * opening, signs({"offset": 1.0}),
                   advice="adjust the null; watch whether it shifts on"),
        Hypothesis("free_air", "free air in the oil", "1", 0.02, moves({"free_air": 1.0}),
                   advice="bleed the cylinder; look at tank level and suction line"),
        # The piston sticks and slips, which no equation of the balance states.
        Hypothesis("friction_up", "more friction", "N", friction, moves({"coulomb": 1.0}),
                   advice=_FRICTION, error=1.0),
        Hypothesis("friction_down", "less friction", "N", friction, moves({"coulomb": -1.0}),
                   advice=_FRICTION, error=1.0),
        Hypothesis("weak_supply", "low supply pressure", "Pa", 0.05 * supply,
                   moves({"supply": -1.0 / supply}), ("pressure",),
                   "read the supply gauge under load; look at pump, relief valve and filter"),
        Hypothesis("raised_return", "high return pressure", "Pa", 0.03 * supply,
                   moves({"return_pressure": 1.0}), ("pressure",), "look at the return filter and line"),
        Hypothesis("stiff_oil", "stiffer oil or hoses", "1", 0.2, moves({"compressibility": -modulus}),
                   advice="another oil, colder oil, or a hose was replaced"),
        Hypothesis("soft_oil", "softer oil or hoses", "1", 0.2, moves({"compressibility": modulus}),
                   advice="warm oil, an ageing hose, or air"),
        *sensor(1, first),
        *sensor(2, -second),
        Hypothesis("gain_x", "gain of the position sensor", "1", 0.02, signs(of_position),
                   advice="measure the stroke by hand"),
        Hypothesis("flow_gain", "gain of valve or command", "1", 0.05, signs(of_command),
                   advice="check the amplifier; compare spool position and command"),
    )  # fmt: skip
    shown = set(names) - (set() if balance.both else {"bias_2", "gain_2", "external_2"})
    return [fault for fault in all_ if fault.name not in _NEEDS or _NEEDS[fault.name] in shown]


REPAIRS: Mapping[str, str] = {
    "swapped_pressures": "P1 and P2 are swapped",
    "wrong_sign_u": "the command has the wrong sign",
    "wrong_sign_x": "the position has the wrong sign",
}
"""Fault of the recording that is undone exactly → what a person calls it."""


_UNLISTED = (
    "lap", "clearance", "supply_resistance", "gain_by_direction", "gain_by_feeding", "gain_by_chamber", "lag",
    "position_lag", "bow", "viscous", "stiffness",
)  # fmt: skip
"""Causes of which one may change alone in a fault without a hypothesis."""

_N_CHANGE = len(NAMES) + 2
"""Number of the causes that are no detail of a listed fault."""

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

    history: HealthyMachine
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
                index = self.history.names.index(name)
                scatter[index, index] *= 1.0 + _FREE**2
        scatter[-1, -1] += _MISFIT**2
        # Causes of the balance are seen through its estimate, forces and pressure directly.
        own, rest = np.split(hypothesis.directions, [len(CAUSES)], axis=1)
        moved = np.hstack((own @ gain.T, rest))
        changes = np.zeros((_N_CHANGE, len(difference)))
        changes[:, : len(gain)] = gain[:, :_N_CHANGE].T
        white, log_determinant = whitened(scatter, np.vstack((difference, moved, changes)))
        changes = white[-_N_CHANGE:]
        # The machine differs from the model in the directions in which its causes are seen, and in others.
        values, vectors = np.linalg.eigh(changes.T @ changes)
        shares = 0.5 * np.maximum(values, 0.0) / np.sum(values) + 0.5 / len(difference)
        turned = white[: len(moved) + 1] @ vectors
        return Shift(turned[0], turned[1:], shares, log_determinant)

    @cached_property
    def unlisted(self) -> Hypothesis:
        """A fault without a hypothesis that changes one cause alone."""
        causes, deviations = self.history.causes, np.sqrt(np.diag(self.scatter))
        shown = [causes.index(name) for name in _UNLISTED if name in causes]
        directions = np.zeros((len(shown), len(causes)))
        for row, column in enumerate(shown):
            # Forces have no scale of their own.
            own = column - len(CAUSES) + len(NAMES)
            directions[row, column] = 1.0 if column < len(CAUSES) else 10.0 * deviations[own]
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
            densities = [self._density(shift, hypothesis, factor) for shift in own] or [nothing]
            logs[hypothesis.name] = _log_mean(np.array(densities)) + log_prior
        for name, signature in repaired.items():
            white, _ = whitened(self.scatter, (signature - self.history.centre)[None])
            density = float(self._log_density(np.array(np.sum(white**2) / factor), log_determinant))
            logs[name] = density + log_prior
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
