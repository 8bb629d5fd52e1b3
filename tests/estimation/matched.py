"""Signals of an actuator that is known to the last digit, for the tests of observers."""

import numpy as np
from scipy.integrate import solve_ivp

from hydrofdi.indicators.catalogue.observers import Cylinder, nominal_flows
from hydrofdi.physics.cylinder import chamber_pressure_rates, internal_leakage_flow

CYLINDER = Cylinder(633e-6, 633e-6, 280e-6, 280e-6, 0.0292, 20.75e-3, 0.0)
SUPPLY, DAMPING, STIFFNESS = 17.2e6, 5e4, 150e3
"""[Pa], [N·s/m] and [N/m] of a piston whose mass does not count."""


def moving(time):
    """Spool position [m] that excites pressures and their rates."""
    return 20e-6 * np.sin(2 * np.pi * 0.7 * time) + 15e-6 * np.sin(2 * np.pi * 4.3 * time + 1.0)


def matched_signals(spool, coefficient, bulk_modulus, duration, frequency, start=(9e6, 8e6, 0.0)):
    """Signals (5, 1, n_time) of the very equations that observers hold.

    Parameters
    ----------
    spool : callable
        Time [s] → spool position [m].
    coefficient, bulk_modulus : float
        K_i [m^3.5/kg^0.5] and β [Pa].
    duration, frequency : float
        [s] and [Hz]
    start : tuple of float
        P_1 and P_2 [Pa] and x_p [m].
    """

    def rates(time, state):
        p1, p2, x = state
        q1, q2 = nominal_flows(spool(time), p1, p2, SUPPLY, CYLINDER)
        speed = (CYLINDER.area_1 * (p1 - p2) - STIFFNESS * x) / DAMPING
        swept, leak = CYLINDER.area_1 * speed, internal_leakage_flow(p1 - p2, coefficient)
        net = q1 - swept - leak, swept + leak - q2
        c = CYLINDER
        rates = chamber_pressure_rates(x, *net, bulk_modulus, c.volume_1, c.volume_2, c.area_1, c.area_2)
        return *rates, speed

    time = np.arange(round(duration * frequency)) / frequency
    found = solve_ivp(rates, (0.0, time[-1]), start, "RK45", time, rtol=1e-9, atol=1e-6, max_step=5e-3)
    p1, p2, x = found.y
    return np.stack([p1, p2, x, spool(time) + 0.0 * time, SUPPLY + 0.0 * time])[:, None]
