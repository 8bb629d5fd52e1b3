"""What a person types first: -h, and the tabulator."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main
from commands import run_hydrofdi

from hydrofdi.api.detectors.training import setting_keys
from hydrofdi.cli.app import application

SCRIPT = Path(sys.executable).parent / "hydrofdi"


@pytest.mark.parametrize("command", [(), ("sweep",), ("measure",)])
def test_h_is_help(command):
    short, full = (run_hydrofdi(*command, option) for option in ("-h", "--help"))
    assert short.returncode == 0
    assert short.stdout == full.stdout


@pytest.mark.skipif(not SCRIPT.exists(), reason="the command is not installed beside Python")
def test_the_shell_completes_commands():
    asked = {"_HYDROFDI_COMPLETE": "complete_bash", "COMP_WORDS": "hydrofdi sw", "COMP_CWORD": "1"}
    done = subprocess.run([SCRIPT], env=os.environ | asked, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == ["sweep"]
    assert not done.stderr


def test_every_plain_setting_of_a_detector_is_an_option_of_train():
    command = typer.main.get_command(application(["train"])).commands["train"]
    options = {parameter.name for parameter in command.params}
    assert setting_keys().keys() - options == {"options", "indicators", "score"}


def test_commands_stand_in_groups():
    shown = run_hydrofdi("--help").stdout
    assert not {"Start:", "Study:", "Records:", "Live:", "Look up:", "Audit:"} - {*shown.splitlines()}
