"""Balances, filters, observers and Volterra series on simulated runs: K_i and β come out as stated."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from estimation.plants import PER_LITRE_PER_MINUTE

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.indicators.catalogue.kalman_filters import EkfJoint, JointOptions, UkfJoint, UnscentedOptions
from hydrofdi.indicators.estimation.whole_record import likeliest_wrong, sentence
from hydrofdi.physics.cylinder import scored_share
from hydrofdi.records import Channel
from indicators.signals import (
    KNOWN,
    LEAKS,
    MODULI,
    P1,
    P2,
    XV,
    U,
    X,
    assert_rows_stand_alone,
    batch,
    measured,
    noisy,
    simulated,
)
from tests.machines import GAP, LOOP, RIG, settings_of

PS = Channel.SUPPLY_PRESSURE
LITRE_PER_MINUTE = 1e-3 / 60.0
CLOSED_LOOP = (
    *settings_of(LOOP), "control.amplitude=20 mm", "input.shape=steps", "input.period=1 s",
)  # fmt: skip
BLIND = {"spool": "command", "supply": "sum"}
ALONE = KNOWN | {"bulk_modulus_deviation": 10.0}
OBSERVED = {"transient": "12 s"}
NOT_NOMINAL = (
    *settings_of(RIG), "record.duration=6 s", "valve.flow_gain=0.0298 m^1.5/kg^0.5",
    "supply.pressure=16.6 MPa", "valve.lap=-0.5 um", "valve.lap_leakage=2e-14 m^3/(s*Pa)",
)  # fmt: skip


@pytest.fixture(scope="module")
def long_runs():
    return simulated("record.duration=16 s")


@pytest.fixture(scope="module")
def runs(long_runs):
    """Healthy at three EBM, and two that leak; 6 s, without noise."""
    return long_runs.window(0, 3000)


def with_supply(records):
    return replace(records, channels=records.channels | {PS: np.full_like(records[P1], 17.2e6)})


def without_position(records):
    return batch({channel: records[channel] for channel in (P1, P2, U)})


@pytest.mark.parametrize(
    ("name", "options", "rtol", "atol", "of_modulus"),
    [
        *(("flow_balance", ALONE | {"half_window": 8} | own, 1e-3, 1e-13, 1e-3)
          for own in ({}, {"spool": "command"}, {"half_window": 6}, {"least_opening": 0.0})),
        ("flow_balance", {}, 0.01, 1e-12, 0.01), ("flow_balance", {"chambers": 1}, 0.06, 1e-12, 0.4),
        *(("weak_rls", KNOWN | own, 1e-3, 2e-13, 2e-3)
          for own in ({}, {"spool": "command"}, {"memory": "none"})),
        ("weak_rls", KNOWN | {"chambers": 1}, 0.02, 2e-13, 0.01),
        *(("weak_rls", own, 0.01, 2e-12, 0.01) for own in ({}, BLIND)),
        *(("adaptive_observer", OBSERVED | own, 0.02, 3e-11, 0.08)
          for own in ({}, {"spool": "command"}, {"supply": "nominal"})),
    ],
)  # fmt: skip
def test_leakage_and_bulk_modulus_come_out(long_runs, runs, name, options, rtol, atol, of_modulus):
    records = long_runs if name == "adaptive_observer" else runs
    values, obstacles = measured(records, name, **options)
    assert obstacles == (None,) * 5
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=rtol, atol=atol)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)
    np.testing.assert_allclose(values["bulk_modulus"], MODULI, rtol=of_modulus)
    if name == "adaptive_observer":
        return
    np.testing.assert_allclose(values["supply_pressure"], 17.2e6, rtol=4e-3)
    if rtol == 1e-3:
        np.testing.assert_allclose(values["cross_port_leakage"], values["leakage"], rtol=1e-3, atol=1e-9)
        mean = LEAKS * np.sqrt(np.abs(records[P1] - records[P2])).mean(axis=1)
        np.testing.assert_allclose(values["mean_leakage"], mean, rtol=2e-2, atol=1e-9)


def test_an_actuator_seen_from_its_other_side_leaks_the_same(runs):
    mirrored = {P1: runs[P2], P2: runs[P1], X: -runs[X], XV: -runs[XV], U: -runs[U]}
    one, _ = measured(runs, "flow_balance")
    other, _ = measured(replace(runs, channels=mirrored), "flow_balance")
    for name in ("internal_coefficient", "cross_port_leakage", "bulk_modulus", "lap", "flow_gain"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-6, atol=1e-16, err_msg=name)
    np.testing.assert_allclose(other["offset"], -one["offset"], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "errors", "atol", "known"),
    [
        ("flow_balance", ((P1, 30e3), (P2, -20e3), (XV, -0.4e-6)), 3e-11, KNOWN),
        ("ekf_joint", ((P1, 30e3),), 7e-11, {"states": ["leakage"]}),
    ],
)
def test_a_valve_and_sensors_that_are_not_nominal_are_found_and_hide_no_leak(name, errors, atol, known):
    leaks = np.array([0.0, 1e-10, 1e-9])
    shown = simulated(*NOT_NOMINAL, leaks=leaks, moduli=[689e6] * 3)
    for channel, error in errors:
        shown.channels[channel] = shown[channel] + error
    values, _ = measured(shown, name)
    np.testing.assert_allclose(values["internal_coefficient"], leaks, atol=atol)
    np.testing.assert_allclose(values["supply_pressure"], 16.6e6, rtol=3e-3)
    np.testing.assert_allclose(values["bulk_modulus"], 689e6, rtol=0.02)
    plain, _ = measured(shown, name, **known)
    assert (np.abs(plain["internal_coefficient"] - leaks) > 2e-10).all()
    if name == "flow_balance":
        alike, _ = measured(shown, name, edge_gain_deviation=0.0, edge_lap_deviation=0.0)
        np.testing.assert_allclose(alike["offset"], -0.4e-6, rtol=0.1)


@pytest.mark.parametrize(
    ("wrong", "truth"),
    [
        ({}, None),
        ({"piston_area": "950 mm²"}, 633e-6),
        ({"flow_gain": 0.0205}, 0.0292),
        ({"area_gradient": "31 mm"}, 0.0195),
        ({"supply": "nominal", "supply_pressure": "25 MPa"}, 17.2e6),
    ],
)
def test_a_wrong_constant_that_alone_explains_the_misfit_is_named_with_the_value_that_fits(wrong, truth):
    valve = "valve.lap=0.5 um", "valve.lap_leakage=1e-13 m^3/(s*Pa)"
    healthy = simulated(*CLOSED_LOOP, "record.duration=10 s", *valve, leaks=[0.0] * 2, moduli=[500e6, 600e6])
    options = make_indicators({"weak_rls": {"spool": "command", **wrong}})["weak_rls"].options
    found, name = likeliest_wrong(options, healthy), next(reversed(wrong), "")
    values = {each.name: each.value for each in found}
    if not wrong:
        assert not found
    else:
        assert values[name.replace("area_gradient", "flow_gain")] == pytest.approx(truth, rel=0.15)
        assert name in sentence(options, found)


@pytest.mark.parametrize("name", ["flow_balance", "weak_rls"])
@pytest.mark.parametrize("chambers", ["both", 1])
def test_the_mean_flow_of_a_score_in_a_part_of_the_stroke_comes_out(name, chambers):
    leaks, place = [0.0, 1e-9, 5e-9], ("leakage.scored_width=0.01", "leakage.scored_centre=0.002")
    shown = simulated(*CLOSED_LOOP, "record.duration=20 s", *place, leaks=leaks, moduli=[551e6] * 3)
    share = scored_share(shown[X], 2e-3, 10e-3)
    flow = leaks * np.mean(share * np.sqrt(np.abs(shown[P1] - shown[P2])), axis=1)
    values, _ = measured(shown, name, spool="command", chambers=chambers)
    np.testing.assert_allclose(values["mean_leakage"], flow, rtol=0.15, atol=3e-7)
    assert (np.abs(values["mean_leakage"] - flow) < 2.0 * values["mean_leakage_error"]).all()


def test_the_mean_flow_of_a_laminar_leak_is_seen_by_the_flow_past_piston_and_valve():
    leaks = np.array([1.2e-9, 6e-9])
    shown = simulated(*settings_of(GAP), "record.duration=10 s", leaks=leaks, moduli=[551e6] * 2)
    truth = np.mean(np.abs(shown[P1] - shown[P2]), axis=1) * leaks / np.sqrt(10e6)
    found, _ = measured(shown, "weak_rls", **BLIND)
    np.testing.assert_allclose(found["mean_leakage"], truth, rtol=0.07)
    found, _ = measured(shown, "flow_balance")
    np.testing.assert_allclose(found["cross_port_leakage"], leaks * np.sqrt(10e6) * 0.8, rtol=0.2)


@pytest.mark.parametrize("row", [0, 3])
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("flow_balance", ALONE | {"half_window": 8, "error": "5 mm^3"}),
        ("weak_rls", KNOWN | {"spool": "command"}), ("weak_rls", KNOWN | {"spool": "command", "chambers": 1}),
    ],
)  # fmt: skip
def test_the_stated_deviations_are_those_of_repeats(runs, row, name, options):
    values, _ = measured(noisy(runs, [row] * 200, seed=row), name, **options)
    for output, truth in (("internal_coefficient", LEAKS[row]), ("bulk_modulus", MODULI[row])):
        left, stated = values[output] - truth, values[f"{output}_error"]
        assert 0.1 < left.std() / stated.mean() < 1.5, output
        assert abs(left.mean()) < 2.0 * stated.mean(), output
        if name == "weak_rls" and row == 0:
            assert (np.abs(left) < 1.96 * stated).mean() >= 0.95, output
            assert abs(left.mean()) < 0.5 * stated.mean(), output


@pytest.mark.parametrize(
    ("name", "options", "right", "wrong"),
    [("flow_balance", ALONE, 1e-11, 2e-10), ("adaptive_observer", OBSERVED, 2e-10, 4e-10)],
)
def test_a_wrong_supply_counts_as_leakage_and_a_measured_one_does_not(long_runs, name, options, right, wrong):
    records, options = with_supply(long_runs), options | {"supply_pressure": "16 MPa"}
    one, other = (
        np.abs(
            measured(records, name, **options | {"supply": supply})[0]["internal_coefficient"] - LEAKS
        ).max()
        for supply in ("measured", "nominal")
    )
    assert one < right < wrong < other


def test_a_supply_without_a_scale_is_the_sum_of_the_pressures(runs):
    counts = replace(with_supply(runs), relative=frozenset({PS}))
    total, _ = measured(counts, "flow_balance", **ALONE | {"supply": "auto"})
    assert 1e-11 < np.abs(total["internal_coefficient"] - LEAKS).max() < 2e-10
    one, _ = measured(runs, "flow_balance", chambers=1, supply="sum")
    for supply in (total["supply_pressure"], one["supply_pressure"]):
        assert (supply != 17.2e6).all()
        np.testing.assert_allclose(supply, 17.2e6, rtol=0.03)


REST = batch(dict.fromkeys((P1, P2), np.full((1, 3000), 8.6e6)) | dict.fromkeys((X, XV), np.zeros((1, 3000))))


@pytest.mark.parametrize(
    ("name", "options", "is_still"),
    [
        ("flow_balance", {}, True), ("weak_rls", {"supply": "nominal"}, True),
        ("ekf_joint", {"supply": "nominal"}, True), ("reduced_order", {}, True),
        ("adaptive_observer", {"least_opening": "1 mm"}, False),
        ("adaptive_observer", {"leakage_time": "1e-6 s"}, False),
        ("reduced_order", {"least_opening": "1 mm"}, False),
    ],
)  # fmt: skip
def test_rest_a_closed_valve_or_a_divergence_give_no_numbers(runs, name, options, is_still):
    values, obstacles = measured(REST if is_still else runs, name, **options)
    assert all(obstacles)
    scores = [key for key in ("internal_coefficient", "leakage", "residual") if key in values]
    assert scores
    assert all(np.isnan(values[key]).all() for key in scores)


def test_the_trace_follows_a_leak_that_sets_in_and_the_whole_record_its_mean():
    onset = "leakage.onset_time=6 s", "record.duration=12 s"
    late = simulated(*CLOSED_LOOP, *onset, leaks=[5e-9], moduli=[551e6])
    indicators = make_indicators({"weak_rls": {"spool": "measured", "memory": "1 s"}})
    trace, flow = indicators["weak_rls"].trace(late), np.sqrt(8e6) * 5e-9
    before = trace.values["leakage"][0, (trace.time > 4.0) & (trace.time < 5.9)]
    assert np.abs(before).max() < 0.03 * flow
    np.testing.assert_allclose(trace.values["leakage"][0, -1], flow, rtol=0.05)
    whole = measure(late, indicators).values
    assert 0.3 * flow < whole["weak_rls.leakage"][0] < 1.1 * flow
    assert whole["weak_rls.misfit"][0] > 3.0


MOTIONS = {
    "open loop": ["record.duration=8 s"],
    "closed loop": [
        *CLOSED_LOOP, "record.duration=20 s", "load.random_force=1 kN", "load.random_period=0.5 s",
    ],
}  # fmt: skip
NOMINAL_SUPPLY = {"supply": "nominal"}
INTERVAL_BLIND = {
    "weak_rls": BLIND, "flow_balance": BLIND, "pressure_balance": {"supply": "sum"},
    "ekf_joint": NOMINAL_SUPPLY, "ukf_joint": NOMINAL_SUPPLY,
}  # fmt: skip


@pytest.fixture(scope="module")
def machines():
    """Motion → noisy records of 40 machines that are nominal but for chamber volumes of ±2 %."""
    normal = NormalDist(280e-6, 0.02 * 280e-6)
    each = [[f"actuator.chamber_volume={normal.inv_cdf((i + 0.5) / 40)} m^3"] for i in range(40)]
    sizes = {P1: 5e3, P2: 5e3, X: 10e-6, U: 0.0}
    return {
        motion: noisy(
            simulated(*settings, leaks=[0.0] * 40, moduli=[551e6] * 40, each=each), range(40), 12, sizes
        )
        for motion, settings in MOTIONS.items()
    }


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["weak_rls", "ekf_joint"])
def test_intervals_hold_the_truth_in_open_and_closed_loop(machines, motion, name):
    # Under a square wave, flow gain and lap would take up an error of the volume.
    known = {"flow_gain_deviation": 0.0, "lap_deviation": 0.0}
    options = known if (motion, name) == ("open loop", "weak_rls") else {}
    values, _ = measured(machines[motion], name, **INTERVAL_BLIND[name], **options)
    left = values["bulk_modulus"] - 551e6
    held = (np.abs(left) < 1.96 * values["bulk_modulus_error"]).mean()
    assert 0.9 <= held <= (1.0 if name == "weak_rls" else 0.99)
    assert abs(left.mean()) < 0.5 * values["bulk_modulus_error"].mean()


@pytest.mark.parametrize("name", INTERVAL_BLIND)
def test_the_deviation_of_the_volumes_changes_that_of_the_bulk_modulus_alone(machines, name):
    few = machines["open loop"].rows([0, 1])
    known, usual = (
        measured(few, name, **INTERVAL_BLIND[name], chamber_volume_deviation=share)[0]
        for share in (0.0, 0.02)
    )
    expected = np.hypot(known["bulk_modulus_error"], 0.02 * known["bulk_modulus"])
    np.testing.assert_allclose(usual.pop("bulk_modulus_error"), expected, rtol=1e-12)
    for output, numbers in usual.items():
        np.testing.assert_array_equal(numbers, known[output], err_msg=output)


PRESSURE_LEAKS = np.array([0.0, 0.0, 0.0, 3e-10, 1e-9, 3e-9])


@pytest.fixture(scope="module")
def pressure_runs():
    """Healthy at three EBM, and three that leak; 10 s, without noise and position."""
    moduli = [551e6, 689e6, 827e6, 551e6, 689e6, 551e6]
    return without_position(simulated("record.duration=10 s", leaks=PRESSURE_LEAKS, moduli=moduli))


@pytest.mark.parametrize(
    ("channels", "options", "rtol", "atol"),
    [
        ((P1, P2, U), {}, 0.05, 1e-10), ((P1, U), {"chambers": 1}, 0.15, 3e-10),
        ((P1,), {"chambers": 1, "spool": "square"}, 0.15, 3e-10),
    ],
)  # fmt: skip
def test_leakage_comes_out_of_pressures_at_any_bulk_modulus(pressure_runs, channels, options, rtol, atol):
    """One pressure alone is enough where the drive is a square wave, wherever the record begins."""
    for drive_period in (2.0, None):
        alone = batch({channel: pressure_runs[channel] for channel in channels}, drive_period=drive_period)
        for records in (alone, alone.window(500)):
            values, _ = measured(records, "pressure_balance", **options)
            np.testing.assert_allclose(values["internal_coefficient"], PRESSURE_LEAKS, rtol=rtol, atol=atol)
            assert (values["leakage_error"] < 0.2 / 60e3).all()
    assert_rows_stand_alone(alone, "pressure_balance", **options)


def worst(records, leaks, **options):
    values, _ = measured(records, "pressure_balance", **options)
    return np.abs(values["internal_coefficient"] - leaks).max()


def test_jumps_of_a_load_are_weighed_down_and_ringing_is_waited_for(pressure_runs):
    """Pressures ring after a step and the position does not; this must not count as leakage."""
    leaks = np.array([0.0, 3e-10])
    shown = without_position(simulated(*MOTIONS["closed loop"], leaks=leaks, moduli=[551e6] * 2))
    robust, plain = (worst(shown, leaks, robust=way) for way in (True, False))
    assert robust < 1e-10
    assert plain > 3.0 * robust
    hurried = worst(pressure_runs, PRESSURE_LEAKS, settling=0.0, half_window=8)
    assert worst(pressure_runs, PRESSURE_LEAKS) < 0.2 * hurried


FILTERED = np.array([0.0, 0.1, 0.5])
"""Leaks [L/min]."""
SENSORS = {P1: 5.3e3, P2: 5.3e3, X: 1e-5, XV: 0.0, U: 0.0}


def leaking(*settings, modulus=620e6):
    """Runs of 6 s without noise."""
    leaks = (PER_LITRE_PER_MINUTE * FILTERED).tolist()
    return simulated("record.duration=6 s", *settings, leaks=leaks, moduli=[modulus] * 3)


@pytest.fixture(scope="module")
def open_loop():
    return leaking()


@pytest.fixture(scope="module")
def filtered(open_loop):
    return noisy(open_loop, [0, 1, 2], 0, SENSORS)


@pytest.fixture(scope="module")
def closed_loop():
    return leaking("control.law=pi", "input.shape=steps", "input.period=1 s")


@pytest.mark.parametrize("motion", ["open_loop", "closed_loop"])
@pytest.mark.parametrize("leak", [0, 1, 2])
def test_the_leakage_of_matched_runs_is_within_the_stated_deviation_of_the_filter(request, motion, leak):
    records = noisy(request.getfixturevalue(motion), [leak] * 24, leak, SENSORS)
    values, _ = measured(records, "ekf_joint")
    error = values["internal_coefficient"] - PER_LITRE_PER_MINUTE * FILTERED[leak]
    stated = values["internal_coefficient_error"]
    assert abs(error.mean()) < 0.5 * stated.mean()
    assert (np.abs(error) < 1.96 * stated).mean() > 0.9
    assert stated.max() < 0.006 * PER_LITRE_PER_MINUTE
    np.testing.assert_allclose(values["bulk_modulus"].mean(), 620e6, rtol=0.015)
    np.testing.assert_allclose(values["leakage"], np.sqrt(8e6) * values["internal_coefficient"], rtol=1e-12)


def test_a_filter_takes_a_measured_supply_pressure_where_it_is(filtered):
    records = with_supply(filtered)
    values, _ = measured(records, "ekf_joint", supply_pressure="14 MPa")
    np.testing.assert_allclose(values["supply_pressure"], 17.2e6, rtol=2e-3)
    one, _ = measured(records, "ekf_joint", supply_pressure="14 MPa", states=["leakage", "bulk_modulus"])
    np.testing.assert_allclose(one["leakage"] / LITRE_PER_MINUTE, FILTERED, atol=0.02)


@pytest.mark.parametrize("name", ["ekf_joint", "ekf_innovation", "ukf_joint"])
def test_a_filter_that_diverged_gives_nothing_from_then_on_and_says_so(filtered, name):
    (ekf,) = make_indicators([name]).values()
    for absurd in (np.nan, 1e12):
        broken = replace(filtered, channels=filtered.channels | {P2: filtered[P2].copy()})
        broken[P2][1, 1525] = absurd
        for key, values in ekf.trace(broken).values.items():
            assert np.isfinite(values[1, :30]).all(), key
            assert np.isnan(values[1, 30:]).all(), key
            assert np.isfinite(values[[0, 2]]).all(), key
        values, reasons = measured(broken, name)
        assert np.isnan(values["leakage"]).tolist() == [False, True, False]
        assert [reason is None for reason in reasons] == [True, False, True]


def test_the_healthy_filter_tells_a_leak_by_its_signature(filtered):
    values, _ = measured(filtered, "ekf_innovation", bulk_modulus="620 MPa")
    np.testing.assert_allclose(values["leakage"] / LITRE_PER_MINUTE, FILTERED, rtol=0.15, atol=2e-3)
    assert (np.diff(values["nis"]) > 0.0).all()
    assert 0.3 < values["nis"][0] < 1.2
    assert 5e3 < values["residual"][0] < 30e3


@pytest.mark.parametrize("states", [("leakage",), ("leakage", "bulk_modulus"), JointOptions().states])
def test_points_close_together_make_the_unscented_filter_the_extended_one(filtered, states):
    extended = EkfJoint(JointOptions(states=states)).measure(filtered)
    unscented = UkfJoint(UnscentedOptions(states=states, spread=0.001)).measure(filtered)
    error = extended["leakage_error"]
    np.testing.assert_allclose(unscented["leakage_error"], error, rtol=0.01)
    assert (np.abs(unscented["leakage"] - extended["leakage"]) < 0.4 * error).all()


def test_leakage_alone_may_be_adapted_and_settles_with_its_time_constant(long_runs):
    """At the mean of the pressure differences, which the law is in proportion to."""
    values, _ = measured(long_runs, "adaptive_observer", estimate=["leakage"], **OBSERVED)
    np.testing.assert_allclose(values["internal_coefficient"], LEAKS, rtol=0.04, atol=1e-10)
    assert "bulk_modulus" not in values
    row, time_constant = 4, 1.5 * 8e6 / np.abs(long_runs[P1] - long_runs[P2])[4].mean()
    (indicator,) = make_indicators({"adaptive_observer": {"estimate": ["leakage"]}}).values()
    trace = indicator.trace(long_runs)
    flow = trace.values["leakage"][row] / trace.values["leakage"][row, -1]
    settled = trace.time[np.flatnonzero(flow > 1.0 - np.exp(-1.0))[0]]
    assert settled == pytest.approx(time_constant, rel=0.25)


@pytest.mark.parametrize("options", [{}, {"spool": "command"}, {"supply": "nominal"}])
def test_the_residual_of_a_known_actuator_is_its_leakage(runs, options):
    nominal = np.flatnonzero(MODULI == 551e6)
    values, _ = measured(runs.rows(nominal.tolist()), "reduced_order", **options)
    np.testing.assert_allclose(values["residual"], np.sqrt(8e6) * LEAKS[nominal], rtol=0.03, atol=1e-7)
    np.testing.assert_allclose(values["exceedance"], values["residual"] - values["bound"], rtol=1e-9)


@pytest.mark.parametrize("signal", ["position_rate", "load_pressure"])
def test_coefficients_count_in_the_scales_that_are_given(signal):
    draw = np.random.default_rng(4)
    command = np.repeat(draw.uniform(-2.0, 2.0, (3, 40)), 100, axis=1)
    speed = np.linspace(0.04, 0.06, 3)[:, None] * command
    pressure = 8.6e6 + 2e6 * command + draw.normal(0.0, 1e4, command.shape)
    moved = batch({U: command, X: np.cumsum(speed, axis=1) / 500.0, P1: pressure, P2: 17.2e6 - pressure})
    scales = {"input_scale": "4 V", "pressure_scale": "17.2 MPa", "rate_scale": "0.2 m/s"}
    one, other = (measured(moved, "volterra", signal=signal, ridge=0.0, **own)[0] for own in ({}, scales))
    factors = [0.5, 1.0, 1.0, 2.0, 2.0, 2.0]
    np.testing.assert_allclose(other["coefficients"], factors * one["coefficients"], atol=1e-7)
    np.testing.assert_allclose(other["left"], 0.5 * one["left"], rtol=1e-5, atol=1e-10)
