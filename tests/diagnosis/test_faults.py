"""Faults of simulated days are named, with their sizes; what is no hypothesis is none of these."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.diagnosis.balance import NAMES, PLACE
from hydrofdi.diagnosis.history import history_of, history_of_sheet, signatures
from hydrofdi.diagnosis.judging import Judge
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Channel
from tests.machines import LOOP, TINY

P1 = Channel.CHAMBER_1_PRESSURE
SHEET = {"spool": "command", "supply": "nominal", "return_pressure": 4e5}
FLOW = 0.1e-3 / 60.0

FAULTS = {
    "seal_orifice": ({"leakage.internal_coefficient": FLOW / 8e6**0.5}, FLOW),
    "seal_laminar": ({"leakage.internal_coefficient": 2.0 * FLOW / 8e6**0.5, "leakage.law": "laminar"}, None),
    "external_1": ({"leakage.external_coefficient_1": FLOW / 8e6}, FLOW),
    "worn_edge": ({"supply_1_edge.lap": -2e-6}, 2e-6),
    "null_shift": ({"valve.null_offset": -1.5e-6}, 1.5e-6),
    "weak_supply": ({"supply.pressure": 15.5e6}, 1.7e6),
    "raised_return": ({"supply.return_pressure": 14e5}, 1e6),
    "soft_oil": ({"fluid.bulk_modulus": 551e6 / 1.5}, None),
    "bias_P1": ({"pressure_1_sensor.bias": 5e5}, 5e5),
    "gain_P2": ({"pressure_2_sensor.gain_error": -0.05}, 0.05),
}
"""Fault → what differs on its day, and its size as it is stated; None if that depends on more."""

EVERY_OPTION = {
    name: value
    for name, value in LOOP.items()
    if not name.startswith("control.") and name not in ("fluid.free_air", "fluid.temperature_rise")
} | {"leakage.internal_coefficient": TINY}
"""What changes nothing, so that days with unusual options run a variant of the kernel that others run."""


@pytest.fixture(scope="session")
def options():
    """Balance of the nominal machine."""
    return sound_indicator("flow_balance", SHEET).options


@pytest.fixture(scope="session")
def judge(healthy, options):
    """Judge with the history of healthy days."""
    return Judge(history_of([healthy], options))


def hypothesis_of(judge, name):
    return next(each for each in judge.hypotheses if each.name == name)


def with_channel(batch, channel, samples):
    return replace(batch, channels={**batch.channels, channel: samples})


def findings(judge, batch):
    """The findings on each record."""
    return [judge.findings(batch.rows([row])) for row in range(batch.n_record)]


@pytest.fixture(scope="session")
def of_faults(days, judge):
    """Fault → findings on its day."""
    batch = days([change for change, _ in FAULTS.values()], first=100)
    return dict(zip(FAULTS, findings(judge, batch), strict=True))


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_first_with_its_size(name, of_faults):
    first, *_ = of_faults[name]
    alike = (first.name, *first.looks_like)
    assert name in alike, [(each.name, round(each.probability, 3)) for each in of_faults[name][:3]]
    assert first.name == name
    assert first.low <= first.probability <= first.high
    size = FAULTS[name][1]
    if size is not None:
        assert first.size == pytest.approx(size, rel=0.35)
        assert first.size_low < first.size < first.size_high
    assert sum(each.probability for each in of_faults[name]) == pytest.approx(1.0)


def test_healthy_days_are_healthy(days, judge):
    names = [each[0].name for each in findings(judge, days([{}] * 20, first=200))]
    assert names.count("healthy") >= 19


@pytest.mark.parametrize(
    "change", [{"valve.hysteresis": 0.15}, {"valve.natural_frequency": 40.0}, {"valve.gain_slope": -5e3}]
)
def test_a_fault_without_a_hypothesis_is_none_of_these(change, days, judge):
    batch = days([EVERY_OPTION | change] * 4, first=300)
    assert [each[0].name for each in findings(judge, batch)].count("none_of_these") >= 3


def test_a_score_narrower_than_the_places_of_the_leak_is_named(days, judge):
    scored = EVERY_OPTION | {
        "leakage.scored_width": 6e-3, "leakage.internal_coefficient": 5.0 * FLOW / 8e6**0.5,
    }  # fmt: skip
    batch = days([scored | {"leakage.scored_centre": centre} for centre in (-8e-3, 1e-3, 6e-3)], first=310)
    assert [each[0].name for each in findings(judge, batch)].count("seal_scored") == 3


def test_a_healthy_history_keeps_its_records(days, options):
    batch, draw = days([{}] * 16, first=320), np.random.default_rng(1)
    histories = [draw.permutation(16)[:n] for n in (6, 6, 8, 8, 12, 16)]
    assert not [rows for rows in histories if Judge(history_of([batch.rows([*rows])], options)).stranger()]


def test_a_supply_far_from_the_data_sheet_is_found_exactly(days, options, judge):
    batch = days([{"supply.pressure": 17.2e6 * share} for share in (0.85, 1.0)], first=340)
    balance = judge.history.balance
    found = balance.estimate(balance.fit(batch), judge.history.variance)
    low, usual = found.values[:, PLACE["supply"]] * balance.scales[PLACE["supply"]]
    assert low - usual == pytest.approx(-0.15, abs=0.01)
    assert found.misfits[0] == pytest.approx(found.misfits[1], rel=0.3)


def test_equations_about_the_errors_of_a_pressure_are_those_of_the_right_one(healthy, judge):
    one, balance = healthy.rows([0]), judge.history.balance
    wrong = with_channel(one, P1, 1.15 * one[P1] + 3e5)
    about = np.zeros((2, 1, len(NAMES)))
    for name, error in (("gain_1", 0.15), ("bias_1", 3e5)):
        about[1, :, PLACE[name]] = error / balance.scales[PLACE[name]]
    right, found = (balance._moments(each, at)[0] for each, at in zip((one, wrong), about, strict=True))
    assert found == pytest.approx(right, rel=1e-9, abs=1e-9 * np.abs(right).max())
    assert not np.allclose(balance._moments(wrong, about[0])[0], right, rtol=0.01)


@pytest.mark.parametrize(
    ("name", "channel", "factor"),
    [
        ("gain_P1", P1, 1.01),
        ("gain_x", Channel.PISTON_POSITION, 1.01),
        ("flow_gain", Channel.INPUT_VOLTAGE, 1.02),
    ],
)
def test_an_error_of_a_channel_moves_the_signature_along_its_direction(name, channel, factor, healthy, judge):
    one, history, hypothesis = healthy.rows([0]), judge.history, hypothesis_of(judge, name)
    changed = with_channel(one, channel, factor * one[channel])
    before, estimates = signatures(history.balance, one, history.variance)
    after, _ = signatures(history.balance, changed, history.variance)
    gain = estimates.gains[0]
    n_own, n_cause = gain.shape
    moved = (after - before)[0, :n_own]
    expected = (factor - 1.0) * (gain @ hypothesis.directions[:, :n_cause].T)
    best = expected[:, np.argmax(expected.T @ moved)]
    weights = 1.0 / np.sqrt(np.diag(history.scatter)[:n_own])
    cosine = (weights * moved) @ (weights * best) / np.linalg.norm(weights * moved)
    assert cosine / np.linalg.norm(weights * best) > 0.9
    if name == "gain_x":
        place = history.names.index("stiffness")
        direction = hypothesis.directions[0][history.causes.index("stiffness")]
        assert (after - before)[0, place] == pytest.approx((factor - 1.0) * direction, rel=0.05)


def test_gains_of_valve_and_position_look_alike_until_a_second_sensor_tells(days, judge):
    (found,) = findings(judge, days([{"voltage_sensor.gain_error": 0.06}], first=400))
    assert found[0].name in ("flow_gain", "gain_x")
    other = {"flow_gain": "gain_x", "gain_x": "flow_gain"}[found[0].name]
    assert other in found[0].looks_like
    assert found[0].told_by[other] in ("a second position sensor", "spool position")


def test_the_data_sheet_alone_tells_a_large_leak(days, options):
    batch = days([{"leakage.internal_coefficient": 10.0 * FLOW / 8e6**0.5}], first=500)
    judge = Judge(history_of_sheet(batch, options))
    (found,) = findings(judge, batch)
    assert found[0].name == "seal_orifice"
    assert judge.history.n_record == 0


def test_one_pressure_names_a_large_leak_among_others(healthy, days):
    made = sound_indicator("flow_balance", SHEET | {"chambers": 1}).options
    judge = Judge(history_of([healthy], made))
    assert {"friction_up", "external_2", "bias_P2"}.isdisjoint(each.name for each in judge.hypotheses)
    (found,) = findings(judge, days([{"leakage.internal_coefficient": 8.0 * FLOW / 8e6**0.5}], first=600))
    assert found[0].name != "healthy"
    assert any("seal" in name for name in (found[0].name, *found[0].looks_like))


def test_a_large_null_shift_is_found_by_moving_the_spool(days, judge):
    (found,) = findings(judge, days([{"valve.null_offset": 5e-6}], first=900))
    assert found[0].name == "null_shift"
    assert found[0].size == pytest.approx(5e-6, rel=0.05)


@pytest.mark.parametrize(("share", "name"), [(0.2, "seal_orifice"), (1.5, "none_of_these")])
def test_a_change_beside_the_direction_of_a_fault_is_allowed_in_part(share, name, healthy, judge):
    history, one = judge.history, healthy.rows([0])
    _, estimates = signatures(history.balance, one, history.variance)
    gain, noise = estimates.gains[0], estimates.noise[0]
    direction = hypothesis_of(judge, "seal_orifice").directions[0]
    own, rest = np.split(20.0 * FLOW * direction, [gain.shape[1]])
    moved = np.concatenate((gain @ own, rest))
    factor = np.linalg.cholesky(history.scatter_of(noise))
    white = np.linalg.solve(factor, moved)
    beside = np.random.default_rng(1).normal(size=white.size)
    beside -= (beside @ white) / (white @ white) * white
    beside *= share * np.linalg.norm(white) / np.linalg.norm(beside)
    first, *_ = judge.judge(history.centre + factor @ (white + beside), gain, noise)
    assert first.name == name
