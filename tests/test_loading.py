# ruff: noqa: E501
"""Experiment files: YAML, mistakes with their place, and suggestions."""

import json
import math
import os

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from hydrofdi.config import ExperimentConfig, load_experiment
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.selection import indicators_of
from hydrofdi.settings.files import dotted, parse_yaml, scalar


@pytest.mark.parametrize(("key", "meant"), [
    ("fluid.bulk", "'bulk_modulus'"), ("bulk", "'fluid.bulk_modulus'"), ("bore", ".piston_area'"),
    ("load.mass", "'actuator.mass'"), ("supplly", "'supply'"), ("ki", "'K_i'"), ("K_I", "'K_i'"),
    ("sweep.grid.fluid.bulk", "'fluid.bulk_modulus'"), ("sweep.grid.K_I", "'K_i'"),
    ("sweep.grid.leakage.coef", "'leakage.internal_coefficient'"),
    ("supply.watt", ""), ("a", ""), ("sweep.grid.fluid.a", ""),
])  # fmt: skip
def test_unknown_key_gets_the_key_that_it_means(key, meant):
    with pytest.raises(ConfigError) as error:
        load_experiment(settings=[f"{key}=[1]"])
    (told,) = [each.message for each in error.value.mistakes if each.message != "is missing"]
    assert meant in told
    assert ("did you mean" in told or "give" in told) == bool(meant)


@pytest.mark.parametrize(("key", "wrong", "told", "never"), [
    ("supply.pressure", "210", "'210 bar'", "MPa"), ("fluid.temperature_rise", "15", "'15 K'", "°C"),
    ("actuator.piston_area", "1963", "'1963 mm^2'", "'1963 m^2'"),
    ("actuator.inclination", 90.0, "90 deg; found 90 rad", "1.5"),
    ("fluid.bulk_modulus", "1754", "'1754 MPa'", "Pa' or 'k"),
    ("K_i", "0.1 L/min", "leakage.internal_flow", "kg"),
    ("sweep.grid.K_i", [0, "0.1 L/min"], "leakage.internal_flow", "kg"),
    ("sweep.grid.EBM", {"from": 1e8, "to": 2e8, "number": 3}, "did you mean 'num'", "'count'"),
])  # fmt: skip
def test_a_message_on_a_number_suggests_the_units_in_which_it_is_usual(key, wrong, told, never):
    with pytest.raises(ConfigError) as error:
        load_experiment(settings={key: wrong})
    assert told in str(error.value)
    assert never not in str(error.value)


BASE = """
name: press
study: {healthy: {fit: 9, test: 9}, faults: {leakage.internal_flow: [0.5 L/min], each: 2, fit: 0}}
indicators: {dwt: {levels: 3}, pressure_statistics: {}}
detection: {false_alarm_rate: 20 %}
"""
SWEPT = (
    "name: base\nsweep: {grid: {fluid.bulk_modulus: [551 MPa, 1 GPa], leakage.internal_flow: [0, 1 L/min]}}\n"
)


def test_null_removes_what_is_inherited_and_nothing_else(tmp_path) -> None:
    file = tmp_path / "own.yaml"
    (tmp_path / "base.yaml").write_text(BASE)
    (tmp_path / "swept.yaml").write_text(SWEPT)

    def own(text: str, *settings: str, base: str = "base") -> ExperimentConfig:
        file.write_text(f"extends: {base}.yaml\nname: own\n{text}")
        return load_experiment(file, settings)

    assert [*own("indicators: {dwt: null, modwt: {}}").indicators] == ["pressure_statistics", "modwt"]
    assert [*own("indicators: {dwt: null, pressure_statistics: null, modwt: {}}").indicators] == ["modwt"]
    assert "modwt" in own("indicators: {modwt: }").indicators, "it has no options, and is not inherited"
    plain = own("study: null\ndetection: null")
    assert plain.study is None
    assert plain.detection == own("", "detection=null").detection == load_experiment().detection
    left = own("sweep: {grid: {fluid.bulk_modulus: null}}", base="swept")
    assert left.sweep.names == ["leakage.internal_flow"]
    with pytest.raises(ConfigError, match=r"own\.yaml:3: sweep\.grid\.supply\.pressure"):
        own("sweep: {grid: {supply.pressure: null}}", base="swept")
    (tmp_path / "base.yaml").write_text("indicators: {dwt: {levels: 3}, pressure_statistics: {}}")
    file.write_text("extends: base.yaml\nindicators: {dwt: null}")
    assert [*indicators_of(str(file))] == ["pressure_statistics"]


