"""What ``hydrofdi evaluate`` says to a person: detections, their healthy control, and numbers in full."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.api.evaluation_tables import ranked_by_control
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.rates import healthy_against_healthy
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.studies.detecting import detect
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.studies.rules import Rules
from tests.cli.test_evaluate import GROUPED, write_records
from tests.commands import run, run_json

ASKED = "--indicators", "dwt", "--false-alarm-rate", "10%"


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig")
    write_records(folder, n_unit=4, n_run=12)
    (folder / "rig.yaml").write_text(GROUPED)
    return folder


@pytest.fixture(scope="module")
def differing_units(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("units")
    write_records(folder, n_unit=4, n_run=12, unit_spread=0.4)
    (folder / "rig.yaml").write_text(GROUPED)
    return folder


def test_units_that_differ_as_much_as_faults_are_the_conclusion(differing_units: Path, rig: Path) -> None:
    page = run("evaluate", differing_units / "rig.yaml", *ASKED, check=0).stdout
    assert page.index("Only the unit or the day was detected") < page.index("dwt.")
    assert "~ dwt.d1" in page
    done = run_json("evaluate", differing_units / "rig.yaml", *ASKED)
    assert {score["stands_clear"] for score in done["scores"]} == {False}
    assert done["conclusion"].startswith("only the unit or the day was detected")

    done = run_json("evaluate", rig / "rig.yaml", *ASKED)
    clear = {score["indicator"]: score["stands_clear"] for score in done["scores"]}
    assert clear["dwt.d1"] is True
    assert clear["dwt.a5"] is False, "approximations carry the mean, which no leak here moves"
    assert sorted(clear.values(), reverse=True) == list(clear.values()), "clear ones come first"
    assert f"by {list(clear.values()).count(False)} of 10 scores, marked ~" in done["conclusion"]


def test_of_equal_areas_the_quieter_control_comes_first() -> None:
    groups = tuple(f"unit {unit}" for unit in range(2) for _ in range(10)) + ("unit 0",) * 10
    healthy, leaking = Population("healthy", Kind.HEALTHY, is_fit=True), Population("leak", Kind.FAULT)
    of_record = np.repeat([0, 1], [20, 10])
    records = StudyRecords((healthy, leaking), of_record, np.repeat([0.0, np.nan], [20, 10]), groups=groups)
    ramp = np.arange(10.0)
    moved = np.concatenate([ramp, ramp + 4.0, ramp + 100.0])
    quiet = np.concatenate([ramp, ramp + 0.5, ramp + 100.0])
    scores = [Scored(name, values, (), "1", "", Direction.RISING) for name, values in
              (("a_moved", moved), ("z_quiet", quiet))]  # fmt: skip
    judgements = detect(records, scores, Rules()).judgements
    assert [each.scored.name for each in judgements] == ["a_moved", "z_quiet"]
    pairs = {
        each.name: healthy_against_healthy(
            each.values[:20],
            groups[:20],
            lambda own: quantile_threshold(own, 0.2, direction=Direction.RISING),
        )
        for each in scores
    }
    assert [each.scored.name for each in ranked_by_control(judgements, pairs)] == ["z_quiet", "a_moved"]


def test_a_severity_of_a_label_that_no_record_has_is_a_mistake(rig: Path) -> None:
    (rig / "typo.yaml").write_text(GROUPED + "severity: {lrge: 0.5 L/min}\n")
    done = run("evaluate", rig / "typo.yaml", *ASKED, check=2)
    assert "severity.lrge: no record has this label" in done.stderr
    assert "did you mean 'large'?" in done.stderr
    (rig / "soud.yaml").write_text(GROUPED.replace("healthy: sound", "healthy: [soud]"))
    done = run("evaluate", rig / "soud.yaml", *ASKED, check=2)
    assert "no record has the healthy label 'soud'" in done.stderr
    assert "did you mean 'sound'?" in done.stderr


def test_faults_without_a_number_do_not_vanish(tmp_path: Path) -> None:
    write_records(tmp_path, n_unit=2, n_run=12)
    for file in tmp_path.glob("unit */large *.csv"):
        file.write_text("P1 [bar]\n" + "nan\n" * 600)
    (tmp_path / "rig.yaml").write_text(GROUPED)
    page = run("evaluate", tmp_path / "rig.yaml", *ASKED, check=1).stdout
    assert "without" in page
    assert re.search(r"large .* 24$", page, re.MULTILINE)
    done = run_json("evaluate", tmp_path / "rig.yaml", *ASKED, check=1)
    assert done["scores"][0]["without_number"] == {"large": 24}
