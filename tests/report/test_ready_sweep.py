"""The ready sweep over external leakage, as docs/results.md describes it."""

from pathlib import Path

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.papers.maddahi2015.views import external_view
from hydrofdi.report.runs import run_table
from tests.conftest import REPOSITORY, swept


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    sweep = swept(tmp_path_factory.mktemp("external"), REPOSITORY / "configs" / "external-leakage.yaml")
    return run_table(read_results(Path(sweep.directory)))


def test_the_sweep_leaks_the_flows_that_it_promises(table):
    flows = sorted(table.external_flows.max(axis=1) * 6e4)
    assert len(flows) == 42
    assert flows == pytest.approx(sorted([0.0] * 6 + [0.1, 0.3, 0.6] * 12), abs=0.025)


def test_a4_detects_leakage_out_of_chamber_1_alone(table):
    _, record = external_view(table)
    _, first, second = (each["gap_percentage_points"] for each in record["external_leakage"]["states"])
    assert first["δa4"] == pytest.approx(2.3, abs=0.1)
    assert first["δ′a4"] == pytest.approx(2.6, abs=0.1)
    assert max(first["δd2"], first["δ′d2"]) < 0.0
    assert max(second.values()) < 0.0
