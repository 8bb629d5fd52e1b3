"""Constants of the plant that nobody gave are named, for measured records and not for simulated ones."""

import numpy as np
import pytest

import hydrofdi

GIVEN = {
    "piston_area": "20 cm^2", "chamber_volume": "1 L", "bulk_modulus": "1 GPa", "flow_gain": 0.03,
    "area_gradient": "20 mm",
}  # fmt: skip
COLUMNS = ("P1 [Pa]", "P2 [Pa]", "x [m]", "u [V]")


@pytest.fixture(scope="module")
def records():
    draw = np.random.default_rng(1)
    drive = np.tile(np.repeat([2.0, -2.0], 250), 2)
    motion = np.cumsum(drive) * 1e-5
    signals = (8.6e6 + 1e6 * drive, 8.6e6 - 1e6 * drive, motion, drive)
    sizes = (2e4, 2e4, 1e-5, 1e-3)
    return {
        name: signal + size * draw.standard_normal((40, 1000))
        for name, signal, size in zip(COLUMNS, signals, sizes, strict=True)
    }


def balance(**options):
    return {"flow_balance": {"spool": "command", "supply": "sum"} | options}


def test_constants_that_nobody_gave_are_named(records):
    remark, *_ = hydrofdi.measure(records, balance(piston_area="20 cm^2"), sampling_frequency=500.0).remarks
    named = "chamber_volume, bulk_modulus, flow_gain, area_gradient, spool_gain, natural_frequency"
    assert remark.startswith(f"flow_balance: {named}, damping_ratio are not given; the nominal actuator")


@pytest.mark.parametrize("chosen", ["dwt", {"flow_balance": {"supply": "sum"} | GIVEN}])
def test_nothing_is_assumed_where_all_is_given_or_no_plant_is_needed(records, chosen):
    remarks = hydrofdi.measure(records, chosen, sampling_frequency=500.0).remarks
    assert not any("not given" in remark for remark in remarks)


def test_simulated_records_are_of_the_known_plant():
    experiment = hydrofdi.load_experiment(None, ["record.duration=2 s"])
    assert hydrofdi.measure(hydrofdi.simulate(experiment), "flow_balance").remarks == ()


def test_a_detector_says_which_constants_it_uses_and_which_nobody_gave(records, tmp_path):
    config = {"indicators": balance(piston_area="20 cm^2"), "output": "leakage", "false_alarm_rate": 0.2}
    detector = hydrofdi.train(records, config=config, accept=True, sampling_frequency=500.0)
    assert "It takes the actuator as piston_area = 2000 mm², chamber_volume = 280 cm³" in detector.summary
    assert "Warning: flow_balance: chamber_volume, bulk_modulus" in detector.summary
    detector.save(tmp_path / "detector.json")
    assert hydrofdi.Detector.load(tmp_path / "detector.json").summary.count("Warning: flow_balance") == 1
