"""Bad input: every mistake is one line with its place, all at once; nothing is written or touched."""
# ruff: noqa: E501

import os
import shutil

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

WRITE_A_NAME = "write at least a name, such as 'name: nominal' for the actuator of the paper"


def mistakes(config=None, *settings):
    with pytest.raises(ConfigError) as caught:
        load_experiment(config, settings)
    return str(caught.value).splitlines()


def test_without_a_file_every_parameter_is_nominal():
    nominal = load_experiment()
    assert nominal.name == "nominal"
    assert nominal.fluid.bulk_modulus == 551e6
    assert nominal.wavelet.name == "db8"


def test_what_is_left_out_keeps_its_nominal_value(experiment_file):
    experiment = load_experiment(experiment_file("fluid: {bulk_modulus: 689 MPa}\n"))
    assert experiment.fluid.bulk_modulus == 689e6
    assert experiment.actuator == load_experiment().actuator


@pytest.mark.parametrize("text", ["", "\n", "# nothing\n", "---\n", "null\n", "{}\n"])
def test_a_file_that_states_nothing_is_a_mistake(experiment_file, tmp_path, text):
    config = experiment_file(text)
    assert mistakes(config) == [f"{config}: states nothing; {WRITE_A_NAME}"]
    child = tmp_path / "child.yaml"
    child.write_text("name: child\nextends: experiment.yaml\n")
    assert mistakes(child) == [f"{config}: states nothing; {WRITE_A_NAME}"]


@pytest.mark.parametrize("text", ["name: nominal\n", "fluid: {}\n"])
def test_a_file_that_states_little_is_nominal_besides(experiment_file, text):
    assert load_experiment(experiment_file(text)) == load_experiment()


def test_settings_win_over_the_file(experiment_file):
    config = experiment_file("fluid: {bulk_modulus: 689 MPa}\nsweep: {grid: {fluid.bulk_modulus: [1e9]}}\n")
    experiment = load_experiment(
        config, ["fluid.bulk_modulus=827 MPa", "sweep.grid.fluid.bulk_modulus=[551 MPa, 600 MPa]"]
    )
    assert experiment.fluid.bulk_modulus == 827e6
    assert experiment.sweep.grid == {"fluid.bulk_modulus": [551e6, 600e6]}


