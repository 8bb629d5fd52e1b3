"""Sampled signals of a batch of runs, and the outcome of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Signal = NDArray[np.float64]


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run: ``ok``, or the kind of failure and one sentence."""

    status: str = "ok"
    message: str = ""

    @property
    def is_ok(self) -> bool:
        """Whether the run succeeded, so that its results are valid."""
        return self.status == "ok"


@dataclass(frozen=True)
class Trajectory:
    """Sampled signals; every array but `time` has shape (n_run, n_time).

    Attributes
    ----------
    time : ndarray, shape (n_time,)
        t_k = k/f_s [s].
    input_voltage : ndarray
        u [V].
    reference_position : ndarray
        Position reference in closed loop, NaN in open loop [m].
    load_force : ndarray
        F_L, against positive motion [N].
    spool_position, piston_position, piston_velocity : ndarray
        x_v [m], x_p [m], v_p [m/s].
    chamber_1_pressure, chamber_2_pressure : ndarray
        P_1, P_2 [Pa].
    valve_supply_pressure : ndarray
        P_s at the valve [Pa].
    bristle_deflection : ndarray
        z of the LuGre law; zero for the other laws [m].
    leakage_coefficient : ndarray, shape (n_run,)
        K_i [m^3.5/kg^0.5].
    internal_leakage_flow : ndarray
        q_il from chamber 1 to chamber 2 [m³/s].
    outcomes : tuple of Outcome, length n_run
        Outcome of each run.
    """

    time: Signal
    input_voltage: Signal
    reference_position: Signal
    load_force: Signal
    spool_position: Signal
    piston_position: Signal
    piston_velocity: Signal
    chamber_1_pressure: Signal
    chamber_2_pressure: Signal
    valve_supply_pressure: Signal
    bristle_deflection: Signal
    leakage_coefficient: Signal
    internal_leakage_flow: Signal
    outcomes: tuple[Outcome, ...]

    def rows(self, positions: Sequence[int]) -> Trajectory:
        """Runs at some positions, in the given order."""
        index = np.asarray(positions)
        signals: dict[str, Any] = {
            field.name: getattr(self, field.name)[index]
            for field in fields(self)
            if field.name not in ("time", "outcomes")
        }
        return replace(self, **signals, outcomes=tuple(self.outcomes[k] for k in positions))

    @property
    def mean_internal_leakage_flow(self) -> Signal:
        """Mean of abs(q_il) over the samples [m³/s], shape (n_run,)."""
        mean: Signal = np.mean(np.abs(self.internal_leakage_flow), axis=1)
        return mean
