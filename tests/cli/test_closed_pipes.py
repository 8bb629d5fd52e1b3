"""A reader of the output that has ended, as ``head`` does."""

from __future__ import annotations

import subprocess

import pytest

from tests.commands import COMMAND


def exit_code(*arguments: str, cwd, closes_errors: bool = False) -> tuple[int, bytes]:
    """Exit code of a command whose output nobody reads, and what it said on standard error."""
    errors = subprocess.STDOUT if closes_errors else subprocess.PIPE
    with subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=errors, cwd=cwd) as process:
        process.stdout.close()
        said = b"" if closes_errors else process.stderr.read()
        return process.wait(120), said


@pytest.mark.parametrize("command", ["schema", "indicators", "configs table3", "plan few.yaml --json"])
def test_a_command_ends_quietly_with_a_code_of_its_own(tmp_path, command) -> None:
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 8 s}\nanalysis: {discard: 2}\n")
    assert exit_code(*command.split(), cwd=tmp_path) == (141, b"")


def test_a_sweep_whose_messages_nobody_reads_is_not_called_done(tmp_path) -> None:
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 2 s}\n")
    code, _ = exit_code("sweep", "few.yaml", "--engine", "in-process", cwd=tmp_path, closes_errors=True)
    assert code == 141