LINES = [
    ("unknown key", "fluid:\n  bulk_moduluss: 1\n", "2: fluid.bulk_moduluss: unknown key; did you mean 'bulk_modulus'?"),
    ("unknown section", "fluids:\n  bulk_modulus: 1\n", "1: fluids: unknown key; did you mean 'fluid'?"),
    ("wrong unit", "fluid:\n  bulk_modulus: 551 bar·s\n", "2: fluid.bulk_modulus: '551 bar·s' has the wrong unit"),
    ("unknown unit", "fluid: {bulk_modulus: 551 MPaa}\n", "1: fluid.bulk_modulus: unknown unit 'MPaa'"),
    ("negative area", "actuator: {piston_area: -1 cm²}\n", "1: actuator.piston_area: must be greater than 0"),
    ("zero mass", "actuator: {mass: 0}\n", "1: actuator.mass: must be greater than 0; found 0"),
    ("bool for a number", "actuator: {mass: true}\n", "1: actuator.mass: expected a number in kg"),
    ("bool for a count", "wavelet: {levels: true}\n", "1: wavelet.levels: expected an integer"),
    ("nan", "actuator: {mass: .nan}\n", "1: actuator.mass: must be a finite number; found nan"),
    ("infinity", "actuator: {mass: .inf}\n", "1: actuator.mass: must be a finite number; found inf"),
    ("huge number", "actuator: {mass: 1e400}\n", "1: actuator.mass: must be a finite number"),
    ("huge integer", f"actuator: {{mass: {'9' * 6000}}}\n", "1: actuator.mass: must be a finite number"),
    ("huge exponent", "actuator: {mass: 1 Gg^1000000000}\n", "1: actuator.mass: exponent 1000000000 is too large"),
    ("no value", "actuator: {mass: }\n", "1: actuator.mass: expected a number in kg"),
    ("list for a number", "actuator: {mass: [1]}\n", "1: actuator.mass: expected a number in kg"),
    ("period", "\ninput:\n  period: 1.00001 s\n", "half of input.period = 1.00001 s is not a multiple of record.step"),
    ("endless period", "input: {period: 1e308}\n", "is not a multiple of record.step"),
    ("sampling", "record: {sampling_frequency: 300 Hz}\n", "is not a multiple of step = 0.0001 s"),
    ("duration", "record: {duration: 2.001 s}\n", "duration = 2.001 s is not a multiple of the sampling interval"),
    ("endless duration", "record: {duration: 1e12 s}\n", "too many"),
    ("vanishing step", "record: {step: 1e-320}\n", "is not a multiple of step"),
    ("short record", "record: {duration: 0.2 s}\n", "record.duration = 0.2 s leaves 100 samples, but wavelet.levels = 5 of db8 needs 480"),
    ("unknown wavelet", "wavelet: {name: db99}\n", "1: wavelet.name: 'db99' is not a discrete wavelet"),
    ("continuous wavelet", "wavelet: {name: morl}\n", "1: wavelet.name: 'morl' is not a discrete wavelet"),
    ("no levels", "wavelet: {levels: 0}\n", "1: wavelet.levels: must be at least 1; found 0"),
    ("extension", "wavelet: {extension: mirror}\n", "1: wavelet.extension: 'mirror' is unknown"),
    ("both leakages", "leakage: {internal_flow: 1, internal_coefficient: 1}\n", "1: leakage: give internal_coefficient or"),
    ("supply", "supply: {pressure: 1, return_pressure: 2}\n", "1: supply: the supply pressure must be above"),
    ("empty grid", "sweep: {grid: {}}\n", "1: sweep.grid: names no parameter to vary"),
    ("empty axis", "sweep: {grid: {fluid.bulk_modulus: []}}\n", "1: sweep.grid.fluid.bulk_modulus: an axis is a list"),
    ("axis without section", "sweep: {grid: {bulk_modulus: [1]}}\n", "bulk_modulus: no parameter 'bulk_modulus'; did you mean 'fluid.bulk_modulus'?"),
    ("unequal units", "sweep:\n  grid:\n    fluid.bulk_modulus:\n    - 551 MPa\n    - 2 s\n", "5: sweep.grid.fluid.bulk_modulus[1]: '2 s' has the wrong unit"),
    ("value twice", "sweep: {grid: {fluid.bulk_modulus: [1 MPa, 1e6]}}\n", "1: sweep.grid.fluid.bulk_modulus[1]: value 1000000.0 is in the list twice"),
    ("both on axes", "sweep: {grid: {leakage.internal_flow: [1], leakage.internal_coefficient: [1]}}\n", "not both"),
    ("both in baseline", "baseline: {leakage.internal_flow: 0, leakage.internal_coefficient: 0}\n", "1: baseline"),
    ("baseline name", "baseline: {name: x}\n", "1: baseline.name: no parameter 'name'"),
    ("baseline list", "baseline: [1]\n", "1: baseline: expected a section"),
    ("store", "store: {signals: some}\n", "1: store.signals: must be 'all', 'pressures', 'none' or a list of signals; found 'some'"),
    ("name leaves the folder", "name: ../x\n", "1: name: letters, digits"),
    ("hidden name", "name: .x\n", "1: name: letters, digits"),
    ("name with line break", 'name: "a\\n"\n', "1: name: letters, digits"),
    ("number for a name", "name: 2024\n", "1: name: expected a text"),
    ("list for a section", "record: [1]\n", "1: record: expected a section with 'key: value' pairs; found [1]"),
    ("list for a file", "- 1\n", "1: an experiment file contains 'key: value' pairs"),
    ("text for a file", "hello\n", "1: an experiment file contains 'key: value' pairs"),
    ("key twice", "name: a\nname: b\n", "2: name: key given twice, first in line 1"),
    ("broken YAML", "a: 1\nrecord: {duration: 2 s\n", ": not valid YAML:"),
    ("tab", "run:\n\tduration: 2 s\n", "2: not valid YAML:"),
    ("two documents", "name: a\n---\nname: b\n", "not valid YAML"),
    ("control character", b"name: a\x00\n", "not valid YAML"),
    ("no UTF-8", b"name: caf\xe9\n", "is not a text file in UTF-8"),
    ("cycle", "actuator: &a {mass: *a}\n", "nested too deeply, or too large"),
    ("merge key", "actuator: &m {mass: 12}\n<<: *m\n", "2: <<: unknown key"),
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
        ("=1", "settings =1: expected KEY=VALUE"),
        ("..=1", "settings ..=1: unknown key"),
        ("fluid.bulkmodulus=1", "fluid.bulkmodulus=1: unknown key; did you mean 'bulk_modulus'?"),
        ("fluid=1", "settings fluid=1: expected a section"),
        ("fluid.bulk_modulus=", "fluid.bulk_modulus=: has no value after"),
        ("fluid.bulk_modulus.x=1", "settings fluid.bulk_modulus.x=1: fluid.bulk_modulus: expected a number"),
        ("fluid.bulk_modulus=a: b: c", "fluid.bulk_modulus=a: b: c: not valid YAML"),
        ("sweep.grid=[1]", "sweep.grid=[1]: expected a section"),
        ("fluid.bulk_modulus='689'", "'689 MPa' or '689 Pa'"),
        ("record.sampling_frequency='500'", "'500 Hz'"),
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
    "directory for a file": (["sweep", "."], ".: is a directory, not an experiment file"),
    "unreachable leakage": (
        ["simulate", "--set", "record.duration=2 s", "--set", "leakage.internal_flow=500 L/min", "--out", "x.h5"],
        "no K_i gives a mean leakage of 500 L/min",
    ),
    "leakage without pressure": (
        ["simulate", "--set", "input.amplitude=0", "--set", "leakage.internal_flow=1 L/min"],
        "no K_i gives a mean leakage of 1 L/min",
    ),
    "no folder at all": (["simulate", "--set", "record.duration=2 s", "--out", "/proc/x.h5"], "x.h5: cannot be written: No such file or directory"),
    "file for a folder": (["simulate", "--set", "record.duration=2 s", "--out", "file/x.h5"], "file is not a folder"),
    "long name for a result": (["simulate", "--set", "record.duration=2 s", "--out", "a" * 300 + ".h5"], "aaa…: File name too long"),
    "long name for a source": (["measure", "a" * 300], "aaa…: File name too long"),
    "long name for results": (["report", "a" * 300], "aaa…: File name too long"),
    "folder for a file": (["simulate", "--set", "record.duration=2 s", "--out", "."], "ends in .h5"),
    "kind of figure": (["simulate", "--set", "record.duration=2 s", "--figure", "x.xyz"], ".png, .svg or .pdf"),
    "no results": (["report"], "no experiment file in results/*; run 'hydrofdi sweep CONFIG' first"),
    "missing folder": (["report", "missing"], "missing: no such file"),
    "no HDF5": (["report", "file"], "file: is not a readable HDF5 file"),
    "unknown command": (["simulat"], "No such command 'simulat'"),
    "unknown option": (["simulate", "--foo"], "No such option: --foo"),
    "no workers": (["sweep", "file", "--workers", "0"], "--workers"),
    "unknown format": (["report", "--format", "word"], "--format"),
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


def test_contradictory_settings_are_a_mistake():
    settings = ["leakage.internal_flow=1 L/min", "leakage.internal_coefficient=1e-9"]
    with pytest.raises(ConfigError, match="not both"):
        load_experiment(None, settings)
