"""Numbers of things in messages."""

import re
from pathlib import Path

import numpy as np
import pytest

import hydrofdi
from hydrofdi.settings.counting import counted

PACKAGE = Path(hydrofdi.__file__).parent
IN_STORED_FILES = "config/sections/csv_input.py"
OWN_PLURAL = re.compile(r"""\w\{\s*(''|'s'|"s"|"")\s+if\b""")


@pytest.mark.parametrize(
    ("count", "noun", "told"),
    [
        (1, "run", "1 run"), (0, "run", "0 runs"), (1200, "run", "1,200 runs"), (1, "entry", "1 entry"),
        (np.int64(2), "entry", "2 entries"), (2, "array", "2 arrays"), (2.5, "period", "2.5 periods"),
        (1.0, "period", "1 period"),
    ],
)  # fmt: skip
def test_one_thing_is_counted_in_the_singular(count, noun, told):
    assert counted(count, noun) == told


def test_plurals_are_made_in_one_place():
    found = [
        f"{file.relative_to(PACKAGE)}: {line.strip()}"
        for file in sorted(PACKAGE.rglob("*.py"))
        if str(file.relative_to(PACKAGE)) != IN_STORED_FILES
        for line in file.read_text().splitlines()
        if OWN_PLURAL.search(line)
    ]
    assert found == []


def test_a_message_counts_records():
    with pytest.raises(hydrofdi.HydrofdiError, match="found 1; expected one for each of 2 records"):
        hydrofdi.measure(np.ones((2, 99)), label=["a"], sampling_frequency="1 kHz")
