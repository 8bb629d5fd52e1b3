"""Claims, controls, tables and figures of the paper."""

import csv
import json
import math
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hydrofdi.config.experiment import ClaimId
from hydrofdi.papers.maddahi2015.claims import CLAIMS, ModeGrid, claim_margins
from hydrofdi.papers.maddahi2015.report import StudyReport, alarm_verdicts, deviations
from hydrofdi.report.figures import draw_figure
from hydrofdi.report.page import render_markdown
from hydrofdi.report.runs import run_table
from hydrofdi.store import names
from hydrofdi.store.results import read_results
from tests.commands import run_hydrofdi
from tests.conftest import SMALL, sweep_in

LEAKAGES, BULK_MODULI = 3, 3


def claims(data):
    return {result.claim.id: result for result in StudyReport(data).claims}


def cell(data, leakage, bulk_modulus):
    """Row of a mode; leakage 0 is sealed."""
    return int(StudyReport(data).grid.positions[0, leakage, bulk_modulus])


def test_the_configuration_knows_just_the_claims_of_the_report():
    assert get_args(ClaimId) == tuple(claim.id for claim in CLAIMS)


def test_the_checks_are_as_many_as_the_paper_gives_reason_for(paper_analysis):
    assert [len(result.checks) for result in paper_analysis.claims] == [3, 1, 3, 6, 2, 1]


@pytest.mark.parametrize(
    ("claim", "leakage", "bulk_modulus", "level", "factor"),
    [
        ("C1", 1, 0, 1, 1.2),
        ("C2", 3, 0, 1, 1.4),
        ("C3", 2, 2, 1, 0.5),
        ("C4", 3, 1, 2, 3.0),
        ("C5", 1, 2, 4, 0.5),
    ],
)
def test_breaking_one_cell_turns_the_verdict(paper, break_cell, claim, leakage, bulk_modulus, level, factor):
    position = cell(paper, leakage, bulk_modulus)
    assert claims(paper)[claim].reproduced is True
    rms = paper.columns[names.DETAIL_RMS][position, level]
    study = StudyReport(break_cell(paper, position, level, factor * rms))
    (broken,) = [result for result in study.claims if result.claim.id == claim]
    assert broken.reproduced is False
    assert broken.margin < 0.0
    assert sum(bool(check[0] <= 0.0) for check in broken.checks) == 1


def test_the_margin_is_how_far_a_delta_can_move_before_the_verdict_turns(paper, break_cell):
    (check, *_) = claims(paper)["C1"].checks
    position, healthy = cell(paper, 1, 0), cell(paper, 0, 0)
    rms = paper.columns[names.DETAIL_RMS]
    for excess, outcome in ((-1e-3, True), (1e-3, False)):
        moved = rms[position, 1] + (check[0] + excess) / 100.0 * rms[healthy, 1]
        assert bool(claims(break_cell(paper, position, 1, moved))["C1"].checks[0][0] > 0.0) is outcome


def test_a_missing_run_leaves_a_claim_open_unless_another_check_breaks_it(paper, break_cell):
    position = cell(paper, 3, 1)
    holed = break_cell(paper, position, slice(None), np.nan)
    assert {name: result.reproduced for name, result in claims(holed).items()} == {
        "C1": True, "C2": True, "C3": None, "C4": None, "C5": True, "C6": None,
    }  # fmt: skip
    broken = break_cell(holed, cell(paper, 1, 1), 2, 1e9)
    assert claims(broken)["C4"].reproduced is False


def test_c6_fails_where_one_level_is_the_largest_in_all_modes(paper, break_cell):
    data = paper
    for leakage in range(1, LEAKAGES + 1):
        for bulk_modulus in range(BULK_MODULI):
            data = break_cell(data, cell(paper, leakage, bulk_modulus), 3, 1e9)
    assert claims(data)["C6"].reproduced is False


