"""Studies through the runner: what is read back, what is missing, and what a detector may see."""

import shutil
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.detectors.rules import make_score
from hydrofdi.evaluation.scores import Kind
from hydrofdi.execution.compute import Job, compute_columns, measured_columns
from hydrofdi.execution.simulated import SimulatedRecords
from hydrofdi.papers import make_report
from hydrofdi.report.detection.sections import estimates_block, without_noise
from hydrofdi.store.experiment_data import StoredRecords
from hydrofdi.store.folder import write_request
from hydrofdi.store.names import ANALYSIS_ID, LEAKAGE_COEFFICIENT, STATUS
from hydrofdi.store.results import read_results
from hydrofdi.studies.detecting import judge_estimates
from hydrofdi.studies.reading import read_study
from tests.studies.populations import stored

STUDY = """
name: small
store: {signals: pressures}
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa}
indicators: {dwt: {}, pressure_statistics: {}, ring_down: {},
             balance: {kind: flow_balance, spool: command, supply: nominal}}
study:
  population: {seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}}}
  healthy: {fit: 12, test: 8, shift: 5, confusion: 3}
  faults: {leakage.internal_flow: [0.2 L/min, 1 L/min], each: 8, fit: 4}
  shifts: {stiffer: {fluid.bulk_modulus: 827 MPa}}
  confusions: {worn friction: {friction.viscous: {uniform: [100, 200]}}}
detection:
  false_alarm_rate: 20 %
  confidence: 90 %
  indicators: [dwt, ring_down, balance]
  scores:
    unusual: {kind: mahalanobis, of: [pressure_statistics, dwt.d3]}
    leak: {kind: lda, of: [pressure_statistics.mean, pressure_statistics.kurtosis]}
    calm: {kind: compensated, of: [dwt], by: [pressure_statistics.kurtosis]}
sweep: {grid: {pressure_1_sensor.noise: [5 kPa, 1 kPa]}}
"""
ONE = STUDY[: STUDY.index("sweep:")]
"""The same with one design."""


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("study"), STUDY)


@pytest.fixture
def runs(tmp_path):
    (tmp_path / "study.yaml").write_text(ONE)
    return expand_runs(load_experiment(tmp_path / "study.yaml")).runs


def test_every_population_of_each_design_has_its_records_with_the_true_mean_leak_of_each(data):
    designs = read_study(data)
    found = [records.design for records, _ in designs]
    assert found == [{"pressure_1_sensor.noise": 5e3}, {"pressure_1_sensor.noise": 1e3}]
    for records, _ in designs:
        found = {(each.name, each.kind, each.is_fit): len(records.rows(each)) for each in records.populations}
        assert found == {
            ("healthy", Kind.HEALTHY, True): 12,
            ("healthy", Kind.HEALTHY, False): 8,
            ("0.2 L/min", Kind.FAULT, True): 4,
            ("0.2 L/min", Kind.FAULT, False): 8,
            ("1 L/min", Kind.FAULT, True): 4,
            ("1 L/min", Kind.FAULT, False): 8,
            ("stiffer", Kind.SHIFT, False): 5,
            ("worn friction", Kind.CONFUSION, False): 3,
        }
        coefficients = data.columns[LEAKAGE_COEFFICIENT][records.runs]
        for population in records.populations:
            severity = records.severity[records.rows(population)]
            assert severity == pytest.approx(np.full_like(severity, population.severity), rel=0.1)
            assert len(np.unique(severity)) == (len(severity) if population.severity else 1)
            assert len(np.unique(coefficients[records.rows(population)])) == 1, "that of the level"
    study = data.experiment.study
    faults = study.faults.model_copy(update={"severity": "level"})
    asked = data.experiment.model_copy(update={"study": study.model_copy(update={"faults": faults})})
    (records, _), _ = read_study(replace(data, experiment=asked))
    nominal = np.array([population.severity for population in records.populations])
    np.testing.assert_array_equal(records.severity, nominal[records.of_record])


