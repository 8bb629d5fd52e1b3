"""The ready sweep over external leakage, as docs/results.md describes it."""

from pathlib import Path

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.report.analysis import analyze
from tests.conftest import REPOSITORY, swept


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    sweep = swept(tmp_path_factory.mktemp("external"), REPOSITORY / "configs" / "external-leakage.yaml")
    return analyze(read_results(Path(sweep.directory))).external


def test_the_sweep_leaks_the_flows_that_it_promises(study):
    flows = sorted(max(row.external.flows) * 6e4 for row in study.rows)
    assert len(flows) == 42
    assert flows == pytest.approx(sorted([0.0] * 6 + [0.1, 0.3, 0.6] * 12), abs=0.025)


def test_a4_detects_leakage_out_of_chamber_1_alone(study):
    _, first, second = study.states
    gaps = study.gaps(first)
    assert gaps["δa4"] == pytest.approx(2.3, abs=0.1)
    assert gaps["δ′a4"] == pytest.approx(2.6, abs=0.1)
    assert max(gaps["δd2"], gaps["δ′d2"]) < 0.0
    assert max(study.gaps(second).values()) < 0.0


def test_a4_moves_with_internal_leakage_and_hardly_with_the_bulk_modulus(study):
    inside, modulus = study.effect_of_internal_leakage(), study.effect_of_bulk_modulus()
    assert (inside.low, inside.high) == pytest.approx((0.6, 0.7), abs=0.05)
    assert (modulus.low, modulus.high) == pytest.approx((-0.4, 0.0), abs=0.05)
    shares = study.mean_shares()
    assert (shares.low, shares.high) == pytest.approx((0.81, 0.86), abs=0.01)
