"""Quantities that people know and that are no keys, but give the value of one."""

from __future__ import annotations

from collections.abc import Sequence

_COMPUTED = (
    (
        "actuator.piston_area",
        "bore, bore_diameter, piston_diameter, cylinder_bore, cylinder_diameter, diameter, rod, rod_diameter,"
        " piston_rod, piston_rod_diameter",
        "π/4 · (bore² − rod²)",
    ),
    (
        "actuator.piston_area",
        "a1, a2, a_1, a_2, aa, ab, area_1, area_2, cap_area, bore_area, rod_area, annulus_area, area_ratio",
        "the area of both sides, because the piston has a rod on each",
    ),
    (
        "actuator.end_stop_position",
        "stroke, stroke_length, max_stroke, end_position",
        "stroke / 2; chamber_volume is piston_area · stroke / 2 + dead volume",
    ),
    (
        "valve.flow_gain",
        "cd, c_d, discharge_coefficient, flow_coefficient, cv, c_v, density, rho, oil_density",
        "C_d · √(2 / density)",
    ),
    (
        "valve.area_gradient",
        "rated_flow, nominal_flow, q_n, qn, q_rated, valve_flow",
        "rated flow / (flow_gain · spool position · √(pressure drop of an edge))",
    ),
    ("record.sampling_frequency", "ts, t_s, sampling_time, sample_period, sampling_period", "1 / T_s"),
    ("record.duration", "n_samples, samples, n, n_sample", "samples / sampling_frequency"),
    ("input.period", "frequency, freq, f, f0, drive_frequency", "1 / frequency"),
    (
        "friction.viscous",
        "viscosity, kinematic_viscosity, nu",
        "the only effect of viscosity besides leakage",
    ),
)
"""Key, words in small letters, and how they give its value."""


def computation(word: str, known: Sequence[str]) -> str:
    """How a quantity that is no key gives the value of one; empty where it gives none.

    Parameters
    ----------
    word : str
        In small letters.
    known : sequence of str
        Keys, dotted or not; one of them has to be meant.
    """
    for dotted, words, how in _COMPUTED:
        names = [name for name in (dotted, dotted.partition(".")[2]) if name in known]
        if names and word in words.split(", "):
            return f"; give {names[0]!r} instead: {how}"
    return ""