def test_made_scores_are_judged_beside_the_indicators_that_are_chosen_and_the_usual_ones_if_asked(data):
    (records, scores), _ = read_study(data)
    by_name = {score.name: score for score in scores}
    assert [*by_name][:2] == ["dwt.d1", "dwt.d2"]
    assert {"ring_down.damping_ratio", "balance.leakage"} <= by_name.keys()
    assert not by_name.keys() & {"ring_down.steps", "ring_down.frequency_error", "balance.condition"}
    assert not [name for name in by_name if name.startswith("pressure_statistics")]
    details = [name for name in by_name if name.startswith("dwt.")]
    made = ["unusual", "leak", *(f"calm.{name}" for name in details)]
    assert [*by_name][-len(made) :] == made
    assert all(np.isfinite(by_name[name].values).all() for name in made)
    assert by_name["dwt.d1"].channels == ("chamber_1_pressure",)
    detection = data.experiment.detection.model_copy(update={"usual_scores": True})
    asked = replace(data, experiment=data.experiment.model_copy(update={"detection": detection}))
    more = {score.name for score in read_study(asked)[0][1]} - by_name.keys()
    assert {"mahalanobis(P1)", "lda(P1)", "largest_change(d1 … d5)"} <= more
    columns = [data.columns[f"pressure_statistics.{name}"][records.runs] for name in ("mean", "kurtosis")]
    values, populations = np.stack(columns, axis=1), [records.populations[k] for k in records.of_record]
    is_fit = np.array([each.is_fit and each.kind in (Kind.HEALTHY, Kind.FAULT) for each in populations])
    is_faulty = np.array([each.severity > 0.0 for each in populations])
    model = make_score("lda").fit(values[is_fit], is_faulty[is_fit])
    np.testing.assert_array_equal(by_name["leak"].values[~is_fit], model.score(values[~is_fit]))


def test_a_level_that_no_coefficient_reaches_has_no_numbers(tmp_path):
    data = stored(tmp_path, ONE, "study.faults.leakage.internal_flow=[0.2 L/min, 500 L/min]")
    ((records, scores),) = read_study(data)
    lost = np.concatenate([records.rows(each) for each in records.populations if each.severity > 1e-3])
    assert lost.size == 12
    assert set(data.columns[STATUS][lost]) == {"unreachable_leakage"}
    assert np.isnan(records.severity[lost]).all()
    assert all(np.isnan(score.values[lost]).all() for score in scores)


def test_truth_cannot_reach_an_indicator(runs):
    """Jobs that claim another leak, another plant and another record measure the same of the same signals."""
    experiment = load_experiment(
        {"name": "all"}, ["study.healthy={fit: 2, test: 2}", "detection.indicators=all"]
    )
    runs = expand_runs(experiment).runs
    honest = [Job.of(run, str(row), 1e-9 * row, f"record {row}") for row, run in enumerate(runs)]
    columns = compute_columns(honest)
    claims = {"leakage.internal_coefficient": 7e-8, "fluid.bulk_modulus": 900e6, "friction.viscous": 400.0}
    poisoned = [
        replace(
            job,
            parameters=job.parameters.with_values(claims),
            leakage_coefficient=7e-8,
            record_id=f"leaks {row} L/min",
        )
        for row, job in enumerate(honest)
    ]
    measured = measured_columns(poisoned, columns)
    outputs = [name for name in measured if "." in name and not name.endswith(ANALYSIS_ID)]
    assert len(outputs) > 80
    for name in outputs:
        if measured[name].dtype == float:
            assert np.array_equal(measured[name], columns[name], equal_nan=True), name
        else:
            assert measured[name].tolist() == columns[name].tolist(), name


def test_each_record_is_transformed_from_its_own_start_phase(runs):
    some = runs.at(range(8))
    jobs = [Job.of(run, str(row), 0.0, f"record {row}") for row, run in enumerate(some)]
    together = compute_columns(jobs)
    assert len(set(some.values("wavelet.phase"))) > 4
    for row, job in enumerate(jobs):
        alone = compute_columns([job])
        for name in ("dwt.d1", "dwt.d5", "dwt.a5", "ring_down.frequency", f"dwt{ANALYSIS_ID}"):
            assert together[name][row] == alone[name][0]


def estimates(data, **changed):
    """What is judged of the first design, with some columns changed, by quantity and population."""
    data = replace(data, columns={**data.columns, **changed})
    rows = judge_estimates(data, read_study(data)[0][0])
    return {(each["quantity"], each["population"]): each for each in rows}


K_I = "balance.internal_coefficient"


def test_the_truth_with_a_known_error_gives_this_error_and_its_coverage(data):
    """On test records and shifts."""
    truth = data.columns["internal_leakage_coefficient"]
    told = {K_I: truth + 2e-10 + 1e-9 * np.random.default_rng(5).normal(size=data.n_run)}
    found = estimates(data, **told, **{f"{K_I}_error": np.full(data.n_run, 1e-9)})
    sizes = {"healthy": 8, "stiffer": 5, "faults": 16}
    assert {key: each["n"] for key, each in found.items()} == {
        (quantity, population): n
        for quantity in ("leakage", "bulk_modulus")
        for population, n in sizes.items()
    }
    faults, unit = found["leakage", "faults"], 1e-9 * np.sqrt(8e6) * 6e4
    assert faults["stated_deviation_L_per_min"] == pytest.approx(unit)
    assert abs(faults["mean_error_L_per_min"]) < 2.0 * unit
    assert 0.1 * unit < faults["deviation_L_per_min"] < 3.0 * unit
    for stated, covered in ((1e-15, 0.0), (1e-3, 1.0)):
        found = estimates(data, **told, **{f"{K_I}_error": np.full(data.n_run, stated)})
        assert found["leakage", "faults"]["covered"] == covered


