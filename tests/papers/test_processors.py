"""Table 3 as on another processor."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.commands import COMMAND
from tests.processors import oldest, same

LARGEST_DIFFERENCE = 1e-8
"""Of a δ between the processor of this machine and the oldest [percentage points]."""

NEWER = """
import numpy._core._multiarray_umath as umath
print([name for name in umath.__cpu_dispatch__ if umath.__cpu_features__[name]])
"""


def test_table_3_is_the_same_on_the_oldest_processor(
    table3: SimpleNamespace, table3_rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    def printed(*command: str | Path) -> str:
        options: dict[str, Any] = {"capture_output": True, "text": True, "check": True}
        return subprocess.run(command, env=oldest(), cwd=tmp_path, **options).stdout

    assert printed(sys.executable, "-c", NEWER) == "[]\n"
    printed(*COMMAND, "sweep", table3.config, "--engine", "in-process")
    rows = json.loads(printed(*COMMAND, "report", "--json"))["rows"]
    assert rows == same(table3_rows)
    here, there = (np.array([row["delta_fixed_percent"] for row in each]) for each in (table3_rows, rows))
    assert np.abs(here - there).max() < LARGEST_DIFFERENCE
