"""Links of the pages to files of the repository that are no pages."""

from __future__ import annotations

import os
import re
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_LINK = re.compile(r"(?<=\]\()(?P<path>[^)\s#:]+)(?P<anchor>#[^)\s]*)?(?=\))")

_PAGES = {
    r"README\.md": "index.md",
    r"CHANGELOG\.md": "reference/changelog.md",
    r"CONTRIBUTING\.md": "reference/contributing.md",
    r"configs/schema\.json": "reference/configuration.md",
    r"configs/(measured|monitor)-schema\.json": "reference/samples.md",
    r"configs/fleet-schema\.json": "reference/samples.md#a-fleet",
    r"configs(/[\w/-]+)?": "reference/configurations/index.md",
    r"configs/(.+)\.yaml": r"reference/configurations/\1.md",
    r"docs/deploy": "monitoring-states.md",
    r"hydrofdi/indicators/catalogue": "reference/indicators.md",
    r"results/table3(/table3\.md)?": "reference/table3.md",
}
"""Pattern of files or folders of the repository → the page of the site that shows them."""


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
    matches = ((re.fullmatch(pattern, target), page) for pattern, page in _PAGES.items())
    shown = next((found.expand(page) for found, page in matches if found), None)
    if shown is None and target.startswith("docs/") and not str(folder).startswith("docs"):
        shown = target.removeprefix("docs/")
    return f"/{shown}{anchor}" if shown else f"{path}{anchor}"
