# ruff: noqa: E501
"""Expansion of sweeps: blocks, conditions, identities, large ones."""

import hashlib
import json
import tracemalloc

import numpy as np
import pytest

from hydrofdi.config import RunParameters, expand_runs, load_experiment
from hydrofdi.config.request import RunRequest, parameter_names
from hydrofdi.config.runs import (
    PHYSICS_VERSION,
    record_identities,
    record_identity,
    run_identities,
    run_identity,
)
from hydrofdi.config.sweep import count_points, distinct_rows, parse_condition
from hydrofdi.errors import ConfigError

LEAKAGE = "sweep.grid.leakage.internal_flow=[0 L/min, 0.12 L/min]"
EBM = "sweep.grid.fluid.bulk_modulus=[551 MPa, 689 MPa]"


def table_of(*settings):
    return expand_runs(load_experiment(None, settings))


def test_a_grid_is_all_combinations_with_the_last_axis_varying_fastest_and_its_own_baselines():
    table = table_of(LEAKAGE, EBM, "leakage.external_coefficient=1e-13")
    points = [(run.parameters.leakage.internal_flow, run.parameters.fluid.bulk_modulus) for run in table.runs]
    assert points == [(None, 551e6), (None, 689e6), (2e-6, 551e6), (2e-6, 689e6)]
    assert table.n_swept == 4
    assert table.fixed_baseline.tolist() == [0, 0, 0, 0]
    assert table.matched_baseline.tolist() == [0, 1, 0, 1]
    assert {run.parameters.leakage.external_coefficient for run in table.runs} == {1e-13}
    for run in table.runs[2:]:
        assert run.calibration.fluid.bulk_modulus == 551e6
        assert run.calibration.leakage.internal_flow == 2e-6


@pytest.mark.parametrize("spellings", [
    ["leakage.external_coefficient=0", "leakage.internal_flow=0", "leakage.internal_coefficient=0"],
    ["fluid.bulk_modulus=689 MPa", "fluid={bulk_modulus: 6890 bar}", "fluid.bulk_modulus=689e6"],
])  # fmt: skip
def test_the_identity_follows_what_differs_from_the_defaults_and_not_its_spelling(spellings):
    identities = {run_identity(table_of(setting, f"name=n{len(setting)}").runs[0]) for setting in spellings}
    assert len(identities) == 1
    assert (run_identity(table_of().runs[0]) in identities) == ("leakage" in spellings[0])
    assert RunParameters().text() == "{}"
    stated = table_of("actuator.mass=12.3", "fluid.bulk_modulus=551 MPa", "friction.viscous=60").runs[0]
    sealed = '"leakage":{"internal_coefficient":0.0}'
    assert stated.parameters.text() == '{"friction":{"viscous":60.0},' + sealed + "}"


DEFAULTS = {4: "270bf3718f59bac9"}
"""Version of the physics → digest of all defaults: identities leave defaults out. The schema shows each."""


def test_defaults_change_with_the_physics_version_alone():
    defaults = {name: RunRequest().value(name) for name in parameter_names()}
    digest = hashlib.sha256(json.dumps(defaults).encode()).hexdigest()[:16]
    assert digest == DEFAULTS.get(PHYSICS_VERSION), "only a new parameter changes it without a new version"


def test_an_impossible_combination_names_the_point():
    with pytest.raises(ConfigError, match=r"at record.step = 0.3 ms.*not a multiple"):
        table_of("sweep.grid.record.step=[0.1 ms, 0.3 ms]")


def load(tmp_path, text):
    file = tmp_path / "experiment.yaml"
    file.write_text(text)
    return load_experiment(file)


def swept(tmp_path, sweep):
    """Values of the swept parameters, point by point."""
    table = expand_runs(load(tmp_path, f"sweep: {{{sweep}}}"))
    return [tuple(run.parameters.value(name) for name in table.axes) for run in table.runs[: table.n_swept]]