def margins_of(leaky):
    """Margins of all claims on δ of shape (scenario, leakage, EBM, level)."""
    n_scenario, n_leakage, n_bulk_modulus, n_level = leaky.shape
    delta = np.concatenate([np.zeros_like(leaky[:, :1]), leaky], axis=1)
    grid = ModeGrid(
        scenarios=({},) * n_scenario,
        leakage_flows=tuple(range(1, n_leakage + 1)),
        bulk_moduli=tuple(range(n_bulk_modulus)),
        normal=0,
        positions=np.arange(delta[..., 0].size).reshape(delta.shape[:3]),
    )
    return claim_margins(grid, delta.reshape(-1, n_level))


def holds_as_the_paper_says(d):
    """The checks of all claims on δ of shape (leakage, EBM, level), written out one by one."""
    raised = range(1, BULK_MODULI)
    leads = lambda v, k: v[k] > 0 and all(v[k] > v[j] for j in range(5) if j != k)  # noqa: E731
    largest = {int(np.argmax(np.abs(d[q, b]))) for q in range(LEAKAGES) for b in range(BULK_MODULI)}
    return {
        "C1": all(leads(d[q, 0], 1) for q in range(LEAKAGES)),
        "C2": d[0, 0, 1] < d[1, 0, 1] < d[2, 0, 1],
        "C3": all(d[q, 0, 1] > d[q, 1, 1] > d[q, 2, 1] for q in range(LEAKAGES)),
        "C4": all(leads(d[q, b], 2) for q in range(LEAKAGES) for b in raised),
        "C5": all(d[0, b, 2] > 0 and all(d[0, b, j] < 0 for j in (0, 1, 3, 4)) for b in raised),
        "C6": len(largest) > 1,
    }


@given(
    arrays(int, (4, LEAKAGES, BULK_MODULI, 5), elements=st.integers(1, 100_000), unique=True),
    st.booleans(),
    st.sampled_from([0.0, -200.0]),
)
def test_margins_say_the_same_as_the_checks_written_out(leaky, is_close_to_the_paper, shift):
    leaky = np.where(leaky % 2, leaky, -leaky) / 2000.0  # no two of the same size, below too
    if is_close_to_the_paper:  # most random tables fail everything; these often hold
        leaky = np.abs(leaky)
        leaky[:, :, 0, 1] += 60.0003
        leaky[:, 1:, 0, 1] += 60.0003
        leaky[:, :, 1:, 2] += 60.0003
        leaky[:, :, 2, 1] -= 55.0001
    leaky = leaky + shift
    margins = margins_of(leaky)
    for scenario, delta in enumerate(leaky):
        expected = holds_as_the_paper_says(delta)
        assert {name: bool(margin[scenario] > 0.0) for name, margin in margins.items()} == expected


def test_with_two_levels_there_is_nothing_to_check():
    leaky = np.ones((1, LEAKAGES, BULK_MODULI, 2))
    assert all(np.isnan(margin).all() for margin in margins_of(leaky).values())


def sealed_row(data, beta):
    return int(StudyReport(data).grid.positions[0, 0, beta])


def test_the_rule_alarms_where_the_bulk_modulus_alone_lowers_d3(paper_analysis):
    sealed = paper_analysis.sealed
    assert [round(each / 1e6) for each in sealed[names.BULK_MODULUS]] == [689, 827]
    delta = sealed.changes("fixed")
    assert alarm_verdicts(delta) == [each[2] > 0 and max(each) == each[2] for each in delta]


@pytest.mark.parametrize(
    ("level", "rms", "verdict"),
    [(2, 1e9, False), (0, 1.0, False), (slice(None), math.nan, None)],
    ids=["d3 rises", "d1 falls more", "failed"],
)
def test_the_rule_is_silent_or_open(paper, break_cell, level, rms, verdict):
    analysis = StudyReport(break_cell(paper, sealed_row(paper, 1), level, rms))
    assert alarm_verdicts(analysis.sealed.changes("fixed")) == [verdict, True]


def test_figure_2_shows_the_reference_in_closed_loop_alone(small_sweep, tmp_path):
    text = SMALL.replace("sweep:", "control: {law: pi}\nsweep:")
    closed = StudyReport(read_results(sweep_in(tmp_path, text).directory))
    for analysis, n_line in ((StudyReport(read_results(small_sweep.directory)), 1), (closed, 2)):
        axes = draw_figure(analysis, "figure2").axes
        assert [len(axis.lines) for axis in axes[2:4]] == [n_line] * 2
        assert all(len(axis.lines) == 1 for axis in (*axes[:2], *axes[4:]))


