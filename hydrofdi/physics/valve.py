"""Servovalve: spool dynamics, control flows, and the sampled PID law that drives it."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics import Quantity, equation, limited, signed_root, sine


@equation
def supply_pressure_rate(
    pressure: Quantity, flow: Quantity, rated: Quantity, resistance: Quantity, time_constant: Quantity
) -> Quantity:
    """Rate of a supply pressure that drops with the flow drawn, with a first-order lag.

    Parameters
    ----------
    pressure : float or array
        P_s at the valve [Pa].
    flow : float or array
        Flow q_s from the supply into the valve [m³/s].
    rated : float or array
        Supply pressure P_s0 at zero flow [Pa].
    resistance : float or array
        Source resistance R_s: pressure drop per flow in steady state [Pa·s/m³].
    time_constant : float or array
        τ_s [s].

    Returns
    -------
    float or array
        P_s' = (P_s0 − R_s q_s − P_s)/τ_s [Pa/s].
    """
    return (rated - resistance * flow - pressure) / time_constant  # (7b)


@equation
def return_pressure_rate(
    pressure: Quantity, flow: Quantity, tank: Quantity, resistance: Quantity, time_constant: Quantity
) -> Quantity:
    """Rate of a return pressure that rises with the flow to the tank, with a first-order lag.

    Parameters
    ----------
    pressure : float or array
        P_r at the valve [Pa].
    flow : float or array
        Flow q_r from the valve into the return line [m³/s].
    tank : float or array
        Return pressure P_r0 at zero flow [Pa].
    resistance : float or array
        Resistance R_r of the line: pressure rise per flow in steady state [Pa·s/m³].
    time_constant : float or array
        τ_r [s].

    Returns
    -------
    float or array
        P_r' = (P_r0 + R_r q_r − P_r)/τ_r [Pa/s].
    """
    return (tank + resistance * flow - pressure) / time_constant  # (7f)


@equation
def ripple_rate(time: Quantity, amplitude: Quantity, frequency: Quantity) -> Quantity:
    """Rate of a sine that a pump adds to the supply pressure.

    Parameters
    ----------
    time : float or array
        Time t since the start of the record [s].
    amplitude : float or array
        Amplitude p_w [Pa].
    frequency : float or array
        f_w [Hz].

    Returns
    -------
    float or array
        2π f_w p_w cos(2π f_w t) [Pa/s], added to P_s'.
    """
    # (7e): a quarter of a turn ahead, the sine is a cosine.
    return 2.0 * np.pi * frequency * amplitude * sine(frequency * time + 0.25)


@equation
def spool_acceleration(
    position: Quantity,
    velocity: Quantity,
    voltage: Quantity,
    frequency: Quantity,
    damping_ratio: Quantity,
    gain: Quantity,
) -> Quantity:
    """Acceleration of the spool.

    Parameters
    ----------
    position, velocity : float or array
        Spool position x_v [m] and velocity v_v [m/s].
    voltage : float or array
        Input u [V].
    frequency : float or array
        Undamped natural frequency ω_v [rad/s].
    damping_ratio : float or array
        Damping ratio ξ [-].
    gain : float or array
        Position gain k_v [m/V].

    Returns
    -------
    float or array
        v_v' [m/s²]. Equation (4).
    """
    # (4), with the command minus the position formed first: at rest there, the difference is exactly zero.
    return frequency * frequency * (gain * voltage - position) - 2.0 * damping_ratio * frequency * velocity


@equation
def acting_voltage(voltage: Quantity, previous: Quantity, width: Quantity) -> Quantity:
    """Voltage that acts on the spool after rate-independent hysteresis (play operator).

    Parameters
    ----------
    voltage : float
        Input u [V].
    previous : float
        Acting voltage u_h,prev at the previous step [V].
    width : float
        Width h of the hysteresis loop as defined in ISO 10770-1: difference between the voltages that give
        the same spool position with rising and with falling input [V].

    Returns
    -------
    float
        u_h = min(max(u_h,prev, u − h/2), u + h/2) [V]. Visintin, *Differential Models of Hysteresis*, 1994,
        ch. III.
    """
    # (4b): the acting voltage rests while the input moves within ±h/2 of it.
    return np.minimum(np.maximum(previous, voltage - 0.5 * width), voltage + 0.5 * width)


@equation
def null_position(time: Quantity, offset: Quantity, drift: Quantity) -> Quantity:
    """Spool position at which the ports are centred (null position of the valve).

    Parameters
    ----------
    time : float or array
        Time t since the start of the record [s].
    offset : float or array
        Null position x_n0 at t = 0 [m].
    drift : float or array
        Drift rate r_n [m/s].

    Returns
    -------
    float or array
        x_n = x_n0 + r_n t [m]; the ports see x_v − x_n. Null bias and null shift (Merritt, *Hydraulic Control
        Systems*, 1967; ISO 10770-1) expressed as spool travel.
    """
    return offset + drift * time  # (7c)


@equation
def chamber_1_orifice_drop(
    spool_position: Quantity, pressure: Quantity, supply: Quantity, ret: Quantity
) -> Quantity:
    """Pressure drop across the metering orifice of chamber 1, from supply or to return.

    Parameters
    ----------
    spool_position : float or array
        x_v [m]; its sign selects the orifice.
    pressure, supply, ret : float or array
        P_1, P_s and P_r [Pa].

    Returns
    -------
    float or array
        Argument of the root in equation (7) [Pa]; negative if the flow is reversed.
    """
    side = np.copysign(1.0, spool_position)
    # (7): P_s − P_1 if the spool is at 0 or above, P_1 − P_r below; copysign is never 0, unlike sgn.
    return 0.5 * (supply - ret) + side * (0.5 * (supply + ret) - pressure)


@equation
def chamber_2_orifice_drop(
    spool_position: Quantity, pressure: Quantity, supply: Quantity, ret: Quantity
) -> Quantity:
    """Pressure drop across the metering orifice of chamber 2, to return or from supply.

    Parameters
    ----------
    spool_position : float or array
        x_v [m]; its sign selects the orifice.
    pressure, supply, ret : float or array
        P_2, P_s and P_r [Pa].

    Returns
    -------
    float or array
        Argument of the root in equation (8) [Pa]; negative if the flow is reversed.
    """
    side = np.copysign(1.0, spool_position)
    # (8): P_2 − P_r if the spool is at 0 or above, P_s − P_2 below.
    return 0.5 * (supply - ret) + side * (pressure - 0.5 * (supply + ret))


@equation
def control_flow(
    spool_position: Quantity, orifice_drop: Quantity, flow_gain: Quantity, area_gradient: Quantity
) -> Quantity:
    """Flow through one metering orifice of the servovalve.

    Parameters
    ----------
    spool_position : float or array
        x_v [m].
    orifice_drop : float or array
        Pressure drop across the orifice [Pa].
    flow_gain : float or array
        K_v [m^1.5/kg^0.5].
    area_gradient : float or array
        w [m].

    Returns
    -------
    float or array
        q_1 (into chamber 1) or q_2 (out of chamber 2) [m³/s]. Equations (7) and (8); a negative drop
        gives reverse flow.
    """
    return flow_gain * area_gradient * spool_position * signed_root(orifice_drop)  # (7), (8)


@equation
def edge_flow(
    spool_position: float,
    orifice_drop: float,
    flow_gain: float,
    area_gradient: float,
    lap: float,
    lap_leakage: float,
) -> float:
    """Flow across one metering edge of a spool with overlap or underlap.

    Parameters
    ----------
    spool_position : float
        x_v, positive in the opening direction of this edge [m].
    orifice_drop : float
        Pressure drop across the edge [Pa].
    flow_gain : float
        K_v [m^1.5/kg^0.5].
    area_gradient : float
        w [m].
    lap : float
        Lap x_0 [m]; positive for overlap, negative for underlap.
    lap_leakage : float
        Conductance c_lap of the radial clearance at the edge [m³/(s·Pa)].

    Returns
    -------
    float
        q = K_v w max(x_v − x_0, 0) √̂Δp + c_lap Δp [m³/s]. The supply edge feeds chamber 1 at x_v; the return
        edge drains it at −x_v. With x_0 = 0 and c_lap = 0, equations (7) and (8).
    """
    opening = np.maximum(spool_position - lap, 0.0)
    # (7a): the clearance lies in parallel with the opening, and passes at every spool position.
    flow: float = control_flow(opening, orifice_drop, flow_gain, area_gradient) + lap_leakage * orifice_drop
    return flow


def clearance_conductance(null_leakage: float, supply: float, ret: float) -> float:
    """Conductance of the clearance at each edge of a valve with a null leakage.

    At null, supply and return edge of a chamber are in series, and the two chambers in parallel.

    Parameters
    ----------
    null_leakage : float
        Flow q_0 from supply to return with the spool at its null and closed control ports [m³/s].
    supply, ret : float
        P_s and P_r [Pa].

    Returns
    -------
    float
        c_lap = q_0/(P_s − P_r) [m³/(s·Pa)].
    """
    return null_leakage / (supply - ret)  # (7g)


@equation
def worn_opening(travel: Quantity, rounding: Quantity, slope: Quantity) -> Quantity:
    """Opening of a rounded metering edge whose flow gain changes over the stroke.

    Parameters
    ----------
    travel : float or array
        Travel s = x_v − x_0 beyond the lap, positive in the opening direction of the edge [m].
    rounding : float or array
        Radius r of the edge [m].
    slope : float or array
        Relative change g of the flow gain per opening [1/m].

    Returns
    -------
    float or array
        y (1 + g y) with y = [s + √(s² + r²)]/2 [m]; it replaces max(x_v − x_0, 0). An open edge has y = s for
        s ≫ r, a shut edge leaks through r²/(4 abs(s)), and both through r/2 at s = 0.
    """
    # (7d): for s ≪ −r the sum cancels, but the lost 1e-16 abs(s) is no opening that matters.
    opening = 0.5 * (travel + np.sqrt(travel * travel + rounding * rounding))
    return opening * (1.0 + slope * opening)


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
