"""What the documentation says is run."""

import os
import re
import shlex
import shutil
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from hydrofdi.config import load_experiment
from tests.commands import run, run_json

ROOT = Path(__file__).parent.parent


ENVIRONMENT = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def shell_blocks(file, marked="these commands", language="sh"):
    pattern = rf"<!-- a test runs {marked} -->\s*```{language}\n(.*?)```"
    return re.findall(pattern, file.read_text(), re.DOTALL)


def run_command(command, folder):
    """Run a command as a reader would."""
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    return done


def run_shell(script, folder):
    """Run a script with the configurations as they are in a clone."""
    shutil.copytree(ROOT / "configs", folder / "configs")
    return run_command(["bash", "-eu", "-c", script], folder)


def test_the_first_page_runs(tmp_path, monkeypatch):
    """The file and the commands of the README, its lines of Python, and the picture that it shows."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (experiment,), (code,) = (
        re.findall(rf"```{kind}\n(.*?)```", text, re.DOTALL) for kind in ("yaml", "python")
    )
    (block,) = shell_blocks(ROOT / "README.md")
    (tmp_path / "mine.yaml").write_text(experiment, encoding="utf-8")
    assert load_experiment(tmp_path / "mine.yaml").sweep == load_experiment("grid").sweep
    commands = [shlex.split(line, comments=True) for line in [*block.splitlines(), *block.splitlines()[:1]]]
    done = [run(*words[1:], cwd=tmp_path, check=0) for words in commands if words]
    assert "400 computed, 0 stored before" in done[0].stderr
    assert "0 computed, 400 stored before" in done[-1].stderr
    assert (tmp_path / "sensitivity.png").stat().st_size > 10_000
    monkeypatch.chdir(tmp_path)
    found: dict[str, Any] = {}
    exec(code.replace('duration="10 s"', 'duration="2 s", engine="in-process"'), found)
    assert dict(found["cube"].delta.sizes) == {"EBM": 2, "K_i": 3, "level": 5}
    assert found["run"].detail_rms.shape == (5,)


@pytest.mark.long
def test_the_cluster_on_one_machine_runs(tmp_path):
    (block,) = shell_blocks(ROOT / "docs" / "cluster.md")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    patient = block.replace("hydrofdi sweep", "sleep 8; hydrofdi sweep").replace("8786", port)
    done = run_shell(f"set -m\ntrap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n{patient}", tmp_path)
    assert "4 computed" in done.stderr


@pytest.mark.long
def test_the_script_of_a_cluster_of_jobs_runs_on_a_local_one(tmp_path):
    (script,) = shell_blocks(ROOT / "docs" / "cluster.md", "this with LocalCluster", "python")
    local = 'LocalCluster(n_workers=0, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)'
    script = re.sub(r"SLURMCluster\(.*?\)", local, script).replace(
        "dask_jobqueue import SLURMCluster", "distributed import LocalCluster"
    )
    (tmp_path / "script.py").write_text(script.replace("scale(64)", "scale(2)"))
    run_command([sys.executable, "script.py"], tmp_path)
    assert run_json("status", tmp_path / "results" / "smoke")["done"] == 4


@pytest.mark.long
def test_the_array_of_jobs_runs(tmp_path):
    (job,) = shell_blocks(ROOT / "docs" / "cluster.md", "this as an array of two")
    axis = "{fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 80]}}"
    study = f"name: study\nrecord: {{duration: 2 s}}\nsweep: {{grid: {axis}}}\n"
    (tmp_path / "study.yaml").write_text(study)
    tasks = [f"SLURM_ARRAY_TASK_ID={task}\n{job.replace('/64', '/2')}" for task in (1, 2)]
    done = run_shell("".join([*tasks, "hydrofdi collect shared/study"]), tmp_path)
    assert "80 runs, 0 missing" in done.stderr


def test_the_cross_check_by_hand_holds(tmp_path):
    page = (ROOT / "docs" / "indicators.md").read_text()
    (code,) = re.findall(r"<!-- a test runs this -->\s*```python\n(.*?)```", page, re.DOTALL)
    assert "pywt.wavedec" in code
    run_command([sys.executable, "-c", f"{code}\nassert len(by_hand) == 5"], tmp_path)
