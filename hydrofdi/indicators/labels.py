"""Valid labels of indicators in an experiment; they become part of variable names."""

from __future__ import annotations

import re

LABEL_PATTERN = "^[A-Za-z][A-Za-z0-9_-]{0,63}$"

_IN_FILES = """
run time level phase run_id record_id status message verdict bulk_modulus replicate_of_run fixed_baseline_run
matched_baseline_run internal_leakage_level internal_leakage_coefficient internal_leakage_flow
chamber_1_pressure chamber_2_pressure piston_position piston_velocity spool_position input_voltage
reference_position load_force valve_supply_pressure detail_rms approximation_rms phase_detail_rms
settled_detail_rms settled_approximation_rms settled_phase_detail_rms settled_from settling_change
mean_chamber_1_pressure mean_internal_leakage_flow mean_external_leakage_flow_1 mean_external_leakage_flow_2
chamber_1_pressure_min chamber_1_pressure_max chamber_2_pressure_min chamber_2_pressure_max
piston_position_min piston_position_max above_supply_share cavitating_share clipped_share pressure_variation
unusual_share volume_residual energy_residual hydraulic_mode_frequency hydraulic_mode_damping_ratio
"""

TAKEN = frozenset(_IN_FILES.split())
"""Variables and dimensions of an experiment file."""


def label_mistake(label: object, of: str = "an indicator") -> str | None:
    """Message if a label is not valid, else None."""
    if not isinstance(label, str) or not re.fullmatch(LABEL_PATTERN, label):
        rule = "letters, digits, '_' and '-', beginning with a letter, at most 64"
        return f"is not a valid label of {of} ({rule})"
    if label in TAKEN:
        return "is the name of a variable of experiment files; choose another label and add 'kind: NAME'"
    return None
