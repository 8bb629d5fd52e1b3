# ruff: noqa: E501
"""Expansion of sweeps: blocks, conditions, identities, large ones."""

import json
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.config import RunParameters, expand_runs, load_experiment
from hydrofdi.config.request import RunRequest, parameter_names
from hydrofdi.config.runs import PHYSICS_VERSION, run_identities, run_identity
from hydrofdi.config.sweep import count_points, distinct_rows, parse_condition
from hydrofdi.errors import ConfigError

LEAKAGE = "sweep.grid.leakage.internal_flow=[0 L/min, 0.12 L/min]"
EBM = "sweep.grid.fluid.bulk_modulus=[551 MPa, 689 MPa]"


def table_of(*settings):
    return expand_runs(load_experiment(None, settings))


def test_a_grid_is_all_combinations_with_the_last_axis_varying_fastest_and_its_own_baselines():
    table = table_of(LEAKAGE, EBM)
    points = [(run.parameters.leakage.internal_flow, run.parameters.fluid.bulk_modulus) for run in table.runs]
    assert points == [(None, 551e6), (None, 689e6), (2e-6, 551e6), (2e-6, 689e6)]
    assert table.n_swept == 4
    assert table.fixed_baseline.tolist() == [0, 0, 0, 0]
    assert table.matched_baseline.tolist() == [0, 1, 0, 1]
    for run in table.runs[2:]:
        assert run.calibration.fluid.bulk_modulus == 551e6
        assert run.calibration.leakage.internal_flow == 2e-6


def test_baselines_that_the_sweep_lacks_are_added_after_it():
    table = table_of(
        "sweep.grid.leakage.internal_coefficient=[1e-8]", "sweep.grid.fluid.bulk_modulus=[689 MPa]"
    )
    assert (table.n_swept, len(table.runs)) == (1, 3)
    fixed = table.runs[table.fixed_baseline[0]].parameters
    matched = table.runs[table.matched_baseline[0]].parameters
    assert (fixed.fluid.bulk_modulus, fixed.leakage.internal_coefficient) == (551e6, 0.0)
    assert (matched.fluid.bulk_modulus, matched.leakage.internal_coefficient) == (689e6, 0.0)


@pytest.mark.parametrize(
    "spellings",
    [
        ["leakage.external_coefficient=0", "leakage.internal_flow=0", "leakage.internal_coefficient=0"],
        ["fluid.bulk_modulus=689 MPa", "fluid={bulk_modulus: 6890 bar}", "fluid.bulk_modulus=689e6"],
    ],
)
def test_the_identity_follows_the_request_and_not_its_spelling(spellings):
    identities = {run_identity(table_of(setting, f"name=n{len(setting)}").runs[0]) for setting in spellings}
    assert len(identities) == 1
    assert (run_identity(table_of().runs[0]) in identities) == ("leakage" in spellings[0])


def test_only_what_differs_from_the_defaults_enters_the_identity():
    assert RunParameters().text() == "{}"
    stated = table_of("actuator.mass=12.3", "fluid.bulk_modulus=551 MPa", "friction.viscous=60").runs[0]
    sealed = '"leakage":{"internal_coefficient":0.0}'
    assert stated.parameters.text() == '{"friction":{"viscous":60.0},' + sealed + "}"


DEFAULTS = Path(__file__).parent / "defaults.json"


def test_defaults_change_with_the_physics_version_alone():
    """Identities leave defaults out: with HYDROFDI_WRITE_GOLDEN=1 the present ones are written down."""
    present = {name: RunRequest().value(name) for name in parameter_names()}
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        known = {"physics_version": PHYSICS_VERSION, "defaults": present}
        DEFAULTS.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    known = json.loads(DEFAULTS.read_text(encoding="utf-8"))
    assert known["physics_version"] == PHYSICS_VERSION, "write the defaults of the new version down"
    changed = {name for name, value in known["defaults"].items() if present.get(name) != value}
    assert not changed, "a default that changes makes stored runs wrong: raise PHYSICS_VERSION"
    assert present.keys() == known["defaults"].keys(), "write the new parameter's default down"


def test_an_impossible_combination_names_the_point():
    with pytest.raises(ConfigError, match=r"at record.step = 0.3 ms.*not a multiple"):
        table_of("sweep.grid.record.step=[0.1 ms, 0.3 ms]")


def load(tmp_path, text):
    file = tmp_path / "experiment.yaml"
    file.write_text(text)
    return load_experiment(file)


