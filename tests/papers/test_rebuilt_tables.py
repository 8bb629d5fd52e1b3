"""A fresh run of the study against the tables that the repository keeps.

The same machine gives the same bits. Another processor or library version may round differently in the last
bits, which the stiff friction zone can magnify over 20 s. The tolerance of 0.05 percentage points is half of
the last digit that the tables print: within it no printed number changes by more than one unit of that digit.
Identities of runs and the configuration change with every new parameter, and are not compared.
"""

import csv
import re
from pathlib import Path

import pytest

from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.report.forms.page import render_markdown
from hydrofdi.report.record import tidy_columns

KEPT = Path(__file__).parents[2] / "results" / "table3"
TOLERANCE = {"delta_fixed_percent": 0.05, "delta_matched_percent": 0.05}


def test_the_numbers_are_those_that_the_repository_keeps(paper_analysis):
    with open(KEPT / "table3.csv", newline="", encoding="utf-8") as file:
        kept = list(csv.DictReader(file))
    columns = tidy_columns(paper_analysis)
    assert list(kept[0]) == list(columns)
    del columns["run_id"]
    for header, values in columns.items():
        texts = [line[header] for line in kept]
        if isinstance(values[0], float):
            numbers = [float(text) for text in texts]
            assert values == pytest.approx(numbers, rel=1e-4, abs=TOLERANCE.get(header, 1e-12)), header
        else:
            assert [str(value) for value in values] == texts, header


def test_the_markdown_is_that_which_the_repository_keeps(paper_analysis):
    kept = words((KEPT / "table3.md").read_text(encoding="utf-8"))
    fresh = words(render_markdown(StudyReport(paper_analysis).document()))
    assert [word for word in fresh if not is_number(word)] == [word for word in kept if not is_number(word)]
    numbers = [float(word) for word in kept if is_number(word)]
    assert [float(word) for word in fresh if is_number(word)] == pytest.approx(numbers, rel=1e-4, abs=0.11)


def words(markdown):
    """Words without emphasis and identities of runs, up to the configuration."""
    text = re.sub(r"\*\*|[|,;:()]", " ", markdown.partition("## Configuration")[0])
    return [word for word in text.split() if not re.fullmatch(r"[0-9a-f]{6}", word)]


def is_number(word):
    return re.fullmatch(r"[-+]?\d+(\.\d+)?\.?", word) is not None
