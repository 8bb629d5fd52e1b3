"""Bad input: every mistake is one line with its place, all at once; nothing is written or touched."""
# ruff: noqa: E501

import os
import shutil

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError


def mistakes(config=None, *settings):
    with pytest.raises(ConfigError) as caught:
        load_experiment(config, settings)
    return str(caught.value).splitlines()


def test_without_a_file_every_parameter_is_nominal():
    nominal = load_experiment()
    assert nominal.name == "nominal"
    assert nominal.fluid.bulk_modulus == 551e6
    assert nominal.wavelet.name == "db8"


def test_settings_win_over_the_file(experiment_file):
    config = experiment_file("fluid: {bulk_modulus: 689 MPa}\nsweep: {grid: {fluid.bulk_modulus: [1e9]}}\n")
    experiment = load_experiment(
        config, ["fluid.bulk_modulus=827 MPa", "sweep.grid.fluid.bulk_modulus=[551 MPa, 600 MPa]"]
    )
    assert experiment.fluid.bulk_modulus == 827e6
    assert experiment.sweep.grid == {"fluid.bulk_modulus": [551e6, 600e6]}


LINES = [
    ("unknown key", "fluid:\n  bulk_moduluss: 1\n", "2: fluid.bulk_moduluss"),
    ("unknown section", "fluids:\n  bulk_modulus: 1\n", "1: fluids"),
    ("negative area", "actuator: {piston_area: -1 cm²}\n", "1: actuator.piston_area"),
    ("bool for a number", "actuator: {mass: true}\n", "1: actuator.mass"),
    ("nan", "actuator: {mass: .nan}\n", "1: actuator.mass"),
    ("huge integer", f"actuator: {{mass: {'9' * 6000}}}\n", "1: actuator.mass"),
    ("huge exponent", "actuator: {mass: 1 Gg^1000000000}\n", "1: actuator.mass"),
    ("duration", "record: {duration: 2.001 s}\n", "duration = 2.001 s is not a multiple of the sampling interval"),
    ("endless duration", "record: {duration: 1e12 s}\n", "too many"),
    ("short record", "record: {duration: 0.2 s}\n", "record.duration = 0.2 s leaves 100 samples, but wavelet.levels = 5 of db8 needs 480"),
    ("continuous wavelet", "wavelet: {name: morl}\n", "1: wavelet.name"),
    ("both leakages", "leakage: {internal_flow: 1, internal_coefficient: 1}\n", "1: leakage"),
    ("axis without section", "sweep: {grid: {bulk_modulus: [1]}}\n", "bulk_modulus: no parameter 'bulk_modulus'; did you mean 'fluid.bulk_modulus'?"),
    ("unequal units", "sweep:\n  grid:\n    fluid.bulk_modulus:\n    - 551 MPa\n    - 2 s\n", "5: sweep.grid.fluid.bulk_modulus[1]"),
    ("baseline name", "baseline: {name: x}\n", "1: baseline.name"),
    ("name leaves the folder", "name: ../x\n", "1: name"),
    ("list for a section", "record: [1]\n", "1: record"),
    ("list for a file", "- 1\n", "1: an experiment file contains 'key: value' pairs"),
    ("key twice", "name: a\nname: b\n", "2: name"),
    ("broken YAML", "a: 1\nrecord: {duration: 2 s\n", ": not valid YAML:"),
    ("tab", "run:\n\tduration: 2 s\n", "2: not valid YAML:"),
    ("control character", b"name: a\x00\n", "not valid YAML"),
    ("no UTF-8", b"name: caf\xe9\n", "is not a text file in UTF-8"),
    ("cycle", "actuator: &a {mass: *a}\n", "nested too deeply, or too large"),
    ("merge key", "actuator: &m {mass: 12}\n<<: *m\n", "2: <<"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), [case[1:] for case in LINES], ids=[case[0] for case in LINES])
