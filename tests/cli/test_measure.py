"""``hydrofdi measure``: any source, every form."""

import csv
import json

import numpy as np
import pyarrow.parquet

from tests.commands import run, run_json
from tests.conftest import REPOSITORY

PRESSURES = REPOSITORY / "tests" / "museum" / "format_4_physics_3" / "pressures.h5"


def rows(text):
    return list(csv.DictReader(text.splitlines()))


def measured(tmp_path, indicators):
    """What a file of indicators makes of the pressures: JSON, rows of CSV and the command."""
    chosen = tmp_path / "chosen.yaml"
    chosen.write_text(f"indicators: {indicators}\n")
    measure = ("measure", PRESSURES, "--indicators", chosen)
    return run_json(*measure)["records"], run(*measure, "--format", "csv", check=0), measure


def test_all_forms_hold_the_same_numbers(tmp_path):
    for name in ("m.csv", "m.json", "m.parquet"):
        done = run("measure", PRESSURES, "--out", tmp_path / name, check=0)
        assert (done.stdout, f"{name}: 4 records" in done.stderr) == ("", True)
    text = run("measure", PRESSURES, "--format", "csv", check=0).stdout
    assert (tmp_path / "m.csv").read_text() == text
    records = json.loads((tmp_path / "m.json").read_text())["records"]
    table = pyarrow.parquet.read_table(tmp_path / "m.parquet").to_pylist()
    for line, record, row in zip(rows(text), records, table, strict=True):
        assert line["record_id"] == record["record_id"] == row["record_id"]
        for name, number in record["values"].items():
            assert float(line[f"{name}_Pa"]) == number == row[f"{name}_Pa"]


def test_failed_runs_are_rows_with_a_reason_and_exit_code_1(one_failed):
    for place in (one_failed.directory, one_failed.config):
        records = run_json("measure", place, check=1)["records"]
        (failed,) = (record for record in records if record["status"] == "diverged")
        assert (len(records), failed["label"]) == (3, "sealed, 1e+07 MPa")
        assert set(failed["values"].values()) == {None}
        assert "grew without bound" in failed["reasons"]["dwt"]
    done = run("measure", one_failed.directory, check=1)
    assert "diverged" in done.stdout
    assert "rejected: 1 of 3 records" in done.stderr


def test_what_cannot_be_measured_is_null_with_its_reason_and_the_rest_goes_on(tmp_path):
    records, table, measure = measured(tmp_path, "{dwt: {}, stroke: {kind: dwt, channel: piston_position}}")
    for record, row in zip(records, rows(table.stdout), strict=True):
        assert record["reasons"] == {"stroke": "has no piston_position"}
        assert record["values"]["stroke.d1"] is None
        assert record["values"]["dwt.d1"] > 0.0
        assert (row["reasons"], row["stroke.d1_m"]) == ("stroke: has no piston_position", "")
    assert "without some numbers: 4 records" in table.stderr
    assert "stroke: not measured in 4 of 4: has no piston_position" in run(*measure, check=0).stdout


def test_options_come_from_a_file_and_arrays_are_lists(tmp_path):
    records, table, measure = measured(tmp_path, "{fine: {kind: dwt, levels: 2, phase: all}}")
    for row, record in zip(rows(table.stdout), records, strict=True):
        phases = record["values"]["fine.d1_phases"]
        assert (len(phases), phases[0]) == (4, record["values"]["fine.d1"])
        assert float(row["fine.d2_phases.3_Pa"]) == record["values"]["fine.d2_phases"][3]
    assert "d1_phases: 4 numbers for each record" in run(*measure, check=0).stdout


def test_counts_stay_counts_and_do_not_mix_with_pascals(tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text(
        'files: "*.tsv"\nsampling_frequency: 1 kHz\nchannels: {chamber_1_pressure: {column: P, unit: counts}}'
    )
    numbers = np.random.default_rng(6).integers(0, 4000, 700).tolist()
    (tmp_path / "one.tsv").write_text("P\n" + "\n".join(map(str, numbers)) + "\n")
    done = run_json("measure", rig)
    assert {indicator["unit"] for indicator in done["indicators"]} == {"counts"}
    (row,) = rows(run("measure", rig, "--format", "csv", check=0).stdout)
    assert float(row["dwt.d1_counts"]) == done["records"][0]["values"]["dwt.d1"]
    mixed = run("measure", rig, PRESSURES, "--json", check=2)
    assert "is in Pa, but in counts in an earlier source" in mixed.stderr


def test_a_mistake_is_one_line_and_exit_code_2(tmp_path):
    (tmp_path / "a.yaml").write_text("name: x\n")
    for options in ("--sampling-frequency 1kHz", "--out x.xlsx", "--format parquet", "--indicators dtw"):
        done = run("measure", "a.yaml", *options.split(), cwd=tmp_path, check=2)
        assert (done.stdout, done.stderr.count("hydrofdi: ")) == ("", 1)


def test_a_record_without_any_number_is_exit_code_1(tmp_path):
    good = 80.0 + np.random.default_rng(1).normal(size=1000)
    file, chosen = tmp_path / "rig.csv", tmp_path / "chosen.yaml"
    options = ("--sampling-frequency", "500Hz", "--indicators")
    for bad in (np.where(good > 82.0, np.nan, good), np.full_like(good, 80.0)):
        np.savetxt(file, np.c_[bad, good], delimiter=",", header="p1 [bar],p2 [bar]", comments="")
        (record,) = run_json("measure", file, *options, "dwt", check=1)["records"]
        assert set(record["values"].values()) == {None}
        assert record["reasons"]
    chosen.write_text("indicators:\n  dwt: {}\n  rod: {kind: dwt, channel: chamber_2_pressure}\n")
    (record,) = run_json("measure", file, *options, chosen, check=0)["records"]
    assert (record["status"], {*record["reasons"]}) == ("stuck", {"dwt"})
    assert record["values"]["dwt.d1"] is None
    assert record["values"]["rod.d1"] > 0.0
