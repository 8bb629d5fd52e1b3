"""Pages that show a file of the repository from outside of ``docs``."""

from __future__ import annotations

from pathlib import Path

from generators.links import led_to_pages
from generators.writing import write_page

ROOT = Path(__file__).parents[2]

SHOWN = {"changelog": "CHANGELOG.md", "contributing": "CONTRIBUTING.md", "table3": "results/table3/table3.md"}
"""Page below ``reference`` → file of the repository."""


def write(reference: Path) -> None:
    """Write these pages, with their links led to pages of the site."""
    for page, file in SHOWN.items():
        write_page(reference / f"{page}.md", led_to_pages((ROOT / file).read_text(encoding="utf-8"), file))
