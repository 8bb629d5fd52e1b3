"""What a person types first: -h, and the tabulator."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from commands import run_hydrofdi

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
