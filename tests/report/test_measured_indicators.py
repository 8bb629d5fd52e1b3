"""A sweep whose experiment file asks for indicators, from the file to the report."""

import csv
import io
import json

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from tests.commands import run_hydrofdi
from tests.conftest import sweep_in

MEASURED = """\
name: measured
record: {duration: 6 s}
store: {signals: none}
pressure_1_sensor: {noise: 20 kPa}
indicators: {dwt: {}, statistics: {kind: pressure_statistics}, ring_down: {}}
replicates: {count: 3}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], friction.viscous: [40, 60]}}
"""


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    return sweep_in(tmp_path_factory.mktemp("measured"), MEASURED)


def reported(measured, form):
    return run_hydrofdi("report", measured.directory, "--full", "--format", form, cwd=measured.folder).stdout


def test_numbers_and_changes_are_those_of_the_file(measured):
    data = read_results(measured.directory)
    means = data.columns["statistics.mean"]
    record = json.loads(reported(measured, "json"))
    lines = {line["run_id"]: line for line in csv.DictReader(io.StringIO(reported(measured, "csv")))}
    rows = {run_id: row for row, run_id in enumerate(data.columns["run_id"].astype(str))}
    assert len(record["rows"]) == 4
    for row in record["rows"]:
        place = rows[row["run_id"]]
        healthy = means[data.replicate_of == data.matched_baseline[place]].mean()
        change = 100.0 * (means[place] - healthy) / healthy
        assert row["indicators"]["statistics.mean"] == means[place]
        line = lines[row["run_id"]]
        assert float(line["statistics.mean [Pa]"]) == means[place]
        assert float(line["statistics.mean change_matched [%]"]) == pytest.approx(change)
        assert np.isfinite(change)


def test_without_the_indicator_of_the_details_there_is_no_table_of_them(tmp_path):
    text = MEASURED.replace("dwt: {}, ", "").replace("replicates: {count: 3}\n", "")
    text = text.replace("friction.viscous: [40, 60]", "fluid.bulk_modulus: [551 MPa, 689 MPa]")
    sweep = sweep_in(tmp_path, text)
    printed = run_hydrofdi("report", sweep.directory, "--full", cwd=tmp_path).stdout
    printed, _, _ = printed.partition("Configuration and provenance")
    assert "statistics (pressure_statistics)" in printed
    for words in ("details", "Table 3", "Claims"):
        assert words not in printed