def swept(tmp_path, sweep):
    """Values of the swept parameters, point by point."""
    table = expand_runs(load(tmp_path, f"sweep:\n{sweep}"))
    return [tuple(run.parameters.value(name) for name in table.axes) for run in table.runs[: table.n_swept]]


@pytest.mark.parametrize(
    ("block", "points"),
    [
        (
            "  grid: {friction.viscous: [1, 2]}\n"
            "  zip: {friction.coulomb: [160, 200], friction.breakaway: [200, 250]}\n",
            [(1, 160, 200), (1, 200, 250), (2, 160, 200), (2, 200, 250)],
        ),
        (
            "  union:\n    - grid: {friction.viscous: [1, 2]}\n    - zip: {friction.coulomb: [160]}\n",
            [(1, 200), (2, 200), (50, 160)],  # a block leaves nominal what it does not name
        ),
        (
            "  grid: {friction.viscous: [1]}\n  union:\n"
            "    - union: [{grid: {friction.coulomb: [10]}}, {grid: {friction.coulomb: [20, 30]}}]\n"
            "      where: friction.coulomb != 20\n",
            [(1, 10), (1, 30)],
        ),
        (
            "  union: [{grid: {friction.viscous: [1, 2]}}, {grid: {friction.viscous: [2, 3]}}]\n",
            [(1,), (2,), (3,)],
        ),
        ("  grid: {measurement.seed: {arange: [0, 4, 1]}}\n", [(0,), (1,), (2,), (3,)]),
    ],
)
def test_blocks_multiply_unite_and_nest_and_equal_points_are_one_run(tmp_path, block, points):
    assert swept(tmp_path, block) == points


@pytest.mark.parametrize(
    ("generator", "values"),
    [
        ("{linspace: [551 MPa, 0.827 GPa, 3]}", [551e6, 689e6, 827e6]),
        ("{logspace: [1 MPa, 100 MPa, 3]}", [1e6, 1e7, 1e8]),
        ("{arange: [1 MPa, 2 MPa, 0.25 MPa]}", [1e6, 1.25e6, 1.5e6, 1.75e6]),
        ("{arange: [0.1, 0.4, 0.1]}", [0.1, 0.2, 0.3]),
    ],
)
def test_generators_of_values(tmp_path, generator, values):
    points = swept(tmp_path, f"  grid: {{fluid.bulk_modulus: {generator}}}\n")
    np.testing.assert_allclose([point[0] for point in points], values, rtol=1e-12)


@pytest.mark.parametrize(
    "condition",
    [
        f"friction.viscous > {'9' * 400}",
        "'a' * 999999999 == 'b'",
        "friction.law < 3",
        "friction.law * measurement.seed == 'b'",
        "-friction.law == 'b'",
        "friction.viscous > 5",
    ],
)
def test_a_condition_that_takes_text_for_a_number_or_selects_no_point_is_a_mistake(tmp_path, condition):
    text = f'sweep: {{grid: {{measurement.seed: [999999999], friction.viscous: [1]}}, where: "{condition}"}}'
    with pytest.raises(ConfigError) as refused:
        expand_runs(load(tmp_path, text))
    (mistake,) = refused.value.mistakes
    assert mistake.where.startswith("sweep")
    assert "\n" not in str(refused.value)


SAMPLE = "  sample: {{method: {}, count: {}, seed: {}, over: {}}}\n"


@pytest.mark.parametrize("method", ["sobol", "lhs", "random"])
def test_samples_are_seeded_and_stay_in_their_range(tmp_path, method):
    over = "{fluid.bulk_modulus: {uniform: [551 MPa, 827 MPa]}, actuator.mass: {normal: [12.3 kg, 0.6 kg]}}"
    points = np.array(swept(tmp_path, SAMPLE.format(method, 64, 7, over)))
    assert np.array_equal(points, swept(tmp_path, SAMPLE.format(method, 64, 7, over)))
    assert not np.array_equal(points, swept(tmp_path, SAMPLE.format(method, 64, 8, over)))
    assert ((points[:, 0] >= 551e6) & (points[:, 0] <= 827e6)).all()
    assert abs(points[:, 1].mean() - 12.3) < 0.3
    if method != "random":
        strata = np.floor((points[:, 0] - 551e6) / 276e6 * 64)
        assert len(set(strata)) == 64
    choices = swept(tmp_path, SAMPLE.format(method, 64, 7, "{actuator.mass: {choice: [12, 13]}}"))
    assert {*choices} == {(12.0,), (13.0,)}


