"""A key under its old name and its present one."""

from __future__ import annotations

from pathlib import Path

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.errors import ConfigError

_ONCE = "give it once: run.duration is the old name of record.duration"


@pytest.mark.filterwarnings("ignore::hydrofdi.errors.RenamedKeyWarning")
@pytest.mark.parametrize(
    "text",
    [
        "run:\n  duration: 4 s\nrecord:\n  duration: 2 s\n",
        "sweep:\n  grid:\n    run.duration: [4 s, 6 s]\n\n    record.duration: [2 s]\n",
        "sweep:\n  zip:\n    run.duration: [4 s, 6 s]\n\n    record.duration: [2 s, 3 s]\n",
        "baseline:\n\n  run.duration: 4 s\n\n  record.duration: 2 s\n",
        "replicates:\n  over:\n    run.duration: [4 s]\n\n    record.duration: [2 s]\n",
        "sweep:\n  sample:\n    over:\n      run.duration: [4 s]\n      record.duration: [2 s]\n",
    ],
    ids=["sections", "grid", "zip", "baseline", "replicates", "sample"],
)
def test_a_key_under_both_names_is_a_mistake_with_both_lines(tmp_path: Path, text: str) -> None:
    file = tmp_path / "both.yaml"
    file.write_text(f"name: both\n{text}")
    lines = file.read_text().splitlines()
    old, new = (
        next(n for n, line in enumerate(lines, 1) if any(key in line for key in keys))
        for keys in (("run.duration", "  duration: 4 s"), ("record.duration", "  duration: 2 s"))
    )
    with pytest.raises(ConfigError) as raised:
        load_experiment(file)
    said = next(line for line in str(raised.value).splitlines() if _ONCE in line)
    assert f"{file}:{old}" in said
    assert f"{file}:{new}" in said


@pytest.mark.filterwarnings("ignore::hydrofdi.errors.RenamedKeyWarning")
@pytest.mark.parametrize("around", ["", "baseline."])
def test_settings_under_both_names_are_a_mistake(around: str) -> None:
    settings = [f"{around}record.duration=2 s", f"{around}run.duration=4 s"]
    for order in (settings, settings[::-1]):
        with pytest.raises(ConfigError, match=_ONCE):
            load_experiment(settings=order)


@pytest.mark.filterwarnings("ignore::hydrofdi.errors.RenamedKeyWarning")
def test_a_setting_under_the_old_name_still_wins_over_the_file(tmp_path: Path) -> None:
    file = tmp_path / "new.yaml"
    file.write_text("name: new\nrecord: {duration: 2 s}\n")
    assert load_experiment(file, ["run.duration=4 s"]).parameters.record.duration == 4.0
