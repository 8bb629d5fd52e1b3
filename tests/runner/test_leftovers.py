"""Half-written files of killed sweeps."""

from tests.commands import run


def test_a_sweep_without_missing_runs_removes_half_written_files_too(tmp_path):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 2 s}\n")
    sweep = ("sweep", tmp_path / "few.yaml", "--out", tmp_path / "out", "--engine", "in-process")
    run(*sweep, check=0)
    leftover = tmp_path / "out" / ".few.h5.1.part"
    leftover.write_bytes(b"half")
    run(*sweep, check=0)
    assert not leftover.exists()