def test_conditions_compare_compute_and_combine():
    values = {"a.b": 3.0, "c.d": 4.0, "e.f": None, "g.h": "db8"}
    for text, holds in {
        "a.b < c.d": True,
        "a.b + 1 >= c.d": True,
        "a.b * 2 == 6 and not c.d < 0": True,
        "1 < a.b < c.d": True,
        "1 < a.b < 2": False,
        "a.b > 5 or (c.d > 3 and a.b != 4)": True,
        "-a.b < 0": True,
        "e.f > 0": False,
        "e.f <= 0": False,
        "c.d / 0 > 1": False,
        "a.b < '4 mm'": False,
        "a.b > '4 mm'": True,
        "g.h == 'db8'": True,
        "a.b - 1 - 1 == 1": True,
        "12 / a.b / 2 == 2": True,
    }.items():
        assert parse_condition(text).holds(values) is holds, text


NO_CONDITIONS = """
a.b >
> 1
(a.b
a.b == 'x
a;b
a.b if c.d else 1
f(a.b) > 0
a.b[0] > 0
a.b ** 2 > 0
a.b in c.d
True
1j > 0"""


@pytest.mark.parametrize("text", [*NO_CONDITIONS.splitlines(), "(" * 5000, "-" * 99999 + "1"])
def test_what_is_no_condition_is_refused(text):
    with pytest.raises(ValueError, match="condition"):
        parse_condition(text)


def test_later_files_win_and_mistakes_are_those_of_their_own_file(tmp_path):
    base, top = tmp_path / "base.yaml", tmp_path / "top.yaml"
    base.write_text(
        "name: base\nfluid: {bulk_modulus: 600 MPa}\nfriction: {viscous: 10, coulomb: 11}\n"
        "leakage: {internal_coefficient: 1e-9}\n"
    )
    top.write_text("extends: base.yaml\nfriction: {viscous: 20}\nleakage: {internal_flow: 1 L/min}\n")
    experiment = load_experiment(top, ["fluid.bulk_modulus=700 MPa"])
    assert (experiment.name, experiment.fluid.bulk_modulus) == ("base", 700e6)
    assert (experiment.friction.viscous, experiment.friction.coulomb) == (20.0, 11.0)
    assert (experiment.leakage.internal_coefficient, experiment.leakage.internal_flow) == (None, 1 / 60000)
    base.write_text("\nfluid: {bulk_modulus: -1}\n")
    with pytest.raises(ConfigError, match=r"base\.yaml:2: fluid\.bulk_modulus: "):
        load_experiment(top)


@pytest.mark.parametrize(
    "block",
    [
        "grid: {fluid.bulk_modulus: {linspce: [1, 2, 3]}}",
        "grid: {fluid.bulk_modulus: {linspace: [1, 2, 2.5]}}",
        "grid: {fluid.bulk_modulus: {logspace: [-1, 2, 3]}}",
        "grid: {fluid.bulk_modulus: {arange: [1, 2, 0]}}",
        "grid: {fluid.bulk_modulus: {arange: [1, 2, 1 kg]}}",
        "grid: {measurement.seed: {linspace: [0, 5, 3]}}",
        "grid: {fluid.bulk_modulus: '551 MPa:827:4'}",
        "sample: {count: 0, over: {fluid.bulk_modulus: {uniform: [1, 2]}}}",
        "sample: {count: 2, over: {fluid.bulk_modulus: {uniform: [2, 1]}}}",
        "sample: {count: 2, over: {fluid.bulk_modulus: {normal: [2, -1]}}}",
        "sample: {count: 2, over: {fluid.bulk: {uniform: [1, 2]}}}",
        "zip: {friction.coulomb: [1, 2], friction.viscous: [1]}",
        "where: 'friction.viscos > 1', grid: {friction.viscous: [1]}",
        "where: 'friction.viscous >', grid: {friction.viscous: [1]}",
        "where: '__import__(\"os\")', grid: {friction.viscous: [1]}",
        "where: \"friction.viscous < '150 MPa'\", grid: {friction.viscous: [1]}",
        "grid: {friction.viscous: [1]}, zip: {friction.viscous: [2]}",
    ],
)
def test_mistakes_in_a_block_are_reported_with_their_place(tmp_path, block):
    with pytest.raises(ConfigError, match=r"^\S*experiment\.yaml:1: sweep"):
        load(tmp_path, f"sweep: {{{block}}}")


LARGE_SWEEPS_EBM = "sweep.grid.fluid.bulk_modulus={linspace: [500 MPa, 900 MPa, %d]}"
VISCOUS = "sweep.grid.friction.viscous={linspace: [10, 100, %d]}"
FLOW = "leakage.internal_flow=0.5 L/min"


