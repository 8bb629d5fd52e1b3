"""A study asks for scores that are made of others: from its file to what is judged."""

from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.api.stored import read_results
from hydrofdi.api.sweep import run_sweep
from hydrofdi.config import load_experiment
from hydrofdi.detectors.registry import make_score
from hydrofdi.execution import InProcessEngine
from hydrofdi.studies.reading import read_study

STUDY = """
name: made
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa}
indicators: [dwt, pressure_statistics]
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 12, test: 4}
  faults: {leakage.internal_flow: [1 L/min], each: 2, fit: 8}
detection:
  indicators: [dwt]
  scores:
    unusual: {kind: mahalanobis, of: [pressure_statistics, dwt.d3]}
    leak: {kind: lda, of: [pressure_statistics.mean, pressure_statistics.kurtosis]}
    calm: {kind: compensated, of: [dwt], by: [pressure_statistics.kurtosis]}
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    (folder / "study.yaml").write_text(STUDY)
    run_sweep(load_experiment(folder / "study.yaml"), folder / "results", InProcessEngine())
    return folder


def test_made_scores_are_judged_beside_the_indicators_that_are_chosen(study):
    (design,) = read_study(read_results(study / "results"))
    names = [score.name for score in design.scores]
    assert not [name for name in names if name.startswith("pressure_statistics")]
    assert [name for name in names if not name.startswith("dwt.")] == [
        "unusual",
        "leak",
        *(f"calm.{name}" for name in names if name.startswith("dwt.")),
    ]
    for score in design.scores[-3:]:
        assert np.isfinite(score.values).all(), score.note


def test_test_records_are_scored_by_the_model_of_all_fit_records(study):
    data = read_results(study / "results")
    (design,) = read_study(data)
    values = np.stack([data.columns[f"pressure_statistics.{name}"] for name in ("mean", "kurtosis")], axis=1)
    populations = [design.records.populations[each] for each in design.records.of_record]
    is_fit = np.array([each.is_fit for each in populations])
    is_faulty = np.array([each.severity > 0.0 for each in populations])
    model = make_score("lda").fit(values[is_fit], is_faulty[is_fit])
    found = next(score.values for score in design.scores if score.name == "leak")
    np.testing.assert_array_equal(found[~is_fit], model.score(values[~is_fit]))
    assert not np.any(found[is_fit] == model.score(values[is_fit]))


def test_the_usual_scores_come_where_they_are_asked_for(study):
    data = read_results(study / "results")
    detection = data.experiment.detection.model_copy(update={"usual_scores": True})
    asked = replace(data, experiment=data.experiment.model_copy(update={"detection": detection}))
    plain, more = ({score.name for score in read_study(each)[0].scores} for each in (data, asked))
    assert more - plain == {"mahalanobis(P1)", "lda(P1)", "largest_change(d1 … d5)"}
