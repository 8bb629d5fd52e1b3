"""Recursive least squares of the volume balance: what comes out of simulated runs, sample by sample."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest

from hydrofdi.indicators import load_indicators, make_indicators
from indicators.signals import KNOWN, P1, P2, XV, U, X, batch, measured, noisy, simulated
from tests.machines import GAP, LOOP, settings_of

LEAKS = np.array([0.0, 0.0, 1e-9, 5e-9])
MODULI = np.array([551e6, 827e6, 551e6, 689e6])
BLIND = {"spool": "command", "supply": "sum"}
N_TIME = 3000
PRESSURE, REST = np.full((1, N_TIME), 8.6e6), np.zeros((1, N_TIME))
STILL = batch({P1: PRESSURE, P2: PRESSURE, X: REST, XV: REST})


@pytest.fixture(scope="module")
def runs():
    """Healthy at two EBM, and two that leak; 6 s."""
    return simulated("record.duration=6 s", leaks=LEAKS, moduli=MODULI)


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"chambers": 1}, {"memory": "none"}])
def test_leakage_and_bulk_modulus_of_a_known_actuator_come_out(runs, options):
    values, _ = measured(runs, "weak_rls", **KNOWN | options)
    is_one = "chambers" in options
    np.testing.assert_allclose(
        values["internal_coefficient"], LEAKS, rtol=0.02 if is_one else 1e-3, atol=2e-13
    )
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=0.01 if is_one else 2e-3)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)


@pytest.mark.parametrize("options", [{}, BLIND])
def test_an_uncertain_actuator_hides_neither(runs, options):
    values, _ = measured(runs, "weak_rls", **options)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.01, atol=2e-12)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=0.01)
    np.testing.assert_allclose(values["supply_pressure"], 17.2e6, rtol=1e-3)


def test_a_record_as_a_whole_agrees_with_the_flow_balance(runs):
    options = KNOWN | {"spool": "command", "start_up": 0.0, "leakage_deviation": 1.0}
    ours, _ = measured(runs, "weak_rls", **options)
    theirs, _ = measured(runs, "flow_balance", **{key: options[key] for key in (*KNOWN, "spool")})
    for name, smallest in (("leakage", 1e-12), ("bulk_modulus", 0.0), ("cross_port_leakage", 1e-12)):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=2e-4, atol=smallest, err_msg=name)


@pytest.mark.parametrize("options", [KNOWN, KNOWN | {"chambers": 1}])
def test_intervals_hold_the_truth_as_often_as_they_say(runs, options):
    values, _ = measured(noisy(runs, [0] * 300, seed=1), "weak_rls", spool="command", **options)
    for name, truth in (("internal_coefficient", 0.0), ("bulk_modulus", MODULI[0])):
        left, stated = values[name] - truth, values[f"{name}_error"]
        assert (np.abs(left) < 1.96 * stated).mean() >= 0.95, name
        assert abs(left.mean()) < 0.5 * stated.mean(), name
        assert 0.1 < left.std() / stated.mean() < 1.1, name


def test_noise_of_the_pressures_biases_the_bulk_modulus_less_than_its_deviation(runs):
    values, _ = measured(noisy(runs, [0] * 100, seed=2), "weak_rls", **BLIND)
    assert abs(values["bulk_modulus"].mean() - MODULI[0]) < values["bulk_modulus_error"].mean()


def test_a_ripple_of_the_pressures_hides_no_leak_and_no_bulk_modulus(runs):
    ripple = 0.2e6 * np.sin(2.0 * np.pi * 225.0 * np.arange(runs.n_time) / runs.sampling_frequency)
    shaken = replace(runs, channels=runs.channels | {c: runs[c] + ripple for c in (P1, P2)})
    values, _ = measured(shaken, "weak_rls", **BLIND)
    calm, _ = measured(runs, "weak_rls", **BLIND)
    np.testing.assert_allclose(values["bulk_modulus"], calm["bulk_modulus"], rtol=0.04)
    np.testing.assert_allclose(values["leakage"], calm["leakage"], rtol=0.02, atol=0.002 / 60e3)


@pytest.mark.parametrize("law", ["orifice", "laminar"])
def test_the_mean_flow_of_a_large_leak_is_that_of_any_law(law):
    leaks = [1.2e-9, 6e-9]
    machine = settings_of({"orifice": {}, "laminar": GAP}[law])
    records = simulated(*machine, "record.duration=10 s", leaks=leaks, moduli=[551e6] * 2)
    flow, _ = measured(records, "weak_rls", **BLIND)
    # K_i √ΔP, or as much at 10 MPa in proportion to ΔP.
    root, drop = np.sqrt(np.abs(records[P1] - records[P2])), np.abs(records[P1] - records[P2])
    truth = np.mean(root if law == "orifice" else drop / np.sqrt(10e6), axis=1) * leaks
    np.testing.assert_allclose(flow["mean_leakage"], truth, rtol=0.07)


@pytest.mark.parametrize("name", ["weak_rls", "ekf_joint"])
def test_a_record_at_rest_does_not_determine_the_leakage_and_keeps_its_prior(name):
    values, reasons = measured(STILL, name, supply="nominal")
    assert all(np.isnan(array).all() for array in values.values())
    assert reasons[0] is not None
    if name == "ekf_joint":
        return
    (rls,) = make_indicators({"weak_rls": {"supply": "nominal"}}).values()
    last = {key: array[:, -1] for key, array in rls.trace(STILL).values.items()}
    assert last["leakage"] == 0.0
    np.testing.assert_allclose(last["leakage_error"], 1e-3 / 60.0)
    np.testing.assert_allclose(last["bulk_modulus"], 551e6)
    np.testing.assert_allclose(last["bulk_modulus_error"], np.hypot(0.3, 0.02) * 551e6)
    assert last["flow_gain"] == 1.0


def test_the_trace_follows_a_leak_that_sets_in_and_the_whole_record_its_mean():
    onset = "leakage.onset_time=6 s", "record.duration=12 s"
    motion = "control.amplitude=20 mm", "input.shape=steps", "input.period=1 s"
    late = simulated(*settings_of(LOOP), *motion, *onset, leaks=[5e-9], moduli=[551e6])
    (indicator,) = make_indicators({"weak_rls": {"spool": "measured", "memory": "1 s"}}).values()
    trace = indicator.trace(late)
    flow = np.sqrt(8e6) * LEAKS[3]
    before = trace.values["leakage"][0, (trace.time > 4.0) & (trace.time < 5.9)]
    assert np.abs(before).max() < 0.03 * flow
    np.testing.assert_allclose(trace.values["leakage"][0, -1], flow, rtol=0.05)
    whole, _ = measured(late, "weak_rls", spool="measured", memory="1 s")
    assert 0.3 * flow < whole["leakage"][0] < 1.1 * flow
    assert whole["misfit"][0] > 3.0


def test_the_preset_states_the_defaults(runs):
    (both,) = load_indicators("configs/detectors/weak-rls.yaml").values()
    (one,) = load_indicators("configs/detectors/weak-rls-one-chamber.yaml").values()
    assert both.options.stated() == BLIND
    assert one.options.stated() == BLIND | {"chambers": 1}


MODULUS, VOLUME = 551e6, 280e-6
N_RECORD = 40
MOTIONS = {
    "open loop": ["record.duration=8 s"],
    "closed loop": [
        *settings_of(LOOP), "record.duration=20 s", "control.amplitude=20 mm", "input.shape=steps",
        "input.period=1 s", "load.random_force=1 kN", "load.random_period=0.5 s",
    ],
}  # fmt: skip
NOMINAL_SUPPLY = {"supply": "nominal"}
INTERVAL_BLIND = {
    "weak_rls": BLIND, "flow_balance": BLIND, "pressure_balance": {"supply": "sum"},
    "ekf_joint": NOMINAL_SUPPLY, "ukf_joint": NOMINAL_SUPPLY,
}  # fmt: skip
KNOWN_VALVE = {"flow_gain_deviation": 0.0, "lap_deviation": 0.0}
"""Under a square wave, flow gain and lap would take up an error of the volume."""


def machines(settings):
    """Noisy records of machines that are nominal but for chamber volumes of ±2 %."""
    normal = NormalDist(VOLUME, 0.02 * VOLUME)
    volumes = (normal.inv_cdf((i + 0.5) / N_RECORD) for i in range(N_RECORD))
    each = [[f"actuator.chamber_volume={volume} m^3"] for volume in volumes]
    exact = simulated(*settings, leaks=[0.0] * N_RECORD, moduli=[MODULUS] * N_RECORD, each=each)
    return noisy(exact, range(N_RECORD), 12, {P1: 5e3, P2: 5e3, X: 10e-6, U: 0.0})


@pytest.fixture(scope="module")
def records():
    return {motion: machines(settings) for motion, settings in MOTIONS.items()}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["weak_rls", "ekf_joint"])
def test_intervals_hold_the_truth_in_open_and_closed_loop(records, motion, name):
    options = KNOWN_VALVE if (motion, name) == ("open loop", "weak_rls") else {}
    values, _ = measured(records[motion], name, **INTERVAL_BLIND[name], **options)
    left = values["bulk_modulus"] - MODULUS
    held = (np.abs(left) < 1.96 * values["bulk_modulus_error"]).mean()
    assert 0.9 <= held <= (1.0 if name == "weak_rls" else 0.99)
    assert abs(left.mean()) < 0.5 * values["bulk_modulus_error"].mean()


@pytest.mark.parametrize("name", INTERVAL_BLIND)
def test_the_deviation_of_the_volumes_changes_that_of_the_bulk_modulus_alone(records, name):
    few = records["open loop"].rows([0, 1])
    known, usual = (
        measured(few, name, **INTERVAL_BLIND[name], chamber_volume_deviation=share)[0]
        for share in (0.0, 0.02)
    )
    expected = np.hypot(known["bulk_modulus_error"], 0.02 * known["bulk_modulus"])
    np.testing.assert_allclose(usual.pop("bulk_modulus_error"), expected, rtol=1e-12)
    for output, numbers in usual.items():
        np.testing.assert_array_equal(numbers, known[output], err_msg=output)