@pytest.fixture
def memory():
    """Held and largest memory since the beginning of a test [B]."""
    tracemalloc.start()
    yield tracemalloc.get_traced_memory
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("settings", "count"),
    [
        ([LARGE_SWEEPS_EBM % 10_000, VISCOUS % 1000], "10,000,000"),
        ([LARGE_SWEEPS_EBM % 1000, VISCOUS % 1000, "sweep.zip.friction.coulomb=[160, 200]"], "2,000,000"),
        ([LARGE_SWEEPS_EBM % 1000, "ensemble.sample={count: 1001, over: {friction.viscous: {uniform: [1, 2]}}}"], "1,001,000"),
    ],
)  # fmt: skip
def test_a_sweep_that_is_too_large_is_refused_with_its_size_before_it_takes_memory(settings, count, memory):
    experiment = load_experiment(None, settings)
    before, _ = memory()
    tracemalloc.reset_peak()
    with pytest.raises(ConfigError, match=f"sweep: {count} runs exceed the limit of 1,000,000 per sweep"):
        expand_runs(experiment)
    assert memory()[1] - before < 1e6


def test_points_are_counted_block_by_block():
    part = "{grid: {friction.coulomb: [1, 2, 3]}, zip: {valve.lap: [0, 1e-5]}}"
    settings = [
        LARGE_SWEEPS_EBM % 7,
        f"sweep.union=[{part}, {{sample: {{count: 5, over: {{actuator.mass: {{choice: [9, 10]}}}}}}}}]",
    ]
    assert count_points(load_experiment(None, settings).sweep) == 7 * (3 * 2 + 5)
    assert count_points(load_experiment().sweep) == 1


def test_a_hundred_thousand_runs_share_what_they_have_in_common(memory):
    table = table_of(LARGE_SWEEPS_EBM % 300, VISCOUS % 300, FLOW)
    held, most = memory()
    assert len(table.runs) == 2 * 90_000 + 300
    assert held / len(table.runs) < 100, "bytes per run"
    assert most / len(table.runs) < 500, "bytes per run"
    assert len({id(run.parameters.friction) for run in table.runs[:600]}) == 300
    assert table.runs.solutions() == {"flows": 1, "conditions": 300, "total": 300}


@pytest.mark.parametrize(
    "settings",
    [
        [LARGE_SWEEPS_EBM % 3, VISCOUS % 4, FLOW, "baseline.friction.coulomb=150"],
        [LARGE_SWEEPS_EBM % 2, "sweep.grid.measurement.seed=[1, 2]", "pressure_1_sensor.noise=1 kPa", FLOW],
        ["sweep.grid.leakage.internal_flow=[0, 1e-5]", "ensemble.grid.friction.law=[smooth, lugre]"],
        [],
    ],
)
def test_runs_made_together_are_those_made_one_by_one(settings):
    experiment = load_experiment(None, settings)
    table = expand_runs(experiment)
    assert run_identities(table.runs) == tuple(run_identity(run) for run in table.runs)
    assert len(set(run_identities(table.runs))) == len(table.runs)
    for position, run in enumerate(table.runs):
        healthy = run.parameters.with_values(experiment.baseline)
        fixed = table.runs[int(table.fixed_baseline[position])].parameters
        assert fixed.fluid == healthy.fluid
        assert fixed.friction == healthy.friction
        assert not fixed.leakage.internal_flow
        matched = table.runs[int(table.matched_baseline[position])].parameters
        assert matched.with_valid_sections({"leakage": run.parameters.leakage}) == run.parameters


def test_values_slices_and_distinct_runs_are_those_of_the_runs():
    table = table_of(LARGE_SWEEPS_EBM % 5, VISCOUS % 3, FLOW)
    runs = list(table.runs)
    for name in ("fluid.bulk_modulus", "friction.viscous", "actuator.mass", "leakage.internal_flow"):
        assert table.runs.values(name) == [run.parameters.value(name) for run in runs]
    assert [run.parameters for run in table.runs[4:20:3]] == [run.parameters for run in runs[4:20:3]]
    assert table.runs[-1].parameters == runs[-1].parameters
    assert len(list(table.runs.distinct("fluid"))) == 6, "with that of the baseline"
    assert len(list(table.runs.distinct("fluid", "friction"))) == 18
    with pytest.raises(IndexError):
        table.runs[len(runs)]


def test_distinct_rows_of_many_columns_do_not_overflow():
    columns = [np.random.default_rng(k).permutation(70_000).astype(np.int32) for k in range(6)]
    first, inverse = distinct_rows([*columns, *columns], 70_000)
    assert np.array_equal(first, np.arange(70_000))
    assert np.array_equal(inverse, first)