@pytest.mark.parametrize(("block", "points"), [
    ("grid: {friction.viscous: [1, 2]}, zip: {friction.coulomb: [160, 200], friction.breakaway: [200, 250]}",
     [(1, 160, 200), (1, 200, 250), (2, 160, 200), (2, 200, 250)]),
    ("union: [{grid: {friction.viscous: [1, 2]}}, {zip: {friction.coulomb: [160]}}]",
     [(1, 200), (2, 200), (50, 160)]),  # a block leaves nominal what it does not name
    ("grid: {friction.viscous: [1]}, union: [{union: [{grid: {friction.coulomb: [10]}}, "
     "{grid: {friction.coulomb: [20, 30]}}], where: friction.coulomb != 20}]", [(1, 10), (1, 30)]),
    ("union: [{grid: {friction.viscous: [1, 2]}}, {grid: {friction.viscous: [2, 3]}}]", [(1,), (2,), (3,)]),
    ("grid: {measurement.seed: {arange: [0, 4, 1]}}", [(0,), (1,), (2,), (3,)]),
])  # fmt: skip
def test_blocks_multiply_unite_and_nest_and_equal_points_are_one_run(tmp_path, block, points):
    assert swept(tmp_path, block) == points


def test_conditions_compare_compute_and_combine():
    values = {"a.b": 3.0, "c.d": 4.0, "e.f": None, "g.h": "db8"}
    true = [
        "a.b < c.d", "a.b + 1 >= c.d", "a.b * 2 == 6 and not c.d < 0", "1 < a.b < c.d", "-a.b < 0", "a.b > '4 mm'",
        "a.b > 5 or (c.d > 3 and a.b != 4)", "g.h == 'db8'", "a.b - 1 - 1 == 1", "12 / a.b / 2 == 2",
    ]  # fmt: skip
    false = ["1 < a.b < 2", "e.f > 0", "e.f <= 0", "c.d / 0 > 1", "a.b < '4 mm'"]
    assert [parse_condition(text).holds(values) for text in true + false] == [True] * 10 + [False] * 5


NO_CONDITIONS = [
    "", "a.b >", "> 1", "(a.b", "a.b == 'x", "a;b", "a.b if c.d else 1", "f(a.b) > 0", "a.b[0] > 0", "a.b ** 2 > 0",
    "a.b in c.d", "True", "1j > 0", "(" * 5000, "-" * 99999 + "1",
]  # fmt: skip
NO_POINTS = [
    f"friction.viscous > {'9' * 400}", "'a' * 999999999 == 'b'", "friction.law < 3", "-friction.law == 'b'",
    "friction.law * measurement.seed == 'b'", "friction.viscous > 5",
]  # fmt: skip


def test_what_is_no_condition_takes_text_for_a_number_or_selects_no_point_is_refused():
    for text in NO_CONDITIONS:
        with pytest.raises(ValueError, match="condition"):
            parse_condition(text)
    for text in NO_POINTS:
        grid = {"measurement.seed": [999999999], "friction.viscous": [1]}
        with pytest.raises(ConfigError) as refused:
            expand_runs(load_experiment({"sweep": {"grid": grid, "where": text}}))
        (mistake,) = refused.value.mistakes
        assert mistake.where.startswith("sweep"), text


def test_later_files_win_and_mistakes_are_those_of_their_own_file(tmp_path):
    base, top = tmp_path / "base.yaml", tmp_path / "top.yaml"
    base.write_text(
        "name: base\nfriction: {viscous: 10, coulomb: 11}\nleakage: {internal_coefficient: 1e-9}\n"
    )
    top.write_text("extends: base.yaml\nfriction: {viscous: 20}\nleakage: {internal_flow: 1 L/min}\n")
    loaded = load_experiment(top, ["fluid.bulk_modulus=700 MPa"])
    assert (loaded.name, loaded.fluid.bulk_modulus) == ("base", 700e6)
    assert (loaded.friction.viscous, loaded.friction.coulomb) == (20.0, 11.0)
    assert (loaded.leakage.internal_coefficient, loaded.leakage.internal_flow) == (None, 1 / 60000)
    base.write_text("\nfluid: {bulk_modulus: -1}\n")
    with pytest.raises(ConfigError, match=r"base\.yaml:2: fluid\.bulk_modulus: "):
        load_experiment(top)


