"""Sweeps without a leak: what is zero by construction is left out."""

import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.errors import ReportError
from hydrofdi.papers import make_report
from hydrofdi.report.figures import draw_figure
from tests.conftest import sweep_in

SEALED = """\
name: sealed
record: {duration: 2 s}
store: {signals: none}
indicators: [dwt, modwt]
sweep: {grid: {friction.viscous: [70 N·s/m, 50 N·s/m, 40 N·s/m]}}
"""
AGAINST_50 = SEALED + "baseline: {fluid.bulk_modulus: 551 MPa, friction.viscous: 50 N·s/m}\n"


def report_of(folder, text):
    return make_report(read_results(sweep_in(folder, text).directory))


def headers(report):
    tables = [table for block in report.document().blocks for table in block.shown_tables]
    return {column.heading for table in tables for column in table.shown}


def test_a_sealed_sweep_is_compared_with_the_fixed_baseline_only(tmp_path):
    report = report_of(tmp_path, AGAINST_50)
    assert report.analysis.baselines == ("fixed",)
    titles = [axis.get_title(loc="left") for axis in draw_figure(report, "sensitivity").axes]
    assert any("fixed" in title for title in titles)
    assert not any("matched" in title for title in titles)


def test_without_a_baseline_for_what_varies_there_is_no_table_of_zeros(tmp_path):
    report = report_of(tmp_path, SEALED)
    assert report.analysis.baselines == ()
    assert not [header for header in headers(report) if header.startswith("δ")]
    assert "sensitivity" not in report.document().figures
    assert report.usual_figure == "responses"
    with pytest.raises(ReportError, match="set a varied parameter in the baseline"):
        draw_figure(report, "sensitivity")


def test_rows_ascend_along_what_varies(tmp_path):
    table = report_of(tmp_path, AGAINST_50).analysis.table
    assert table.values("friction.viscous") == [40.0, 50.0, 70.0]
