"""Position control by a sampled PID law."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation, limited


@equation
def converted(value: Quantity, lowest: Quantity, highest: Quantity, resolution: Quantity) -> Quantity:
    """Value after a converter (ADC or DAC) of limited range and resolution.

    Parameters
    ----------
    value, lowest, highest : float
        In the unit of the signal; either limit may be infinite.
    resolution : float
        Step between adjacent levels, counted from `lowest`, in the unit of the signal; 0 means no
        quantisation.

    Returns
    -------
    float
        Equations (m5) and (m6).
    """
    within = np.minimum(np.maximum(value, lowest), highest)  # (m5)
    has_levels = resolution > 0.0
    # Both branches are computed: level 0 and step 1 spare the unused one ∞ − ∞ and a division by zero.
    first, step = np.where(has_levels, lowest, 0.0), np.where(has_levels, resolution, 1.0)
    # (m6): rint rounds halves to the even level.
    return np.where(has_levels, first + step * np.rint((within - first) / step), within)


@equation
def pid_step(
    error: float,
    previous_error: float,
    integral: float,
    proportional_gain: float,
    integral_gain: float,
    derivative_gain: float,
    sample_time: float,
    limit: float,
) -> tuple[Quantity, Quantity]:
    """Output voltage and integral term of a PID controller after one sample.

    Parameters
    ----------
    error, previous_error : float
        Reference minus position at this sample and at the previous one [m].
    integral : float
        Integral term before this sample [V].
    proportional_gain, integral_gain, derivative_gain : float
        K_p [V/m], K_I [V/(m·s)] and K_D [V·s/m].
    sample_time : float
        Sample time T [s].
    limit : float
        Largest absolute voltage [V].

    Returns
    -------
    voltage : float
        u = K_p e + I + K_D (e − e_prev)/T, limited [V].
    integral : float
        I = I_prev + K_I T e [V]; held while the voltage is saturated and the error would drive it further
        (anti-windup).
    """
    integrated = integral + integral_gain * sample_time * error
    # (c1), before the limit.
    wanted = proportional_gain * error + integrated + derivative_gain * (error - previous_error) / sample_time
    voltage = limited(wanted, limit)
    # Positive only if the voltage is limited on the side to which the error drives it.
    winds_up = (wanted - voltage) * error > 0.0
    return voltage, np.where(winds_up, integral, integrated)
