"""External leakage by an approximation, from the sweep to every form."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from hydrofdi.papers import make_report
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.report.runs import external_coefficients, run_table
from hydrofdi.report.views import external_view
from hydrofdi.store import names
from hydrofdi.store.results import read_results
from tests.conftest import REPOSITORY, sweep_in, swept

GAP = 5.8e-13
"""K_e of about 0.3 L/min [m³/(s·Pa)]."""

LEAKING = f"""\
name: leaking
record: {{duration: 4 s}}
leakage: {{external_coefficient_1: 0, external_coefficient_2: 0}}
baseline: {{leakage.external_coefficient_1: 0, leakage.external_coefficient_2: 0}}
sweep:
  grid: {{leakage.internal_flow: [0 L/min, 0.48 L/min], fluid.bulk_modulus: [551 MPa, 827 MPa]}}
  zip: {{leakage.external_coefficient_1: [0, {GAP}, 0], leakage.external_coefficient_2: [0, 0, {GAP}]}}
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Internal leakage, external leakage of either chamber, and EBM on short records."""
    return read_results(sweep_in(tmp_path_factory.mktemp("leaking"), LEAKING).directory)


def test_the_mean_external_flow_is_that_of_the_chamber_pressure(data):
    with h5py.File(data.path) as file:
        pressures = [file[f"chamber_{chamber}_pressure"][:].mean(axis=1) for chamber in (1, 2)]
        assert file["mean_external_leakage_flow_1"].attrs["units"] == "m3 s-1"
    for chamber, (name, pressure) in enumerate(zip(names.EXTERNAL_LEAKAGE_FLOWS, pressures, strict=True), 1):
        runs = data.values(f"leakage.external_coefficient_{chamber}")
        np.testing.assert_allclose(data.columns[name], np.array(runs) * pressure, rtol=1e-12)
        assert (data.columns[name] > 3e-6).sum() == 4


def with_a4(data, outside_1, outside_2):
    """The same experiment where a4 is 10, and so many per mille less with a leak out of either chamber."""
    rms = np.full_like(data.columns[names.APPROXIMATION_RMS], 1e7)
    first, second = (data.values(f"leakage.external_coefficient_{chamber}") for chamber in (1, 2))
    for position, request in enumerate(data.leakage_requests):
        loss = outside_1 * bool(first[position]) + outside_2 * bool(second[position])
        rms[position] *= 1.0 - 1e-3 * (loss + 20 * bool(request))
    return replace(data, columns=data.columns | {names.APPROXIMATION_RMS: rms})


@pytest.mark.parametrize(("loss", "gap"), [(50, 3.0), (-5, -1.5), (-30, 1.0)])
def test_a_leak_is_separated_where_no_other_run_reaches_its_delta(data, loss, gap):
    report = make_report(with_a4(data, loss, 7))
    _, first, second = report.record()["external_leakage"]["states"]
    assert first["gap_percentage_points"]["δa4"] == pytest.approx(gap)
    assert second["gap_percentage_points"]["δa4"] == pytest.approx(-1.3)
    (block,) = (block for block in report.document().blocks if block.key == "external")
    column = next(each for each in block.tables[0].content if each.name == "Gap δa4")
    assert (1 in column.strong) == (gap > 0.0)


def test_claims_and_controls_look_at_the_runs_without_external_leakage(data, small_sweep):
    analysis = StudyReport(data)
    assert len(analysis.grid.scenarios) == 1
    assert analysis.sealed[names.BULK_MODULUS].tolist() == [827e6]
    compared = analysis.grid.positions[analysis.grid.positions >= 0]
    assert (external_coefficients(data)[compared] == 0.0).all()


def test_the_ready_sweep_leaks_the_flows_that_it_promises_and_a4_detects_those_out_of_chamber_1(tmp_path):
    sweep = swept(tmp_path, REPOSITORY / "configs" / "external-leakage.yaml")
    table = run_table(read_results(sweep.directory))
    flows = sorted(table.external_flows.max(axis=1) * 6e4)
    assert len(flows) == 42
    assert flows == pytest.approx(sorted([0.0] * 6 + [0.1, 0.3, 0.6] * 12), abs=0.025)
    _, record = external_view(table)
    _, first, second = (each["gap_percentage_points"] for each in record["external_leakage"]["states"])
    assert first["δa4"] == pytest.approx(2.3, abs=0.1)
    assert first["δ′a4"] == pytest.approx(2.6, abs=0.1)
    assert max(first["δd2"], first["δ′d2"]) < 0.0
    assert max(second.values()) < 0.0
