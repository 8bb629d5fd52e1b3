"""How commands end: readers that have gone, Ctrl-C and SIGTERM before a command runs."""

import signal
import subprocess
import sys

import pytest

from tests.commands import COMMAND


def exit_code(*arguments, cwd, closes_errors=False):
    """Exit code of a command whose output nobody reads, and what it said on standard error."""
    errors = subprocess.STDOUT if closes_errors else subprocess.PIPE
    with subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=errors, cwd=cwd) as process:
        process.stdout.close()
        said = b"" if closes_errors else process.stderr.read()
        return process.wait(120), said


@pytest.mark.parametrize("command", ["schema", "indicators", "configs table3", "plan few.yaml --json"])
def test_a_command_ends_quietly_with_a_code_of_its_own(tmp_path, command):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 8 s}\nanalysis: {discard: 2}\n")
    assert exit_code(*command.split(), cwd=tmp_path) == (141, b"")


def test_a_sweep_whose_messages_nobody_reads_is_not_called_done(tmp_path):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 2 s}\n")
    code, _ = exit_code("sweep", "few.yaml", "--engine", "in-process", cwd=tmp_path, closes_errors=True)
    assert code == 141


SIGNAL_AT_AN_IMPORT = """
import os, sys

class Signal:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), {number})

sys.meta_path.insert(0, Signal())
sys.argv = ["hydrofdi", *{arguments!r}]
from hydrofdi.__main__ import main
main()
"""


def _signalled(number, module, *arguments):
    """A command that gets a signal when it begins to load a module."""
    code = SIGNAL_AT_AN_IMPORT.format(number=int(number), module=module, arguments=arguments)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("module", ["typer", "hydrofdi.api.run"])
def test_ctrl_c_while_a_command_loads_is_one_line_and_130(module):
    done = _signalled(signal.SIGINT, module, "simulate", "--set", "record.duration=2 s")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "hydrofdi: interrupted\n")


def test_sigterm_while_a_monitor_loads_ends_it_as_later():
    done = _signalled(signal.SIGTERM, "typer", "monitor", "detector.json", "-")
    assert (done.returncode, done.stderr) == (0, "")


def test_sigterm_ends_other_commands_as_usual():
    assert _signalled(signal.SIGTERM, "typer", "plan", "smoke").returncode == -signal.SIGTERM
