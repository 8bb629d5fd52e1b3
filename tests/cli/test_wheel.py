"""The wheel, installed where there is no clone."""

import os
import subprocess
import sys
import venv
from pathlib import Path

import pytest

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
    assert "1,460 records" in run("plan", "mine")
    assert {path.name for path in tmp_path.iterdir()} == {"results", "record.h5", "mine.yaml"}
