"""Presets of detectors write their numbers out: nothing is taken from the paper silently."""

from pathlib import Path

import pytest
import yaml

from hydrofdi.indicators.selection import load_indicators

PRESETS = sorted((Path(__file__).parents[2] / "configs" / "detectors").glob("*.yaml"))
_FRICTION = {
    "coulomb_friction", "breakaway_friction", "viscous_friction", "friction_transition", "velocity_threshold",
}  # fmt: skip
_OF_STATES = {
    "leakage": {"leakage_deviation", "leakage_walk"},
    "bulk_modulus": {"bulk_modulus_deviation", "bulk_modulus_walk", "chamber_volume_deviation"},
    "supply": {"supply_deviation", "supply_walk"},
    "flow_gain": {"flow_gain_deviation", "flow_gain_walk"},
    "offset": {"offset_deviation", "offset_walk"},
    "lap": {"lap_deviation", "lap_walk"},
    "clearance": {"clearance_deviation", "clearance_walk"},
    "bias_1": {"pressure_bias"},
    "bias_2": {"pressure_bias"},
}


def without_effect(options):
    """Options that the others make idle."""
    idle = {"piston_area_2", "chamber_volume_2", "position_zero", "stroke", "trace_duration"}
    if getattr(options, "friction", "") == "random_walk":
        idle |= _FRICTION
    if not hasattr(options, "mass") and getattr(options, "chambers", "both") == "both":
        idle.add("load_stiffness")
    if hasattr(options, "pressure_walk"):
        idle |= set().union(*(keys for state, keys in _OF_STATES.items() if state not in options.states))
    if getattr(options, "signal", "") == "position_rate":
        idle |= {"pressure_centre", "pressure_scale"}
    return idle


@pytest.mark.parametrize("preset", PRESETS, ids=lambda path: path.stem)
def test_every_entry_of_a_preset_writes_each_number_out(preset):
    written = yaml.safe_load(preset.read_text(encoding="utf-8"))["indicators"]
    for label, made in load_indicators(str(preset)).items():
        missing = type(made.options).model_fields.keys() - written[label].keys()
        assert missing <= without_effect(made.options), label
