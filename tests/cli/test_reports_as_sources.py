"""A report in the place of an experiment file, and values that are too long to quote."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.commands import run


@pytest.mark.parametrize("command", ["plan", "inspect", "measure", "sweep"])
def test_a_report_is_named_as_one(small_sweep: SimpleNamespace, tmp_path: Path, command: str) -> None:
    file = tmp_path / "press.json"
    file.write_text(run("report", small_sweep.directory, "--json", check=0).stdout)
    (line,) = run(command, file, cwd=tmp_path, check=2).stderr.splitlines()
    assert "press.json: is a report, not an experiment file; name the experiment file or the results" in line


def test_a_long_value_is_shortened(tmp_path: Path) -> None:
    file = tmp_path / "long.yaml"
    file.write_text(f"name: long\ndetection: [{', '.join(map(str, range(10_000)))}]\n")
    (line,) = run("plan", file, check=2).stderr.splitlines()
    assert "detection: expected a section with 'key: value' pairs; found [0, 1, 2" in line
    assert len(line) < 500
