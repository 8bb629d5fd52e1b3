"""``hydrofdi measure``: any source, every form."""

import csv
import json
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from tests.commands import run, run_json
from tests.conftest import sweep_in

MUSEUM = Path(__file__).parents[1] / "museum" / "format_4_physics_3"

FAILING = """\
name: failing
record: {duration: 2 s}
store: {signals: pressures}
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 1e7 MPa, 689 MPa]}}
"""


def write_csv(path, n_time=1000, header="pressure_1 [bar]"):
    """A plain file of a noisy pressure; returns it in Pa."""
    pressure = 50.0 + np.random.default_rng(5).normal(size=n_time)
    path.write_text(f"{header}\n" + "".join(f"{value!r}\n" for value in pressure.tolist()))
    return 1e5 * pressure


def rows(text):
    return list(csv.DictReader(text.splitlines()))


def test_all_forms_hold_the_same_numbers(tmp_path):
    for name in ("m.csv", "m.json", "m.parquet"):
        done = run("measure", MUSEUM / "pressures.h5", "--out", tmp_path / name, check=0)
        assert done.stdout == ""
        assert f"{name}: 4 records" in done.stderr
    text = run("measure", MUSEUM / "pressures.h5", "--format", "csv", check=0).stdout
    assert (tmp_path / "m.csv").read_text() == text
    records = json.loads((tmp_path / "m.json").read_text())["records"]
    table = pyarrow.parquet.read_table(tmp_path / "m.parquet").to_pylist()
    for line, record, row in zip(rows(text), records, table, strict=True):
        assert line["record_id"] == record["record_id"] == row["record_id"]
        for level in range(1, 6):
            number = record["values"][f"dwt.d{level}"]
            assert float(line[f"dwt.d{level}_Pa"]) == number == row[f"dwt.d{level}_Pa"]


def test_failed_runs_are_rows_with_a_reason_and_exit_code_1(tmp_path):
    swept = sweep_in(tmp_path, FAILING)
    for place in (swept.directory, swept.config):
        records = run_json("measure", place, check=1)["records"]
        assert [record["status"] for record in records].count("diverged") == 1
        (failed,) = (record for record in records if record["status"] == "diverged")
        assert failed["label"] == "sealed, 1e+07 MPa"
        assert set(failed["values"].values()) == {None}
        assert "grew without bound" in failed["reasons"]["dwt"]
    done = run("measure", swept.directory, check=1)
    assert "diverged" in done.stdout
    assert "rejected: 1 of 3 records" in done.stderr


def test_what_cannot_be_measured_is_null_with_its_reason_and_the_rest_goes_on(tmp_path):
    chosen = tmp_path / "chosen.yaml"
    chosen.write_text("indicators:\n  dwt: {}\n  stroke: {kind: dwt, channel: piston_position}\n")
    measure = ("measure", MUSEUM / "pressures.h5", "--indicators", chosen)
    for record in run_json(*measure)["records"]:
        assert record["reasons"] == {"stroke": "has no piston_position"}
        assert record["values"]["stroke.d1"] is None
        assert record["values"]["dwt.d1"] > 0.0
    done = run(*measure, "--format", "csv", check=0)
    assert all(row["reasons"] == "stroke: has no piston_position" for row in rows(done.stdout))
    assert all(row["stroke.d1_m"] == "" for row in rows(done.stdout))
    assert "without some numbers: 4 records" in done.stderr
    assert "stroke: not measured in 4 of 4: has no piston_position" in run(*measure, check=0).stdout


def test_options_come_from_a_file_and_arrays_are_lists(tmp_path):
    chosen = tmp_path / "chosen.yaml"
    chosen.write_text(
        "indicators:\n  fine: {kind: dwt, levels: 2, phase: all}\n"
        "  rod: {kind: dwt, levels: 1, channel: chamber_2_pressure}\n"
    )
    measure = ("measure", MUSEUM / "pressures.h5", "--indicators", chosen)
    done = run_json(*measure)
    units = {indicator["name"]: indicator["channels"] for indicator in done["indicators"]}
    assert units["rod.d1"] == ["chamber_2_pressure"]
    text = run(*measure, "--format", "csv", check=0).stdout
    for row, record in zip(rows(text), done["records"], strict=True):
        assert len(record["values"]["fine.d1_phases"]) == 4
        assert record["values"]["fine.d1_phases"][0] == record["values"]["fine.d1"]
        assert float(row["fine.d2_phases.3_Pa"]) == record["values"]["fine.d2_phases"][3]
    assert "d1_phases: 4 numbers for each record" in run(*measure, check=0).stdout


