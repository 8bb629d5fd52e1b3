"""Links and anchors of all Markdown files of the repository, as a code host resolves them."""

import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
ROOMS = [DOCS, *(DOCS / room for room in ("tutorials", "how-to", "explanation"))]
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
