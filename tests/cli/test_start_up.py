"""What a command loads before it answers."""

import os
import signal
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.commands import COMMAND, run_hydrofdi

LOADING = """
import sys
from hydrofdi.cli.app import main
INNER = ("hydrofdi.papers.", "hydrofdi.execution.", "hydrofdi.simulation.")
try:
    main()
except SystemExit as end:
    names = {name.removeprefix("hydrofdi.").split(".")[0] for name in sys.modules}
    commands = {name.split(".")[-1] for name in sys.modules if name.startswith("hydrofdi.cli.")}
    inner = {name.removeprefix("hydrofdi.") for name in sys.modules if name.startswith(INNER)}
    sys.stderr.write(f"{end.code} {' '.join(names | inner | {f'cli.{name}' for name in commands})}\\n")
"""

COMPILERS = {"numba", "llvmlite"}
HEAVY = {"numba", "scipy", "matplotlib", "pyarrow", "xarray", "pandas", "distributed"}


def _loaded(folder, *arguments):
    """Libraries, rooms of hydrofdi and modules of its command line in a process after a command."""
    command = [sys.executable, "-c", LOADING, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    code, *libraries = done.stderr.splitlines()[-1].split()
    assert code == "0", done.stderr
    return set(libraries)


STUDIES = {"studies", "monitor", "cli.live", "cli.sweep"}
SAYING = {"report", "papers", "rich"}
RUNNING = {"execution.compute", "simulation.sensing", "compilation"}


@pytest.mark.parametrize(
    ("arguments", "absent"),
    [
        (("--version",), {"numpy", "config", "studies", "monitor", *SAYING, *RUNNING}),
        (("--help",), {"numpy", "pydantic", "h5py"}),
        (("report", "--help"), set()),
        (("schema",), {"numpy", "config", *STUDIES, *SAYING, *RUNNING}),
        (("status", "results/small"), {*STUDIES, *SAYING, *RUNNING}),
        (("verify", "results/small"), set()),
        (("why", "results/small", "1"), {"report", "papers", *STUDIES, *RUNNING}),
        (("report",), {"papers.maddahi2015.report", *STUDIES, *RUNNING}),
        (("plan", "experiment.yaml"), set()),
        (("sweep", "experiment.yaml"), set()),
        (("indicators",), set()),
        (("measure", "results/small", "--json"), set()),
        (("inspect", "results/small"), set()),
    ],
)
def test_a_command_that_simulates_nothing_loads_no_compiler_and_only_its_own_rooms(
    small_sweep, arguments, absent
):
    loaded = _loaded(small_sweep.folder, *arguments)
    assert "typer" in loaded
    assert not loaded & (HEAVY | COMPILERS | absent)


def test_measuring_a_plain_file_loads_nothing_of_simulated_runs(tmp_path):
    (tmp_path / "rig.csv").write_text("time [s],p1 [bar]\n0,1\n0.1,2\n0.2,4\n")
    code = f"{LOADING}\nsys.stderr.write(' '.join(name for name in sys.modules if 'hydrofdi' in name))"
    command = [sys.executable, "-c", code, "measure", "rig.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    rooms = {name.split(".")[1] for name in done.stderr.splitlines()[-1].split() if "." in name}
    assert {"indicators", "records"} <= rooms
    assert not rooms & {"config", "physics", "simulation", "store"}


@pytest.mark.parametrize("command", ["simulate", "check", "plan"])
def test_a_warm_command_that_simulates_does_not_load_numba(tmp_path, command):
    (tmp_path / "short.yaml").write_text("record: {duration: 2 s}\n")
    assert run_hydrofdi(command, "short.yaml", cwd=tmp_path).returncode == 0
    loaded = _loaded(tmp_path, command, "short.yaml")
    assert "llvmlite" in loaded
    assert not loaded & (HEAVY | {"h5py"})
    assert command != "simulate" or not loaded & {"papers", *STUDIES}


def exit_code(*arguments, cwd, closes_errors=False):
    """Exit code of a command whose output nobody reads, and what it said on standard error."""
    errors = subprocess.STDOUT if closes_errors else subprocess.PIPE
    with subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=errors, cwd=cwd) as process:
        process.stdout.close()
        said = b"" if closes_errors else process.stderr.read()
        return process.wait(120), said


@pytest.mark.parametrize("command", ["schema", "indicators", "plan few.yaml --json"])
def test_a_command_ends_quietly_with_a_code_of_its_own(tmp_path, command):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 8 s}\nanalysis: {discard: 2}\n")
    assert exit_code(*command.split(), cwd=tmp_path) == (141, b"")


def test_a_sweep_whose_messages_nobody_reads_is_not_called_done(tmp_path):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 2 s}\n")
    code, _ = exit_code("sweep", "few.yaml", "--engine", "in-process", cwd=tmp_path, closes_errors=True)
    assert code == 141


SIGNAL_AT_AN_IMPORT = """
import os, sys

class Signal:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), {number})

sys.meta_path.insert(0, Signal())
sys.argv = ["hydrofdi", *{arguments!r}]
from hydrofdi.__main__ import main
main()
"""


def _signalled(number, module, *arguments):
    """A command that gets a signal when it begins to load a module."""
    code = SIGNAL_AT_AN_IMPORT.format(number=int(number), module=module, arguments=arguments)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("module", ["typer", "hydrofdi.api.run"])
def test_ctrl_c_while_a_command_loads_is_one_line_and_130(module):
    done = _signalled(signal.SIGINT, module, "simulate", "--set", "record.duration=2 s")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "hydrofdi: interrupted\n")


def test_sigterm_while_a_monitor_loads_ends_it_as_later():
    done = _signalled(signal.SIGTERM, "typer", "monitor", "detector.json", "-")
    assert (done.returncode, done.stderr) == (0, "")


def test_sigterm_ends_other_commands_as_usual():
    assert _signalled(signal.SIGTERM, "typer", "plan", "smoke").returncode == -signal.SIGTERM


ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Wheel and script of hydrofdi in an environment that sees what is installed here, but not the clone."""
    folder = tmp_path_factory.mktemp("wheel")
    dependencies = [path for path in sys.path if path.endswith("site-packages")]
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*build, "--wheel-dir", folder, ROOT], check=True, capture_output=True, timeout=300)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv", symlinks=True)
    (packages,) = (folder / "venv").glob("[Ll]ib/**/site-packages")
    (packages / "dependencies.pth").write_text("\n".join(dependencies))
    binaries = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    install = [sys.executable, "-m", "pip", "--python", binaries / "python", "install", "--no-index"]
    subprocess.run([*install, "--no-deps", wheel], check=True, capture_output=True, timeout=300)
    assert (packages / "hydrofdi" / "py.typed").exists()
    return binaries / "hydrofdi"


@pytest.mark.long
def test_the_wheel_works_in_an_empty_folder(installed, tmp_path):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

    def run(*arguments):
        command = [installed, *arguments]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, f"{arguments}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    assert "table3" in run("configs")
    run("sweep", "smoke")
    assert "δd3" in run("report", "--full", "results/smoke")
    run("plan", "detectability/unknown-plant-rest")
    assert "d2" in run("measure", "smoke", "--indicators", "dwt")
    run("simulate", "smoke", "--out", "record.h5")
    assert "hydrofdi plan mine.yaml" in run("init", "mine")
    assert "1,460" in run("plan", "mine")
    assert {path.name for path in tmp_path.iterdir()} == {"results", "record.h5", "mine.yaml"}
