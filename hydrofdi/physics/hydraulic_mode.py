"""Modes of the linearised actuator, the steps at which they are stable, and its steady state.

EBM changes the frequency, leakage the damping. The wavelet level that responds is the one whose band contains
the mode.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from functools import lru_cache


@dataclass(frozen=True)
class HydraulicMode:
    """Frequency [Hz] and damping ratio [-] of the hydraulic mode."""

    frequency: float
    damping_ratio: float


Pair = tuple[float, float]
"""Values of chamber 1 and of chamber 2."""


def mode_frequency(bulk_modulus: float, areas: Pair, volumes: Pair, mass: float, stiffness: float) -> float:
    """Undamped natural frequency of the hydraulic mode.

    Parameters
    ----------
    bulk_modulus, mass, stiffness : float
        β [Pa], m [kg] and K_ex [N/m].
    areas, volumes : tuple of float
        A_1, A_2 [m²] and V_1, V_2 at the position of the piston [m³].

    Returns
    -------
    float
        ω_h = √(β (A_1²/V_1 + A_2²/V_2)/m + K_ex/m) [rad/s].
    """
    # (h1): stiffness of the oil of each chamber over the mass [1/s²].
    first, second = (
        bulk_modulus * area**2 / (volume * mass) for area, volume in zip(areas, volumes, strict=True)
    )
    return math.sqrt(first + second + stiffness / mass)


def softest_position(areas: Pair, volumes: Pair) -> float:
    """Position at which the frequency of the hydraulic mode is least.

    Parameters
    ----------
    areas, volumes : tuple of float
        A_1, A_2 [m²] and V_1, V_2 with the piston centred [m³].

    Returns
    -------
    float
        x = (V_2/A_2^1.5 − V_1/A_1^1.5)/(A_1^−0.5 + A_2^−0.5) [m], where the slope of A_1²/V_1 + A_2²/V_2 over
        the position vanishes.
    """
    (area_1, area_2), (volume_1, volume_2) = areas, volumes
    difference = volume_2 / math.pow(area_2, 1.5) - volume_1 / math.pow(area_1, 1.5)
    return difference / (1.0 / math.sqrt(area_1) + 1.0 / math.sqrt(area_2))  # (h1a)


def damping_of_chamber_1(areas: Pair, volumes: Pair, coefficients: Pair, conductance: float) -> Pair:
    """K_c and G with which two equal chambers damp the mode as these two chambers do.

    While the mode swings by x, p_1 = −β A_1 x/V_1 and p_2 = β A_2 x/V_2 drive flows through K_c1, K_c2 and G,
    whose dissipated power is set equal.

    Parameters
    ----------
    areas, volumes : tuple of float
        A_1, A_2 [m²] and V_1, V_2 [m³].
    coefficients : tuple of float
        K_c1 and K_c2 [m³/(s·Pa)].
    conductance : float
        G of the internal leakage [m³/(s·Pa)].

    Returns
    -------
    tuple of float
        K_c = s_1 K_c1 + s_2 K_c2 V_1/V_2 and G (s_1 + 2 s_1 r + s_2 V_1/V_2)/2 for the volume V_1 in h4
        [m³/(s·Pa)], with s_j = (A_j²/V_j)/(A_1²/V_1 + A_2²/V_2) and r = A_2 V_1/(A_1 V_2).
    """
    (area_1, area_2), (volume_1, volume_2) = areas, volumes
    stiffness_1, stiffness_2 = area_1**2 / volume_1, area_2**2 / volume_2
    share_1, share_2 = (each / (stiffness_1 + stiffness_2) for each in (stiffness_1, stiffness_2))
    # h4 divides by V_1, so chamber 2 counts V_1/V_2 times; `ratio` is abs(p_2/p_1) of the swing.
    of_volume, ratio = share_2 * (volume_1 / volume_2), area_2 * volume_1 / (area_1 * volume_2)
    valve = share_1 * coefficients[0] + of_volume * coefficients[1]
    # (h4a): G sees p_1 − p_2, so s_1 (1 + r)² with s_1 r² = s_2 V_1/V_2; halved, as h4 doubles it.
    return valve, 0.5 * conductance * (share_1 + 2.0 * share_1 * ratio + of_volume)


def valve_flow_pressure_coefficient(
    spool_opening: float, orifice_drop: float, flow_gain: float, area_gradient: float
) -> float:
    """Flow-pressure coefficient of the valve: sensitivity of control flow to chamber pressure.

    Parameters
    ----------
    spool_opening : float
        abs(x_v) [m].
    orifice_drop : float
        Pressure drop across the orifice [Pa], positive.
    flow_gain, area_gradient : float
        K_v [m^1.5/kg^0.5] and w [m].

    Returns
    -------
    float
        K_c = K_v w abs(x_v)/(2√Δp) [m³/(s·Pa)].
    """
    return flow_gain * area_gradient * spool_opening / (2.0 * math.sqrt(orifice_drop))  # (h2)


def leakage_conductance(pressure_difference: float, coefficient: float) -> float:
    """Linearised conductance of the internal leakage: dq_il/dΔP.

    Parameters
    ----------
    pressure_difference : float
        abs(P_1 − P_2) [Pa], positive.
    coefficient : float
        K_i [m^3.5/kg^0.5].

    Returns
    -------
    float
        G = K_i/(2√abs(ΔP)) [m³/(s·Pa)].
    """
    return coefficient / (2.0 * math.sqrt(pressure_difference))  # (h3)


def laminar_conductance(coefficient: float, reference: float) -> float:
    """Conductance of the laminar leakage: G = K_i/√Δp_ref [m³/(s·Pa)]."""
    return coefficient / math.sqrt(reference)  # (h3a)


def blended_conductance(pressure_difference: float, coefficient: float, blending_pressure: float) -> float:
    """Linearised conductance of the blended leakage: dq_il/dΔP.

    Parameters
    ----------
    pressure_difference, blending_pressure : float
        ΔP and Δp_small [Pa].
    coefficient : float
        K_i [m^3.5/kg^0.5].

    Returns
    -------
    float
        G = K_i (ΔP²/2 + Δp_small²)/(ΔP² + Δp_small²)^(5/4) [m³/(s·Pa)].
    """
    squares = pressure_difference**2 + blending_pressure**2
    slope: float = (0.5 * pressure_difference**2 + blending_pressure**2) / math.pow(squares, 1.25)
    return coefficient * slope  # (h3b)


def mode_damping_ratio(
    frequency: float,
    bulk_modulus: float,
    volume: float,
    mass: float,
    viscous: float,
    valve_coefficient: float,
    leakage_conductance: float,
) -> float:
    """Damping ratio of the hydraulic mode.

    Parameters
    ----------
    frequency : float
        ω_h [rad/s].
    bulk_modulus, volume, mass, viscous : float
        β [Pa], V [m³], m [kg] and f [N·s/m].
    valve_coefficient, leakage_conductance : float
        K_c and G [m³/(s·Pa)].

    Returns
    -------
    float
        ζ ≈ f/(2mω_h) + β(K_c + 2G)/(2Vω_h) [-].
    """
    mechanical = viscous / (2.0 * mass * frequency)
    hydraulic = bulk_modulus * (valve_coefficient + 2.0 * leakage_conductance) / (2.0 * volume * frequency)
    return mechanical + hydraulic  # (h4)


def amplification(product: complex) -> complex:
    """Factor by which one step of classic Runge-Kutta amplifies a mode.

    Parameters
    ----------
    product : complex
        hλ, step times eigenvalue [-].

    Returns
    -------
    complex
        R(hλ) = 1 + hλ + (hλ)²/2 + (hλ)³/6 + (hλ)⁴/24.
    """
    return 1.0 + product * (1.0 + product / 2.0 * (1.0 + product / 3.0 * (1.0 + product / 4.0)))  # (s1)


def largest_stable_step(eigenvalue: complex) -> float:
    """Longest step at which classic Runge-Kutta does not amplify a mode.

    Parameters
    ----------
    eigenvalue : complex
        λ [1/s], with non-positive real part.

    Returns
    -------
    float
        h [s] with abs(R(hλ)) = 1; 2.785/abs(λ) on the real and 2.828/abs(λ) on the imaginary axis.
    """
    # The region of stability depends on hλ alone, so the search is cached by the direction of λ.
    return _largest_stable_product(eigenvalue / abs(eigenvalue)) / abs(eigenvalue)


@lru_cache(maxsize=65536)
def _largest_stable_product(direction: complex) -> float:
    """Largest abs(hλ) that does not amplify a mode with this direction in the complex plane."""
    # Outward in coarse steps to the first unstable product, then bisection; 50 halvings exhaust a double.
    stable, unstable = 0.0, 0.05
    while abs(amplification(unstable * direction)) <= 1.0 + 1e-12:
        stable, unstable = unstable, unstable + 0.05
    for _ in range(50):
        middle = 0.5 * (stable + unstable)
        if abs(amplification(middle * direction)) <= 1.0 + 1e-12:
            stable = middle
        else:
            unstable = middle
    return stable


def second_order_eigenvalues(frequency: float, damping_ratio: float) -> tuple[complex, complex]:
    """Eigenvalues of a second-order lag: λ = −ζω ± ω√(ζ² − 1) [1/s], ω in rad/s."""
    # (s2): the complex root covers a damping ratio below 1 as well.
    root = cmath.sqrt(damping_ratio**2 - 1.0)
    return frequency * (-damping_ratio - root), frequency * (-damping_ratio + root)


def rest_pressures(
    supply: float, ret: float, area_1: float, area_2: float, force: float
) -> tuple[float, float]:
    """Chamber pressures while a servovalve with equal edges holds the piston at rest.

    Through each chamber the same flow passes its supply and its return edge, one of which the spool opens as
    far as it shuts the other. So the drops at the edges of chamber 1 have the inverse ratio of those of
    chamber 2, and P_1 + P_2 = P_s + P_r, whatever the lap. Edges of different chambers may differ.

    Parameters
    ----------
    supply, ret : float
        P_s and P_r [Pa].
    area_1, area_2 : float
        A_1 and A_2 [m²].
    force : float
        Constant force F against extension [N].

    Returns
    -------
    tuple of float
        P_1 = (A_2 (P_s + P_r) + F)/(A_1 + A_2), P_2 = (A_1 (P_s + P_r) − F)/(A_1 + A_2) [Pa]; no lower than
        P_r and no higher than P_s, which a larger force would need.
    """
    total, areas = supply + ret, area_1 + area_2
    pressures = (area_2 * total + force) / areas, (area_1 * total - force) / areas  # (r1)
    first, second = (min(max(pressure, ret), supply) for pressure in pressures)
    return first, second


def steady_speed(
    supply: float,
    ret: float,
    area_in: float,
    area_out: float,
    conductance_in: float,
    conductance_out: float,
    force: float,
) -> float:
    """Speed of a piston under constant opening and force, without leakage.

    Parameters
    ----------
    supply, ret : float
        P_s and P_r [Pa].
    area_in, area_out : float
        Areas of the chamber that is fed and of the one that is drained [m²].
    conductance_in, conductance_out : float
        K_v w x of the open edges: flow over √Δp [m³/(s·√Pa)].
    force : float
        F against the motion [N].

    Returns
    -------
    float
        v = √[(A_in P_s − A_out P_r − F)/(A_in³/k_in² + A_out³/k_out²)] [m/s]; 0 if the force is too large.
    """
    # (r2): each edge takes Δp = (A v/k)², a force A³ v²/k² on the piston.
    excess = area_in * supply - area_out * ret - force
    return math.sqrt(max(excess, 0.0) / (area_in**3 / conductance_in**2 + area_out**3 / conductance_out**2))


def pressure_gain(area_ratio: float, gains: tuple[float, float], coefficients: tuple[float, float]) -> float:
    """Change of the load pressure per spool travel at the null, with the piston blocked.

    Parameters
    ----------
    area_ratio : float
        A_2/A_1 [-].
    gains : tuple of float
        Flow gain K_q = K_v w √Δp of the edge that opens, for chambers 1 and 2 [m²/s].
    coefficients : tuple of float
        Flow-pressure coefficient K_c of each chamber: clearances and external leakage [m³/(s·Pa)].

    Returns
    -------
    float
        K_p = K_q1/K_c1 + (A_2/A_1) K_q2/K_c2 [Pa/m], the slope of P_1 − P_2 A_2/A_1; infinite without
        clearance. Merritt, *Hydraulic Control Systems*, 1967, ch. 5, for each chamber.
    """
    # (r3)
    first, second = (
        gain / coefficient if coefficient else math.inf
        for gain, coefficient in zip(gains, coefficients, strict=True)
    )
    return first + area_ratio * second
