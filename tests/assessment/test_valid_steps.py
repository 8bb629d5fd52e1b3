"""Steps that are suggested where one is too long."""

import re

import pytest

from hydrofdi.api.step_limits import step_warnings
from hydrofdi.config import expand_runs, load_experiment


@pytest.mark.parametrize("sampling", [500.0, 250.0])
def test_the_step_that_is_suggested_is_accepted_and_not_warned_of(tmp_path, sampling):
    file = tmp_path / "step.yaml"
    file.write_text(f"name: step\nrecord: {{duration: 2 s, sampling_frequency: {sampling}}}\n")

    def too_long(step):
        runs = expand_runs(load_experiment(file, [f"record.step={step}"])).runs
        return step_warnings(runs.distinct)

    warnings = too_long("1 ms")
    assert warnings
    steps = [float(re.search(r"give record.step: ([\d.]+) ms", text)[1]) for text in warnings]
    assert too_long(f"{min(steps)} ms") == []
