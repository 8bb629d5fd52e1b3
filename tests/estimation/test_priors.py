"""Priors are narrower than the machines of real-rig, and those of a data-sheet file than its own."""

from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.values import quantiles
from hydrofdi.indicators.nominal_actuator import _SUPPLY
from hydrofdi.indicators.registry import sound_indicator

CONFIGS = Path(__file__).parents[2] / "configs"
RELATIVE = {
    "fluid.bulk_modulus": "bulk_modulus_deviation", "actuator.chamber_volume": "chamber_volume_deviation",
    "valve.flow_gain": "flow_gain_deviation", "supply.pressure": "supply_deviation",
}  # fmt: skip
PARAMETERS = RELATIVE | {
    "valve.null_offset": "offset_deviation", "valve.lap": "lap_deviation",
    "valve.lap_leakage": "largest_clearance", "pressure_1_sensor.bias": "pressure_bias",
    "pressure_2_sensor.bias": "pressure_bias",
}  # fmt: skip
"""Parameter → prior standard deviation."""
STUDY = "study: {healthy: {fit: 100, test: 100}}\n"


@pytest.mark.parametrize(
    ("base", "more"), [("populations/real-rig", "indicators: {flow_balance: {}}\n"), ("machines/rudder", "")]
)
def test_the_population_spreads_beyond_the_prior(base: str, more: str, tmp_path: Path) -> None:
    file = tmp_path / "rig.yaml"
    file.write_text(f"extends: {CONFIGS / base}.yaml\n{STUDY}{more}", encoding="utf-8")
    experiment = load_experiment(file)
    options = sound_indicator("flow_balance", experiment.indicators["flow_balance"]).options
    for name, deviation in PARAMETERS.items():
        prior = getattr(options, deviation) or _SUPPLY["nominal"]
        drawn = quantiles(experiment.study.population.over[name], (np.arange(2000) + 0.5) / 2000)
        spread = np.std(drawn) / (experiment.value(name) if name in RELATIVE else 1.0)
        if name in ("fluid.bulk_modulus", "valve.lap_leakage"):  # the least known: wide by intention
            assert not 0.9 < spread / prior < 1.1, name
        else:
            assert spread > 1.1 * prior, name
