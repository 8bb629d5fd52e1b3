"""Steps that are suggested where one is too long."""

import re

import pytest

from hydrofdi.api.step_limits import step_warnings, too_long_sentence
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


@pytest.mark.parametrize(("limit", "step"), [(69e-6, 62.5e-6), (1e-4, 1e-4), (1.0, 2e-3)])
def test_it_divides_the_sampling_interval(limit, step):
    assert f"give record.step: {1e3 * step:g} ms" in too_long_sentence("valve", 0.1, limit, 500.0)
