"""Information of records for a Kalman filter of the nominal plant."""

from __future__ import annotations

import numpy as np

from hydrofdi.estimation.observability import finite_horizon_gramian
from hydrofdi.estimation.plant import N_MOVING, N_STATE, STATES
from hydrofdi.estimation.prediction import TANGENT_SHAPE, predict
from hydrofdi.indicators.information import Information, Unknown
from hydrofdi.indicators.kalman import LITRE_PER_MINUTE, MOTION, KalmanOptions
from hydrofdi.records import Array, RecordBatch

_NAMES_AND_UNITS = {
    "pressure_1": ("P1", "Pa", 1e6),
    "pressure_2": ("P2", "Pa", 1e6),
    "position": ("position", "m", 1e-3),
    "velocity": ("velocity", "m/s", 1e-3),
    "resistance": ("friction and load", "N", 1.0),
    "leakage": ("leakage", "m^3/s", LITRE_PER_MINUTE),
    "bulk_modulus": ("bulk modulus", "1", 1.0),
    "supply": ("supply pressure", "1", 1.0),
    "flow_gain": ("flow gain", "1", 1.0),
    "offset": ("valve null", "m", 1e-6),
    "lap": ("lap", "m", 1e-6),
    "clearance": ("clearance", "m^3/(s*Pa)", 1e-15),
    "bias_1": ("bias of P1", "Pa", 1e6),
    "bias_2": ("bias of P2", "Pa", 1e6),
}
"""State → name and unit in tables, and the factor from estimator units to that unit."""


def plant_information(options: KalmanOptions, records: RecordBatch, covariance: Array) -> Information:
    """Information of the first record about the estimated states.

    The Gramian refers to the initial states and assumes an exact plant model.

    Parameters
    ----------
    options : KalmanOptions
    records : RecordBatch
    covariance : ndarray, shape (N_STATE, N_STATE)
        Covariance of a filter after the record, in estimator units.
    """
    prior = np.sqrt(options.prior_variances(records))
    (open_,) = np.nonzero(prior)
    scale, chosen = np.outer(prior[open_], prior[open_]), np.ix_(open_, open_)
    seen = np.eye(len(options.sensor_variances), N_STATE)
    gramian = finite_horizon_gramian(_transitions(options, records), seen, np.sqrt(options.sensor_variances))
    words = [(*_NAMES_AND_UNITS[name], prior[place]) for place, name in enumerate(STATES) if prior[place]]
    return Information(
        tuple(Unknown(name, unit, deviation * size) for name, unit, size, deviation in words),
        gramian[chosen] * scale,
        covariance[chosen] / scale,
        sum(name in MOTION for name, deviation in zip(STATES, prior, strict=True) if deviation),
    )


def _transitions(options: KalmanOptions, records: RecordBatch) -> Array:
    """State transition matrices of the nominal plant, shape (n_time - 1, N_STATE, N_STATE).

    Linearised about the measured pressures and position; the spool position is interpolated linearly.
    """
    frequency, first = records.sampling_frequency, records.rows([0])
    measured = options.measured_states(first)[0]
    spool, n_step = _spool(options, first), len(measured) - 1
    states = np.zeros((n_step, N_STATE))
    states[:, : measured.shape[1]] = measured[:-1]
    states[:, N_MOVING - 1] = np.diff(measured[:, -1]) * frequency
    part = np.linspace(0.0, 1.0, 2 * options.substeps + 1)
    moving = np.empty((n_step, N_MOVING, N_STATE))
    predict(
        states, spool[:-1, None] + np.diff(spool)[:, None] * part, 1.0 / (frequency * options.substeps),
        np.ascontiguousarray(options.supply_of(first)[0]), options.plant,
        np.empty_like(states), moving, np.empty(TANGENT_SHAPE),
    )  # fmt: skip
    transitions = np.tile(np.eye(N_STATE), (n_step, 1, 1))
    transitions[:, :N_MOVING] = moving
    return transitions


def _spool(options: KalmanOptions, records: RecordBatch) -> Array:
    """x_v [mm], shape (n_time,)."""
    drive = options.spool_drive(records)
    if options.spool == "measured":
        return np.asarray(drive[0])
    command = drive / options.spool_gain
    spool, _ = options.follow_command(command, command[:, :1], None, records.sampling_frequency)
    return np.asarray(spool[0])
