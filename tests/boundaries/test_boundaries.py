"""What comes from outside of the program: streams, environment, files and their names."""

import os
import stat
import subprocess
import sys

import numpy as np
import pytest

from hydrofdi.compilation import object_code
from hydrofdi.errors import without_credentials
from hydrofdi.monitor.sources import printable
from hydrofdi.records import files as opening
from tests.commands import COMMAND, run, run_process


@pytest.fixture
def record(tmp_path):
    """A file with a pressure."""
    time, path = np.arange(400) / 100.0, tmp_path / "rig.csv"
    columns = np.column_stack([time, 80.0 + np.sin(7.0 * time), 70.0 - np.sin(7.0 * time)])
    np.savetxt(path, columns, delimiter=",", header="time [s],P1 [bar],P2 [bar]", comments="")
    return path


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_standard_streams_lead_nowhere(record, closed):
    command = " ".join([*COMMAND, "inspect", str(record), closed])
    assert subprocess.run(["sh", "-c", command], timeout=120, capture_output=True).returncode == 0


def test_what_an_encoding_lacks_is_escaped(record, tmp_path):
    named = record.rename(tmp_path / "Prüfstand….csv")
    done = run_process("inspect", named, env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0
    assert r"\u2026" in done.stdout


def test_docstrings_are_needed(record):
    command = [sys.executable, "-OO", "-m", "hydrofdi", "inspect", str(record)]
    done = subprocess.run(command, timeout=120, capture_output=True, text=True)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("kilobytes", [60_000, 150_000])
def test_too_little_memory_is_no_bug(record, kilobytes):
    command = f"ulimit -v {kilobytes}; {' '.join(COMMAND)} inspect {record}"
    done = subprocess.run(["sh", "-c", command], timeout=120, capture_output=True, text=True)
    assert done.returncode in (0, 1, 2)
    assert "Traceback" not in done.stderr


def test_more_columns_than_a_sheet_has_and_an_archive_that_unpacks_to_too_much_are_refused(
    tmp_path, monkeypatch
):
    (path := tmp_path / "rig.csv").write_text(f"time [s]{',x' * 20_000}\n", encoding="utf-8")
    assert "columns" in run("inspect", path, check=2).stderr
    np.savez_compressed(path := tmp_path / "rig.npz", P1=np.zeros(100_000), time=np.arange(100_000.0))
    monkeypatch.setattr(opening, "MOST_BYTES", 1_000_000)
    assert "unpacks" in run("inspect", path, check=2).stderr


@pytest.mark.parametrize("command", ["inspect", "measure", "trend"])
def test_a_pipe_without_a_writer_is_refused(tmp_path, command):
    os.mkfifo(pipe := tmp_path / "rig.csv")
    assert run_process(command, pipe, timeout=120).returncode == 2


def test_a_name_that_is_no_text_can_be_read_and_logged(record, tmp_path):
    name = os.fsdecode(b"rig\xff.csv")
    run("inspect", record.rename(tmp_path / name), check=0)
    assert (printable(name), printable("Prüfstand.csv")) == (r"rig\xff.csv", "Prüfstand.csv")


def test_the_query_of_a_url_is_not_repeated_and_names_of_files_are_no_credentials():
    assert "SECRET" not in without_credentials("events: http://h:80/a?token=SECRET&x=SECRET is no topic")
    for text in (
        "is x.csv there?", "runs@night.csv", "a/b@c.csv", "day.csv:3: x@y is no number", "x: y@z",
    ):  # fmt: skip
        assert without_credentials(text) == text


def test_folders_above_the_cache_belong_to_their_user_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home" / ".cache"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    before = os.umask(0)
    try:
        assert object_code.cache_directory.__wrapped__("physics")
    finally:
        os.umask(before)
    for folder in (tmp_path / "home", tmp_path / "home" / ".cache"):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
