"""Claims, controls, tables and figures of the paper."""

import csv
import json
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
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.report.figures import draw_figure
from hydrofdi.report.page import render_markdown
from hydrofdi.store.results import read_results
from tests.commands import run_hydrofdi
from tests.conftest import SMALL, sweep_in

LEAKAGES, BULK_MODULI = 3, 3


def claims(data):
    return {result.claim.id: result for result in StudyReport(data).claims}


def cell(data, leakage, bulk_modulus):
    """Row of a mode; leakage 0 is sealed."""
    return int(StudyReport(data).grid.positions[0, leakage, bulk_modulus])


def test_the_claims_of_the_configuration_have_the_checks_that_the_paper_gives_reason_for(paper_analysis):
    assert get_args(ClaimId) == tuple(claim.id for claim in CLAIMS)
    assert [len(result.checks) for result in paper_analysis.claims] == [3, 1, 3, 6, 2, 1]


def test_a_missing_run_leaves_a_claim_open_unless_another_check_breaks_it(paper, break_cell):
    position = cell(paper, 3, 1)
    holed = break_cell(paper, position, slice(None), np.nan)
    assert [result.reproduced for result in claims(holed).values()] == [True, True, None, None, True, None]
    broken = break_cell(holed, cell(paper, 1, 1), 2, 1e9)
    assert (claims(broken)["C4"].reproduced, claims(broken)["C4"].margin < 0.0) == (False, True)


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
    st.sampled_from([0.0, 1000.0]),
)
def test_margins_say_the_same_as_the_checks_written_out(leaky, is_close_to_the_paper, shift, lead):
    leaky = np.where(leaky % 2, leaky, -leaky) / 2000.0  # no two of the same size, below too
    if is_close_to_the_paper:  # most random tables fail everything; these often hold
        leaky = np.abs(leaky)
        leaky[:, :, 0, 1] += 60.0003
        leaky[:, 1:, 0, 1] += 60.0003
        leaky[:, :, 1:, 2] += 60.0003
        leaky[:, :, 2, 1] -= 55.0001
    leaky = leaky + shift
    leaky[..., 3] += lead  # one level is the largest in all modes
    margins = margins_of(leaky)
    for scenario, delta in enumerate(leaky):
        expected = holds_as_the_paper_says(delta)
        assert {name: bool(margin[scenario] > 0.0) for name, margin in margins.items()} == expected
    assert all(np.isnan(margin).all() for margin in margins_of(leaky[..., :2]).values()), "two levels"


def test_figure_2_shows_the_reference_in_closed_loop_alone(small_sweep, tmp_path):
    text = SMALL.replace("sweep:", "control: {law: pi}\nsweep:")
    closed = StudyReport(read_results(sweep_in(tmp_path, text).directory))
    for analysis, n_line in ((StudyReport(read_results(small_sweep.directory)), 1), (closed, 2)):
        axes = draw_figure(analysis, "figure2").axes
        assert [len(axis.lines) for axis in axes[2:4]] == [n_line] * 2
        assert all(len(axis.lines) == 1 for axis in (*axes[:2], *axes[4:]))


KEPT = Path(__file__).parents[2] / "results" / "table3"


def test_the_numbers_are_those_that_the_repository_keeps(paper_analysis):
    with open(KEPT / "table3.csv", newline="", encoding="utf-8") as file:
        kept = list(csv.DictReader(file))
    columns = paper_analysis.columns()
    assert list(kept[0]) == list(columns)
    del columns["run_id"]
    for header, values in columns.items():
        texts = [line[header] for line in kept]
        if isinstance(values[0], float):
            absolute = 0.05 if header in ("delta_fixed_percent", "delta_matched_percent") else 1e-12
            assert values == pytest.approx([float(text) for text in texts], rel=1e-4, abs=absolute), header
        else:
            assert [str(value) for value in values] == texts, header
    (kept_words, kept_numbers), (words, numbers) = map(
        parted, ((KEPT / "table3.md").read_text(encoding="utf-8"), render_markdown(paper_analysis.document()))
    )
    assert words == kept_words
    assert numbers == pytest.approx(kept_numbers, rel=1e-4, abs=0.11)


def parted(markdown):
    """Texts and numbers up to the configuration, without emphasis and identities of runs."""
    text = re.sub(r"\*\*|\b[0-9a-f]{6}\b", "", markdown.partition("## Configuration")[0])
    parts = re.split(r"([-+]?\b\d+(?:\.\d+)?)", text)
    return parts[::2], [float(number) for number in parts[1::2]]