LINES = [
    ("unknown key", "fluid:\n  bulk_moduluss: 1\n", "2: fluid.bulk_moduluss"),
    ("negative area", "actuator: {piston_area: -1 cm²}\n", "1: actuator.piston_area"),
    ("bool for a number", "actuator: {mass: true}\n", "1: actuator.mass"),
    ("nan", "actuator: {mass: .nan}\n", "1: actuator.mass"),
    ("huge integer", f"actuator: {{mass: {'9' * 6000}}}\n", "1: actuator.mass"),
    ("huge exponent", "actuator: {mass: 1 Gg^1000000000}\n", "1: actuator.mass"),
    ("duration", "record: {duration: 2.001 s}\n", "1: record"),
    ("endless duration", "record: {duration: 1e12 s}\n", "1: record"),
    ("short record", "record: {duration: 0.2 s}\n", "1: record.duration"),
    ("continuous wavelet", "wavelet: {name: morl}\n", "1: wavelet.name"),
    ("both leakages", "leakage: {internal_flow: 1, internal_coefficient: 1}\n", "1: leakage"),
    ("axis of no parameter", "sweep: {grid: {bulk: {linspace: [0, 1, 3]}}}\n", "1: sweep.grid.bulk"),
    ("axis with one end", "sweep: {grid: {EBM: {from: 1 GPa, num: 3}}}\n", "1: sweep.grid.fluid.bulk_modulus"),
    ("two names", "sweep:\n  grid:\n    EBM: [1 GPa]\n    beta: [2 GPa]\n", "4: sweep.grid.beta"),
    ("unequal units", "sweep:\n grid:\n  fluid.bulk_modulus:\n   - 551 MPa\n   - 2 s\n", "5: sweep.grid.fluid.bulk_modulus[1]"),
    ("baseline name", "baseline: {title: x}\n", "1: baseline.title"),
    ("name leaves the folder", "name: ../x\n", "1: name"),
    ("list for a section", "record: [1]\n", "1: record"),
    ("list for a file", "- 1\n", "1: "),
    ("key twice", "name: a\nname: b\n", "2: name: key given twice, first in line 1"),
    ("broken YAML", "a: 1\nrecord: {duration: 2 s\n", "3: not valid YAML"),
    ("tab", "run:\n\tduration: 2 s\n", "2: not valid YAML"),
    ("control character", b"name: a\x00\n", " not valid YAML"),
    ("HDF5", b"\x89HDF\0", " "),
    ("no UTF-8", b"name: caf\xe9\n", " is not a text file in UTF-8"),
    ("cycle", "actuator: &a {mass: *a}\n", " nested too deeply, or too large"),
    ("merge key", "actuator: &m {mass: 12}\n<<: *m\n", "2: <<"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), [case[1:] for case in LINES], ids=[case[0] for case in LINES])
def test_a_mistake_is_one_line_with_its_place(experiment_file, text, expected):
    config = experiment_file(text)
    with pytest.raises(ConfigError) as caught:
        load_experiment(config)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"{config}:{expected}")


SETTINGS = [
    "abc", "fluid.bulkmodulus=1", "fluid=1", "fluid.bulk_modulus=", "fluid.bulk_modulus=a: b: c",
    "fluid.bulk_modulus='689'", "sweep.grid.fluid.bulk_modulus=[1, 1 m]",
]  # fmt: skip


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_mistake_in_a_setting_names_the_setting(setting):
    with pytest.raises(ConfigError) as caught:
        load_experiment(None, [setting])
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"settings {setting}: ")


MANY = """\
name: ../up
actuator:
  mass: -1
  piston_area: 633 mm
fluid: {bulk_modulu: 551 MPa}
sweep: {grid: {friction.viscos: [1], fluid.bulk_modulus: [551 MPa, 3 s]}}
"""


def test_all_mistakes_of_a_file_are_reported_at_once_in_its_order(hydrofdi, experiment_file, tmp_path):
    config = experiment_file(MANY)
    result = hydrofdi("sweep", config, "--set", "input.period=1 kg")
    assert (result.returncode, result.stdout) == (2, "")
    setting, *lines = sorted(result.stderr.splitlines(), key=lambda line: "settings" not in line)
    assert setting.startswith("hydrofdi: settings input.period=1 kg: ")
    assert [line.removeprefix(f"hydrofdi: {config}:")[0] for line in lines] == ["1", "3", "4", "5", "6", "6"]
    assert os.listdir(tmp_path) == [config.name]


