"""``hydrofdi evaluate``: scores of several numbers, by models that saw no record of the same group."""

import numpy as np
import pytest
from scipy.signal import lfilter

from hydrofdi.detectors.registry import make_score
from hydrofdi.evaluation.roc import area_under_curve
from tests.commands import run, run_json

DESCRIPTION = """\
files: "unit */*.csv"
sampling_frequency: 500 Hz
channels: {chamber_1_pressure: "P1 [bar]"}
path: "unit {unit}/{condition} {run}"
label: "{condition}"
healthy: sound
"""
GROUPED = DESCRIPTION + 'group: "unit {unit}"\n'
USUAL = ("--usual-scores", "--false-alarm-rate", "5%")


def write_units(folder, conditions, n_run=20):
    """Records of units with a sound of their own, whatever their condition; each unit has one condition."""
    draw = np.random.default_rng(4)
    for unit, condition in enumerate(conditions):
        place = folder / f"unit {unit}"
        place.mkdir()
        sound = draw.normal(size=40) * 0.8 ** np.arange(40)
        for number in range(n_run):
            pressure = 50.0 + lfilter(sound, [1.0], draw.normal(size=600))
            rows = "".join(f"{value:.6g}\n" for value in pressure)
            (place / f"{condition} {number}.csv").write_text(f"P1 [bar]\n{rows}")
    (folder / "rig.yaml").write_text(GROUPED)
    (folder / "plain.yaml").write_text(DESCRIPTION)


@pytest.fixture(scope="module")
def confounded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("confounded")
    write_units(folder, ["sound", "worn"] * 4)
    return folder


def scores_of(evaluation):
    return {score["indicator"]: score for score in evaluation["scores"]}


def test_a_score_does_not_find_the_units_that_it_was_not_shown(confounded):
    records = run_json("measure", confounded / "rig.yaml")["records"]
    values = np.array([[*record["values"].values()] for record in records], dtype=float)
    is_worn = np.array([record["label"] == "worn" for record in records])
    recognised = make_score("lda").fit(values, is_worn).score(values)
    trap = area_under_curve(recognised[~is_worn], recognised[is_worn])
    found = scores_of(run_json("evaluate", confounded / "rig.yaml", *USUAL))
    (honest,) = found["lda(P1)"]["auc"]
    assert trap.low > 0.8, "scored by the model that saw them, the units are told apart"
    assert honest["low"] < 0.5, "nothing but the unit was ever there"
    assert honest["value"] < trap.value - 0.2
    assert {"mahalanobis(P1)", "largest_change(d1 … d5)"} <= set(found)


def test_a_file_of_indicators_may_ask_for_scores(confounded, tmp_path):
    file = tmp_path / "asked.yaml"
    text = "indicators: [dwt]\nscores:\n  far: {kind: mahalanobis, of: [dwt], shrinkage: SHRINKAGE}\n"
    areas = []
    for shrinkage in ("0", "1"):
        file.write_text(text.replace("SHRINKAGE", shrinkage))
        found = scores_of(run_json("evaluate", confounded / "rig.yaml", "--indicators", file))
        areas.append(found["far"]["auc"][0]["value"])
        assert "lda(P1)" not in found
    assert areas[0] != areas[1]
    file.write_text(text.replace("shrinkage: SHRINKAGE", "shrinkag: 1"))
    done = run("evaluate", confounded / "rig.yaml", "--indicators", file, check=2)
    assert "asked.yaml:3: scores.far.shrinkag: unknown key; did you mean 'shrinkage'?" in done.stderr