def deviations_of(data):
    return deviations(run_table(data), data.experiment.reference)


def test_computed_published_and_deviation_stand_side_by_side(made_up):
    d2, d1, absent = deviations_of(made_up)
    assert (d2["computed"], d2["deviation"], d2["agrees"]) == (pytest.approx(10.0), pytest.approx(0.0), True)
    assert d1["agrees"] is None, "the run of this cell failed"
    assert absent["agrees"] is None, "there is no such run"


def test_a_deviation_beyond_the_tolerance_is_reported(made_up, break_cell):
    found = deviations_of(break_cell(made_up, 2, 1, 181_100.0))
    assert found[0]["deviation"] == pytest.approx(-0.55)
    assert found[0]["agrees"] is False
    assert deviations_of(break_cell(made_up, 2, 1, 180_900.0))[0]["agrees"] is True


KEPT = Path(__file__).parents[2] / "results" / "table3"
TOLERANCE = {"delta_fixed_percent": 0.05, "delta_matched_percent": 0.05}


def test_the_numbers_are_those_that_the_repository_keeps(paper_analysis):
    with open(KEPT / "table3.csv", newline="", encoding="utf-8") as file:
        kept = list(csv.DictReader(file))
    columns = paper_analysis.columns()
    assert list(kept[0]) == list(columns)
    del columns["run_id"]
    for header, values in columns.items():
        texts = [line[header] for line in kept]
        if isinstance(values[0], float):
            numbers = [float(text) for text in texts]
            assert values == pytest.approx(numbers, rel=1e-4, abs=TOLERANCE.get(header, 1e-12)), header
        else:
            assert [str(value) for value in values] == texts, header


def test_the_markdown_is_that_which_the_repository_keeps(paper_analysis):
    kept = words((KEPT / "table3.md").read_text(encoding="utf-8"))
    fresh = words(render_markdown(paper_analysis.document()))
    assert [word for word in fresh if not is_number(word)] == [word for word in kept if not is_number(word)]
    numbers = [float(word) for word in kept if is_number(word)]
    assert [float(word) for word in fresh if is_number(word)] == pytest.approx(numbers, rel=1e-4, abs=0.11)


def words(markdown):
    """Words without emphasis and identities of runs, up to the configuration."""
    text = re.sub(r"\*\*|[|,;:()]", " ", markdown.partition("## Configuration")[0])
    return [word for word in text.split() if not re.fullmatch(r"[0-9a-f]{6}", word)]


def is_number(word):
    return re.fullmatch(r"[-+]?\d+(\.\d+)?\.?", word) is not None


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


def test_check_asks_that_a_claim_holds_in_every_feasible_reading(ensemble, study):
    result = ensemble("report", "results/scenarios", "--check")
    assert result.returncode == (0 if study["reproducing"]["C2"] == study["feasible"] else 1)


@pytest.mark.long
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


@pytest.mark.parametrize(
    ("leak", "expected"),
    [("0.12 L/min", {"C2": None, "C3": 2, "C1–C4": None}), ("3 L/min", {"C1": 0, "C2": None, "C1–C4": 0})],
)
def test_a_claim_that_no_scenario_can_test_is_open_unless_another_fails_in_all(tmp_path, leak, expected):
    sweep = sweep_in(tmp_path, ONE_LEAK.replace("0.12 L/min", leak))
    study = json.loads(run_hydrofdi("report", sweep.directory, "--json").stdout)["scenarios"]
    assert {name: study["reproducing"][name] for name in expected} == expected


def test_only_independent_draws_have_intervals(tmp_path, study):
    text = ENSEMBLE.replace("sample: {count: 2,", "sample: {method: random, count: 2,")
    sweep = sweep_in(tmp_path, text)
    drawn = json.loads(run_hydrofdi("report", sweep.directory, "--json").stdout)["scenarios"]
    for record, has_intervals in ((study, False), (drawn, True)):
        interval = record["sealed_alarms"]["feasible"]["alarms"]["interval_95"]
        assert (interval is not None) is has_intervals
