"""What a session of tests says at its end: what was skipped, how to get it, and whether kernels are few."""

import os
import tempfile
from collections import Counter
from pathlib import Path

import pytest

MOST_VARIANTS = 15
"""Of each kernel of the simulation; a new test uses one of the machines of `tests.machines`."""
KERNELS = ("advance_lanes", "integrate_balances")


class Session:
    """``make test`` begins with an empty cache, so that kernels are compiled and can be counted."""

    def __init__(self, config: pytest.Config) -> None:
        self._is_short = config.option.markexpr == "not long"
        self._cache = tempfile.TemporaryDirectory(prefix="hydrofdi-tests-")
        if self._is_short:
            os.environ["NUMBA_CACHE_DIR"] = self._cache.name

    def _surplus(self) -> dict[str, int]:
        files = Counter(file.name.partition("-")[0] for file in Path(self._cache.name).rglob("*.o"))
        return {kernel: files[kernel] for kernel in KERNELS if files[kernel] > MOST_VARIANTS}

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self._surplus():
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        write = terminalreporter.write_line
        for kernel, number in self._surplus().items():
            write(
                f"{number} variants of {kernel}, at most {MOST_VARIANTS} are allowed (tests/machines.py)",
                red=True,
            )
        reports = terminalreporter.stats.get("skipped", [])
        reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in reports)
        for reason, number in reasons.most_common():
            write(f"skipped, {number} test{'s' * (number > 1)}: {reason}")
        if self._is_short:
            write("left out, the long tests: make test-long")
