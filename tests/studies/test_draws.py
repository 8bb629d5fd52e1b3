"""What a study draws: who differs from whom, and what stays when a study is extended."""

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.loading import stored_experiment
from hydrofdi.evaluation.scores import NOTHING, Kind
from tests.studies.populations import drawn, rows

POPULATION = "{seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}, friction.viscous: {uniform: ±30 %}}}"
STUDY = [
    f"study.population={POPULATION}",
    "study.healthy={fit: 200, test: 150}",
    "study.faults={leakage.internal_flow: [0.1 L/min, 1 L/min], each: 120, fit: 100}",
]
MODULUS = "fluid.bulk_modulus"


def expanded(*more):
    return expand_runs(load_experiment(settings=[*STUDY, *more]))


def by_population(table, name):
    return [
        np.array(table.runs.values(name))[np.flatnonzero(table.study.of_run == number)]
        for number in range(len(table.study.populations))
    ]


def test_all_populations_and_parameters_are_drawn_independently():
    table = expanded("study.shifts={thick: {friction.scale: 2}}")
    columns = [
        (values[:100] - values[:100].mean()) / values[:100].std()
        for name in (MODULUS, "friction.viscous", "measurement.seed", "wavelet.phase")
        for values in by_population(table, name)
    ]
    correlations = np.corrcoef(columns) - np.eye(len(columns))
    assert len(columns) == 28
    assert abs(correlations).max() < 0.45  # 4.7 standard errors: 378 pairs reach it once in a thousand seeds


def test_a_larger_population_begins_with_the_draws_of_a_smaller_one():
    small, large = expanded(), expanded("study.healthy.test=400")
    for name in (MODULUS, "measurement.seed"):
        few, many = (drawn(table, name, Kind.HEALTHY) for table in (small, large))
        assert few.tolist() == many[:150].tolist()


def test_what_is_added_to_a_study_leaves_its_other_draws_alone():
    plain = expanded()
    more = expanded(
        "study.shifts={stiffer: {fluid.bulk_modulus: 689 MPa}}",
        "study.population.over.supply.pressure={uniform: ±5 %}",
        "study.faults.leakage.internal_flow=[0.1 L/min, 0.5 L/min, 1 L/min]",
    )
    for name in (MODULUS, "friction.viscous", "measurement.seed", "wavelet.phase"):
        old = dict(zip(plain.study.populations, by_population(plain, name), strict=True))
        new = dict(zip(more.study.populations, by_population(more, name), strict=True))
        assert all(new[each].tolist() == values.tolist() for each, values in old.items())


def test_a_shift_sets_its_parameter_and_another_seed_draws_all_anew_as_a_shift_does():
    table = expanded("study.shifts={stiffer: {fluid.bulk_modulus: 689 MPa}}", "study.healthy.shift=70")
    assert set(drawn(table, MODULUS, Kind.SHIFT)) == {689e6}
    friction = drawn(table, "friction.viscous", Kind.SHIFT)
    assert len(friction) == 70
    assert not set(friction) & set(drawn(table, "friction.viscous", Kind.HEALTHY))
    other = expanded("study.population.seed=4")
    for name in (MODULUS, "measurement.seed"):
        assert not set(drawn(table, name, Kind.HEALTHY)) & set(drawn(other, name, Kind.HEALTHY))


def test_designs_repeat_the_study_with_the_same_draws():
    table = expanded("sweep.grid.record.duration=[10 s, 20 s]")
    one, other = (np.flatnonzero(table.study.design_of_run == design) for design in (0, 1))
    assert table.study.of_run[one].tolist() == table.study.of_run[other].tolist()
    assert table.study.designs == ({"record.duration": 10.0}, {"record.duration": 20.0})
    for name in (MODULUS, "friction.viscous", "measurement.seed", "wavelet.phase"):
        values = np.array(table.runs.values(name))
        assert values[one].tolist() == values[other].tolist()
    assert set(np.array(table.runs.values("record.duration"))[other]) == {20.0}
    assert table.runs.solutions()["total"] == 2, "a coefficient for each level, whatever the design"


