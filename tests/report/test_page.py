"""Tables, intervals and pages of reports."""

import csv
import math
import re

import numpy as np
import pytest
from scipy.stats import binomtest

from hydrofdi.errors import UnknownNameError
from hydrofdi.papers.maddahi2015.study import clustered_share
from hydrofdi.report.page import write_page
from hydrofdi.tables.table import Column, Table, quantity
from tests.browser import needs_chromium, open_page, requests_of_the_page, serious_faults


@pytest.fixture(scope="module")
def page(paper_analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "table3.html"
    write_page(paper_analysis, path)
    return path


def test_the_page_names_no_other_host_has_no_script_and_unique_ids_to_which_its_references_lead(page):
    text = page.read_text(encoding="utf-8")
    assert "<script" not in text
    outside = re.findall(r"""(?:src|href|action)\s*=\s*["']?(?!#|data:)[^"'\s>]+""", text)
    assert outside == []
    assert re.findall(r"url\((?!#)", text) == []
    assert "@import" not in text
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    assert {*re.findall(r'href="#([^"]+)"', text), *re.findall(r"url\(#([^)]+)\)", text)} <= set(ids)


@needs_chromium
def test_all_figures_and_tables_are_there_the_console_is_silent_and_no_host_is_asked(
    page, paper_analysis, tmp_path
):
    log = tmp_path / "network.json"
    dom, console = open_page(page, tmp_path / "profile", f"--log-net-log={log}")
    shown = re.findall(r'<figure id="(\w+)" tabindex="0">\s*<svg', dom)
    assert sorted(shown) == sorted(set(paper_analysis.figures()) - {"responses"})
    assert (console, requests_of_the_page(log.read_text(errors="replace"))) == ([], [])
    for baseline in ("fixed", "matched"):
        table = re.search(rf'<table id="table3-{baseline}">.*?<tbody>(.*?)</table>', dom, re.DOTALL)[1]
        rows = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr.*?</tr>", table, re.DOTALL)]
        found = [[float(re.sub("<.*?>", "", text).replace("−", "-")) for text in row[3:]] for row in rows]
        expected = [row[f"delta_{baseline}_percent"] for row in paper_analysis.record()["rows"]]
        assert found == [pytest.approx(row, abs=0.051) for row in expected]


@pytest.mark.long
@needs_chromium
def test_a_request_of_a_page_would_be_seen(tmp_path):
    asking = tmp_path / "asking.html"
    asking.write_text('<!DOCTYPE html><html><body><img src="http://example.invalid/a.png"></body></html>')
    log = tmp_path / "network.json"
    open_page(asking, tmp_path / "profile", f"--log-net-log={log}")
    assert "http://example.invalid/a.png" in requests_of_the_page(log.read_text(errors="replace"))


@needs_chromium
@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_axe_finds_no_serious_fault(page, tmp_path, scheme):
    assert serious_faults(page, tmp_path, scheme) == []


@pytest.fixture
def table():
    columns = (
        Column("record", ["a|b", "c*"], is_text=True),
        Column("flow", np.array([1.25e-5, math.nan]), "m^3/s", "Flow [L/min]", lambda q: f"{q * 6e4:g}"),
        Column("n", [3, None], strong=(0,)),
        Column("rms", np.arange(4.0).reshape(2, 2), "Pa", dims=("level",)),
    )
    return Table(columns, title="Records", row="record", notes=("a note",), breaks=(1,))


def test_programs_get_all_numbers_and_none_where_one_is_missing(table, tmp_path):
    from pyarrow import parquet

    assert table.columns == ["record", "flow", "n", "rms"]
    assert table.to_dict()["flow"] == [1.25e-5, None]
    assert [*table][1] == {"record": "c*", "flow": None, "n": None, "rms": [2.0, 3.0]}
    rows = [*csv.DictReader(table.to_csv().splitlines())]
    assert [*rows[0]] == [*table.to_pandas().columns] == ["record", "flow", "n", "rms.0", "rms.1"]
    assert (float(rows[0]["flow"]), rows[1]["flow"]) == (1.25e-5, "")
    dataset = table.to_xarray()
    assert dataset["rms"].dims == ("record", "level")
    assert dataset["flow"].attrs == {"units": "m^3/s"}
    (tmp_path / "t.parquet").write_bytes(table.to_parquet())
    assert parquet.read_table(tmp_path / "t.parquet")["flow"].to_pylist() == [1.25e-5, None]
    np.testing.assert_array_equal(table["n"], [3.0, np.nan])
    mixed = Table.of({"alarm": [True, None], "fault": ["", ""]})
    assert mixed["alarm"].tolist() == [True, None]
    assert [each.name for each in mixed.shown] == ["alarm"]
    with pytest.raises(UnknownNameError):
        table["flwo"]


def test_people_read_headings_and_texts_and_not_the_arrays(table):
    """Markdown keeps its columns whatever the texts contain, and HTML escapes them."""
    assert [column.heading for column in table.shown] == ["record", "Flow [L/min]", "n"]
    assert next(table.texts()) == [("a|b", False), ("0.75", False), ("3", True)]
    lines, shown = table.to_markdown().splitlines(), [*table.lines(80)]
    assert [line.replace(r"\|", "").count("|") for line in lines] == [4] * 4
    assert "**3**" in lines[2]
    assert r"c\*" in lines[3]
    assert shown[next(n for n, line in enumerate(shown) if "c*" in line) - 1] == ""
    page = Table((Column("name", ["<script>"]),)).to_html()
    assert ("&lt;script&gt;" in page, "<script>" in page) == (True, False)
    small = quantity("p_error", [1.25e4], "Pa", sizes=[8.6e6])
    assert (small.heading, small.text_of(0), small.listed) == ("p_error [MPa]", "0.0125", [1.25e4])
    assert quantity("p", [8.6e6, None], "Pa").heading == "p [MPa]"
    records = Table.of_records([{"delay_median_s": 1.5, "stated_deviation_L_per_min": 0.1, "δd2_percent": 3}])
    headings = [each.heading for each in records.shown]
    assert headings == ["Delay median [s]", "Stated deviation [L/min]", "δd2 [%]"]
    named = Table((Column("leakage.external_coefficient_1", [1.0]),))
    assert {"deviation", "coefficient_1"} <= {*f"{records}\n{named}".split()}, "no word is broken"


@pytest.mark.parametrize("truth", [0.05, 0.5, 0.9])
@pytest.mark.parametrize("alike", [0.0, 0.5, 1.0])
def test_the_interval_covers_the_truth_however_alike_the_pairs_are(truth: float, alike: float) -> None:
    generator, repeats, n_pair, covered = np.random.default_rng(3), 1500, 120, 0
    for _ in range(repeats):
        first = generator.random(n_pair) < truth
        second = np.where(generator.random(n_pair) < alike, first, generator.random(n_pair) < truth)
        share = clustered_share(np.column_stack([first, second]).ravel(), np.repeat(np.arange(n_pair), 2))
        covered += share.low <= truth <= share.high
    assert 0.93 < covered / repeats < 0.975


def test_pairs_that_agree_count_once_and_no_draws_have_no_share() -> None:
    share = clustered_share(np.repeat(np.arange(100) < 30, 2), np.repeat(np.arange(100), 2))
    assert (share.count, share.total) == (60, 200)
    expected = binomtest(30, 100).proportion_ci(0.95, method="wilson")
    assert (share.low, share.high) == pytest.approx((expected.low, expected.high), abs=1e-3)
    nothing = clustered_share(np.zeros(0, dtype=bool), [])
    assert (nothing.total, np.isnan(nothing.value)) == (0, True)
