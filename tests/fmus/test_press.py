"""The press of the page "My own plant": an FMU in Python, which needs no compiler."""

import re
import subprocess
import sys

import pytest

from tests.commands import run_process
from tests.documentation.pages import ROOT, blocks

PAGE = ROOT / "docs" / "how-to" / "my-own-plant.md"


@pytest.fixture
def press(tmp_path):
    for block in blocks(PAGE):
        if block.word == "file":
            (tmp_path / block.value).write_text(block.text, encoding="utf-8")
    build = ["build", "-f", "press.py", "-d", "press.fmu", "--no-external-tool"]
    subprocess.run([sys.executable, "-m", "pythonfmu", *build], cwd=tmp_path, check=True, timeout=60)
    return tmp_path


def test_a_plant_in_python_leaks_as_it_is_told(press):
    settings = ["--set", "record.duration=2 s", "--set", "leakage.internal_coefficient=5e-9"]
    done = run_process("simulate", "press.yaml", *settings, cwd=press)
    assert done.returncode == 0, done.stderr
    flow = float(re.search(r"mean of the absolute internal leakage flow +(\S+) +L/min", done.stdout)[1])
    assert 0.2 < flow < 1.2  # the coefficient times the root of 0.5 to 16 MPa
