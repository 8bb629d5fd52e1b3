"""Volume balance of both chambers, with an unknown for each thing that a fault may change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.balancing import VolumeBalance, counting_windows, window_equations
from hydrofdi.indicators.catalogue.balances import BalanceOptions
from hydrofdi.indicators.estimation.chamber_balance import UNKNOWNS, weak_weights
from hydrofdi.physics import signed_root
from hydrofdi.records import Array, RecordBatch

N_PLACE = 6
"""Number of places on the stroke at which K_i is an unknown of its own."""

LEAKS = tuple(f"internal_coefficient_{number}" for number in range(N_PLACE))

N_FINE = 18
"""Number of places on the stroke at which a score may leak."""

SCORES = tuple(f"leak_{number}" for number in range(N_FINE))

GAPS = tuple(f"gap_{number}" for number in range(N_FINE))

_MORE = ("laminar", "external_1", "external_2", "gain_1", "gain_2", "lag", "position_lag")

NAMES = (*LEAKS, *UNKNOWNS[1:], *_MORE)
"""Unknowns: K_i along the stroke, those of `chamber_balance`, conductances of a laminar seal leak and of
leaks of each chamber to the outside, relative gain errors of the pressures, and how much spool and position
are behind [s]."""

CAUSES = (*NAMES, "position_gain", "bow", "feed_1", "feed_2", *SCORES, *GAPS)
"""The unknowns, and what else a fault may change and is seen through them: relative gain error of the
position (as an unknown it would explain all motion away), that of the valve at its largest opening if it
grows evenly from none, conductances of the clearance of each supply edge, and holes and gaps along the
stroke, at more places than K_i is an unknown of its own."""

PLACE = {name: index for index, name in enumerate(CAUSES)}

EDGES = {"supply 1": (1, 1), "return 1": (1, -1), "supply 2": (-1, -1), "return 2": (-1, 1)}
"""Metering edge → sign of its chamber, and of the spool position that opens it."""

OF_EDGES = ("lap", "offset", "lap_by_feeding", "lap_by_chamber")

CONTRASTS = np.array([(1, side, chamber * side, chamber) for chamber, side in EDGES.values()], dtype=float)
"""Lap of each edge from `OF_EDGES`."""

_OF_PRESSURES = ("supply", "bias_1", "bias_2", "gain_1", "gain_2")

_N_FIT, _FARTHEST = 6, 0.2
"""Number of fits, each about the laps and pressures found before; the farthest of these, over the largest
spool position and the supply pressure."""

_CORRELATED = 25.0
"""Number of windows that share an error of the model, as in `weak_rls`."""


class FlowEquations(NamedTuple):
    """Equations of records: moments (n_record, M + 1, M + 1) of the M causes and the target, counts, and
    the unknowns about which they are linear (n_record, N)."""

    moments: Array
    counts: Array
    about: Array


class FlowEstimates(NamedTuple):
    """Unknowns over their scales (n_record, N), misfits (n_record,), gain matrices from the true causes to
    these (n_record, N, M), and expected covariances of the values (n_record, N, N)."""

    values: Array
    misfits: Array
    gains: Array
    noise: Array


@dataclass(frozen=True)
class FaultBalance:
    """The balance of a machine: its data sheet and sensors, the largest spool position, and the positions at
    which K_i is an unknown of its own.
    """

    options: BalanceOptions
    largest_opening: float
    places: tuple[float, ...]

    @property
    def both(self) -> bool:
        """Whether both chamber pressures are measured."""
        return self.options.chambers == "both"

    @cached_property
    def flow(self) -> float:
        """Flow through the valve at the largest opening, half of the supply pressure over an edge [m³/s]."""
        options = self.options
        gain = options.flow_gain * options.area_gradient * self.largest_opening
        return float(gain * np.sqrt(0.5 * options.supply_pressure))

    @cached_property
    def scales(self) -> Array:
        """Size of a change of each cause (M,); of an unknown also the prior deviation of its estimate."""
        options, flow = self.options, 0.2 * self.flow
        supply, modulus, lap = options.supply_pressure, options.bulk_modulus, 0.05 * self.largest_opening
        at = options.reference_pressure
        own = {
            "compressibility": options.bulk_modulus_deviation / modulus, "flow_gain": 0.05, "supply": 0.1,
            "offset": lap, "lap": lap, "clearance": 0.2 * flow / at, "bias_1": 0.01 * supply,
            "bias_2": 0.01 * supply, "return_pressure": 0.05 * supply, "free_air": 0.05,
            "supply_resistance": 0.01 * supply / self.flow, "gain_by_direction": 0.015,
            "gain_by_feeding": 0.015, "gain_by_chamber": 0.015, "lap_by_feeding": lap,
            "lap_by_chamber": lap, **dict.fromkeys(("laminar", "external_1", "external_2"), flow / at),
            **dict.fromkeys(("feed_1", "feed_2", *GAPS), flow / at), "bow": 0.05,
            "gain_1": 0.02, "gain_2": 0.02, "position_gain": 0.02, "lag": 2e-3, "position_lag": 2e-3,
        }  # fmt: skip
        if not self.both:
            for name in ("bias_2", "gain_2", "external_2", "gain_by_chamber", "lap_by_chamber"):
                # Without the second sensor the prior holds these at zero.
                own[name] *= 1e-6
        return np.array([own.get(name, flow / np.sqrt(at)) for name in CAUSES])

    def fit(self, records: RecordBatch) -> FlowEquations:
        """Equations of each record, linear about its laps and pressures."""
        fitted = FlowEquations(
            *self._moments(records, about := np.zeros((records.n_record, len(NAMES)))), about
        )
        for _ in range(_N_FIT - 1):
            # Gauss-Newton: what is found moves spool and pressures, the others are found about it.
            about = self._near(self._settled(fitted)[0])
            fitted = FlowEquations(*self._moments(records, about), about)
        return fitted

    def _near(self, values: Array) -> Array:
        """Those unknowns (n_record, N) in which the equations are not linear, within their bounds."""
        about = np.zeros_like(values)
        laps, reach = [PLACE[name] for name in OF_EDGES], _FARTHEST * self.largest_opening
        edges = np.clip((values[:, laps] * self.scales[laps]) @ CONTRASTS.T, -reach, reach)
        # Rows of `CONTRASTS` are orthogonal, of length 2.
        about[:, laps] = 0.25 * edges @ CONTRASTS / self.scales[laps]
        for name in _OF_PRESSURES:
            index, most = PLACE[name], _FARTHEST
            most *= (self.options.supply_pressure if name.startswith("bias") else 1.0) / self.scales[index]
            about[:, index] = np.clip(values[:, index], -most, most)
        return about

    def estimate(self, fitted: FlowEquations, variance: float) -> FlowEstimates:
        """Estimates if the squared error of the equations is `variance` times the stated one."""
        values, misfits, normal, covariances = self._solved(fitted, np.full(len(fitted.counts), variance))
        gains = covariances @ (normal / variance)
        noise = covariances @ np.swapaxes(gains[:, :, : len(NAMES)], 1, 2)
        return FlowEstimates(values, misfits, gains, 0.5 * (noise + np.swapaxes(noise, 1, 2)))

    def _solved(self, fitted: FlowEquations, variances: Array) -> tuple[Array, Array, Array, Array]:
        """Values and misfits of records, their equations with all causes, and covariances."""
        normal, right, square = self._normal(fitted.moments)
        own, spread = normal[:, :, : len(NAMES)], variances[:, None, None]
        # Unknowns are in prior deviations, so the prior adds the unit matrix; it is about the data sheet.
        covariances = np.asarray(np.linalg.inv(own / spread + np.eye(len(NAMES))), dtype=float)
        whole = right + np.einsum("rij,rj->ri", own, fitted.about)
        values = np.einsum("rij,rj->ri", covariances / spread, whole)
        # Residual sum of squares from sums of products; rounding can leave less than zero.
        change = values - fitted.about
        left = square - 2.0 * np.sum(change * right, axis=1)
        left += np.einsum("ri,rij,rj->r", change, own, change)
        return values, np.sqrt(np.maximum(left, 0.0) / np.maximum(fitted.counts, 1.0)), normal, covariances

    def variance(self, fits: Sequence[FlowEquations]) -> float:
        """Squared error of the equations over the stated one that agrees with the misfits of some records."""
        return float(np.median(np.concatenate([self._settled(fitted)[1] for fitted in fits])))

    def _settled(self, fitted: FlowEquations) -> tuple[Array, Array]:
        """Estimates (n_record, N), and squared errors that agree with the misfit of each record."""
        # Estimates and variance depend on each other: fixed-point steps down from the data sheet alone.
        scaled = fitted.moments[:, -1, -1] / self.options.error**2
        variances = 1.0 + _CORRELATED * scaled / np.maximum(fitted.counts, 1.0)
        for _ in range(4):
            values, misfits, *_ = self._solved(fitted, variances)
            variances = 1.0 + _CORRELATED * np.maximum(misfits**2 - 1.0, 0.0)
        return values, variances

    def _normal(self, moments: Array) -> tuple[Array, Array, Array]:
        """Equations of the unknowns: products with all causes, with the target, and its square."""
        scaled, n_own = moments / self.options.error**2, len(NAMES)
        normal = scaled[:, :n_own, :-1] * self.scales[:n_own, None] * self.scales
        return normal, scaled[:, :n_own, -1] * self.scales[:n_own], scaled[:, -1, -1]

    def _moments(self, records: RecordBatch, about: Array) -> tuple[Array, Array]:
        """Sums of products of regressors and target, and numbers of equations, of both chambers."""
        options, half = self.options, self.options.half_window
        frequency, n_record = records.sampling_frequency, records.n_record
        balance = VolumeBalance(records, options)
        shape = (n_record, records.n_time)
        physical = about * self.scales[: len(NAMES)]
        laps = physical[:, [PLACE[name] for name in OF_EDGES]] @ CONTRASTS.T
        more, *errors = (physical[:, [PLACE[name]]] for name in _OF_PRESSURES)
        reference = np.ascontiguousarray(np.broadcast_to(balance.supply, shape))
        supply = reference * (1.0 + more)
        first, second = (
            np.ascontiguousarray((pressure - bias) / (1.0 + gain))
            for pressure, bias, gain in zip(balance.pressures, errors[:2], errors[2:], strict=True)
        )
        position = np.ascontiguousarray(balance.position)
        weights = weak_weights(half, frequency)
        moments = np.zeros((n_record, len(CAUSES) + 1, len(CAUSES) + 1))
        counts = np.zeros(n_record)
        drop = first - second
        leaks = self._along(signed_root(drop), position, N_PLACE)
        scores = [*self._along(signed_root(drop), position, N_FINE), *self._along(drop, position, N_FINE)]
        speed = np.gradient(position, axis=1) * frequency

        def integral(signal: Array, row: int = 0) -> Array:
            # A window is two adjacent blocks, each of which it shares with a neighbour.
            blocks = signal[:, : signal.shape[1] // half * half].reshape(n_record, -1, half)
            return np.asarray((blocks @ weights[0, row])[:, :-1] + (blocks @ weights[1, row])[:, 1:])

        for chamber, pressure in enumerate((first, second)[: options.n_pressure]):
            sign, area = 1.0 - 2.0 * chamber, options.areas[chamber]
            spool = self._moved(balance.spool, laps, chamber)
            signals = spool, position, first, second, supply, reference
            regular, targets = window_equations(options, records, *signals)
            # The target is about the reference; here it is about the supply pressure used.
            targets = targets - regular[:, :, :, UNKNOWNS.index("supply")] * more[:, :, None]
            regular = regular[:, :, chamber]
            # (7), (8): the supply edge is open, else the return edge.
            feeds = sign * spool >= 0.0
            root = signed_root(np.where(feeds, supply - pressure, pressure - options.return_pressure))
            gain = options.flow_gain * options.area_gradient
            # Slope of the flow over the pressure; 300 √Pa (0.9 bar) limits it where the drop vanishes.
            slope = 0.5 * gain * spool / np.maximum(np.abs(root), 300.0) * np.where(feeds, -1.0, 1.0)
            external = sign * integral(pressure)
            # A gain error of a pressure acts on the orifice and on the compression.
            of_gain = integral(slope * pressure) - regular[:, :, PLACE_OF_MODULUS] / options.bulk_modulus
            nothing = np.zeros_like(external)
            fed = [-sign * integral(supply - pressure), nothing]
            own = [external, nothing] if chamber == 0 else [nothing, external]
            own += [of_gain, nothing] if chamber == 0 else [nothing, of_gain]
            columns = [
                *(integral(leak) for leak in leaks),
                *np.moveaxis(regular[:, :, 1:], 2, 0),
                integral(drop),
                *own,
                integral(gain * root * np.gradient(spool, axis=1) * frequency),
                area * integral(speed, 1),
                -area * integral(position, 1),
                integral(gain * root * spool * np.abs(spool) / self.largest_opening),
                *(fed[::-1] if chamber else fed),
                *(integral(score) for score in scores),
                targets[:, :, chamber],
            ]
            kept = counting_windows(spool, frequency, options)
            equations = np.stack(columns, axis=2) * kept[:, :, None]
            moments += np.swapaxes(equations, 1, 2) @ equations
            counts += kept.sum(axis=1)
        return moments, counts

    def _along(self, flow: Array, position: Array, count: int) -> list[Array]:
        """A flow at places along the stroke: hat functions with sum 1."""
        at = np.interp(position, self.places, np.linspace(0.0, count - 1.0, N_PLACE))
        return [flow * np.clip(1.0 - np.abs(at - number), 0.0, 1.0) for number in range(count)]

    def _moved(self, spool: Array, laps: Array, chamber: int) -> Array:
        """Spool position less the lap of the edge of a chamber that it opens; zero in between."""
        plus, minus = (laps[:, [0]], laps[:, [1]]) if chamber == 0 else (laps[:, [3]], laps[:, [2]])
        opened = np.where(spool < np.minimum(plus, -minus), spool + minus, 0.0)
        return np.ascontiguousarray(np.where(spool > np.maximum(plus, -minus), spool - plus, opened))


PLACE_OF_MODULUS = UNKNOWNS.index("compressibility")
