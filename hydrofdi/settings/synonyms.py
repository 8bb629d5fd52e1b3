"""What users call keys that have another name here."""

from __future__ import annotations

import re
from collections.abc import Sequence

_SYNONYMS = {
    "bulk_modulus": "ebm, beta, betae, beta_e, effective_bulk_modulus, modulus, compressibility, stiffness",
    "free_air": "air, air_content, entrained_air, air_fraction, gas_content",
    "vapour_pressure": "vapor_pressure, cavitation_pressure",
    "internal_coefficient": "ki, k_i, kil, leakage_coefficient, leak_coefficient, coefficient",
    "internal_flow": "flow, leak, leakage, leak_flow, leakage_flow, q_il, qil, internal_leakage, internal",
    "external_coefficient": "ke, k_e, external_leakage, external_leak, external",
    "sampling_frequency": "fs, f_s, sample_rate, sampling_rate, rate, frequency, sample_frequency",
    "duration": "length, time, t_end, tend, end_time, stop_time, simulation_time, t_max, t_stop",
    "step": "dt, time_step, timestep, h, step_size, max_step, tol, rtol, tolerance",
    "pressure": "ps, p_s, supply_pressure, system_pressure, pump_pressure, psupply",
    "return_pressure": "pt, p_t, pr, p_r, tank_pressure, tank, drain_pressure",
    "mass": "m, piston_mass, load_mass, moving_mass, inertia",
    "piston_area": "area, a, ap, a_p",
    "chamber_volume": "volume, v, v0, v_0, dead_volume",
    "load_stiffness": "spring, spring_constant, spring_rate, k, stiffness, spring_stiffness",
    "constant_force": "force, load_force, f_load",
    "flow_gain": "kv, k_v, gain",
    "spool_gain": "spool_constant, gain",
    "lap": "deadband, dead_band, deadzone, dead_zone, overlap",
    "shape": "signal, waveform, type, kind, form",
    "amplitude": "gain, size, level, height, amp",
    "period": "cycle, cycle_time, t",
    "proportional_gain": "kp, k_p, p",
    "integral_gain": "i, k_int, ki",
    "derivative_gain": "kd, k_d, d",
    "law": "controller, model, pid, pi",
    "natural_frequency": "wn, omega, omega_n, bandwidth, eigenfrequency",
    "damping_ratio": "zeta, xi",
    "coulomb": "coulomb_friction, coulomb_force, fc, f_c, dry, mu",
    "viscous": "viscous_friction, b, damping, viscous_damping, mu, c",
    "transition": "stribeck, stribeck_coefficient",
    "velocity_threshold": "stribeck_velocity, v_th, vth",
    "breakaway": "static, stiction, static_friction, fs, f_s",
    "noise": "noise_std, std, sigma, rms, standard_deviation",
    "bias": "offset, zero",
    "levels": "level, depth, n_levels, max_level",
    "name": "wavelet, family, mother, order",
    "window": "window_length, width",
    "actuator": "cylinder, piston, jack, ram, plant",
    "supply": "pump, source, power_unit",
    "fluid": "oil, medium, hydraulic_fluid",
    "valve": "servovalve, servo_valve, spool",
    "pressure_1_sensor": "sensor, sensors, pressure_sensor, p1_sensor",
    "pressure_2_sensor": "p2_sensor",
    "control": "controller, feedback, regulator",
    "record": "solver, simulation, sampling, time",
    "input": "excitation, reference, drive, command",
}
"""Key or section → what users call it, in small letters."""


def plain_word(name: str) -> str:
    """A name in small letters, without underscores, blanks and hyphens."""
    return re.sub(r"[-_\s]", "", name.lower())


_KEYS: dict[str, list[str]] = {}
for _key, _names in _SYNONYMS.items():
    for _name in _names.split(", "):
        _KEYS.setdefault(plain_word(_name), []).append(_key)

_SECTIONS = ("actuator", "supply", "fluid", "valve", "control", "record", "input")


def meant(word: str, known: Sequence[str], section: str = "") -> list[str]:
    """The known keys, dotted or not, that a user's word means: those of its section before any other.

    A single letter means something only in its own section, and in one that the name of the key contains.
    """
    word, section = plain_word(word), plain_word(section)
    section = next((key for key in _KEYS.get(section, ()) if key in _SECTIONS), section)
    for keys in ([word], _KEYS.get(word, ())):
        found = [each for each in known if plain_word(each.rpartition(".")[2]) in map(plain_word, keys)]
        alike = [each for each in found if each.rpartition(".")[0] == section]
        if len(word) == 1:
            found = [each for each in found if "." not in each or (section and section in each)]
        if alike or found:
            return alike or found
    return []
