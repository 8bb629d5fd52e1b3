"""Links and anchors of all Markdown files of the repository, as a code host resolves them."""

import re
from functools import cache
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
ROOMS = "tutorials", "how-to", "explanation"
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/reference/index.md")),
    *sorted(
        page
        for room in ("", "tutorials/", "how-to/", "explanation/")
        for page in ROOT.glob(f"docs/{room}*.md")
    ),
]
"""Those that people write; the rest of the reference is made by the build, which checks its links."""


def parsed(page):
    return MarkdownIt().parse(page.read_text(encoding="utf-8"))


@cache
def anchors(page):
    """The anchors of a page: its headings in small letters, without punctuation, numbered when repeated."""
    tokens, slugs = parsed(page), []
    for place, token in enumerate(tokens):
        if token.type == "heading_open":
            parts = tokens[place + 1].children
            text = "".join(part.content for part in parts if part.type in ("text", "code_inline"))
            slug = re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")
            same = sum(re.fullmatch(rf"{re.escape(slug)}(-\d+)?", each) is not None for each in slugs)
            slugs.append(f"{slug}-{same}" if same else slug)
    return set(slugs)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_relative_link_leads_to_a_file_and_a_heading_of_it(page):
    parts = [part for token in parsed(page) for part in token.children or []]
    for target in filter(None, (part.attrGet("href") or part.attrGet("src") for part in parts)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{target}: no such file"
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{target}: no such heading"
