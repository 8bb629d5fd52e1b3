"""What the file of `init` says of its valve, and what `status` says of missing runs."""

import math
import re
from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from tests.commands import run

STATED = re.compile(r"(\d+) L/min at (\d+) V and (\d+) bar per edge")
SCALED = re.compile(r"(\d+) L/min at the same .* need [\d.]+ mm · \d+ / \d+ = ([\d.]+) mm")


@pytest.mark.parametrize("template", ["actuator", "online"])
def test_the_rated_flow_in_the_comment_is_that_of_the_numbers(tmp_path: Path, template: str) -> None:
    run("init", "mine", "--from", template, cwd=tmp_path, check=0)
    file = tmp_path / "mine.yaml"
    stated, scaled = STATED.search(file.read_text()), SCALED.search(file.read_text())
    assert stated is not None
    assert scaled is not None
    flow, voltage, drop = map(float, stated.groups())
    valve = load_experiment(file).valve
    per_width = valve.flow_gain * valve.spool_gain * voltage * math.sqrt(drop * 1e5) * 60e3
    assert per_width * valve.area_gradient == pytest.approx(flow, rel=0.01)
    assert per_width * float(scaled[2]) * 1e-3 == pytest.approx(float(scaled[1]), rel=0.01)
