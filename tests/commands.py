"""How tests run the command: in this process, or in one of its own."""

import io
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

import hydrofdi.__main__ as entry_point

COMMAND = [sys.executable, "-m", "hydrofdi"]

Completed = subprocess.CompletedProcess[str]


def run_process(*arguments: str | Path, **options: Any) -> Completed:
    """``python -m hydrofdi`` in a process of its own."""
    usual = {"capture_output": True, "text": True, "timeout": 300, "env": os.environ}
    return subprocess.run([*COMMAND, *map(str, arguments)], **usual | options)


def run_hydrofdi(*arguments: str | Path, cwd: Path | None = None, **options: Any) -> Completed:
    """The same as ``run_process`` without the process; options of ``subprocess.run`` ask for one."""
    if options:
        return run_process(*arguments, cwd=cwd, **options)
    output, errors = _Pipe(), _Pipe()
    command = [str(entry_point.__file__), *map(str, arguments)]
    with mock.patch.dict(os.environ), pytest.MonkeyPatch.context() as patch:
        patch.chdir(cwd or Path.cwd())
        patch.setattr(sys, "argv", command)
        patch.setitem(sys.modules, "__main__", entry_point)
        for names, pipe in ((("stdout", "__stdout__"), output), (("stderr", "__stderr__"), errors)):
            for name in names:
                patch.setattr(sys, name, pipe)
        with pytest.raises(SystemExit) as end:
            entry_point.main()
    assert isinstance(end.value.code, int)
    return subprocess.CompletedProcess(command, end.value.code, output.text(), errors.text())


class _Pipe(io.TextIOWrapper):
    """Text that is kept; no terminal, and nothing that the system could write to."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", write_through=True)

    def text(self) -> str:
        """All that was written."""
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined]


def run(*arguments: str | Path, check: int | None = None, **options: Any) -> Completed:
    """Run a command and look at its exit code."""
    done = run_hydrofdi(*arguments, **options)
    assert check in (None, done.returncode), f"exit {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done


def run_json(*arguments: str | Path, check: int = 0, **options: Any) -> Any:
    """The JSON that a command prints."""
    return json.loads(run(*arguments, "--json", check=check, **options).stdout)


def wait_until(
    holds: Callable[[], Any], process: subprocess.Popen[str] | None = None, seconds: float = 120.0
) -> Any:
    """Wait for something to become true, as long as a process lives; its last value."""
    end = time.monotonic() + seconds
    while not (value := holds()):
        assert process is None or process.poll() is None, "it ended"
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)
    return value