MISTAKES = """\
grid: {fluid.bulk_modulus: {linspce: [1, 2, 3]}}
grid: {fluid.bulk_modulus: {linspace: [1, 2, 2.5]}}
grid: {fluid.bulk_modulus: {logspace: [-1, 2, 3]}}
grid: {fluid.bulk_modulus: {arange: [1, 2, 0]}}
grid: {fluid.bulk_modulus: {arange: [1, 2, 1 kg]}}
grid: {measurement.seed: {linspace: [0, 5, 3]}}
grid: {fluid.bulk_modulus: '551 MPa:827:4'}
grid: {friction.viscous: [1]}, zip: {friction.viscous: [2]}
zip: {friction.coulomb: [1, 2], friction.viscous: [1]}
where: 'friction.viscos > 1', grid: {friction.viscous: [1]}
where: '__import__("os")', grid: {friction.viscous: [1]}
where: "friction.viscous < '150 MPa'", grid: {friction.viscous: [1]}
sample: {count: 0, over: {fluid.bulk_modulus: {uniform: [1, 2]}}}""".splitlines()
DRAWS = [
    "fluid.bulk_modulus: {uniform: [2, 1]}", "fluid.bulk_modulus: {normal: [2, -1]}", "supply.presure: {uniform: ±5 %}",
    "valve.lap: {uniform: ±20 %}", "supply.pressure: {uniform: ±0.2 mm}", "supply.pressure: {uniform: ±0 MPa}",
    "supply.pressure: {loguniform: ±5 %}", "friction.law: {uniform: ±5 %}", "input.seed: {uniform: [0, 9]}",
    "friction.viscous: {truncated_normal: [50, 1]}", "friction.viscous: {truncated_normal: [50, 0, 1, 2]}",
    "friction.viscous: {lognormal: [50, 1]}", "friction.viscous: {lognormal: [50, 2 kg]}",
    "friction.viscous: {triangular: [1, 3, 2]}", "friction.viscous: {trianglar: [1, 2, 3]}",
    "leakage.internal_flow: {uniform: ±5 %}", "supply.pressure: {integers: [1, 9]}", "input.seed: {integers: [9, 1]}",
]  # fmt: skip


@pytest.mark.parametrize("block", [*MISTAKES, *(f"sample: {{count: 2, over: {{{draw}}}}}" for draw in DRAWS)])
def test_mistakes_in_a_block_are_reported_with_their_place(tmp_path, block):
    with pytest.raises(ConfigError, match=r"^\S*experiment\.yaml:1: sweep") as refused:
        load(tmp_path, f"sweep: {{{block}}}")
    assert {each.origin for each in refused.value.mistakes} == {f"{tmp_path / 'experiment.yaml'}:1"}


MODULI = "sweep.grid.fluid.bulk_modulus={linspace: [500 MPa, 900 MPa, %d]}"
VISCOUS = "sweep.grid.friction.viscous={linspace: [10, 100, %d]}"
FLOW = "leakage.internal_flow=0.5 L/min"


@pytest.fixture
def memory():
    """Held and largest memory since the beginning of a test [B]."""
    tracemalloc.start()
    yield tracemalloc.get_traced_memory
    tracemalloc.stop()


@pytest.mark.parametrize(("settings", "count"), [
    ([MODULI % 10_000, VISCOUS % 1000], "10,000,000"),
    ([MODULI % 1000, VISCOUS % 1000, "sweep.zip.friction.coulomb=[160, 200]"], "2,000,000"),
    ([MODULI % 1000, "ensemble.sample={count: 1001, over: {friction.viscous: {uniform: [1, 2]}}}"], "1,001,000"),
])  # fmt: skip
def test_a_sweep_that_is_too_large_is_refused_with_its_size_before_it_takes_memory(settings, count, memory):
    experiment = load_experiment(None, settings)
    before, _ = memory()
    tracemalloc.reset_peak()
    with pytest.raises(ConfigError, match=f"sweep: {count} runs exceed the limit of 1,000,000 per sweep"):
        expand_runs(experiment)
    assert memory()[1] - before < 1e6