def test_no_healthy_run_is_added_no_run_has_a_baseline_and_each_level_is_solved_once():
    table = expanded()
    assert len(table.runs) == table.n_swept == 200 + 150 + 2 * (120 + 100)
    assert {*table.fixed_baseline, *table.matched_baseline} == {-1}
    assert table.study.actuators is None
    assert table.runs.solutions()["total"] == 2
    assert expanded("calibration.at=run").runs.solutions()["total"] == 440


def test_seeds_and_phases_are_drawn_where_they_matter_and_the_file_names_none():
    def per_record(*more):
        experiment = load_experiment(settings=[*STUDY, *more])
        return set(experiment.study.population.per_record)

    assert per_record() == {"measurement.seed", "wavelet.phase"}
    assert per_record("wavelet.phase=3") == {"measurement.seed"}
    assert per_record("indicators=[ring_down]") == {"measurement.seed"}
    moving = ("input.shape=steps", "load.random_force=1 kN", "indicators=[ring_down]")
    assert per_record(*moving) == {"measurement.seed", "input.seed", "load.seed"}
    assert per_record(*moving, "input.seed=5") == {"measurement.seed", "load.seed"}


def test_all_cheap_indicators_are_measured_where_all_are_judged():
    experiment = load_experiment(settings=[*STUDY, "detection.indicators=all"])
    assert "ring_down" in experiment.indicators
    assert not {"emd", "vmd"} & set(experiment.indicators)
    chosen = load_experiment(settings=[*STUDY, "indicators=[dwt, emd]", "detection.indicators=[emd]"])
    assert (list(chosen.indicators), chosen.detection.indicators) == (["dwt", "emd"], ["emd"])


def test_the_stored_configuration_says_the_same():
    experiment = load_experiment(settings=[*STUDY, "study.shifts={thin: {friction.scale: {uniform: ±9 %}}}"])
    again = stored_experiment(experiment.model_dump_json(), "a file")
    assert again == experiment
    one, other = (
        drawn(expand_runs(each), MODULUS, Kind.HEALTHY, is_fit=True) for each in (again, experiment)
    )
    assert one.tolist() == other.tolist()


BULK, LAW, SUPPLY = NAMES = ("fluid.bulk_modulus", "friction.law", "supply.pressure")

ALONE_STUDY = """
name: small
record: {duration: 2 s}
study:
  population:
    seed: 3
    over:
      fluid.bulk_modulus: {uniform: ±20 %}
      friction.law: {choice: [threshold, smooth]}
      supply.pressure: {uniform: ±5 %}
  healthy: {fit: 6, test: 5}
  faults: {leakage.internal_flow: [0.2 L/min], each: 4, fit: 2}
"""


def alone_expanded(tmp_path, text=ALONE_STUDY, sensitivity="{alone: 50}"):
    path = tmp_path / "study.yaml"
    path.write_text(text + (f"  sensitivity: {sensitivity}\n" if sensitivity else ""))
    return expand_runs(load_experiment(path))


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return alone_expanded(tmp_path_factory.mktemp("study"))


def test_alone_one_nuisance_varies_and_the_others_are_nominal(table):
    nominal = {BULK: 551e6, LAW: "threshold", SUPPLY: 17.2e6}
    for name in (*NAMES, NOTHING):
        for parameter in NAMES:
            values = set(drawn(table, parameter, Kind.ALONE, name=name))
            if parameter == name:
                assert len(values) == (2 if parameter == LAW else 50)
            else:
                assert values == {nominal[parameter]}
    seeds = table.runs.values("measurement.seed")
    assert len(set(seeds)) == len(seeds), "every record has noise of its own"
    healthy = rows(table, Kind.ALONE, name=NOTHING)
    assert {table.runs[row].parameters.leakage.internal_coefficient for row in healthy.tolist()} == {0.0}


def test_a_design_takes_what_it_says(table, tmp_path):
    without = alone_expanded(tmp_path, sensitivity="")
    assert len(table.runs) == len(without.runs) + (3 + 1) * 50
    ids = list(without.runs.record_texts())
    assert list(table.runs.record_texts())[: len(ids)] == ids
