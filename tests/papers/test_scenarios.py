import json

import pytest

from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

ENSEMBLE = """\
name: scenarios
record: {duration: 2 s}
store: {signals: none}
paper: maddahi2015
claims: [C2]
ensemble:
  zip: {friction.coulomb: [200 N, 20 N], friction.breakaway: [250 N, 25 N]}
  sample: {count: 2, seed: 3, over: {actuator.chamber_volume: {uniform: [200 cm^3, 400 cm^3]}}}
  grid: {valve.spool_gain: [22 µm/V, 0.4 µm/V]}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("scenarios")


@pytest.fixture(scope="module")
def ensemble(folder):
    def run(*arguments):
        return run_hydrofdi(*arguments, cwd=folder)

    (folder / "scenarios.yaml").write_text(ENSEMBLE, encoding="utf-8")
    swept = run("sweep", "scenarios.yaml", "--engine", "in-process")
    assert swept.returncode == 1, "scenarios whose leakage is out of reach are failed runs"
    return run


@pytest.fixture(scope="module")
def study(ensemble):
    return json.loads(ensemble("report", "results/scenarios", "--json").stdout)["scenarios"]


def test_scenarios_with_an_unreachable_leakage_count_as_infeasible(study):
    assert (study["scenarios"], study["feasible"]) == (8, 4)
    assert study["infeasible"] == {"unreachable_leakage": 4}
    for member in study["members"]:
        outcome = "ok" if member["values"]["valve.spool_gain"] == 22e-6 else "unreachable_leakage"
        assert member["outcome"] == outcome


def test_the_counts_are_those_of_the_members(study):
    for claim in ("C1", "C2", "C3", "C4", "C5", "C6"):
        margins = [member["margins_percentage_points"][claim] for member in study["members"]]
        assert study["reproducing"][claim] == sum(margin is not None and margin > 0 for margin in margins)


def test_the_shares_of_each_parameter_add_up_to_all_scenarios(study):
    by_parameter = {}
    for value in study["values"]:
        by_parameter.setdefault(tuple(value["parameters"]), []).append(value)
    assert ("friction.coulomb", "friction.breakaway") in by_parameter, "what varies together is one parameter"
    for values in by_parameter.values():
        assert sum(value["scenarios"] for value in values) == study["scenarios"]
        for claim, count in study["reproducing"].items():
            assert sum(value["reproducing"][claim] for value in values) == count


def test_a_scenario_gives_the_margins_of_the_same_experiment_by_itself(study, ensemble, folder):
    sections = ENSEMBLE.split("ensemble:")[0], "sweep:" + ENSEMBLE.split("sweep:")[1]
    (folder / "alone.yaml").write_text("".join(sections).replace("name: scenarios", "name: alone"))
    member = next(member for member in study["members"] if member["outcome"] == "ok")
    settings = [f"--set={name}={value!r}" for name, value in member["values"].items()]
    assert ensemble("sweep", "alone.yaml", "--engine", "in-process", *settings).returncode == 0
    claims = json.loads(ensemble("report", "results/alone", "--json").stdout)["claims"]
    for claim in claims:
        assert claim["margin_percentage_points"] == member["margins_percentage_points"][claim["id"]]


def test_a_parameter_that_varies_in_sweep_and_ensemble_is_a_mistake(ensemble):
    result = ensemble("sweep", "scenarios.yaml", "--set=ensemble.grid.fluid.bulk_modulus=[551 MPa, 600 MPa]")
    assert result.returncode == 2
    assert "fluid.bulk_modulus varies in both ensemble and sweep" in result.stderr


def test_check_asks_that_a_claim_holds_in_every_feasible_reading(ensemble, study):
    result = ensemble("report", "results/scenarios", "--check")
    assert result.returncode == (0 if study["reproducing"]["C2"] == study["feasible"] else 1)


def test_scenarios_that_differ_in_the_leak_alone_share_their_sealed_controls(ensemble, folder):
    text = ENSEMBLE.split("ensemble:")[0] + "ensemble: {grid: {leakage.law: [orifice, laminar]}}\nsweep:"
    (folder / "laws.yaml").write_text(
        text.replace("name: scenarios", "name: laws") + ENSEMBLE.split("sweep:")[1]
    )
    assert ensemble("sweep", "laws.yaml", "--engine", "in-process").returncode == 0
    members = json.loads(ensemble("report", "results/laws", "--json").stdout)["scenarios"]["members"]
    alarms = [member["sealed_alarms"] for member in members]
    assert len(alarms) == 2
    assert alarms[0] == alarms[1] == [True]


ONE_LEAK = """\
name: one-leak
record: {duration: 2 s}
store: {signals: none}
paper: maddahi2015
claims: [C2, C3]
ensemble: {grid: {friction.viscous: [40, 60]}}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


def test_a_claim_that_no_scenario_can_test_is_open(tmp_path):
    report = sweep_in(tmp_path, ONE_LEAK).directory, "--format"
    study = json.loads(run_hydrofdi("report", *report, "json", cwd=tmp_path).stdout)["scenarios"]
    assert study["reproducing"]["C2"] is study["reproducing"]["C1–C4"] is None
    assert study["reproducing"]["C3"] == 2


def test_claims_together_fail_where_one_of_them_fails_in_all_scenarios(tmp_path):
    text = ONE_LEAK.replace("[0 L/min, 0.12 L/min]", "[0 L/min, 3 L/min]")
    report = sweep_in(tmp_path, text).directory, "--json"
    study = json.loads(run_hydrofdi("report", *report, cwd=tmp_path).stdout)["scenarios"]
    assert study["reproducing"]["C1"] == 0
    assert study["reproducing"]["C2"] is None
    assert study["reproducing"]["C1–C4"] == 0


@pytest.mark.parametrize(("method", "has_intervals"), [("sobol", False), ("random", True)])
def test_only_independent_draws_have_intervals(tmp_path, method, has_intervals):
    text = ENSEMBLE.replace("sample: {count: 2,", f"sample: {{method: {method}, count: 2,")
    (tmp_path / "scenarios.yaml").write_text(text)
    assert run_hydrofdi("sweep", "scenarios.yaml", "--engine", "in-process", cwd=tmp_path).returncode == 1
    record = json.loads(run_hydrofdi("report", "--json", cwd=tmp_path).stdout)["scenarios"]
    interval = record["sealed_alarms"]["feasible"]["alarms"]["interval_95"]
    assert (interval is not None) is has_intervals
