"""What a motion tells model-based indicators, and how ``hydrofdi check`` says it."""

import pytest

from hydrofdi.api.check import observability, select_runs
from hydrofdi.config import load_experiment
from tests.commands import run_json

FREE = ("actuator.load_stiffness=0 N/m",)
SHORT = ("record.duration=8 s",)
OTHERS_KNOWN = (
    "indicators={weak_rls: {spool: command, supply_deviation: 0, lap_deviation: 0 m, clearance_deviation:"
    " 0 m^3/(s*Pa), offset_deviation: 0 m, pressure_bias: 0 Pa}}"
)

FILTER = "indicators={ekf_joint: {states: [leakage, flow_gain], load_stiffness: 1e-3 N/m}}"


def observed(*settings):
    (found,) = observability(select_runs(load_experiment(None, (*SHORT, *settings))).jobs[0])
    return found


def correlation(found, *names):
    return {frozenset(pair[:2]): pair[2] for pair in found.collinear}.get(frozenset(names))


@pytest.mark.parametrize("choice", [OTHERS_KNOWN, FILTER], ids=["weak_rls", "ekf_joint"])
def test_flow_gain_and_leakage_are_collinear_at_one_amplitude_against_no_spring(choice):
    found = observed(*FREE, "input.amplitude=0.5 V", choice)
    assert correlation(found, "leakage", "flow gain") > 0.98
    several = observed(*FREE, "input.shape=steps", "input.period=1 s", "input.amplitude=1 V", choice)
    assert correlation(several, "leakage", "flow gain") is None


@pytest.mark.parametrize(
    "settings",
    [(*FREE, "input.shape=steps", "input.period=1 s", "input.amplitude=1 V"), ()],
    ids=["several amplitudes", "one amplitude against the spring"],
)
def test_several_amplitudes_or_a_load_tell_them_apart(settings):
    found = observed(*settings, OTHERS_KNOWN)
    assert correlation(found, "leakage", "flow gain") is None
    leakage = next(each for each in found.unknowns if each.name == "leakage")
    assert leakage.after < 0.01 * leakage.before


def test_at_one_amplitude_a_lap_is_a_flow_gain():
    found = observed("indicators={weak_rls: {spool: command}}")
    assert correlation(found, "lap", "flow gain") > 0.98
    assert found.weakest.startswith("lap")
    assert "flow gain" in found.weakest
    assert found.weakest_left > 0.9


def test_a_leak_of_the_run_is_left_aside():
    healthy, leaking = (
        observed("indicators=[weak_rls]", *more) for more in ((), ("leakage.internal_coefficient=2e-8",))
    )
    assert healthy == leaking


def test_a_kalman_filter_is_told_of_motion_and_parameters():
    choice = "indicators={ekf_joint: {states: [leakage, bulk_modulus, flow_gain, lap]}}"
    found = observed(choice)
    assert [each.name for each in found.unknowns[5:]] == ["leakage", "bulk modulus", "flow gain", "lap"]
    assert found.weakest.startswith("lap")
    assert "flow gain" in found.weakest
    steps = observed(choice, "input.shape=steps", "input.period=1 s")
    assert steps.weakest_left < 0.6 < 0.9 < found.weakest_left


def test_an_estimate_that_diverges_has_no_numbers(tmp_path):
    (tmp_path / "wrong.yaml").write_text(
        "name: wrong\nrecord: {duration: 4 s}\nindicators: {ekf_joint: {mass: 0.01 kg}}\n"
    )
    (record,) = run_json("check", tmp_path / "wrong.yaml")["observability"]
    assert (record["unknowns"], record["weakest_left"]) == ([], None)
