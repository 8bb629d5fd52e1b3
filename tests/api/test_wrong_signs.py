"""Records in which a sign is wrong or two pressures are swapped."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.errors import DataError

P1, P2, X, U = "chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage"
INDICATOR = {"flow_balance": {"spool": "command", "supply": "sum"}}
RATE = "500 Hz"


def machine(seed, duration="64 s", leak="0 L/min"):
    run = hydrofdi.simulate(
        "motions/closed-loop", duration=duration, input={"seed": seed}, load={"seed": seed},
        pressure_1_sensor={"noise": "20 kPa"}, pressure_2_sensor={"noise": "20 kPa"}, internal_flow=leak,
    )  # fmt: skip
    signals = run.to_xarray()
    return {name: np.array(signals[name]) for name in (P1, P2, X, U)}


def reversed_position(of):
    return of | {X: -of[X]}


def swapped_pressures(of):
    return of | {P1: of[P2], P2: of[P1]}


@pytest.fixture(scope="module")
def healthy():
    return machine(1)


@pytest.fixture(scope="module")
def leaking():
    return machine(9, "16 s", "0.5 L/min")


@pytest.fixture(scope="module")
def detector(healthy):
    return trained(healthy)


def trained(signals, **more):
    return hydrofdi.train(
        signals, INDICATOR, window="2 s", false_alarm_rate="5 %", sampling_frequency=RATE, **more
    )  # fmt: skip


@pytest.mark.parametrize("mistaken", [reversed_position, swapped_pressures])
def test_a_detector_is_not_trained_on_records_that_no_actuator_gives(healthy, mistaken):
    with pytest.raises(DataError):
        trained(mistaken(healthy))
    accepted = trained(mistaken(healthy), accept=True)
    assert any(accepted.judge(mistaken(healthy), sampling_frequency=RATE)["doubt"])


@pytest.mark.parametrize("mistaken", [reversed_position, swapped_pressures])
def test_measure_remarks_on_records_that_no_actuator_gives(healthy, mistaken):
    table = hydrofdi.measure(mistaken(healthy), INDICATOR, sampling_frequency=RATE)
    assert any("bulk_modulus" in remark for remark in table.remarks)
    assert list(table["status"]) == ["doubtful"]
    sound = hydrofdi.measure(healthy, INDICATOR, sampling_frequency=RATE)
    assert not any("doubtful" in remark for remark in sound.remarks)
    assert list(sound["status"]) == ["ok"]


@pytest.mark.parametrize("mistaken", [reversed_position, swapped_pressures])
def test_a_leaking_machine_with_mistaken_channels_is_never_healthy(detector, leaking, mistaken):
    found = detector.judge(mistaken(leaking), sampling_frequency=RATE)
    assert False not in list(found["alarm"])
    assert "novel" in list(found["fault"])


def test_a_reversed_position_alone_makes_every_healthy_window_novel(detector):
    found = detector.judge(reversed_position(machine(9, "16 s")), sampling_frequency=RATE)
    assert set(found["fault"]) == {"novel"}


def test_alarms_of_a_leak_do_not_depend_on_other_quantities(detector, leaking):
    assert all(detector.judge(leaking, sampling_frequency=RATE)["alarm"])
