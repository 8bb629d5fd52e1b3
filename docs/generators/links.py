"""Links of the pages to files of the repository that are no pages."""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_LINK = re.compile(r"(?<=\]\()(?P<path>[^)\s#:]+)(?P<anchor>#[^)\s]*)?(?=\))")

_PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "reference/changelog.md",
    "CONTRIBUTING.md": "reference/contributing.md",
    "docs/decisions": "decisions/index.md",
    "docs/deploy": "monitoring-states.md",
    "results/table3": "reference/table3.md",
    "results/table3/table3.md": "reference/table3.md",
}
"""File or folder of the repository → the page of the site that shows it."""


def lead_to_pages(app: Sphinx, name: str, content: list[str]) -> None:
    """Lead links to files of the repository to the pages that show them: Sphinx passes each source."""
    page = f"docs/{app.env.doc2path(name, base=False)}"
    content[0] = led_to_pages(content[0], page)


def led_to_pages(text: str, page: str) -> str:
    """The text with its links led to pages.

    Parameters
    ----------
    text : str
        Markdown.
    page : str
        Path of its file in the repository, where relative links start.
    """
    folder = PurePosixPath(page).parent
    return _LINK.sub(lambda link: _led(link["path"], link["anchor"] or "", folder), text)


def _led(path: str, anchor: str, folder: PurePosixPath) -> str:
    target = os.path.normpath(folder / path)
    shown = _PAGES.get(target) or _configuration(target)
    if shown is None and target.startswith("docs/") and not str(folder).startswith("docs"):
        shown = target.removeprefix("docs/")
    return f"/{shown}{anchor}" if shown else f"{path}{anchor}"


def _configuration(target: str) -> str | None:
    if target == "configs" or (target.startswith("configs/") and not Path(target).suffix):
        return "reference/configurations/index.md"
    if target.startswith("configs/") and target.endswith(".yaml"):
        return f"reference/{target.replace('configs/', 'configurations/').removesuffix('.yaml')}.md"
    return None
