"""The site as it is built and as a browser shows it."""

import re

import pytest

from tests.browser import needs_chromium, open_page, requests_of_the_page, serious_faults

pytestmark = pytest.mark.long

SHOWN = [
    "index.html", "tutorials/my-actuator.html", "gallery.html", "search.html", "reference/indicators.html",
    "reference/samples.html", "reference/commands/sweep.html", "reference/api/simulate.html",
]  # fmt: skip

OUTSIDE = re.compile(
    r"""<(?:script|img|iframe|source)[^>]*\ssrc=["'](?:https?:)?//|<link(?![^>]*rel=["']canonical)[^>]*\shref=["'](?:https?:)?//"""
    r"""|url\(["']?(?:https?:)?//|@import\s+["'(]+(?:https?:)?//"""
)


def test_no_page_or_style_loads_anything_from_elsewhere(site):
    files = [file for kind in ("html", "css") for file in site.rglob(f"*.{kind}")]
    assert len(files) > 100
    assert [file.name for file in files if OUTSIDE.search(file.read_text(encoding="utf-8"))] == []


def test_pages_that_people_ask_for_are_in_the_navigation(site):
    text = (site / "index.html").read_text(encoding="utf-8")
    bar = text.partition("bd-header")[2].partition("</header>")[0]
    rooms = ("tutorials/index", "how-to/index", "explanation/index", "reference/index", "gallery")
    assert all(f'href="{room}.html"' in bar for room in rooms)


def test_every_figure_of_the_gallery_was_drawn(site):
    text = (site / "gallery.html").read_text(encoding="utf-8")
    pictures = re.findall(r'<img[^>]*src="(_images/[^"]+)"', text)
    assert len(pictures) >= 15
    assert all((site / picture).stat().st_size > 10_000 for picture in pictures)


@needs_chromium
def test_search_finds_a_word_from_a_folder(site, tmp_path):
    asked = (site / "search.html").as_uri() + "?q=unsettled"
    dom, console = open_page(asked, tmp_path / "profile")
    found = re.findall(r'<li class="kind-[^"]*"><a href="([^"?#]+)', dom)
    assert "physics.html" in found
    assert [line for line in console if "Uncaught" in line or "blocked" in line] == []


@needs_chromium
@pytest.mark.parametrize("name", SHOWN)
def test_a_page_asks_no_host_for_anything_and_axe_finds_no_serious_fault(site, tmp_path, name):
    log = tmp_path / "network.json"
    open_page(site / name, tmp_path / "profile", f"--log-net-log={log}")
    assert requests_of_the_page(log.read_text(errors="replace")) == []
    for scheme in ("light", "dark"):
        assert serious_faults(site / name, tmp_path, scheme) == []
