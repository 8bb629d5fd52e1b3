"""A reader who follows a page sees what the page shows."""

import re

import pytest

from tests.commands import run
from tests.documentation.pages import ROOT, blocks, compare, follow

DOCS = ROOT / "docs"
LONG = {
    "my-actuator.md", "my-csv.md", "monitor-a-machine.md", "what-can-i-detect.md",
    "another-oil-as-a-shift.md", "compare-two-sensors.md", "write-a-report.md",
}  # fmt: skip
PAGES = sorted([*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md")])
PAGES = [page for page in PAGES if page.name != "index.md"]


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.long] if page.name in LONG else []) for page in PAGES],
    ids=lambda page: page.stem,
)
def test_a_page_can_be_followed(page, tmp_path):
    follow(page, tmp_path)


def test_every_command_and_option_of_the_pages_exists():
    helps: dict[str, str] = {}
    for page in PAGES:
        for block in blocks(page):
            if block.language != "sh":
                continue
            for command, rest in re.findall(
                r"hydrofdi ([a-z]+)([^|;&#>\n]*)", block.text.replace("\\\n", " ")
            ):
                if command not in helps:
                    helps[command] = run(command, "--help", check=0).stdout
                for option in re.findall(r" (--[a-z-]+)", rest):
                    assert option in helps[command], f"{page.name}: hydrofdi {command} {option}"


@pytest.mark.parametrize(
    "shown",
    ["a 3 b", "…\na 3 b", "a …\nc\n", "a 3\nc", "c\na 3 b\n…", "a 3 b\nc\nd"],
)
def test_output_that_is_not_printed_is_noticed(shown):
    with pytest.raises(AssertionError, match=r"page\.md"):
        compare(shown, "a 3 b\nx\nc\n\n", "page.md")


@pytest.mark.parametrize("shown", ["a 3 b\nx\nc", "a … b\n…\nc", "…", "…\nx\n…"])
def test_output_may_be_shortened(shown):
    compare(shown, "a 3   b\nx\nc\n\n", "page.md")
