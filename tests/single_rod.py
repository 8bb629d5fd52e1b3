"""A single-rod cylinder with a servovalve, by equations and a solver that are not those of hydrofdi."""

import math
from functools import cache

import numpy as np

AREA, STROKE, DEAD, MODULUS, SUPPLY, MASS = math.pi / 4.0 * 0.050**2, 0.4, 50e-6, 1.2e9, 21e6, 250.0
RATE, STEPS = 500.0, 10
LOAD = 3000.0


def data_sheet(ratio):
    """Options of indicators for it, with another bulk modulus; position zero is the centre."""
    return {
        "piston_area": AREA,
        "piston_area_2": ratio * AREA,
        "chamber_volume": DEAD + AREA * STROKE / 2.0,
        "chamber_volume_2": DEAD + ratio * AREA * STROKE / 2.0,
        "bulk_modulus": 1e9,
        "supply_pressure": SUPPLY,
    }


def flow_coefficient(leakage):
    """K_i of a leak that is stated in L/min at 8 MPa."""
    return leakage / 60e3 / math.sqrt(8e6)


def root(drop):
    return math.copysign(math.sqrt(abs(drop)), drop)


def rates(state, command, ratio, coefficient):
    x, v, p1, p2, spool = state
    gain, rod_side = 0.0292 * 20.75e-3 * spool, ratio * AREA
    into_1 = gain * root(SUPPLY - p1 if spool > 0.0 else p1)
    out_of_2 = gain * root(p2 if spool > 0.0 else SUPPLY - p2)
    leak = coefficient * root(p1 - p2)
    force = AREA * p1 - rod_side * p2 - 2e3 * v - 200.0 * math.tanh(v / 5e-3) - LOAD
    return (
        v,
        force / MASS,
        MODULUS * (into_1 - leak - AREA * v) / (DEAD + AREA * (STROKE / 2.0 + x)),
        MODULUS * (rod_side * v + leak - out_of_2) / (DEAD + rod_side * (STROKE / 2.0 - x)),
        (command - spool) / 4e-3,
    )


def moved(state, step, slopes):
    return [value + step * slope for value, slope in zip(state, slopes, strict=True)]


@cache
def recorded(ratio, leakage=0.0, seconds=20):
    """Noisy P1, P2, x_p from the centre and x_v by the classical Runge-Kutta method, steps of 0.2 ms.

    A position controller follows random targets; the leak is stated in L/min at 8 MPa.
    """
    random, step, coefficient = np.random.default_rng(3), 1.0 / RATE / STEPS, flow_coefficient(leakage)
    state, target, rows = [0.0, 0.0, 10e6 * ratio + LOAD / AREA, 10e6, 0.0], 0.0, []
    for sample in range(round(seconds * RATE)):
        if sample % 300 == 0:
            target = random.uniform(-0.06, 0.06)
        rows.append(state)
        for _ in range(STEPS):
            command = min(max(8e-3 * (target - state[0]), -200e-6), 200e-6)
            first = rates(state, command, ratio, coefficient)
            second = rates(moved(state, step / 2.0, first), command, ratio, coefficient)
            third = rates(moved(state, step / 2.0, second), command, ratio, coefficient)
            fourth = rates(moved(state, step, third), command, ratio, coefficient)
            mean = [
                (a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(first, second, third, fourth, strict=True)
            ]
            state = moved(state, step, mean)
    x, _, p1, p2, spool = np.array(rows).T
    signals = {
        "chamber_1_pressure": p1,
        "chamber_2_pressure": p2,
        "piston_position": x,
        "spool_position": spool,
    }
    return {
        name: values + (2e3 if "pressure" in name else 1e-7) * random.standard_normal(values.size)
        for name, values in signals.items()
    }
