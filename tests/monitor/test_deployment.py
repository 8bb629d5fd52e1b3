"""The systemd unit and the container file: what they say is there, and is taken by the command."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from hydrofdi.cli.app import application

ROOT = Path(__file__).parent.parent.parent
UNIT, CONTAINER = (ROOT / "docs" / "deploy" / name for name in ("hydrofdi-monitor.service", "Containerfile"))


def parsed(arguments):
    """What the command understands of its arguments; unknown ones raise."""
    (name, *rest) = arguments
    return typer.main.get_command(application()).commands[name].make_context(name, rest).params


def test_the_command_of_the_systemd_unit_is_understood():
    command = re.search(r"^ExecStart=((?:.*\\\n)*.*)", UNIT.read_text(), re.MULTILINE)[1]
    program, *arguments = shlex.split(command.replace("\\\n", " "))
    assert program.endswith("/hydrofdi")
    params = parsed(arguments)
    assert params["source"].startswith("mqtts://")
    assert Path(params["state"]).parent == Path("${STATE_DIRECTORY}")
    assert params["json"]


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")
def test_systemd_finds_nothing_wrong_with_the_unit(tmp_path):
    unit = tmp_path / UNIT.name
    unit.write_text(UNIT.read_text().replace("/opt/hydrofdi/bin/hydrofdi", "/bin/true"))
    done = subprocess.run(
        ["systemd-analyze", "verify", str(unit)], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_the_command_of_the_container_file_is_understood():
    comment = " ".join(line.strip("# \\") for line in CONTAINER.read_text().splitlines() if line[:1] == "#")
    words = shlex.split(comment.partition("podman run")[2].partition("docker takes")[0])
    params = parsed(words[words.index("monitor") :])
    assert params["state"] == "/state/press-1.state"


def test_what_the_container_file_copies_and_installs_is_there():
    text = CONTAINER.read_text()
    for line in re.findall(r"^COPY (?!--from)(.*)", text, re.MULTILINE):
        for name in line.split()[:-1]:
            assert (ROOT / name).exists(), name
    (groups,) = re.findall(r"requirements\.py (runtime .*?) >", text)
    script = [sys.executable, ROOT / ".ci" / "requirements.py", *groups.split()]
    needed = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    assert all(name in needed for name in ("numpy", "paho-mqtt", "asyncua", "prometheus-client"))
    pinned = (ROOT / "constraints.txt").read_text()
    for requirement in needed.splitlines():
        name = re.match(r"[\w-]+", requirement)[0].lower().replace("_", "-")
        assert re.search(rf"^{name}==", pinned, re.MULTILINE), name
