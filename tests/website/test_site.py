"""The site as it is built and as a browser shows it."""

import re
import shlex
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from generators import commands, configurations, detectors, interface, units
from generators.examples import EXAMPLES
from generators.links import led_to_pages
from markdown_it import MarkdownIt

import hydrofdi
from hydrofdi.settings.ready import ready_names
from tests.browser import needs_chromium, open_page, requests_of_the_page, serious_faults

pytestmark = pytest.mark.long

SHOWN = [
    "index.html", "tutorials/my-actuator.html", "gallery.html", "search.html", "indicators.html",
    "reference/commands/sweep.html", "reference/api/simulate.html",
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
@pytest.mark.parametrize("name", SHOWN)
def test_a_page_asks_no_host_for_anything(site, tmp_path, name):
    log = tmp_path / "network.json"
    open_page(site / name, tmp_path / "profile", f"--log-net-log={log}")
    assert requests_of_the_page(log.read_text(errors="replace")) == []


@needs_chromium
def test_search_finds_a_word_from_a_folder(site, tmp_path):
    asked = (site / "search.html").as_uri() + "?q=unsettled"
    dom, console = open_page(asked, tmp_path / "profile")
    found = re.findall(r'<li class="kind-[^"]*"><a href="([^"?#]+)', dom)
    assert "physics.html" in found
    assert [line for line in console if "Uncaught" in line or "blocked" in line] == []


@needs_chromium
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", SHOWN)
def test_axe_finds_no_serious_fault(site, tmp_path, name, scheme):
    assert serious_faults(site / name, tmp_path, scheme) == []


@needs_chromium
def test_the_keyboard_focus_is_visible(site, tmp_path):
    probed = site / "probed-focus.html"
    script = (
        "setTimeout(() => { const seen = [...document.querySelectorAll('a[href], button')]"
        ".filter(e => e.offsetParent).map(e => { e.focus(); const s = getComputedStyle(e);"
        " return document.activeElement !== e ||"
        " (s.outlineStyle === 'solid' && parseFloat(s.outlineWidth) >= 2); });"
        " const made = document.createElement('pre'); made.id = 'focus-seen';"
        " made.textContent = JSON.stringify(seen); document.body.append(made); }, 1000);"
    )
    text = (site / "index.html").read_text(encoding="utf-8")
    probed.write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    dom, _ = open_page(probed, tmp_path / "profile")
    seen = re.search(r'<pre id="focus-seen">\[(.*?)\]</pre>', dom)[1].split(",")
    assert len(seen) > 15
    assert set(seen) == {"true"}


pytest.importorskip("markdown_it", reason="the extra 'docs' is not installed")


ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
ROOMS = [DOCS, *(DOCS / room for room in ("tutorials", "how-to", "explanation", "decisions"))]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(page for room in ROOMS for page in sorted(room.glob("*.md"))),
    DOCS / "reference" / "index.md",
]
"""Those that people write; the rest of the reference is made by the build, which checks its links."""


def tokens(page):
    def walk(found):
        for token in found:
            yield token
            yield from walk(token.children or [])

    return list(walk(MarkdownIt().parse(page.read_text(encoding="utf-8"))))


def targets(page):
    found = [token.attrGet("href") or token.attrGet("src") for token in tokens(page)]
    return [target for target in found if target and not re.match(r"[a-z]+:", target)]


@cache
def anchors(page):
    """The anchors of a page: its headings in small letters, without punctuation, numbered when repeated."""
    parsed, slugs = MarkdownIt().parse(page.read_text(encoding="utf-8")), []
    for heading, inline in pairwise(parsed):
        if heading.type == "heading_open":
            text = "".join(
                child.content for child in inline.children if child.type in ("text", "code_inline")
            )
            slug = re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")
            same = sum(re.fullmatch(rf"{re.escape(slug)}(-\d+)?", each) is not None for each in slugs)
            slugs.append(f"{slug}-{same}" if same else slug)
    return set(slugs)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_relative_link_leads_to_a_file_and_a_heading_of_it(page):
    for target in targets(page):
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{target}: no such file"
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{target}: no such heading"


pytest.importorskip("sphinx", reason="the extra 'docs' is not installed")


GENERATED_PAGES_DOCS = Path(__file__).parents[2] / "docs"
COMMANDS = commands.command_group().commands


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reference")
    for room in (commands, configurations, detectors, interface, units):
        room.write(folder)
    return folder


def test_every_command_has_a_page_with_its_options_and_an_example(reference):
    assert {page.stem for page in (reference / "commands").iterdir()} == {"index", *COMMANDS}
    for name, command in COMMANDS.items():
        text = (reference / "commands" / f"{name}.md").read_text(encoding="utf-8")
        options = [
            option for parameter in command.params for option in parameter.opts if option.startswith("--")
        ]
        assert all(f"`{option}" in text for option in options if option != "--help")
        assert f"hydrofdi {name}" in text.partition("## Examples")[2]


@pytest.mark.parametrize("line", [line for text in EXAMPLES.values() for line in text.splitlines()])
def test_every_example_is_a_command_line_that_hydrofdi_takes(line):
    for part in line.replace(" > ", " | ").split(" | "):
        program, *arguments = shlex.split(part)
        if program == "hydrofdi":
            name, *rest = arguments
            COMMANDS[name].make_context(name, rest)


def test_every_public_name_has_a_page_and_a_place_in_the_overview(reference):
    index = (reference / "api" / "index.md").read_text(encoding="utf-8")
    for name in set(hydrofdi.__all__) - {"__version__"}:
        assert f"   hydrofdi.{name}\n" in index
        assert f":: hydrofdi.{name}\n" in (reference / "api" / f"{name}.md").read_text(encoding="utf-8")


def test_every_ready_configuration_has_a_page_with_its_file(reference):
    for name in ready_names():
        page = reference / "configurations" / f"{name}.md"
        assert f"configs/{name}.yaml\n" in page.read_text(encoding="utf-8")
        assert f"]({name}.md)" in (reference / "configurations" / "index.md").read_text(encoding="utf-8")


def test_every_kind_of_figure_is_in_the_gallery():
    text = (GENERATED_PAGES_DOCS / "gallery.md").read_text(encoding="utf-8")
    _, listed = (GENERATED_PAGES_DOCS / "report.md").read_text(encoding="utf-8").split("## Figures")
    figures = re.findall(r"`(\w+)`", " ".join(re.findall(r"^\| (`.*?) \|", listed, re.MULTILINE)))
    assert len(figures) > 15
    assert [name for name in figures if f"{name}.png" not in text and f"`{name}`" not in text] == []


@pytest.mark.parametrize(
    ("page", "link", "led"),
    [
        ("docs/results.md", "../configs/table3.yaml", "/reference/configurations/table3.md"),
        ("docs/running.md", "../configs/", "/reference/configurations/index.md"),
        ("CHANGELOG.md", "docs/files.md#layout", "/files.md#layout"),
        ("docs/measured.md", "https://example.org/a.yaml", "https://example.org/a.yaml"),
    ],
)
def test_links_lead_to_the_page_that_shows_the_file(page, link, led):
    assert led_to_pages(f"see [this]({link}).", page) == f"see [this]({led})."
