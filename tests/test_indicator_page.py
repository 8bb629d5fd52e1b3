"""docs/indicators.md: its cross-check by hand runs, and it lists what there is."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "indicators.md"


def test_the_cross_check_by_hand_holds(tmp_path: Path) -> None:
    (code,) = re.findall(r"<!-- a test runs this -->\s*```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert "pywt.wavedec" in code
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nprint(len(by_hand))"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "5\n"), done.stderr


def test_the_page_is_what_would_be_written() -> None:
    script = ROOT / "docs" / "generate_indicators.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
