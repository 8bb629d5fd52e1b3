"""The page as a browser sees it: Debian's chromium, headless; axe-core from the test extra."""

import json
import os
import re
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, files

import pytest

from hydrofdi.papers import make_report
from hydrofdi.papers.maddahi2015 import StudyReport
from hydrofdi.report.publication import write_page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
    "--disable-default-apps",
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--virtual-time-budget=20000", "--enable-logging=stderr", "--v=0",
)  # fmt: skip

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium here (Debian package chromium)")


@pytest.fixture(scope="module")
def page(paper_analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "table3.html"
    write_page(StudyReport(paper_analysis), path)
    return path


def open_page(path, profile, *flags):
    """The document after loading, and what the browser says of its console."""
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", *flags, "--dump-dom", path.as_uri()]
    environment = {**os.environ, "HOME": str(profile)}
    result = subprocess.run(command, capture_output=True, text=True, timeout=100, env=environment)
    assert result.returncode == 0, result.stderr[-2000:]
    console = [line for line in result.stderr.splitlines() if "CONSOLE" in line]
    return result.stdout, console


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
    shown = re.findall(r'<figure id="(\w+)">\s*<svg', dom)
    assert sorted(shown) == sorted(set(StudyReport(paper_analysis).figures()) - {"scenarios"})
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


def requests_of_the_page(log):
    """URLs that the page itself asked for; what the browser asks for by itself has no origin."""
    parameters = [event.get("params", {}) for event in json.loads(log)["events"]]
    asked = [
        params["url"] for params in parameters if params.get("initiator", "not an origin") != "not an origin"
    ]
    return [url for url in asked if not url.startswith(("file:", "data:"))]


@needs_chromium
def test_the_tables_are_those_of_the_json(opened, paper_analysis):
    dom, _, _ = opened
    record = StudyReport(paper_analysis).record()
    for baseline in ("fixed", "matched"):
        table = re.search(rf'<table id="table3-{baseline}">.*?</table>', dom, re.DOTALL)[0]
        body = table.partition("<tbody>")[2]
        rows = [
            re.findall(r'<data value="([^"]*)">', row) for row in re.findall(r"<tr.*?</tr>", body, re.DOTALL)
        ]
        assert [[float(value) for value in row] for row in rows] == [
            [
                row["leakage_L_per_min"], row["bulk_modulus_MPa"], row["hydraulic_mode_Hz"],
                *row[f"delta_{baseline}_percent"],
            ]
            for row in record["rows"]
        ]  # fmt: skip
    claims = re.search(r'<table id="claims">.*?</table>', dom, re.DOTALL)[0]
    margins = [float(value) for value in re.findall(r'<data value="([-+.e\d]+)">', claims)]
    keys = ("margin_percentage_points", "each_may_move_percentage_points")
    assert margins == [claim[key] for claim in record["claims"] for key in keys]


def axe_source():
    try:
        packaged = files("axe-core-python") or []
    except PackageNotFoundError:
        pytest.skip("axe-core-python of the test extra is not installed")
    (script,) = [file for file in packaged if file.name == "axe.min.js"]
    return script.read_text(encoding="utf-8")


@needs_chromium
@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_axe_finds_no_serious_fault(page, tmp_path, scheme):
    run = (
        "axe.run().then(found => { const made = document.createElement('pre'); made.id = 'axe-found';"
        " made.textContent = JSON.stringify(found.violations.map(v => [v.impact, v.id, v.nodes.length]));"
        " document.body.append(made); });"
    )
    probed = tmp_path / "probed.html"
    text = page.read_text(encoding="utf-8")
    probed.write_text(
        text.replace("</body>", f"<script>{axe_source()}</script><script>{run}</script></body>"),
        encoding="utf-8",
    )
    colors = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    dom, _ = open_page(probed, tmp_path / "profile", *colors)
    found = json.loads(re.search(r'<pre id="axe-found">(.*?)</pre>', dom)[1])
    assert [violation for violation in found if violation[0] in ("serious", "critical")] == []


def test_a_figure_that_cannot_be_drawn_leaves_a_hole_with_the_reason(made_up, tmp_path):
    path = tmp_path / "made_up.html"
    write_page(make_report(made_up), path)
    text = path.read_text(encoding="utf-8")
    assert '<p class="hole">This figure is missing: ' in text
    assert "results/made_up/made_up.h5: no such file" in text
