"""Links of all Markdown files that people write, as a code host resolves them; the build checks headings."""

import re
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = [page for page in ROOT.glob("docs/**/*.md") if "reference" not in page.parts]
PAGES += [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/reference/index.md")]


@pytest.mark.parametrize("page", sorted(PAGES), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_relative_link_leads_to_a_file(page):
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    parts = [part for token in tokens for part in token.children or []]
    for target in filter(None, (part.attrGet("href") or part.attrGet("src") for part in parts)):
        if not re.match(r"[a-z]+:|#", target):
            assert (page.parent / target.partition("#")[0]).exists(), f"{target}: no such file"
