"""What users call keys that have another name here."""

from __future__ import annotations

from collections.abc import Sequence

_SYNONYMS = {
    "bulk_modulus": "ebm, beta, betae, beta_e, effective_bulk_modulus, modulus, compressibility, stiffness",
    "internal_coefficient": "ki, k_i, kil, leakage_coefficient, leak_coefficient, coefficient",
    "internal_flow": "flow, leak, leakage, leak_flow, leakage_flow, q_il, qil, internal_leakage",
    "external_coefficient": "ke, k_e, external_leakage, external_leak",
    "sampling_frequency": "fs, f_s, sample_rate, sampling_rate, rate, frequency, sample_frequency",
    "duration": "length, time, t_end, tend, end_time, stop_time, simulation_time",
    "step": "dt, time_step, timestep, h, step_size",
    "pressure": "ps, p_s, supply_pressure",
    "mass": "m, piston_mass, load_mass",
    "piston_area": "area, a, ap, a_p",
    "chamber_volume": "volume, v, v0, v_0",
    "load_stiffness": "spring, spring_constant, k, stiffness",
    "amplitude": "gain, size, level, height",
    "period": "cycle, cycle_time, t",
    "proportional_gain": "kp, k_p, p",
    "integral_gain": "i, k_int",
    "derivative_gain": "kd, k_d, d",
    "natural_frequency": "wn, omega, omega_n, bandwidth",
    "damping_ratio": "zeta, xi, damping",
    "coulomb": "coulomb_friction, fc, f_c, dry",
    "viscous": "viscous_friction, b, damping",
    "breakaway": "static, stiction, static_friction, fs, f_s",
    "noise": "noise_std, std, sigma, rms, standard_deviation",
    "bias": "offset, zero",
    "levels": "level, depth, n_levels, max_level",
    "name": "wavelet, family, mother",
    "window": "window_length, width",
}
"""Key → what users call it, in small letters."""

_KEYS: dict[str, list[str]] = {}
for _key, _names in _SYNONYMS.items():
    for _name in _names.split(", "):
        _KEYS.setdefault(_name, []).append(_key)


def meant(name: str, known: Sequence[str]) -> str | None:
    """The known key, dotted or not, that a user's word means; None where there is none, or more than one."""
    section, dot, word = name.strip().lower().replace("-", "_").replace(" ", "_").rpartition(".")
    found = [f"{section}{dot}{key}" for key in _KEYS.get(word, ()) if f"{section}{dot}{key}" in known]
    return found[0] if len(found) == 1 else None
