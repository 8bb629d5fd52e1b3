"""Real sweeps in real processes, and what is left of them."""

import os
import signal
import subprocess
from pathlib import Path

from tests.commands import COMMAND, wait_until


def start(*arguments, command=COMMAND, **options):
    """Start a command in a session of its own."""
    return subprocess.Popen(
        [*command, *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **options,
    )  # fmt: skip


def _status(pid):
    """State, parent, group, session and more of a process; the file of Linux less its first two fields."""
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()


def session_members(session):
    """Living processes of a session: process id → command line and parent."""
    members = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            state, parent, _, own, *_ = _status(entry.name)
            if int(own) == session and state != "Z":
                line = (entry / "cmdline").read_text().replace("\0", " ")
                members[int(entry.name)] = (line, int(parent))
        except OSError:
            continue
    return members


def workers(session):
    """Process ids of the workers of a sweep: the children of its fork server."""
    members = session_members(session)
    servers = {pid for pid, (line, _) in members.items() if "forkserver" in line}
    return [pid for pid, (_, parent) in members.items() if parent in servers]


def computing(session):
    """Process ids of workers that have computed for half a second: their fork server loads the package."""
    ticks = 0.5 * os.sysconf("SC_CLK_TCK")
    return [pid for pid in workers(session) if sum(map(int, _status(pid)[11:13])) > ticks]


def nobody_left(session, seconds=2.0):
    """Wait until all processes of a session are gone."""
    return wait_until(lambda: not session_members(session), seconds=seconds)


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
