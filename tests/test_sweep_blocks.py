"""Sweep blocks, conditions, generators, files that extend others, and the schema."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.config import expand_runs, load_experiment
from hydrofdi.config.sweeps.condition import parse_condition
from hydrofdi.errors import ConfigError

ROOT = Path(__file__).parent.parent


def load(tmp_path, text):
    file = tmp_path / "experiment.yaml"
    file.write_text(text)
    return load_experiment(file)


def swept(tmp_path, sweep):
    """Values of the swept parameters, point by point."""
    experiment = load(tmp_path, f"sweep:\n{sweep}")
    table = expand_runs(experiment)
    return [tuple(run.parameters.value(name) for name in table.axes) for run in table.runs[: table.n_swept]]


def test_blocks_beside_each_other_multiply_and_the_last_varies_fastest(tmp_path):
    points = swept(
        tmp_path,
        "  grid: {friction.viscous: [1, 2]}\n"
        "  zip: {friction.coulomb: [160, 200], friction.breakaway: [200, 250]}\n",
    )
    assert points == [(1, 160, 200), (1, 200, 250), (2, 160, 200), (2, 200, 250)]


def test_a_union_concatenates_and_leaves_nominal_what_a_block_does_not_name(tmp_path):
    points = swept(
        tmp_path,
        "  union:\n    - grid: {friction.viscous: [1, 2]}\n    - zip: {friction.coulomb: [160]}\n",
    )
    assert points == [(1, 200), (2, 200), (50, 160)]


def test_blocks_nest(tmp_path):
    points = swept(
        tmp_path,
        "  grid: {friction.viscous: [1]}\n  union:\n"
        "    - union: [{grid: {friction.coulomb: [10]}}, {grid: {friction.coulomb: [20, 30]}}]\n"
        "      where: friction.coulomb != 20\n",
    )
    assert points == [(1, 10), (1, 30)]


def test_equal_points_are_one_run(tmp_path):
    union = "  union: [{grid: {friction.viscous: [1, 2]}}, {grid: {friction.viscous: [2, 3]}}]\n"
    assert swept(tmp_path, union) == [(1,), (2,), (3,)]


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


def test_generators_of_whole_numbers_give_whole_numbers(tmp_path):
    points = swept(tmp_path, "  grid: {measurement.seed: {arange: [0, 4, 1]}}\n")
    assert points == [(0,), (1,), (2,), (3,)]


@pytest.mark.parametrize(
    "condition",
    [
        f"friction.viscous > {'9' * 400}",
        "'a' * 999999999 == 'b'",
        "friction.viscous > 'x' * 3",
        "friction.law < 3",
        "friction.law * 999999999 > 1",
        "friction.law * measurement.seed == 'b'",
        "measurement.seed * friction.law == 'b'",
        "-friction.law == 'b'",
    ],
)
def test_a_condition_that_takes_text_for_a_number_is_a_mistake(tmp_path, condition):
    text = f'sweep: {{grid: {{measurement.seed: [999999999], friction.viscous: [1]}}, where: "{condition}"}}'
    with pytest.raises(ConfigError) as refused:
        expand_runs(load(tmp_path, text))
    (mistake,) = refused.value.mistakes
    assert mistake.where == "sweep.where"
    assert "\n" not in str(refused.value)


def test_an_empty_selection_is_a_mistake(tmp_path):
    experiment = load(tmp_path, "sweep: {grid: {friction.viscous: [1, 2]}, where: friction.viscous > 5}")
    with pytest.raises(ConfigError, match="no point satisfies"):
        expand_runs(experiment)


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


def test_choices_and_loguniform_are_drawn(tmp_path):
    over = "{fluid.bulk_modulus: {choice: [551 MPa, 827 MPa]}, friction.viscous: {loguniform: [1, 100]}}"
    points = np.array(swept(tmp_path, SAMPLE.format("sobol", 64, 0, over)))
    assert set(points[:, 0]) == {551e6, 827e6}
    assert np.sum(points[:, 1] < 10.0) == 32


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


@given(
    st.integers(-9, 9), st.integers(-9, 9), st.integers(-9, 9), st.sampled_from("+-*"), st.sampled_from("+-*")
)
def test_arithmetic_follows_the_usual_precedence(a, b, c, first, second):
    text = f"{a} {first} {b} {second} {c}".replace("- -", "- (0-1)*").replace("+ -", "+ (0-1)*")
    expected = eval(text)
    assert parse_condition(f"{text} == ({expected})".replace("(-", "(0-")).holds({})


NO_CONDITIONS = """
a.b >
> 1
(a.b
a.b)
a.b ! 1
a.b == 'x
1 2
a;b
a.b if c.d else 1
f(a.b) > 0
a.b[0] > 0
a.b ** 2 > 0
a.b in c.d
lambda: 1
True
1j > 0"""


@pytest.mark.parametrize("text", [*NO_CONDITIONS.splitlines(), "(" * 5000, "-" * 99999 + "1"])
def test_what_is_no_condition_is_refused(text):
    with pytest.raises(ValueError, match="condition"):
        parse_condition(text)


def test_later_files_win_and_settings_win_over_all(tmp_path):
    (tmp_path / "base.yaml").write_text(
        "name: base\nfluid: {bulk_modulus: 600 MPa}\nfriction: {viscous: 10, coulomb: 11}\n"
        "leakage: {internal_coefficient: 1e-9}\n"
    )
    (tmp_path / "top.yaml").write_text(
        "extends: base.yaml\nfriction: {viscous: 20}\nleakage: {internal_flow: 1 L/min}\n"
    )
    experiment = load_experiment(tmp_path / "top.yaml", ["fluid.bulk_modulus=700 MPa"])
    assert experiment.name == "base"
    assert experiment.fluid.bulk_modulus == 700e6
    assert (experiment.friction.viscous, experiment.friction.coulomb) == (20.0, 11.0)
    assert (experiment.leakage.internal_coefficient, experiment.leakage.internal_flow) == (None, 1 / 60000)


def test_a_mistake_in_an_extended_file_is_reported_with_that_file(tmp_path):
    (tmp_path / "base.yaml").write_text("\nfluid: {bulk_modulus: -1}\n")
    (tmp_path / "top.yaml").write_text("extends: base.yaml\n")
    with pytest.raises(ConfigError, match=r"base\.yaml:2: fluid\.bulk_modulus: must be greater than 0"):
        load_experiment(tmp_path / "top.yaml")


def test_every_config_names_the_schema_and_loads():
    for file in sorted((ROOT / "configs").glob("*.yaml")):
        assert file.read_text().splitlines()[0] == "# yaml-language-server: $schema=schema.json"
        expand_runs(load_experiment(file))


@pytest.mark.parametrize(
    "block",
    [
        "grid: {fluid.bulk_modulus: {linspce: [1, 2, 3]}}",
        "grid: {fluid.bulk_modulus: {linspace: [1, 2, 2.5]}}",
        "grid: {fluid.bulk_modulus: {logspace: [-1, 2, 3]}}",
        "grid: {fluid.bulk_modulus: {arange: [1, 2, 0]}}",
        "grid: {fluid.bulk_modulus: {arange: [1, 2, 1 kg]}}",
        "grid: {measurement.seed: {linspace: [0, 5, 3]}}",
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
