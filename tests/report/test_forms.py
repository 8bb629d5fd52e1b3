"""Every form of a report. HYDROFDI_WRITE_GOLDEN=1 writes the golden texts anew."""

import csv
import io
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hydrofdi.api.stored import read_results
from hydrofdi.papers import make_report
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.figures import KINDS
from hydrofdi.report.forms.page import render_page, write_all_forms
from hydrofdi.report.record import render_json, tidy_columns
from hydrofdi.report.table import Table
from hydrofdi.store.layout import names

GOLDEN = Path(__file__).parent / "golden"


def without_configuration(report):
    """A report less its configuration, which grows with every parameter that hydrofdi gains."""
    document = report.document()
    return replace(document, blocks=tuple(block for block in document.blocks if block.key != "provenance"))


@pytest.mark.parametrize(
    ("suffix", "render"),
    [
        ("csv", lambda report: Table.of(report.columns()).to_csv()),
        ("json", render_json),
        ("html", lambda report: render_page(without_configuration(report), {}, {})),
    ],
)
def test_a_form_has_its_golden_text(made_up, suffix, render):
    check_golden(f"made_up.{suffix}", render(make_report(made_up)))


def check_golden(name, text):
    path = GOLDEN / name
    if os.environ.get("HYDROFDI_WRITE_GOLDEN"):
        GOLDEN.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")


NUMBERS = st.lists(st.floats(-1e200, 1e200) | st.just(float("nan")), min_size=6, max_size=6)
NAMES = (names.MEAN_LEAKAGE_FLOW, names.MODE_FREQUENCY, names.MODE_DAMPING_RATIO, names.DETAIL_RMS)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50, deadline=None)
@given(columns=st.fixed_dictionaries(dict.fromkeys(NAMES, NUMBERS)))
def test_a_table_survives_csv_and_json(made_up, columns):
    columns[names.DETAIL_RMS] = np.tile(columns[names.DETAIL_RMS], (5, 1)).T
    with np.errstate(all="ignore"):
        report = make_report(replace(made_up, columns=made_up.columns | columns_of(columns)))
        tidy, record = tidy_columns(report.analysis), report.record()
    read = list(csv.DictReader(io.StringIO(Table.of(tidy).to_csv())))
    for header, values in tidy.items():
        texts = [line[header] for line in read]
        for text, value in zip(texts, values, strict=True):
            assert text == "" if value is None else type(value)(text) == value
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    for run, line in zip(report.analysis.table[names.DETAIL_RMS].tolist(), record["rows"], strict=True):
        assert line["detail_rms_Pa"] == [value if value == value else None for value in run]


def columns_of(lists):
    return {name: np.array(values) for name, values in lists.items()}


def test_parquet_holds_the_same_columns_as_csv(made_up):
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra 'parquet' is not installed")
    analysis = Analysis(made_up)
    read = parquet.read_table(io.BytesIO(Table.of(tidy_columns(analysis)).to_parquet()))
    assert read.to_pydict() == tidy_columns(analysis)


def test_the_same_data_give_the_same_bytes_in_all_forms(small_sweep, tmp_path):
    report = StudyReport(Study(read_results(small_sweep.directory)))
    for name in ("first", "second"):
        list(write_all_forms(report, tmp_path / name))
    files = sorted(path.name for path in (tmp_path / "first").iterdir())
    figures = ("figure2", "figure3", "figure4", "sensitivity", "spectrum", "mode_plane")
    forms = {f"small.{suffix}" for suffix in ("md", "csv", "json", "html")}
    assert {*files} - {"small.parquet"} == forms | {f"{name}.{kind}" for name in figures for kind in KINDS}
    for file in files:
        assert (tmp_path / "first" / file).read_bytes() == (tmp_path / "second" / file).read_bytes(), file


def test_the_page_shows_configuration_and_versions(made_up):
    page = render_page(make_report(made_up).document(), {}, {})
    assert '<td class="words">actuator.mass</td><td class="words">12.3 kg</td>' in page
    assert '<td class="words">numpy</td><td class="words">2.0</td>' in page


def test_text_is_no_formula_in_a_spreadsheet():
    cells = ["=1+1", "+a", "-b", "@c", "\td", "e=1", -1.5, None]
    lines = Table.of({"label": cells}).to_csv().splitlines()
    assert lines == ["label", "'=1+1", "'+a", "'-b", "'@c", "'\td", "e=1", "-1.5", '""']
