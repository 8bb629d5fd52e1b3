"""Keys of the section that was called ``run``."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import RenamedKeyWarning

EARLIER = """\
name: earlier
run: {duration: 4 s, step: 0.1 ms, discard: 1 period}
input: {period: 1 s}
baseline: {run.step: 0.1 ms}
sweep:
  where: run.duration > '1 s' and run.step <= '0.1 ms'
  grid: {run.step: [0.1 ms, 0.05 ms]}
  union:
    - zip: {run.duration: [4 s]}
"""
PRESENT = EARLIER.replace(", discard: 1 period}", "}\nanalysis: {discard: 1 period}").replace("run", "record")


def test_a_file_with_earlier_keys_is_the_same_experiment(tmp_path):
    earlier, present = tmp_path / "earlier.yaml", tmp_path / "present.yaml"
    earlier.write_text(EARLIER)
    present.write_text(PRESENT)
    with pytest.warns(RenamedKeyWarning) as warned:
        experiment = load_experiment(earlier)
    assert experiment == load_experiment(present)
    assert sorted(str(each.message).split(": ")[1].split(";")[0] for each in warned) == [
        "run.discard is now analysis.discard",
        "run.duration is now record.duration",
        "run.step is now record.step",
    ]
    assert f"{earlier}:2: run.duration" in "".join(str(each.message) for each in warned)


def test_a_setting_with_an_earlier_key_wins_over_the_file(tmp_path):
    file = tmp_path / "file.yaml"
    file.write_text("record: {duration: 8 s}\n")
    with pytest.warns(RenamedKeyWarning, match=r"settings run.duration=2 s: run.duration is now"):
        assert load_experiment(file, ["run.duration=2 s"]).record.duration == 2.0


def test_a_mistake_under_an_earlier_key_keeps_its_line(tmp_path):
    file = tmp_path / "file.yaml"
    file.write_text("name: wrong\nrun:\n  duration: -1 s\n")
    with pytest.warns(RenamedKeyWarning), pytest.raises(ValueError, match=r"file.yaml:3: record.duration"):
        load_experiment(file)


def test_the_command_warns_and_goes_on(hydrofdi):
    result = hydrofdi("simulate", "--json", "--set", "run.duration=2 s")
    assert result.returncode == 0
    assert "warning: settings run.duration=2 s: run.duration is now record.duration" in result.stderr