ENSEMBLE = """\
name: scenarios
record: {duration: 2 s}
store: {signals: none}
paper: maddahi2015
claims: [C2]
ensemble:
  zip: {friction.coulomb: [200 N, 20 N], friction.breakaway: [250 N, 25 N]}
  sample:
    {method: random, count: 2, seed: 3, over: {actuator.chamber_volume: {uniform: [200 cm^3, 400 cm^3]}}}
  grid: {valve.spool_gain: [22 µm/V, 0.4 µm/V]}
"""
GRID = """\
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min]
    fluid.bulk_modulus: [551 MPa, 689 MPa]
"""


@pytest.fixture(scope="module")
def ensemble(tmp_path_factory):
    """Runs commands in the folder of the sweep."""
    folder = tmp_path_factory.mktemp("scenarios")

    def run(*arguments, text=None):
        if text is not None:
            (folder / arguments[1]).write_text(text, encoding="utf-8")
        return run_hydrofdi(*arguments, cwd=folder)

    swept = run("sweep", "scenarios.yaml", "--engine", "in-process", text=ENSEMBLE + GRID)
    assert swept.returncode == 1, "scenarios whose leakage is out of reach are failed runs"
    return run


@pytest.fixture(scope="module")
def study(ensemble):
    return json.loads(ensemble("report", "results/scenarios", "--json").stdout)["scenarios"]


def test_scenarios_are_counted_by_what_their_members_show(study, ensemble):
    assert (study["scenarios"], study["feasible"]) == (8, 4)
    assert study["infeasible"] == {"unreachable_leakage": 4}
    for member in study["members"]:
        outcome = "ok" if member["values"]["valve.spool_gain"] == 22e-6 else "unreachable_leakage"
        assert member["outcome"] == outcome
    for claim in ("C1", "C2", "C3", "C4", "C5", "C6"):
        margins = [member["margins_percentage_points"][claim] for member in study["members"]]
        assert study["reproducing"][claim] == sum(margin is not None and margin > 0 for margin in margins)
    alarms = study["sealed_alarms"]["feasible"]["alarms"]
    assert (
        0.0 <= alarms["interval_95"][0] <= alarms["count"] / alarms["of"] <= alarms["interval_95"][1] <= 1.0
    )
    checked = ensemble("report", "results/scenarios", "--check").returncode
    assert checked == (0 if study["reproducing"]["C2"] == study["feasible"] else 1)


def test_a_scenario_gives_the_margins_of_the_same_experiment_by_itself(study, ensemble):
    alone = "name: alone" + ENSEMBLE[len("name: scenarios") : ENSEMBLE.index("ensemble:")] + GRID
    member = next(member for member in study["members"] if member["outcome"] == "ok")
    settings = [f"--set={name}={value!r}" for name, value in member["values"].items()]
    assert ensemble("sweep", "alone.yaml", "--engine", "in-process", *settings, text=alone).returncode == 0
    claims = json.loads(ensemble("report", "results/alone", "--json").stdout)["claims"]
    margins = {claim["id"]: claim["margin_percentage_points"] for claim in claims}
    assert margins == {claim: member["margins_percentage_points"][claim] for claim in margins}


@pytest.mark.long
def test_scenarios_that_differ_in_the_leak_alone_share_their_sealed_controls(ensemble):
    laws = ENSEMBLE[: ENSEMBLE.index("ensemble:")] + "ensemble: {grid: {leakage.law: [orifice, laminar]}}\n"
    laws = laws.replace("name: scenarios", "name: laws") + GRID
    assert ensemble("sweep", "laws.yaml", "--engine", "in-process", text=laws).returncode == 0
    members = json.loads(ensemble("report", "results/laws", "--json").stdout)["scenarios"]["members"]
    assert [member["sealed_alarms"] for member in members] == [[True], [True]]


ONE_LEAK = """\
name: one-leak
record: {duration: 2 s}
store: {signals: none}
paper: maddahi2015
claims: [C2, C3]
ensemble: {grid: {friction.viscous: [40, 60]}}
sweep: {grid: {leakage.internal_flow: [0, 0.12 L/min], fluid.bulk_modulus: [551 MPa, 689 MPa]}}
"""


@pytest.mark.parametrize(
    ("leak", "expected"),
    [("0.12 L/min", {"C2": None, "C3": 2, "C1–C4": None}), ("3 L/min", {"C1": 0, "C2": None, "C1–C4": 0})],
)
def test_a_claim_that_no_scenario_can_test_is_open_unless_another_fails_in_all(tmp_path, leak, expected):
    sweep = sweep_in(tmp_path, ONE_LEAK.replace("0.12 L/min", leak))
    study = json.loads(run_hydrofdi("report", sweep.directory, "--json").stdout)["scenarios"]
    assert {name: study["reproducing"][name] for name in expected} == expected
    assert study["sealed_alarms"]["feasible"]["alarms"]["interval_95"] is None, "nothing is drawn"
