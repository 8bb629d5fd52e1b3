"""Fixtures that several test files share: the command, and sweeps that are run once."""

import os

# Threads of a BLAS spin while they wait: beside other processes they take five times the processor time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import signal
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import settings

from tests.commands import Completed, run_hydrofdi
from tests.session import Session

os.environ.pop("COLUMNS", None)  # the width of a terminal is none of the tests' business

REPOSITORY = Path(__file__).parent.parent

VTNSI = REPOSITORY.parent / "shared" / "data" / "vtnsi"
needs_vtnsi = pytest.mark.skipif(
    not VTNSI.is_dir(),
    reason="70 records chosen from github.com/vtnsi/actuator_dataset are not here, and are not distributed",
)

FOREIGN = REPOSITORY.parent / "shared" / "data" / "foreign"
needs_foreign = pytest.mark.skipif(not FOREIGN.is_dir(), reason="records of another simulator are not here")

settings.register_profile("hydrofdi", deadline=None)
settings.load_profile("hydrofdi")

Command = Callable[..., Completed]


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Session(config))


@pytest.fixture
def hydrofdi(tmp_path: Path) -> Command:
    """Runs the command in an empty folder; in a process of its own where options of one are given."""

    def run(*arguments: str | Path, **options: Any) -> Completed:
        return run_hydrofdi(*arguments, cwd=options.pop("cwd", tmp_path), **options)

    return run


SMALL = """\
name: small
record: {duration: 2 s}
sweep: {grid: {leakage.internal_coefficient: [0, 1e-8], fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""


def sweep_in(folder: Path, text: str, *arguments: str) -> SimpleNamespace:
    """A sweep of an experiment text in a folder; fails loudly where the command does."""
    config = folder / "experiment.yaml"
    config.write_text(text, encoding="utf-8")
    return swept(folder, config, *arguments)


def swept(folder: Path, config: Path, *arguments: str) -> SimpleNamespace:
    result = run_hydrofdi("sweep", config, "--json", "--engine", "in-process", *arguments, cwd=folder)
    assert result.returncode in (0, 1), result.stderr
    summary = json.loads(result.stdout)
    file = folder / summary["file"]
    return SimpleNamespace(
        folder=folder, config=config, file=file, directory=file.parent, summary=summary, result=result
    )


@pytest.fixture(scope="session", autouse=True)
def _interrupts_reach_processes() -> None:
    """Also where the shell that runs the tests ignores Ctrl-C, as it does for jobs in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def small_sweep(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Four runs of 2 s with all signals; to be read only."""
    return sweep_in(tmp_path_factory.mktemp("small"), SMALL)


@pytest.fixture(scope="session")
def table3(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The study of the paper as it is; to be read only."""
    return swept(tmp_path_factory.mktemp("table3"), REPOSITORY / "configs" / "table3.yaml")


@pytest.fixture(scope="session")
def table3_rows(table3: SimpleNamespace) -> list[dict[str, Any]]:
    """The rows that ``report --json`` prints for the study of the paper."""
    result = run_hydrofdi("report", "--json", cwd=table3.folder)
    assert result.returncode == 0, result.stderr
    rows: list[dict[str, Any]] = json.loads(result.stdout)["rows"]
    return rows


FAILING = """\
name: failing
record: {duration: 2 s}
store: {signals: none}
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 1e7 MPa, 689 MPa]}}
"""


@pytest.fixture(scope="session")
def failing_sweep(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Three runs of which the second diverges; to be read only."""
    return sweep_in(tmp_path_factory.mktemp("failing"), FAILING)


@pytest.fixture
def experiment_file(tmp_path: Path) -> Callable[[str | bytes], Path]:
    """Writes an experiment file."""

    def write(text: str | bytes) -> Path:
        path = tmp_path / "experiment.yaml"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write
