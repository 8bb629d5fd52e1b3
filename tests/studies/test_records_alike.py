"""Records that differ in nothing but what has no effect are told before anything runs, and in the report."""

import pytest

from tests.commands import run

STUDY = """\
name: alike
record: {{duration: 2 s}}
indicators: [pressure_statistics]
{more}
study:
  population: {{over: {{{over}}}}}
  healthy: {{fit: 8, test: 4}}
"""


@pytest.fixture
def written(tmp_path):
    def write(over="", more=""):
        file = tmp_path / "alike.yaml"
        file.write_text(STUDY.format(over=over, more=more))
        return file

    return write


SAME = "10 of 12 records are others of their population once more (measurement.seed has no effect in any run)"


def test_an_idle_seed_makes_no_record_another(written):
    for command in ("plan", "check"):
        done = run(command, written(), check=0)
        assert SAME in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("over", "more"),
    [
        ("friction.scale: {uniform: ±20 %}", ""),
        ("", "pressure_1_sensor: {noise: 1 kPa}"),
        ("", "measurement: {jitter: 1 µs}"),
        ("pressure_1_sensor.noise: {choice: [0 kPa, 1 kPa]}", ""),
    ],
)
def test_what_has_an_effect_does(written, over, more):
    assert "once more" not in run("plan", written(over, more), check=0).stdout


def test_the_sweep_warns_and_the_report_remarks_equal_scores(written, tmp_path):
    done = run("sweep", written(), "--out", tmp_path / "out", "--engine", "in-process", check=0)
    assert SAME in done.stderr
    report = run("report", tmp_path / "out", "--format", "markdown", check=0).stdout
    assert "all 8 healthy fit records have the same score" in report