def test_a_hundred_thousand_runs_share_what_they_have_in_common(memory):
    table = table_of(MODULI % 300, VISCOUS % 300, FLOW)
    held, most = memory()
    assert len(table.runs) == 2 * 90_000 + 300
    assert held / len(table.runs) < 100, "bytes per run"
    assert most / len(table.runs) < 500, "bytes per run"
    assert len({id(run.parameters.friction) for run in table.runs[:600]}) == 300
    assert table.runs.solutions() == {"flows": 1, "conditions": 300, "total": 300}


PART = "{grid: {friction.coulomb: [1, 2, 3]}, zip: {valve.lap: [0, 1e-5]}}"
DRAWN = "{sample: {count: 5, over: {actuator.mass: {choice: [9, 10]}}}}"


@pytest.mark.parametrize(("settings", "n_point"), [
    ([MODULI % 3, VISCOUS % 4, FLOW, "baseline.friction.coulomb=150"], 12),
    ([MODULI % 2, "sweep.grid.measurement.seed=[1, 2]", "pressure_1_sensor.noise=1 kPa", FLOW], 4),
    (["sweep.grid.leakage.internal_flow=[0, 1e-5]", "ensemble.grid.friction.law=[smooth, lugre]"], 2),
    ([MODULI % 2, f"sweep.union=[{PART}, {DRAWN}]"], 2 * (3 * 2 + 5)),
    (["sweep.grid.wavelet.levels=[4, 5]", "sweep.grid.analysis.discard=[0 s, 1 period]", FLOW, "indicators=[dwt, modwt]"], 4),
    ([], 1),
])  # fmt: skip
def test_runs_made_together_are_those_made_one_by_one(settings, n_point):
    experiment = load_experiment(None, settings)
    assert count_points(experiment.sweep) == n_point
    table = expand_runs(experiment)
    assert run_identities(table.runs) == tuple(run_identity(run) for run in table.runs)
    assert record_identities(table.runs) == tuple(record_identity(run) for run in table.runs)
    assert len(set(run_identities(table.runs))) == len(table.runs)
    for position, run in enumerate(table.runs):
        healthy = run.parameters.with_values(experiment.baseline)
        fixed = table.runs[int(table.fixed_baseline[position])].parameters
        matched = table.runs[int(table.matched_baseline[position])].parameters
        assert (fixed.fluid, fixed.friction) == (healthy.fluid, healthy.friction)
        assert not fixed.leakage.internal_flow
        assert matched.with_valid_sections({"leakage": run.parameters.leakage}) == run.parameters


def test_values_slices_and_distinct_runs_are_those_of_the_runs():
    runs = table_of(MODULI % 5, VISCOUS % 3, FLOW).runs
    each = [run.parameters for run in runs]
    for name in ("fluid.bulk_modulus", "actuator.mass", "leakage.internal_flow"):
        assert runs.values(name) == [parameters.value(name) for parameters in each]
    assert [run.parameters for run in runs[4:20:3]] == each[4:20:3]
    assert runs[-1].parameters == each[-1]
    assert len(list(runs.distinct("fluid", "friction"))) == 18, "with those of the baseline"
    with pytest.raises(IndexError):
        runs[len(each)]


def test_distinct_rows_of_many_columns_do_not_overflow():
    columns = [np.random.default_rng(k).permutation(70_000).astype(np.int32) for k in range(6)]
    first, inverse = distinct_rows([*columns, *columns], 70_000)
    assert np.array_equal(first, np.arange(70_000))
    assert np.array_equal(inverse, first)
