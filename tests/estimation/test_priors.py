"""The priors of the estimators are narrower than the machines of configs/populations/real-rig.yaml."""

from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import load_experiment
from hydrofdi.config.sweeps.sweep import quantiles
from hydrofdi.indicators.nominal_plant import _SUPPLY, UncertainActuator

POPULATIONS = Path(__file__).parents[2] / "configs" / "populations"
PRIORS = UncertainActuator()
OF_PARAMETER = {
    "fluid.bulk_modulus": PRIORS.bulk_modulus_deviation,
    "actuator.chamber_volume": PRIORS.chamber_volume_deviation,
    "valve.flow_gain": PRIORS.flow_gain_deviation,
    "supply.pressure": _SUPPLY["nominal"],
    "valve.null_offset": PRIORS.offset_deviation,
    "valve.lap": PRIORS.lap_deviation,
    "valve.lap_leakage": PRIORS.clearance_deviation,
    "pressure_1_sensor.bias": PRIORS.pressure_bias,
    "pressure_2_sensor.bias": PRIORS.pressure_bias,
}
"""Parameter → prior standard deviation, relative for the first four."""

RELATIVE = list(OF_PARAMETER)[:4]


@pytest.mark.parametrize("name", OF_PARAMETER)
def test_real_rig_spreads_beyond_the_prior(name: str, tmp_path: Path) -> None:
    file = tmp_path / "rig.yaml"
    study = "study: {healthy: {fit: 100, test: 100}}\n"
    file.write_text(f"extends: {POPULATIONS / 'real-rig.yaml'}\n{study}", encoding="utf-8")
    experiment = load_experiment(file)
    assert experiment.study is not None
    values = np.array(quantiles(experiment.study.population.over[name], (np.arange(2000) + 0.5) / 2000))
    spread = values.std() / (experiment.value(name) if name in RELATIVE else 1.0)
    if name == "fluid.bulk_modulus":  # a prior that is wide by intention: oil is the least known
        assert not 0.9 < spread / OF_PARAMETER[name] < 1.1
    else:
        assert spread > 1.1 * OF_PARAMETER[name]
