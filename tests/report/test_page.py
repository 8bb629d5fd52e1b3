"""The page as a browser sees it: Debian's chromium, headless; axe-core from the test extra."""

import re

import pytest

from hydrofdi.papers import make_report
from hydrofdi.papers.maddahi2015.report import StudyReport
from hydrofdi.report.forms.page import write_page
from tests.browser import needs_chromium, open_page, requests_of_the_page, serious_faults


@pytest.fixture(scope="module")
def page(paper_analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "table3.html"
    write_page(StudyReport(paper_analysis), path)
    return path


@pytest.fixture(scope="module")
def opened(page, tmp_path_factory):
    profile = tmp_path_factory.mktemp("profile")
    log = profile / "network.json"
    dom, console = open_page(page, profile, f"--log-net-log={log}")
    return dom, console, log.read_text(errors="replace")


def test_the_page_names_no_other_host_and_has_no_script(page):
    text = page.read_text(encoding="utf-8")
    assert "<script" not in text
    outside = re.findall(r"""(?:src|href|action)\s*=\s*["']?(?!#|data:)[^"'\s>]+""", text)
    assert outside == []
    assert re.findall(r"url\((?!#)", text) == []
    assert "@import" not in text


def test_the_ids_of_the_page_are_unique_and_all_references_have_a_target(page):
    text = page.read_text(encoding="utf-8")
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    assert {*re.findall(r'href="#([^"]+)"', text), *re.findall(r"url\(#([^)]+)\)", text)} <= set(ids)


@needs_chromium
def test_all_figures_are_there_and_the_console_is_silent(opened, paper_analysis):
    dom, console, _ = opened
    shown = re.findall(r'<figure id="(\w+)" tabindex="0">\s*<svg', dom)
    assert sorted(shown) == sorted(set(StudyReport(paper_analysis).figures()) - {"scenarios", "responses"})
    assert console == []


@needs_chromium
def test_the_page_asks_no_host_for_anything(opened):
    assert requests_of_the_page(opened[2]) == []


@pytest.mark.long
@needs_chromium
def test_a_request_of_a_page_would_be_seen(tmp_path):
    asking = tmp_path / "asking.html"
    asking.write_text('<!DOCTYPE html><html><body><img src="http://example.invalid/a.png"></body></html>')
    log = tmp_path / "network.json"
    open_page(asking, tmp_path / "profile", f"--log-net-log={log}")
    assert "http://example.invalid/a.png" in requests_of_the_page(log.read_text(errors="replace"))


@needs_chromium
def test_the_tables_are_those_of_the_json(opened, paper_analysis):
    dom, _, _ = opened
    record = StudyReport(paper_analysis).record()
    for baseline in ("fixed", "matched"):
        table = re.search(rf'<table id="table3-{baseline}">.*?</table>', dom, re.DOTALL)[0]
        body = table.partition("<tbody>")[2]
        rows = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr.*?</tr>", body, re.DOTALL)]
        shown = [[float(re.sub("<.*?>", "", text).replace("−", "-")) for text in row[3:]] for row in rows]
        assert shown == [pytest.approx(row[f"delta_{baseline}_percent"], abs=0.051) for row in record["rows"]]


@needs_chromium
@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_axe_finds_no_serious_fault(page, tmp_path, scheme):
    assert serious_faults(page, tmp_path, scheme) == []


def test_a_figure_that_cannot_be_drawn_leaves_a_hole_with_the_reason(made_up, tmp_path):
    path = tmp_path / "made_up.html"
    write_page(make_report(made_up), path)
    text = path.read_text(encoding="utf-8")
    assert '<p class="hole">This figure is missing: ' in text
    assert "results/made_up/made_up.h5: no such file" in text