def test_bulk_moduli_are_judged_as_shares_of_the_truth_and_records_without_one_counted_apart(data):
    found = estimates(data, **{"balance.bulk_modulus": 1.03 * data.columns["bulk_modulus"]})
    for population in ("healthy", "stiffer", "faults"):
        each = found["bulk_modulus", population]
        assert each["mean_error_percent"] == pytest.approx(3.0)
        assert each["deviation_percent"] < 1e-7
    found = estimates(data, **{"balance.bulk_modulus": np.full(data.n_run, np.nan)})
    each = found["bulk_modulus", "healthy"]
    assert (each["n"], each["not_measurable"], each["covered"]) == (0, 8, None)
    assert each["mean_error_percent"] is None


def test_leaks_that_set_in_later_are_left_out_with_the_reason(data):
    """Neither K_i nor β of such a record has one truth."""
    leakage = data.experiment.leakage.model_copy(update={"onset": "step", "onset_time": 2.0})
    later = replace(data, experiment=data.experiment.model_copy(update={"leakage": leakage}))
    assert {population for _, population in estimates(later)} == {"healthy", "stiffer"}
    for each, is_said in ((later, True), (data, False)):
        (sheet,) = estimates_block(each, [*estimates(each).values()]).tables
        assert ("Faults are left out: leaks set in during the record" in sheet.notes[0]) == is_said


def test_records_of_a_study_are_labelled_by_their_population(data):
    for source in (SimulatedRecords(data.experiment, "study"), StoredRecords(data, "study")):
        labels = Counter(label for batch in source.batches(labels=True) for label in batch.labels)
        assert labels == {
            "healthy": 40, "0.2 L/min": 24, "1 L/min": 24, "shift stiffer": 10, "confusion worn friction": 6,
        }  # fmt: skip


def test_an_unfinished_study_says_so_and_concludes_nothing(data, tmp_path):
    """Its runs are stored, more of them are asked for, and records for nuisances."""
    folder = shutil.copytree(data.path.parent, tmp_path / "out")
    larger = ("study.healthy.fit=60", "study.sensitivity.alone=49")
    write_request(folder, load_experiment(data.path.parents[1] / "study.yaml", larger))
    unfinished = make_report(read_results(folder))
    blocks = {block.key: block for block in unfinished.document().blocks}
    (row,) = blocks["holes"].tables[0]
    assert (row["status"], row["runs"]) == ("missing", unfinished.data.n_run - data.n_run)
    assert blocks.keys().isdisjoint({"why", "designs", "train"})
    record = unfinished.record()
    assert (record["is_complete"], record["runs_computed"]) == (False, data.n_run)
    assert sum(each["n"] for each in record["studies"][0]["populations"]) == data.n_run / 2


SENSORS = """
name: sensors
record: {duration: 2 s}
input: {period: 0.5 s}
pressure_1_sensor: {noise: 5 kPa, bias: 1 kPa}
pressure_2_sensor: {noise: 5 kPa}
position_sensor: {noise: 1 µm}
study:
  population: {over: {fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %}}}
  healthy: {fit: 30, test: 30}
  faults: {leakage.internal_flow: [0.2 L/min, 2 L/min], each: 20, fit: 0}
detection:
  false_alarm_rate: 10 %
  probability: 80 %
  indicators: [dwt, flow_balance]
  scores: {calm: {kind: compensated, of: [dwt.d1], by: [flow_balance.leakage]}}
"""


def test_sensors_without_noise_are_named_and_those_left_out_take_their_scores_with_them(tmp_path):
    def judged_with(*settings):
        made = make_report(stored(tmp_path, SENSORS, *settings))
        return made.detections[0], without_noise(made.data.experiment, made.detections[0])

    judged, perfect = judged_with()
    assert perfect == ["Ps", "xv"]
    assert 0.5 < judged.records.per_mean_flow < 5.0
    fewer, _ = judged_with("detection.sensors=[P1, P2, x, u]")
    assert {each.name.partition(".")[0] for each in fewer.judgements} == {"dwt"}
    assert sum("is left out" in remark for remark in fewer.remarks) == 2
    assert judged_with("study.population.over.spool_sensor.noise={uniform: [0.1 µm, 1 µm]}")[1] == ["Ps"]
