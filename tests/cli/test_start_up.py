"""What a command loads before it answers."""

import os
import signal
import subprocess
import sys
import venv

import pytest

from tests.commands import COMMAND, run_hydrofdi
from tests.conftest import REPOSITORY

LOADING = """
import sys
from hydrofdi.cli.app import main
try:
    main()
except SystemExit as end:
    sys.stderr.write(f"{end.code} {' '.join(sys.modules)}\\n")
"""

COMPILERS = {"numba", "llvmlite"}
HEAVY = {"numba", "scipy", "matplotlib", "pyarrow", "xarray", "pandas", "distributed"}


def _loaded(folder, *arguments):
    """Libraries, and rooms and modules of hydrofdi, in a process after a command."""
    command = [sys.executable, "-c", LOADING, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    code, *modules = done.stderr.splitlines()[-1].split()
    assert code == "0", done.stderr
    names = {name.removeprefix("hydrofdi.") for name in modules}
    return names | {name.split(".")[0] for name in names}


STUDIES = {"studies", "monitor", "cli.live", "cli.sweep"}
SAYING = {"report", "papers", "rich"}
RUNNING = {"execution.compute", "simulation.sensing", "compilation"}


LIGHT = (
    "report --help", "verify results/small", "plan experiment.yaml", "sweep experiment.yaml", "indicators",
    "measure results/small --json", "inspect results/small",
)  # fmt: skip
ABSENT = {
    "--version": {"numpy", "config", "studies", "monitor", *SAYING, *RUNNING},
    "--help": {"numpy", "pydantic", "h5py"},
    "schema": {"numpy", "config", *STUDIES, *SAYING, *RUNNING},
    "status results/small": {*STUDIES, *SAYING, *RUNNING},
    "why results/small 1": {"report", "papers", *STUDIES, *RUNNING},
    "report": {"papers.maddahi2015.report", *STUDIES, *RUNNING},
}


@pytest.mark.parametrize("command", [*LIGHT, *ABSENT])
def test_a_command_that_simulates_nothing_loads_no_compiler_and_only_its_own_rooms(small_sweep, command):
    loaded = _loaded(small_sweep.folder, *command.split())
    assert "typer" in loaded
    assert not loaded & (HEAVY | COMPILERS | ABSENT.get(command, set()))


def test_measuring_a_plain_file_loads_nothing_of_simulated_runs(tmp_path):
    rows = "".join(f"{k / 1000},{50 + k % 7}\n" for k in range(1000))
    (tmp_path / "rig.csv").write_text(f"time [s],p1 [bar]\n{rows}")
    loaded = _loaded(tmp_path, "measure", "rig.csv")
    assert {"indicators", "records"} <= loaded
    assert not loaded & {"config", "physics", "simulation", "store"}


@pytest.mark.parametrize("command", ["simulate", "check", "plan"])
def test_a_warm_command_that_simulates_does_not_load_numba(tmp_path, command):
    (tmp_path / "short.yaml").write_text("record: {duration: 2 s}\n")
    assert run_hydrofdi(command, "short.yaml", cwd=tmp_path).returncode == 0
    loaded = _loaded(tmp_path, command, "short.yaml")
    assert "llvmlite" in loaded
    assert not loaded & (HEAVY | {"h5py"})
    assert command != "simulate" or not loaded & {"papers", *STUDIES}


@pytest.mark.parametrize(("command", "closes_errors"), [
    ("schema", False), ("indicators", False), ("plan few.yaml --json", False),
    ("sweep few.yaml --engine in-process", True),
])  # fmt: skip
def test_a_command_whose_output_nobody_reads_ends_quietly_with_a_code_of_its_own(
    tmp_path, command, closes_errors
):
    (tmp_path / "few.yaml").write_text("name: few\nrecord: {duration: 8 s}\nanalysis: {discard: 2}\n")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT if closes_errors else subprocess.PIPE}
    with subprocess.Popen([*COMMAND, *command.split()], **pipes, cwd=tmp_path) as process:
        process.stdout.close()
        assert closes_errors or process.stderr.read() == b""
        assert process.wait(120) == 141


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


@pytest.mark.parametrize(
    ("number", "module", "arguments", "code", "told"),
    [
        (signal.SIGINT, "typer", "simulate", 130, "hydrofdi: interrupted\n"),
        (signal.SIGINT, "hydrofdi.api.run", "simulate", 130, "hydrofdi: interrupted\n"),
        (signal.SIGTERM, "typer", "monitor detector.json -", 0, ""),
        (signal.SIGTERM, "typer", "plan smoke", -signal.SIGTERM, ""),
    ],
)
def test_a_signal_while_a_command_loads_ends_it_as_later(number, module, arguments, code, told):
    script = SIGNAL_AT_AN_IMPORT.format(number=int(number), module=module, arguments=arguments.split())
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (code, "", told)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Wheel and script of hydrofdi in an environment that sees what is installed here, but not the clone."""
    folder = tmp_path_factory.mktemp("wheel")
    dependencies = [path for path in sys.path if path.endswith("site-packages")]
    build = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*build, "--wheel-dir", folder, REPOSITORY], check=True, capture_output=True, timeout=300)
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
    usual = {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True, "timeout": 300}
    for command, shown in (
        ("configs", "table3"),
        ("sweep smoke", ""),
        ("report --full results/smoke", "δd3"),
        ("plan detectability/unknown-plant-rest", ""),
        ("measure smoke --indicators dwt", "d2"),
        ("simulate smoke --out record.h5", ""),
        ("init mine", "hydrofdi plan mine.yaml"),
        ("plan mine", "1,460"),
    ):
        done = subprocess.run([installed, *command.split()], **usual)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        assert shown in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"results", "record.h5", "mine.yaml"}
