"""What a study draws: who differs from whom, and what stays when a study is extended."""

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.evaluation.scores import NOTHING, Kind
from hydrofdi.store.folder import stored_experiment

POPULATION = "{seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}, friction.viscous: {uniform: ±30 %}}}"
STUDY = [
    f"study.population={POPULATION}",
    "study.healthy={fit: 200, test: 150}",
    "study.faults={leakage.internal_flow: [0.1 L/min, 1 L/min], each: 120, fit: 100}",
]
MODULUS = "fluid.bulk_modulus"


def expanded(*more):
    return expand_runs(load_experiment(settings=[*STUDY, *more]))


def drawn(table, kind, name, *, is_fit=False, severity=None):
    """Values of a parameter in a population of the first design."""
    (number,) = (
        place
        for place, each in enumerate(table.study.populations)
        if (each.kind, each.is_fit) == (kind, is_fit) and severity in (None, each.name)
    )
    rows = np.flatnonzero((table.study.of_run == number) & (table.study.design_of_run == 0))
    return np.array(table.runs.values(name))[rows]


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
        few, many = (drawn(table, Kind.HEALTHY, name) for table in (small, large))
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


def test_a_shift_sets_its_parameter_and_draws_the_others_anew():
    table = expanded("study.shifts={stiffer: {fluid.bulk_modulus: 689 MPa}}", "study.healthy.shift=70")
    assert set(drawn(table, Kind.SHIFT, MODULUS)) == {689e6}
    friction = drawn(table, Kind.SHIFT, "friction.viscous")
    assert len(friction) == 70
    assert not set(friction) & set(drawn(table, Kind.HEALTHY, "friction.viscous"))


def test_another_seed_draws_all_anew():
    first, other = expanded(), expanded("study.population.seed=4")
    for name in (MODULUS, "measurement.seed"):
        assert not set(drawn(first, Kind.HEALTHY, name)) & set(drawn(other, Kind.HEALTHY, name))


def test_pairing_gives_the_same_actuators_their_own_records():
    table = expanded("study.pairing=common")
    for is_fit, count in ((True, 100), (False, 120)):
        healthy, leaking = (
            {name: drawn(table, kind, name, is_fit=is_fit, severity=of)[:count] for name in POPULATION_NAMES}
            for kind, of in ((Kind.HEALTHY, None), (Kind.FAULT, "1 L/min"))
        )
        assert healthy[MODULUS].tolist() == leaking[MODULUS].tolist()
        assert healthy["friction.viscous"].tolist() == leaking["friction.viscous"].tolist()
        assert not set(healthy["measurement.seed"]) & set(leaking["measurement.seed"])
    fit, test = (drawn(table, Kind.HEALTHY, MODULUS, is_fit=is_fit) for is_fit in (True, False))
    assert not set(fit) & set(test)


POPULATION_NAMES = (MODULUS, "friction.viscous", "measurement.seed")


def test_records_of_one_actuator_form_a_group():
    table = expanded("study.pairing=common")
    modulus = np.array(table.runs.values(MODULUS))
    for actuator in set(table.study.actuators[::37]):
        rows = [row for row, own in enumerate(table.study.actuators) if own == actuator]
        assert len(set(modulus[rows])) == 1
    assert len(set(table.study.actuators)) == len(set(modulus))
    assert expanded().study.actuators is None


def test_designs_repeat_the_study_with_the_same_draws():
    table = expanded("sweep.grid.record.duration=[10 s, 20 s]")
    one, other = (np.flatnonzero(table.study.design_of_run == design) for design in (0, 1))
    assert table.study.of_run[one].tolist() == table.study.of_run[other].tolist()
    assert table.study.designs == ({"record.duration": 10.0}, {"record.duration": 20.0})
    for name in (*POPULATION_NAMES, "wavelet.phase"):
        values = np.array(table.runs.values(name))
        assert values[one].tolist() == values[other].tolist()
    assert set(np.array(table.runs.values("record.duration"))[other]) == {20.0}


def test_no_healthy_run_is_added_and_no_run_has_a_baseline():
    table = expanded()
    assert len(table.runs) == table.n_swept == 200 + 150 + 2 * (120 + 100)
    assert {*table.fixed_baseline, *table.matched_baseline} == {-1}


def test_the_leakage_coefficient_is_solved_once_for_each_level():
    assert expanded().runs.solutions()["total"] == 2
    designs = "sweep.grid.record.duration=[10 s, 20 s]"
    assert expanded(designs).runs.solutions()["total"] == 2
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
    assert (
        by_population(expand_runs(again), MODULUS)[0].tolist()
        == drawn(expand_runs(experiment), Kind.HEALTHY, MODULUS, is_fit=True).tolist()
    )


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


def rows(table, kind, name):
    study = table.study
    (number,) = (
        place for place, each in enumerate(study.populations) if (each.kind, each.name) == (kind, name)
    )
    return np.flatnonzero(study.of_run == number)


def alone_drawn(table, kind, name, parameter):
    return [table.runs.values(parameter)[row] for row in rows(table, kind, name)]


def test_alone_one_nuisance_varies_and_the_others_are_nominal(table):
    nominal = {BULK: 551e6, LAW: "threshold", SUPPLY: 17.2e6}
    for name in (*NAMES, NOTHING):
        for parameter in NAMES:
            values = set(alone_drawn(table, Kind.ALONE, name, parameter))
            if parameter == name:
                assert len(values) == (2 if parameter == LAW else 50)
            else:
                assert values == {nominal[parameter]}


def test_every_record_has_noise_of_its_own_and_a_whole_seal(table):
    seeds = table.runs.values("measurement.seed")
    assert len(set(seeds)) == len(seeds)
    healthy = rows(table, Kind.ALONE, NOTHING)
    assert {table.runs[row].parameters.leakage.internal_coefficient for row in healthy.tolist()} == {0.0}


def test_a_design_takes_what_it_says(table, tmp_path):
    without = alone_expanded(tmp_path, sensitivity="")
    assert len(table.runs) == len(without.runs) + (3 + 1) * 50
    ids = list(without.runs.record_texts())
    assert list(table.runs.record_texts())[: len(ids)] == ids
