"""Each mistake in a study is one sentence, at its place in the file."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

STUDY = """\
name: small
study:
  population: {{over: {{{over}}}}}
  healthy: {{fit: 20, test: 10}}
  faults: {{leakage.internal_flow: {levels}, each: 5}}
"""


def mistakes(tmp_path, *settings, over="", levels="[0.1 L/min, 1 L/min]", more=""):
    file = tmp_path / "study.yaml"
    file.write_text(STUDY.format(over=over, levels=levels) + more)
    with pytest.raises(ConfigError) as error:
        load_experiment(file, settings)
    return error.value.mistakes


@pytest.mark.parametrize("level", ["0.1 L/mn", "-1 L/min", "foo", "null", "[1]"])
def test_a_mistaken_level_is_told_at_its_place(tmp_path, level):
    (mistake,) = mistakes(tmp_path, levels=f"[{level}, 1 L/min]")
    assert mistake.key == "study.faults.over.leakage.internal_flow[0]"
    assert mistake.origin.endswith("study.yaml:5")
