"""The six equations as printed and as composed of the package's functions, integrated by SciPy."""

import math

import numpy as np
from scipy.integrate import solve_ivp

SCALES = np.array([1e-3, 1e-2, 1e-6, 1e-3, 1e4, 1e4])
"""Sizes of x_p, v_p, x_v, v_v, P_1, P_2 below which errors do not count relatively."""


def printed_rates(p, K_i, u):
    """The right-hand side as the paper prints it, cases and all, with two areas, weight and constant load."""
    a, v, s, f = p.actuator, p.valve, p.supply, p.friction
    A_1, A_2, V_1, V_2 = *a.areas, *a.volumes_at(0.0)
    F_L = p.load.constant_force + a.mass * 9.80665 * math.sin(a.inclination)
    omega = 2.0 * math.pi * v.natural_frequency
    beta, K_e = p.fluid.bulk_modulus, p.leakage.external_coefficient

    def sign(value):
        return float(value > 0) - float(value < 0)

    def root(value):
        return sign(value) * math.sqrt(abs(value))

    def rates(_, y):
        x_p, v_p, x_v, v_v, P_1, P_2 = y
        if abs(v_p) >= f.velocity_threshold:
            stribeck = f.coulomb + (f.breakaway - f.coulomb) * math.exp(-f.transition * abs(v_p))
            F_f = stribeck * sign(v_p) + f.viscous * v_p
        else:
            at_threshold = math.exp(-f.transition * f.velocity_threshold)
            F_th = f.viscous * f.velocity_threshold + f.coulomb + (f.breakaway - f.coulomb) * at_threshold
            F_f = v_p * F_th / f.velocity_threshold
        half_drop, mean = (s.pressure - s.return_pressure) / 2, (s.pressure + s.return_pressure) / 2
        q_1 = v.flow_gain * v.area_gradient * x_v * root(half_drop + sign(x_v) * (mean - P_1))
        q_2 = v.flow_gain * v.area_gradient * x_v * root(half_drop + sign(x_v) * (P_2 - mean))
        q_il = K_i * sign(P_1 - P_2) * math.sqrt(abs(P_1 - P_2))
        return [
            v_p,
            (A_1 * P_1 - A_2 * P_2 - F_f - F_L - a.load_stiffness * x_p) / a.mass,
            v_v,
            -(omega**2) * x_v - 2 * v.damping_ratio * omega * v_v + v.spool_gain * omega**2 * u,
            beta / (V_1 + A_1 * x_p) * (q_1 - q_il - K_e * P_1 - A_1 * v_p),
            beta / (V_2 - A_2 * x_p) * (-q_2 + q_il - K_e * P_2 + A_2 * v_p),
        ]

    return rates


def integrate(rates_of, parameters, K_i, tolerance):
    """States (6, n_time) at the samples; Radau, restarted at every edge of the input."""
    record, drive, supply = parameters.record, parameters.input, parameters.supply
    time = np.arange(record.n_sample) / record.sampling_frequency
    half = drive.period / 2
    (A_1, A_2), total = parameters.actuator.areas, supply.pressure + supply.return_pressure
    F_L = parameters.load.constant_force + parameters.actuator.weight
    y = np.array([0.0, 0.0, 0.0, 0.0, (A_2 * total + F_L) / (A_1 + A_2), (A_1 * total - F_L) / (A_1 + A_2)])
    states = []
    for number in range(math.ceil(record.duration / half - 1e-9)):
        first, last = number * half, min((number + 1) * half, record.duration)
        inside = time[(time >= first - 1e-9) & (time < last - 1e-9)]
        u = drive.amplitude if number % 2 == 0 else -drive.amplitude
        solution = solve_ivp(
            rates_of(parameters, K_i, u), (first, last), y, method="Radau", rtol=tolerance,
            atol=tolerance * SCALES, t_eval=np.append(inside, last),
        )  # fmt: skip
        assert solution.success
        states.append(solution.y[:, :-1])
        y = solution.y[:, -1]
    return np.concatenate(states, axis=1)
