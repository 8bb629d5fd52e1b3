"""Commands that write tables and pages replace their own earlier files and nothing else."""

import pytest

from tests.commands import run

REFUSED = "was not changed; choose another name"
RECORDING = "time [s],P1 [bar]\n" + "".join(f"{k / 1000},{50 + k % 3}\n" for k in range(2000))


def test_measure_never_replaces_the_recording_that_it_reads(tmp_path):
    (tmp_path / "own.csv").write_text(RECORDING)
    (tmp_path / "own.yaml").write_text("files: own.csv\ntime: {column: 'time [s]'}\n")
    for source in ("own.csv", "own.yaml"):
        assert REFUSED in run("measure", source, "--out", "own.csv", cwd=tmp_path, check=2).stderr
    assert (tmp_path / "own.csv").read_text() == RECORDING


@pytest.mark.parametrize("suffix", ["csv", "json", "parquet"])
def test_measure_replaces_its_own_table_and_no_foreign_file(tmp_path, suffix):
    (tmp_path / "rig.csv").write_text(RECORDING)
    out = tmp_path / f"out.{suffix}"
    measure = ("measure", "rig.csv", "--out", out, "--indicators")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    first = out.read_bytes()
    run(*measure, "pressure_statistics", cwd=tmp_path, check=0)
    assert out.read_bytes() != first
    foreign = first[:12] + b"another file"
    out.write_bytes(foreign)
    assert f"out.{suffix}: already exists" in run(*measure, "dwt", cwd=tmp_path, check=2).stderr
    assert out.read_bytes() == foreign
    out.write_bytes(b"")
    run(*measure, "dwt", cwd=tmp_path, check=0)
    assert out.read_bytes() == first


def test_a_report_replaces_its_own_files_and_no_foreign_one(small_sweep, tmp_path):
    report = ("report", small_sweep.directory, "--out", tmp_path)
    run(*report, check=0)
    run(*report, check=0)
    figure = tmp_path / "sensitivity.png"
    figure.unlink()
    for suffix in ("md", "csv", "json", "html", "parquet"):
        foreign = tmp_path / f"small.{suffix}"
        before = foreign.read_bytes()
        foreign.write_text("# small\n\nNotes on the press.\n")
        assert REFUSED in run(*report, check=2).stderr
        assert foreign.read_text().endswith("press.\n")
        foreign.write_bytes(before)
    assert not figure.exists()


def test_a_page_replaces_an_earlier_page_and_no_foreign_one(small_sweep, tmp_path):
    page = tmp_path / "my.html"
    run("report", small_sweep.directory, "--html", page, check=0)
    run("report", small_sweep.directory, "--html", page, check=0)
    foreign = '<!DOCTYPE html>\n<html lang="en"><title>My press</title></html>\n'
    page.write_text(foreign)
    assert REFUSED in run("report", small_sweep.directory, "--html", page, check=2).stderr
    assert page.read_text() == foreign


@pytest.mark.long
def test_the_files_of_a_study_are_replaced_by_a_second_report(tmp_path):
    run("sweep", "detectability-smoke", "--out", tmp_path / "study", "--engine", "in-process", check=0)
    for _ in range(2):
        run("report", tmp_path / "study", "--out", tmp_path / "report", check=0)
