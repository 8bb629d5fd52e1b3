"""What a session of tests says at its end: what was skipped and how to get it, and variants of kernels."""

import os
import re
import time
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import pytest

from hydrofdi.compilation import object_code
from hydrofdi.compilation.compiling import cache_directory

MOST_VARIANTS = 15
"""Of each kernel of the simulation in ``make test``; each takes seconds to compile."""
KERNELS = ("advance_lanes", "integrate_balances")


class Session:
    """Notes the variants that tests and their processes use, and fails a session with too many.

    What a test needs in a process of pytest is noted with its name. Other processes leave a trace in the
    cache: the time at which a file was last read or written (read: unless the disk is mounted ``noatime``).
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config, self._begin, self._variants = config, time.time(), defaultdict[str, dict](dict)
        self._is_checked = config.option.markexpr == "not long"
        prepare = object_code._prepare

        def noted(function: Any, types: Any, arguments: tuple[Any, ...]) -> Any:
            test = os.environ.get("PYTEST_CURRENT_TEST", "").rpartition(" ")[0]
            options = repr([each for each in arguments if hasattr(each, "_fields")])
            chosen = " ".join(re.findall(r"(\w+)=True", options)) or "no option"
            self._variants[function.__name__].setdefault(repr(types), f"{test}: {chosen}")
            return prepare(function, types, arguments)

        object_code._prepare = noted
        for file in () if hasattr(config, "workerinput") else self._files():
            os.utime(file, (0.0, file.stat().st_mtime))

    def _files(self) -> list[Path]:
        folder = cache_directory("simulation")
        return [file for kernel in KERNELS for file in folder.glob(f"{kernel}-*.o")] if folder else []

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        for kernel, variants in getattr(node, "workeroutput", {}).get("variants", {}).items():
            self._variants[kernel] = variants | self._variants[kernel]

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if hasattr(self._config, "workeroutput"):
            self._config.workeroutput["variants"] = dict(self._variants)
        elif self._surplus():
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def _surplus(self) -> dict[str, int]:
        """Number of variants of each kernel that has too many."""
        if not self._is_checked:
            return {}
        used = (
            file for file in self._files() if max(file.stat().st_atime, file.stat().st_mtime) >= self._begin
        )
        on_disk = Counter(file.name.partition("-")[0] for file in used)
        found = {kernel: max(on_disk[kernel], len(self._variants[kernel])) for kernel in KERNELS}
        return {kernel: number for kernel, number in found.items() if number > MOST_VARIANTS}

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        write = terminalreporter.write_line
        for kernel, number in self._surplus().items():
            write(
                f"{number} variants of {kernel}, at most {MOST_VARIANTS} are allowed (tests/machines.py):",
                red=True,
            )
            for first in sorted(self._variants[kernel].values()):
                write(f"  {first}")
        reports = terminalreporter.stats.get("skipped", [])
        reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in reports)
        for reason, number in reasons.most_common():
            write(f"skipped, {number} test{'s' * (number > 1)}: {reason}")
        if self._is_checked:
            write("left out, the long tests: make test-long")