COUNTS = """\
files: "*.tsv"
sampling_frequency: 1 kHz
channels:
  chamber_1_pressure: {column: P, unit: counts}
"""


def test_counts_stay_counts_and_do_not_mix_with_pascals(tmp_path):
    (tmp_path / "rig.yaml").write_text(COUNTS)
    numbers = np.random.default_rng(6).integers(0, 4000, 700).tolist()
    (tmp_path / "one.tsv").write_text("P\n" + "\n".join(map(str, numbers)) + "\n")
    done = run_json("measure", tmp_path / "rig.yaml")
    assert {indicator["unit"] for indicator in done["indicators"]} == {"counts"}
    text = run("measure", tmp_path / "rig.yaml", "--format", "csv", check=0).stdout
    assert float(rows(text)[0]["dwt.d1_counts"]) == done["records"][0]["values"]["dwt.d1"]
    assert "counts" in run("measure", tmp_path / "rig.yaml", check=0).stdout
    mixed = run("measure", tmp_path / "rig.yaml", MUSEUM / "pressures.h5", "--json", check=2)
    assert "is in Pa, but in counts in an earlier source; measure these sources separately" in mixed.stderr


def test_content_decides_what_a_source_is(tmp_path):
    for name, source in {"runs.data": MUSEUM / "run.h5", "runs.csv": MUSEUM / "run.h5"}.items():
        (tmp_path / name).write_bytes(source.read_bytes())
        assert len(run_json("measure", tmp_path / name)["records"]) == 1


@pytest.mark.parametrize(
    ("file", "text", "options"),
    [
        ("a.csv", "p1 [bar]\n1\n", "--sampling-frequency 1kBz"),
        ("a.csv", "p1 [bar]\n1\n", "--sampling-frequency 1kHz --indicators dtw"),
        ("a.yaml", "name: x\n", "--sampling-frequency 1kHz"),
        ("a.yaml", "name: x\n", "--out x.xlsx"),
        ("a.yaml", "name: x\n", "--format parquet"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(tmp_path, file, text, options):
    (tmp_path / file).write_text(text)
    done = run("measure", file, *options.split(), cwd=tmp_path, check=2)
    assert (done.stdout, sum(line.startswith("hydrofdi: ") for line in done.stderr.splitlines())) == ("", 1)


@pytest.mark.parametrize("kind", ["stuck", "missing_values", "short"])
def test_a_record_without_any_number_is_exit_code_1(tmp_path, kind):
    good = 80.0 + np.random.default_rng(1).normal(size=20 if kind == "short" else 1000)
    bad = {"stuck": np.full_like(good, 80.0), "short": good}.get(kind, np.where(good > 82.0, np.nan, good))
    file, chosen = tmp_path / "rig.csv", tmp_path / "chosen.yaml"
    np.savetxt(file, np.c_[bad, good], delimiter=",", header="pressure_1 [bar],pressure_2 [bar]", comments="")
    options = ("--sampling-frequency", "500Hz", "--indicators")
    (record,) = run_json("measure", file, *options, "dwt", check=1)["records"]
    assert set(record["values"].values()) == {None}
    assert record["reasons"]
    if kind == "stuck":
        chosen.write_text("indicators:\n  dwt: {}\n  rod: {kind: dwt, channel: chamber_2_pressure}\n")
        (record,) = run_json("measure", file, *options, chosen, check=0)["records"]
        assert (record["status"], {*record["reasons"]}) == ("stuck", {"dwt"})
        assert record["values"]["dwt.d1"] is None
        assert record["values"]["rod.d1"] > 0.0
