"""What `train` says when it refuses, and what it promises."""

from __future__ import annotations

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import HydrofdiError

INDICATOR = {"flow_balance": {"spool": "command", "supply": "sum"}}
RATE = "500 Hz"


@pytest.fixture(scope="module")
def healthy():
    run = hydrofdi.simulate(
        "motions/closed-loop", duration="30 s", input={"seed": 1}, load={"seed": 1},
        pressure_1_sensor={"noise": "20 kPa"}, pressure_2_sensor={"noise": "20 kPa"},
    )  # fmt: skip
    signals = run.to_xarray()
    names = "chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage"
    return {name: np.array(signals[name]) for name in names}


def trained(signals, **settings):
    return hydrofdi.train(signals, INDICATOR, sampling_frequency=RATE, **settings)


def test_a_refusal_gives_the_reason_of_most_windows_not_of_the_first(healthy):
    pressure = healthy["chamber_1_pressure"].copy()
    pressure[3] = np.nan
    with pytest.raises(HydrofdiError, match="0 windows are too few for a balance"):
        trained(healthy | {"chamber_1_pressure": pressure}, window="40 ms")


def test_missing_samples_are_told_with_a_remedy(healthy):
    pressure = healthy["chamber_1_pressure"].copy()
    pressure[3] = np.nan
    records = healthy | {"chamber_1_pressure": pressure}
    (reason,) = hydrofdi.measure(records, INDICATOR, sampling_frequency=RATE)["reasons"]
    assert "1 of 15,000 samples of chamber_1_pressure are missing" in reason
    assert "set 'trim' or 'cycles' in a description, or judge windows" in reason


def test_inspect_names_balances_that_can_use_the_command_instead_of_the_spool(healthy):
    (advice,) = hydrofdi.inspect(healthy, sampling_frequency=RATE).assumptions
    assert "flow_balance (spool: command)" in advice
    assert "weak_rls (spool: command)" in advice
    (without,) = hydrofdi.inspect(
        {name: signal for name, signal in healthy.items() if name != "piston_position"},
        sampling_frequency=RATE,
    ).assumptions  # fmt: skip
    assert "flow_balance" not in without


def test_constants_that_nobody_gave_are_asked_for_in_words_that_fit_every_form(healthy):
    remarks = hydrofdi.measure(healthy, INDICATOR, sampling_frequency=RATE).remarks
    assert any("give them as options of flow_balance" in remark for remark in remarks)
    assert not any("YAML" in remark for remark in remarks)


@pytest.mark.parametrize(("window", "is_warned"), [("0.5 s", True), ("2.02 s", True), ("2 s", False)])
def test_windows_that_are_no_whole_periods_of_u_are_warned_of(window, is_warned):
    time = np.arange(0.0, 100.0, 0.02)
    square = np.sign(np.sin(np.pi * time + 0.1))
    pressure = 5e6 + 3e5 * square + 1e5 * np.random.default_rng(0).normal(size=time.size)
    signals = {"chamber_1_pressure": pressure, "input_voltage": square}
    settings = {"output": "standard_deviation", "direction": "both", "false_alarm_rate": "10 %"}
    detector = hydrofdi.train(
        signals, "pressure_statistics", sampling_frequency="50 Hz", window=window, **settings
    )
    assert detector.file.basis.drive_period == 2.0
    assert ("periods of the drive" in detector.summary) is is_warned