SHORT = ["simulate", "--set", "record.duration=2 s"]
BAD_COMMANDS = {
    "missing file": (["simulate", "missing.yaml"], "missing.yaml: no such file"),
    "unreachable leakage": ([*SHORT, "--set", "leakage.internal_flow=500 L/min"], "no K_i gives a mean leakage of 500 L/min"),
    "long name for a result": ([*SHORT, "--out", "a" * 300 + ".h5"], "aaa: File name too long"),
    "folder for a file": ([*SHORT, "--out", "."], "ends in .h5"),
    "no results": (["report"], "no experiment file in results/*; run 'hydrofdi sweep CONFIG' first"),
    "no HDF5": (["report", "file"], "file: is not a readable HDF5 file"),
    "unknown command": (["simulat"], "No such command 'simulat'"),
    "unknown option": (["simulate", "--foo"], "No such option: --foo"),
    "option of another name": (["sweep", "smoke", "--jobs", "2"], "'--workers'"),
    "ready configuration": (["init", "mine", "--from", "onlin"], "'online'"),
    "no workers": (["sweep", "smoke", "--workers", "0"], "workers: "),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "expected"), BAD_COMMANDS.values(), ids=BAD_COMMANDS)
def test_what_the_user_can_fix_is_one_line_and_exit_code_2(hydrofdi, tmp_path, arguments, expected):
    (tmp_path / "file").write_text("text\n")
    result = hydrofdi(*arguments)
    assert (result.returncode, result.stdout) == (2, "")
    (line,) = result.stderr.splitlines()
    assert line.startswith("hydrofdi: ")
    assert expected in line
    assert os.listdir(tmp_path) == ["file"]


SCALARS = {
    "1e-3": 1e-3, "7e6": 7e6, "1.": 1.0, ".5": 0.5, "-2": -2, "+3": 3, "017": 17, "true": True, "False": False,
    "null": None, "~": None, "": None, ".inf": math.inf,
}  # fmt: skip
TEXTS = ["12:30", "no", "yes", "on", "0o17", "1_000", "2024-01-01", "551 MPa"]


def test_scalars_follow_yaml_1_2():
    for text, value in (SCALARS | dict(zip(TEXTS, TEXTS, strict=True))).items():
        assert (scalar(text), type(scalar(text))) == (value, type(value)), text


def test_every_part_remembers_its_line_quoted_scalars_are_texts_and_aliases_what_they_name():
    source = parse_yaml("a: &x '633'\nb:\n  c: *x\n  d:\n    1\ne:\n  - 2\n  - 3\n", "f.yaml")
    assert source.data == {"a": "633", "b": {"c": "633", "d": 1}, "e": [2, 3]}
    lines = {("b", "c"): 1, ("b", "d"): 4, ("e", 1): 8, ("b", "missing"): 2}
    assert {path: source.origin(path) for path in lines} == {path: f"f.yaml:{n}" for path, n in lines.items()}
    assert dotted(("sweep", "grid", "fluid.bulk_modulus", 1)) == "sweep.grid.fluid.bulk_modulus[1]"


ENDLESS = {
    "cycle": "a: &x {b: *x}", "branching cycle": "&x [*x, *x]", "open brackets": "[" * 500, "deep": "[" * 500 + "]" * 500,
    "billion laughs": "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}' if i else 'x'] * 10)}]" for i in range(12)),
}  # fmt: skip


@pytest.mark.parametrize("text", ENDLESS.values(), ids=ENDLESS)
def test_endless_texts_end_in_a_mistake(text):
    source = parse_yaml(text, "f.yaml")
    assert (source.data, len(source.mistakes)) == (None, 1)


@example("!0")
@given(st.text(max_size=60))
def test_any_text_is_data_or_a_mistake_or_states_nothing(text):
    """Tags count for nothing, as in the reader."""
    source = parse_yaml(text, "f.yaml")
    if source.data is None and not source.mistakes:
        node = yaml.compose(text)
        assert node is None or node.value in ("", "~", "null", "Null", "NULL")


PLAIN = st.booleans() | st.integers(-(10**9), 10**9) | st.floats(allow_nan=False, allow_infinity=False)
KEYS = st.text("abcdefgh", min_size=1, max_size=4)


@given(
    st.recursive(
        PLAIN,
        lambda inner: st.lists(inner, min_size=1) | st.dictionaries(KEYS, inner, min_size=1),
        max_leaves=8,
    )
)
def test_json_is_read_as_it_was_written(data):
    assert parse_yaml(json.dumps(data), "f").data == data
