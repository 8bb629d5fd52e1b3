"""Quantities that are not keys, but give the value of one."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.settings.synonyms import plain_word

_COMPUTED = (
    (
        "actuator.piston_area",
        "bore, bore_diameter, piston_diameter, cylinder_bore, cylinder_diameter, diameter, rod, rod_diameter,"
        " piston_rod, piston_rod_diameter, a1, a2, a_1, a_2, aa, ab, area_1, area_2, cap_area, bore_area,"
        " rod_area, annulus_area, area_ratio",
        "the area of both chambers, π/4 · (bore² − rod²) with a rod on each side; a single rod is not"
        " simulated, but records of one can be judged: piston_area_2 of indicators",
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

_DRIVE = ("input", "record")
"""Sections whose quantities other things have as well: a valve has a frequency of its own."""


def computation(word: str, known: Sequence[str], section: str = "") -> str:
    """How a quantity that is not a key gives the value of one; empty if it gives none.

    Parameters
    ----------
    word : str
    known : sequence of str
        Keys, dotted or not; the keys that may be suggested.
    section : str
        The other section that the word stands in.
    """
    for dotted, words, how in _COMPUTED:
        home, _, key = dotted.partition(".")
        is_known = key in known or (dotted in known and not (section and home in _DRIVE))
        if is_known and plain_word(word) in map(plain_word, words.split(", ")):
            return f"; give {(dotted if dotted in known else key)!r} instead: {how}"
    return ""
