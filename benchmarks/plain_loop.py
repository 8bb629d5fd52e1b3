"""Equations as printed, in a plain compiled loop: one job at a time, with numba's default options."""

from __future__ import annotations

import math

import numba
import numpy as np
from jobs import Job, parameter_vector, voltage

from hydrofdi.physics import NEGLIGIBLE


@numba.njit(cache=True)
def rates(y, u, p, dy):
    """Rates of (x_p, v_p, x_v, v_v, P_1, P_2); `p` as in ``jobs.parameter_vector``."""
    x, v, s, sv, p1, p2 = y
    m, A, V, K_ex, p_s, p_r, beta, K_v, w, F_c, F_brk, f, c_v, v_th, K_i, K_e, w_v, xi, k_v = p
    if abs(v) >= v_th:
        friction = (F_c + (F_brk - F_c) * math.exp(-c_v * abs(v))) * np.sign(v) + f * v
    else:
        friction = v * (f * v_th + F_c + (F_brk - F_c) * math.exp(-c_v * v_th)) / v_th
    drop_1 = (p_s - p_r) / 2 + np.sign(s) * ((p_s + p_r) / 2 - p1)
    drop_2 = (p_s - p_r) / 2 + np.sign(s) * (p2 - (p_s + p_r) / 2)
    q_1 = K_v * w * s * np.sign(drop_1) * math.sqrt(abs(drop_1))
    q_2 = K_v * w * s * np.sign(drop_2) * math.sqrt(abs(drop_2))
    q_il = K_i * np.sign(p1 - p2) * math.sqrt(abs(p1 - p2))
    dy[0] = v
    dy[1] = (A * p1 - A * p2 - friction - K_ex * x) / m
    dy[2] = sv
    dy[3] = -w_v * w_v * s - 2 * xi * w_v * sv + k_v * w_v * w_v * u
    dy[4] = beta / (V + A * x) * (q_1 - q_il - K_e * p1 - A * v)
    dy[5] = beta / (V - A * x) * (-q_2 + q_il - K_e * p2 + A * v)


@numba.njit(cache=True)
def integrate(p, u, step, steps_per_sample, pressure):
    """Classic Runge-Kutta from rest; fills `pressure` with the samples of P_1 [Pa].

    Decays are cut off as in the lanes, so that subnormal numbers slow down neither.
    """
    y = np.zeros(6)
    y[4] = y[5] = (p[4] + p[5]) / 2
    z, k1, k2, k3, k4 = np.empty(6), np.empty(6), np.empty(6), np.empty(6), np.empty(6)
    for i in range(u.size):
        if i % steps_per_sample == 0:
            pressure[i // steps_per_sample] = y[4]
        rates(y, u[i], p, k1)
        for j in range(6):
            z[j] = y[j] + 0.5 * step * k1[j]
        rates(z, u[i], p, k2)
        for j in range(6):
            z[j] = y[j] + 0.5 * step * k2[j]
        rates(z, u[i], p, k3)
        for j in range(6):
            z[j] = y[j] + step * k3[j]
        rates(z, u[i], p, k4)
        for j in range(6):
            y[j] += step / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j])
            if abs(y[j]) < NEGLIGIBLE:
                y[j] = 0.0


def pressure(job: Job, refinement: int = 1) -> np.ndarray:
    """Samples of P_1 [Pa], with the step of the run divided by `refinement`."""
    record = job[0].record
    samples = np.empty(record.n_sample)
    integrate(
        parameter_vector(job), voltage(job[0], refinement),
        record.step / refinement, record.steps_per_sample * refinement, samples,
    )  # fmt: skip
    return samples