def test_a_mistake_is_one_line_with_its_place(experiment_file, text, expected):
    config = experiment_file(text)
    lines = mistakes(config)
    assert len(lines) == 1
    assert lines[0].startswith(f"{config}:")
    assert expected in lines[0]


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("abc", "settings abc: expected KEY=VALUE"),
        ("fluid.bulkmodulus=1", "fluid.bulkmodulus=1: unknown key; did you mean 'bulk_modulus'?"),
        ("fluid=1", "settings fluid=1: expected a section"),
        ("fluid.bulk_modulus=", "fluid.bulk_modulus=: has no value after"),
        ("fluid.bulk_modulus=a: b: c", "fluid.bulk_modulus=a: b: c: not valid YAML"),
        ("fluid.bulk_modulus='689'", "'689 MPa' or '689 Pa'"),
        ("sweep.grid.fluid.bulk_modulus=[1, 1 m]", "fluid.bulk_modulus[1]: '1 m' has the wrong unit"),
    ],
)
def test_a_mistake_in_a_setting_names_the_setting(setting, expected):
    lines = mistakes(None, setting)
    assert len(lines) == 1
    assert lines[0].startswith(f"settings {setting}")
    assert expected in lines[0]


def test_a_bare_number_is_in_si_but_not_in_a_string(experiment_file):
    assert load_experiment(None, ["fluid.bulk_modulus=689e6"]).fluid.bulk_modulus == 689e6
    assert load_experiment(None, {"valve.damping_ratio": "0.5"}).valve.damping_ratio == 0.5
    (line,) = mistakes(experiment_file('fluid: {bulk_modulus: "689"}\n'))
    assert "fluid.bulk_modulus" in line
    for settings in ({"fluid.bulk_modulus": "689"}, {"sweep.grid.fluid.bulk_modulus": ["689"]}):
        with pytest.raises(ConfigError):
            load_experiment(None, settings)


MANY = """\
name: ../up
actuator:
  mass: -1
  piston_area: 633 mm
fluid: {bulk_modulu: 551 MPa}
valve: {spool_gain: .nan}
friction: {coulomb: no}
wavelet: {name: db99}
sweep:
  grid:
    fluid.bulk_modulus: [551 MPa, 3 s]
    friction.viscos: [1]
"""


def test_all_mistakes_of_a_file_are_reported_at_once_in_its_order(experiment_file):
    config = experiment_file(MANY)
    lines = mistakes(config, "input.period=1 kg")
    places = [
        line.removeprefix(f"{config}:").split(":")[0] for line in lines if not line.startswith("settings")
    ]
    assert places == ["1", "3", "4", "5", "6", "7", "8", "11", "12"]
    assert any(line.startswith("settings input.period=1 kg: '1 kg'") for line in lines)


def test_the_command_reports_all_mistakes_and_writes_nothing(hydrofdi, experiment_file, tmp_path):
    config = experiment_file(MANY)
    for command in ("simulate", "sweep"):
        result = hydrofdi(command, config)
        assert result.returncode == 2
        assert result.stdout == ""
        lines = result.stderr.splitlines()
        assert len(lines) == 9
        assert all(line.startswith(f"hydrofdi: {config}:") for line in lines)
    assert os.listdir(tmp_path) == [config.name]


BAD_COMMANDS = {
    "missing file": (["simulate", "missing.yaml"], "missing.yaml: no such file"),
    "unreachable leakage": (
        ["simulate", "--set", "record.duration=2 s", "--set", "leakage.internal_flow=500 L/min", "--out", "x.h5"],
        "no K_i gives a mean leakage of 500 L/min",
    ),
    "long name for a result": (["simulate", "--set", "record.duration=2 s", "--out", "a" * 300 + ".h5"], "aaa…: File name too long"),
    "folder for a file": (["simulate", "--set", "record.duration=2 s", "--out", "."], "ends in .h5"),
    "no results": (["report"], "no experiment file in results/*; run 'hydrofdi sweep CONFIG' first"),
    "no HDF5": (["report", "file"], "file: is not a readable HDF5 file"),
    "unknown command": (["simulat"], "No such command 'simulat'"),
    "unknown option": (["simulate", "--foo"], "No such option: --foo"),
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


def test_a_bad_request_leaves_what_is_stored_as_it_is(hydrofdi, small_sweep, tmp_path):
    shutil.copytree(small_sweep.folder, tmp_path, dirs_exist_ok=True)
    files = sorted(path for path in tmp_path.rglob("*") if path.is_file())
    before = [(path, path.read_bytes(), path.stat().st_mtime_ns) for path in files]
    config = tmp_path / "experiment.yaml"
    for setting in ("fluid.bulk_modulus=3 s", "sweep.grid.leakage.internal_flow=[500 L/min]"):
        assert hydrofdi("sweep", config, "--engine", "in-process", "--set", setting).returncode == 2
    files = sorted(path for path in tmp_path.rglob("*") if path.is_file())
    assert [(path, path.read_bytes(), path.stat().st_mtime_ns) for path in files] == before
