"""What a file may say of a study, and the sentences where it is mistaken."""

import pytest

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.errors import ConfigError
from tests.commands import run_json

STUDY = """\
name: small
study:
  healthy: {fit: 20, test: 10}
  faults: {leakage.internal_flow: [0.1 L/min, 1 L/min], each: 5}
"""


@pytest.fixture
def loaded(tmp_path):
    def load(text=STUDY, *settings):
        file = tmp_path / "study.yaml"
        file.write_text(text)
        return load_experiment(file, settings)

    return load


@pytest.mark.parametrize(
    ("setting", "reached"),
    [
        ("study.healthy.fit=30", lambda study: study.healthy.fit == 30),
        ("study.faults.leakage.internal_flow=[2 L/min]", lambda study: len(study.faults.levels) == 1),
        ("study.shifts.much stiffer.fluid.bulk_modulus=827 MPa",
         lambda study: study.shifts == {"much stiffer": {"fluid.bulk_modulus": 827e6}}),
        ("study.population.over.supply.pressure={uniform: ±5 %}",
         lambda study: "supply.pressure" in study.population.over),
    ],
)  # fmt: skip
def test_settings_reach_every_part(loaded, setting, reached):
    assert reached(loaded(STUDY, setting).study)


def test_designs_do_not_vary_what_the_study_draws(loaded):
    with pytest.raises(ConfigError, match=r"measurement\.seed varies in both sweep and study"):
        loaded(STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 9]}}}\n"
               "sweep: {grid: {measurement.seed: [1, 2]}}\n")  # fmt: skip


def test_records_that_are_drawn_alike_are_refused(loaded):
    text = STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 1]}}}\n"
    with pytest.raises(ConfigError, match="twice"):
        expand_runs(loaded(text, "wavelet.phase=0"))


def test_a_plan_names_populations_and_designs_not_every_draw(loaded, tmp_path):
    text = STUDY + "  shifts: {thick: {friction.scale: 2}}\nsweep: {grid: {record.duration: [10 s, 20 s]}}\n"
    loaded(text)
    plan = run_json("plan", tmp_path / "study.yaml", "--out", tmp_path / "out")
    assert plan["study"]["designs"] == [{"record.duration": 10.0}, {"record.duration": 20.0}]
    counts = [(each["name"], each["is_fit"], each["records"]) for each in plan["study"]["populations"]]
    assert counts == [
        ("healthy", True, 20), ("healthy", False, 10), ("0.1 L/min", True, 50), ("0.1 L/min", False, 5),
        ("1 L/min", True, 50), ("1 L/min", False, 5), ("thick", False, 10),
    ]  # fmt: skip
    assert list(plan["study"]["differs_per_record"]) == ["measurement.seed", "wavelet.phase"]
    assert plan["axes"] == {"record.duration": [10.0, 20.0]}


@pytest.mark.parametrize(
    ("more", "where"),
    [
        ("  shifts: {deep: {wavelet.levels: 12}}\n", "'shift deep', at "),
        ("  confusions: {weak: {supply.return_pressure: 30 MPa}}\n",
         "'confusion weak', at "),
    ],
)  # fmt: skip
def test_an_impossible_draw_names_its_population_and_what_makes_it_impossible(loaded, more, where):
    varied = "  population: {over: {friction.viscous: {uniform: ±10 %}, supply.pressure: {uniform: ±5 %}}}\n"
    with pytest.raises(ConfigError) as error:
        expand_runs(loaded(STUDY + varied + more))
    assert where in str(error.value)
    assert "\n" not in str(error.value)
