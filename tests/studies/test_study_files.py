"""What a file may say of a study, and the sentences where it is mistaken."""

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError
from tests.commands import run, run_json

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


def test_the_leak_stands_beside_the_counts_or_under_over(loaded):
    short = loaded()
    long = loaded(
        STUDY.replace("leakage.internal_flow: [", "over: {leakage.internal_flow: [").replace("n],", "n]},")
    )
    assert short.study == long.study
    assert short.study.faults.levels == pytest.approx([0.1e-3 / 60, 1e-3 / 60])


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("study.healthy.fit=30", lambda study: study.healthy.fit == 30),
        ("study.faults.each=7", lambda study: study.faults.each == 7),
        ("study.faults.leakage.internal_flow=[2 L/min]", lambda study: len(study.faults.levels) == 1),
        (
            "study.faults.leakage.internal_coefficient=[1e-9]",
            lambda study: study.faults.parameter == "leakage.internal_coefficient",
        ),
        (
            "study.shifts.much stiffer.fluid.bulk_modulus=827 MPa",
            lambda study: study.shifts == {"much stiffer": {"fluid.bulk_modulus": 827e6}},
        ),
        (
            "study.population.over.supply.pressure={uniform: ±5 %}",
            lambda study: "supply.pressure" in study.population.over,
        ),
    ],
)
def test_settings_reach_every_part(loaded, setting, value):
    assert value(loaded(STUDY, setting).study)


@pytest.mark.parametrize(
    ("text", "line", "sentence"),
    [
        ("  faults: {leakage.internal_flow: [0 L/min], each: 5}", 4, "a leak of 0 is not a fault"),
        ("  faults: {friction.viscous: [60], each: 5}", 4, "faults are leaks: leakage.internal_flow or"),
        (
            "  faults: {each: 5}",
            4,
            "names no leak: give leakage.internal_flow or leakage.internal_coefficient",
        ),
        ("  faults: {leakage.internal_flow: [1 mm], each: 5}", 4, "wrong unit"),
        ("  faults: {leakage.internal_flow: [1 L/min], eech: 5}", 4, "did you mean 'each'?"),
        ("  shifts: {thick: {fluid.bulk_moduls: 1}}", 4, "did you mean 'fluid.bulk_modulus'?"),
        ("  shifts: {thick: 3}", 4, "expected 'parameter: value'"),
        ("  shifts: {leaky: {leakage.internal_flow: 1 L/min}}", 2, "belongs under faults"),
        (
            "  population: {over: {leakage.internal_coefficient: {uniform: [0, 1e-9]}}}",
            2,
            "belongs under faults",
        ),
        ("  population: {methode: random}", 4, "did you mean 'method'?"),
        ("ensemble: {grid: {supply.pressure: [16 MPa]}}", 1, "a study has no ensemble"),
        ("replicates: {count: 3}\npressure_1_sensor: {noise: 1 kPa}", 1, "a study has no replicates"),
        ("detection: {indicators: [dtw]}", 4, "there is no indicator 'dtw'; did you mean 'dwt'?"),
        ("indicators: [dwt]\ndetection: {indicators: [modwt]}", 5, "'modwt' is not among the indicators"),
        ("detection: {scores: {s: {kind: lda, of: [dwt.d9]}}}", 4, "no indicator gives 'dwt.d9'"),
        ("detection: {scores: {s: {kind: compensated, of: [dwt.d1]}}}", 4, "compensated needs 'by'"),
        ("detection: {scores: {dwt: {kind: lda, of: [dwt]}}}", 4, "'dwt' is the label of an indicator"),
    ],
)
def test_a_mistake_is_one_line_with_its_place(loaded, tmp_path, text, line, sentence):
    base = "name: small\nstudy:\n  healthy: {fit: 20, test: 10}\n"
    with pytest.raises(ConfigError) as error:
        loaded(f"{base}{text}\n")
    found = [str(mistake) for mistake in error.value.mistakes]
    assert any(sentence in each for each in found), found
    (mistake,) = (each for each in found if sentence in each)
    assert line == 1 or f"{tmp_path / 'study.yaml'}:{line}: " in mistake


def test_detection_needs_a_study(loaded):
    with pytest.raises(ConfigError, match="add study"):
        loaded("name: none\ndetection: {false_alarm_rate: 5 %}\n")


def test_designs_do_not_vary_what_the_study_draws(loaded):
    with pytest.raises(ConfigError, match=r"measurement\.seed varies in both sweep and study"):
        loaded(STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 9]}}}\n"
               "sweep: {grid: {measurement.seed: [1, 2]}}\n")  # fmt: skip


def test_records_that_are_drawn_alike_are_refused(loaded):
    from hydrofdi.config import expand_runs

    text = STUDY + "  population: {per_record: {measurement.seed: {integers: [0, 1]}}}\n"
    with pytest.raises(ConfigError, match="records twice; let more of them vary"):
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
    lines = run("plan", tmp_path / "study.yaml", "--out", tmp_path / "out", check=0).stdout
    assert "300 records: 150 in each of 2 designs\n" in lines
    assert "fault      0.1, 1 L/min: 50 to fit, 5 to test each\n" in lines
    assert "shift      thick (friction.scale 2): 10 to test\n" in lines
    assert "designs    record.duration 10 s\n             record.duration 20 s\n" in lines


def test_a_plan_says_what_a_study_draws_in_the_units_of_people(loaded, tmp_path):
    over = "supply.pressure: {normal: ±0.3 MPa}, friction.law: {choice: [threshold, smooth]}"
    loaded(STUDY + f"  population: {{over: {{{over}}}}}\n  sensitivity: {{alone: 50}}\n")
    lines = run("plan", tmp_path / "study.yaml", "--out", tmp_path / "out", check=0).stdout.splitlines()
    assert "  varies     supply.pressure  17.2 ± 0.3 MPa (normal)" in lines
    assert "             friction.law     threshold or smooth" in lines
    assert "  per record measurement.seed, wavelet.phase" in lines
    assert "  alone      3 populations: 50 to explain each" in lines
    assert not any(line.startswith(("first point", "  axis")) for line in lines)


def test_an_impossible_draw_names_its_population_and_what_makes_it_impossible(loaded):
    from hydrofdi.config import expand_runs

    varied = "  population: {over: {friction.viscous: {uniform: ±10 %}, supply.pressure: {uniform: ±5 %}}}\n"
    with pytest.raises(ConfigError) as deep:
        expand_runs(loaded(STUDY + varied + "  shifts: {deep: {wavelet.levels: 12}}\n"))
    start = "study: in the population 'shift deep', at wavelet.levels = 12: "
    assert str(deep.value).startswith(start)
    assert "wavelet.levels = 12 of db8 needs" in str(deep.value)
    with pytest.raises(ConfigError) as weak:
        expand_runs(loaded(STUDY + varied + "  confusions: {weak: {supply.return_pressure: 30 MPa}}\n"))
    start = "study: in the population 'confusion weak', at supply.return_pressure = 30 MPa: "
    assert str(weak.value).startswith(start)
    assert len(str(weak.value)) < 200
