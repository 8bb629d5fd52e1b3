"""HDF5 and MAT files are read in a process of their own: whatever happens to it, the next file is read."""

import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import psutil
import pytest

from hydrofdi.records import files as opening
from hydrofdi.records.columns import RejectionError
from tests.commands import wait_until
from tests.records.measuring import P1, USUAL, WRITERS, one

BAR = np.array([100.0, 101.5, 99.25])


def write(folder, name, **arrays):
    WRITERS[name.rpartition(".")[2]](folder / name, arrays)
    return folder / name


def read(folder, suffix):
    return one(folder, USUAL.replace("csv", suffix))


def readers(process=None):
    program = opening.array_reader.__file__
    children = psutil.Process(process).children()
    return [child for child in children if not has_ended(child) and program in child.cmdline()]


def has_ended(process):
    try:
        return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


@pytest.fixture
def hanging(tmp_path_factory, monkeypatch):
    """New readers have a library that never gives the values of a dataset."""
    folder = tmp_path_factory.mktemp("library")
    code = "import time, h5py\nh5py.Dataset.__getitem__ = lambda *_: time.sleep(600)\n"
    (folder / "sitecustomize.py").write_text(code)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.setattr(opening, "_idle", [])


def test_a_file_that_crashes_its_library_is_rejected_and_the_next_is_read(tmp_path):
    """Its type of the data is a number that SciPy follows out of its memory."""
    write(tmp_path, "1.mat", P1=np.arange(64.0))
    with open(tmp_path / "1.mat", "r+b") as file:
        file.seek(176)
        file.write(b"\xff\xff")
    write(tmp_path, "2.mat", P1=BAR)
    batch = read(tmp_path, "mat")
    (rejected,) = batch.rejected
    assert (rejected.record_id, rejected.remark.kind) == ("1.mat", "damaged")
    assert "as MAT" in rejected.remark.message
    np.testing.assert_array_equal(batch[P1], [BAR * 1e5])


def test_a_file_that_hangs_its_library_is_rejected(tmp_path, hanging, monkeypatch):
    monkeypatch.setattr(opening, "SECONDS", 1.0)
    write(tmp_path, "1.h5", P1=BAR)
    (rejected,) = read(tmp_path, "h5").rejected
    assert rejected.remark.kind == "damaged"


@pytest.mark.parametrize("suffix", ["h5", "mat"])
def test_a_reader_killed_in_the_middle_of_a_file_rejects_it_alone(tmp_path, suffix):
    file, kind = write(tmp_path, f"run.{suffix}", P1=BAR, P2=BAR), {"h5": "HDF5", "mat": "MAT"}[suffix]
    with opening.table_read_apart("run", kind, file) as table:
        np.testing.assert_array_equal(table.numbers(0), BAR)
        for reader in readers():
            reader.kill()
        with pytest.raises(RejectionError):
            table.numbers(1)
    with opening.table_read_apart("run", kind, file) as table:
        np.testing.assert_array_equal(table.numbers(1), BAR)


def test_one_process_reads_file_after_file_and_two_at_once_have_their_own(tmp_path):
    for number in range(4):
        write(tmp_path, f"{number}.h5", P1=BAR + number)
    np.testing.assert_array_equal(read(tmp_path, "h5")[P1], [(BAR + n) * 1e5 for n in range(4)])
    before = readers()
    read(tmp_path, "h5")
    assert readers() == before != []
    for reader in before:  # killed between files, it is replaced in silence
        reader.kill()
        reader.wait(60)
    with h5py.File(tmp_path / "0.h5", "r+") as target:  # which were released
        target["P1"][:] = BAR
    with (
        opening.table_read_apart("a", "HDF5", tmp_path / "0.h5") as table,
        opening.table_read_apart("b", "HDF5", tmp_path / "3.h5") as other,
    ):
        np.testing.assert_array_equal(other.numbers(0), BAR + 3)
        np.testing.assert_array_equal(table.numbers(0), BAR)


PROGRAM = """\
import sys, time
from pathlib import Path
from hydrofdi.records import files as opening
opening.SECONDS = float(sys.argv[2])
with opening.table_read_apart("run", "HDF5", Path(sys.argv[1])) as table:
    print("open", flush=True)
    {then}
print("read", flush=True)
"""


@pytest.mark.parametrize(("then", "seconds"), [("time.sleep(600)", 600), ("table.numbers(0)", 4), ("", 600)])
def test_no_reader_outlives_a_process_that_ends_or_is_killed(tmp_path, hanging, then, seconds):
    """While it waits for a request, and while its library hangs."""
    file, program = write(tmp_path, "run.h5", P1=BAR), PROGRAM.replace("{then}", then or "pass")
    command = [sys.executable, "-c", program, str(file), str(seconds)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "open\n"
    found = readers(process.pid)
    if then:
        process.send_signal(signal.SIGKILL)
    assert (process.communicate()[0], process.returncode) == (("", -9) if then else ("read\n", 0))
    for reader in found:
        wait_until(lambda reader=reader: has_ended(reader))


def test_the_reader_starts_without_the_package_and_the_folder_it_is_started_in(tmp_path):
    """A module of the user named like one of Python's is not taken, and stray output is no answer."""
    (tmp_path / "json.py").write_text("raise SystemExit")
    command = [sys.executable, "-P", "-X", "importtime", opening.array_reader.__file__]
    done = subprocess.run(command, input="", capture_output=True, text=True, check=True, cwd=tmp_path)
    assert done.stdout == ""
    assert not any(name in done.stderr for name in ("hydrofdi", "pydantic", "h5py"))
    assert Path(opening.array_reader.__file__).is_file()
