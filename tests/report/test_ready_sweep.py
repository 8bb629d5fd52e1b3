"""The ready sweep over external leakage, as docs/results.md describes it."""

from pathlib import Path

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.papers.maddahi2015.external import study_external
from hydrofdi.report.runs import run_table
from tests.conftest import REPOSITORY, swept


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    sweep = swept(tmp_path_factory.mktemp("external"), REPOSITORY / "configs" / "external-leakage.yaml")
    return study_external(run_table(read_results(Path(sweep.directory))))


def test_the_sweep_leaks_the_flows_that_it_promises(study):
    flows = sorted(max(row.external_flows) * 6e4 for row in study.rows)
    assert len(flows) == 42
    assert flows == pytest.approx(sorted([0.0] * 6 + [0.1, 0.3, 0.6] * 12), abs=0.025)


def test_a4_detects_leakage_out_of_chamber_1_alone(study):
    _, first, second = study.states
    gaps = study.gaps(first)
    assert gaps["δa4"] == pytest.approx(2.3, abs=0.1)
    assert gaps["δ′a4"] == pytest.approx(2.6, abs=0.1)
    assert max(gaps["δd2"], gaps["δ′d2"]) < 0.0
    assert max(study.gaps(second).values()) < 0.0
