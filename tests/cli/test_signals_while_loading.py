"""Ctrl-C and SIGTERM before a command runs."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

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


def _signalled(number: int, module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command that gets a signal when it begins to load a module."""
    code = SIGNAL_AT_AN_IMPORT.format(number=int(number), module=module, arguments=arguments)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("module", ["typer", "hydrofdi.api.run"])
def test_ctrl_c_while_a_command_loads_is_one_line_and_130(module: str) -> None:
    done = _signalled(signal.SIGINT, module, "simulate", "--set", "record.duration=2 s")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "hydrofdi: interrupted\n")


def test_sigterm_while_a_monitor_loads_ends_it_as_later() -> None:
    done = _signalled(signal.SIGTERM, "typer", "monitor", "detector.json", "-")
    assert (done.returncode, done.stderr) == (0, "")


def test_sigterm_ends_other_commands_as_usual() -> None:
    assert _signalled(signal.SIGTERM, "typer", "plan", "smoke").returncode == -signal.SIGTERM
