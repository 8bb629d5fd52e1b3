"""Real sweeps in real processes, and what is left of them."""

import os
import signal
import subprocess
import time
from pathlib import Path

from tests.commands import COMMAND


def start(*arguments, command=COMMAND, **options):
    """Start a command in a session of its own."""
    return subprocess.Popen(
        [*command, *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **options,
    )  # fmt: skip


def session_members(session):
    """Living processes of a session, by their command lines."""
    members = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
                if int(fields[3]) == session and fields[0] != "Z":
                    members[int(entry.name)] = (entry / "cmdline").read_text().replace("\0", " ")
            except OSError:
                continue
    return members


def workers(session):
    """Process ids of the workers of a sweep: the children of its fork server."""
    children = {}
    for pid in session_members(session):
        try:
            parent = int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        children.setdefault(parent, []).append(pid)
    servers = [
        pid for pid, line in session_members(session).items() if "forkserver" in line and pid in children
    ]
    return [pid for server in servers for pid in children[server]]


def computing(session):
    """Process ids of workers that have computed for half a second: their fork server loads the package."""
    ticks = 0.5 * os.sysconf("SC_CLK_TCK")
    return [
        pid
        for pid in workers(session)
        if sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13])) > ticks
    ]


def wait_until(condition, seconds=120.0):
    """Wait for something to become true; the last value."""
    deadline = time.monotonic() + seconds
    while not (value := condition()) and time.monotonic() < deadline:
        time.sleep(0.02)
    return value


def nobody_left(session, seconds=2.0):
    """Whether all processes of a session are gone within some seconds."""
    return wait_until(lambda: not session_members(session), seconds) is True


def shards(directory):
    """Finished shards of a sweep."""
    return list((directory / "shards").glob("[!.]*.h5"))


def says(process, words):
    """Wait until a line on standard error contains some words."""
    return any(words in line for line in iter(process.stderr.readline, ""))


def kill(pid, number=signal.SIGKILL):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        return False
    return True
