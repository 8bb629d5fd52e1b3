from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hydrofdi.config.experiment import ClaimId
from hydrofdi.papers.maddahi2015.claims import CLAIMS, claim_margins
from hydrofdi.papers.maddahi2015.grid import ModeGrid
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.store.layout import names

LEAKAGES, BULK_MODULI = 3, 3


def claims(data):
    return {result.claim.id: result for result in Study(data).claims}


def cell(data, leakage, bulk_modulus):
    """Row of a mode; leakage 0 is sealed."""
    return int(Study(data).grid.positions[0, leakage, bulk_modulus])


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
    study = Study(break_cell(paper, position, level, factor * rms))
    (broken,) = [result for result in study.claims if result.claim.id == claim]
    assert broken.reproduced is False
    assert broken.margin < 0.0
    (failed,) = [check for check in study.checks(broken) if not check["holds"]]
    assert str(paper.columns[names.RUN_ID][position]) in failed["runs"]


def test_the_margin_is_how_far_a_delta_can_move_before_the_verdict_turns(paper, break_cell):
    (check, *_) = claims(paper)["C1"].checks
    position, healthy = cell(paper, 1, 0), cell(paper, 0, 0)
    rms = paper.columns[names.DETAIL_RMS]
    for excess, outcome in ((-1e-3, True), (1e-3, False)):
        moved = rms[position, 1] + (check.margin[0] + excess) / 100.0 * rms[healthy, 1]
        assert bool(claims(break_cell(paper, position, 1, moved))["C1"].checks[0].margin[0] > 0.0) is outcome


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


def grid_of(leaky):
    n_scenario, n_leakage, n_bulk_modulus, _ = leaky.shape
    delta = np.concatenate([np.zeros_like(leaky[:, :1]), leaky], axis=1)
    positions = np.arange(delta[..., 0].size).reshape(delta.shape[:3])
    return ModeGrid(
        scenarios=({},) * n_scenario,
        leakage_flows=tuple(range(1, n_leakage + 1)),
        bulk_moduli=tuple(range(n_bulk_modulus)),
        normal=0,
        positions=positions,
        fixed=delta,
        matched=delta,
    )


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
    margins = claim_margins(grid_of(leaky))
    for scenario, delta in enumerate(leaky):
        expected = holds_as_the_paper_says(delta)
        assert {name: bool(margin[scenario] > 0.0) for name, margin in margins.items()} == expected


def test_with_two_levels_there_is_nothing_to_check():
    leaky = np.ones((1, LEAKAGES, BULK_MODULI, 2))
    assert all(np.isnan(margin).all() for margin in claim_margins(grid_of(leaky)).values())
