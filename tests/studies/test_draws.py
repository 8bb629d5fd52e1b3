"""What a study draws: who differs from whom, and what stays when a study is extended."""

import numpy as np
import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.evaluation.scores import NOTHING, Kind
from tests.studies.populations import drawn, rows

POPULATION = "{seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %}, friction.viscous: {uniform: ±30 %}}}"
STUDY = [
    f"study.population={POPULATION}",
    "study.healthy={fit: 200, test: 150}",
    "study.faults={leakage.internal_flow: [0.1 L/min, 1 L/min], each: 120, fit: 100}",
]
MODULUS = "fluid.bulk_modulus"
DRAWN = (MODULUS, "friction.viscous", "measurement.seed", "wavelet.phase")


def expanded(*more):
    return expand_runs(load_experiment(settings=[*STUDY, *more]))


def by_population(table, name):
    """Population → values."""
    values = np.array(table.runs.values(name))
    return {each: values[table.study.of_run == k] for k, each in enumerate(table.study.populations)}


def test_all_populations_and_parameters_are_drawn_independently():
    table = expanded("study.shifts={thick: {friction.scale: 2}}")
    columns = [own[:100] for name in DRAWN for own in by_population(table, name).values()]
    assert len(columns) == 28
    # 0.45 are 4.7 standard errors: 378 pairs reach it once in a thousand seeds.
    assert abs(np.corrcoef(columns) - np.eye(len(columns))).max() < 0.45


def test_what_is_added_to_a_study_leaves_its_other_draws_alone():
    """Also a larger population begins with those of a smaller one."""
    plain = expanded()
    more = expanded(
        "study.shifts={stiffer: {fluid.bulk_modulus: 689 MPa}}",
        "study.population.over.supply.pressure={uniform: ±5 %}",
        "study.faults.leakage.internal_flow=[0.1 L/min, 0.5 L/min, 1 L/min]",
        "study.healthy.test=400",
    )
    for name in DRAWN:
        new, old = by_population(more, name), by_population(plain, name)
        assert all(new[each][: own.size].tolist() == own.tolist() for each, own in old.items())


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
    for name in DRAWN:
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
    moving = ("input.shape=steps", "load.random_force=1 kN", "indicators=[ring_down]")
    for settings, names in (
        ((), {"measurement.seed", "wavelet.phase"}),
        (("wavelet.phase=3",), {"measurement.seed"}),
        (("indicators=[ring_down]",), {"measurement.seed"}),
        (moving, {"measurement.seed", "input.seed", "load.seed"}),
        ((*moving, "input.seed=5"), {"measurement.seed", "load.seed"}),
    ):
        experiment = load_experiment(settings=[*STUDY, *settings])
        assert set(experiment.study.population.per_record) == names


def test_all_cheap_indicators_are_measured_where_all_are_judged():
    experiment = load_experiment(settings=[*STUDY, "detection.indicators=all"])
    assert "ring_down" in experiment.indicators
    assert not {"emd", "vmd"} & set(experiment.indicators)
    chosen = load_experiment(settings=[*STUDY, "indicators=[dwt, emd]", "detection.indicators=[emd]"])
    assert (list(chosen.indicators), chosen.detection.indicators) == (["dwt", "emd"], ["emd"])


def test_alone_one_nuisance_varies_and_the_others_are_nominal():
    names = (MODULUS, "friction.law", "supply.pressure")
    study = [
        "study.population.over={fluid.bulk_modulus: {uniform: ±20 %}, supply.pressure: {uniform: ±5 %},"
        " friction.law: {choice: [threshold, smooth]}}",
        "study.healthy={fit: 6, test: 5}",
        "study.faults={leakage.internal_flow: [0.2 L/min], each: 4, fit: 2}",
    ]
    table, without = (
        expand_runs(load_experiment(settings=[*study, *more]))
        for more in (["study.sensitivity={alone: 50}"], [])
    )
    nominal = dict(zip(names, (551e6, "threshold", 17.2e6), strict=True))
    for name in (*names, NOTHING):
        for parameter in names:
            values = set(drawn(table, parameter, Kind.ALONE, name=name))
            if parameter == name:
                assert len(values) == (2 if parameter == "friction.law" else 50)
            else:
                assert values == {nominal[parameter]}
    seeds = table.runs.values("measurement.seed")
    assert len(set(seeds)) == len(seeds), "every record has noise of its own"
    healthy = rows(table, Kind.ALONE, name=NOTHING)
    assert {table.runs[row].parameters.leakage.internal_coefficient for row in healthy.tolist()} == {0.0}
    assert len(table.runs) == len(without.runs) + (3 + 1) * 50
    ids = list(without.runs.record_texts())
    assert list(table.runs.record_texts())[: len(ids)] == ids


@pytest.fixture(scope="module")
def pairs():
    return expand_runs(
        load_experiment(
            settings=[
                "study.pairing=common",
                "study.population={seed: 3, over: {fluid.bulk_modulus: {uniform: ±20 %},"
                " friction.scale: {uniform: ±30 %}}}",
                "study.healthy={fit: 3, test: 4, shift: 2}",
                "study.faults={leakage.internal_coefficient: [1e-9, 2e-9], each: 5, fit: 2}",
                "study.shifts={stiffer: {fluid.bulk_modulus: 827 MPa}}",
            ]
        )
    )


@pytest.mark.parametrize("is_fit", [True, False])
def test_every_actuator_that_is_judged_has_a_record_before(pairs, is_fit):
    before, groups = rows(pairs, Kind.BEFORE, is_fit=is_fit), pairs.study.actuators
    assert len(before) == (3 if is_fit else 5)
    assert not np.any(np.array(pairs.runs.values("leakage.internal_coefficient"))[before])
    for kind, severity in ((Kind.HEALTHY, 0.0), (Kind.FAULT, 1e-9), (Kind.FAULT, 2e-9)):
        after = rows(pairs, kind, is_fit=is_fit, severity=severity)
        of_same = before[: len(after)]
        for name in (MODULUS, "friction.scale"):
            values = np.array(pairs.runs.values(name))
            np.testing.assert_array_equal(values[after], values[of_same])
        assert [groups[row] for row in after] == [groups[row] for row in of_same]


def test_actuators_are_groups_of_which_fit_and_test_share_none_and_a_shift_changes_those_seen_before(pairs):
    modulus, friction = (np.array(pairs.runs.values(name)) for name in (MODULUS, "friction.scale"))
    before, after = rows(pairs, Kind.BEFORE), rows(pairs, Kind.SHIFT)
    assert not set(modulus[before]) & set(modulus[rows(pairs, Kind.BEFORE, is_fit=True)])
    np.testing.assert_array_equal(friction[after], friction[before][: len(after)])
    assert (modulus[after] == 827e6).all()
    assert len(set(pairs.runs.values("measurement.seed"))) == len(pairs.runs), "noise is of each record"
    together = set(zip(pairs.study.actuators, friction, strict=True))
    assert len(together) == len(set(pairs.study.actuators)) == len(set(friction))
