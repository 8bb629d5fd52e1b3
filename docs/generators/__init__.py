"""What the site shows beside the pages that people write: made anew by every build."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pygments.lexers.special import TextLexer

from generators import (
    commands,
    configuration,
    configurations,
    detectors,
    gallery,
    indicators,
    interface,
    links,
    outside,
    units,
)

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOMS = (commands, configuration, configurations, detectors, indicators, interface, outside, units)


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the generated pages before Sphinx looks for pages, and lead links to them."""
    app.add_lexer("csv", TextLexer)
    app.connect("builder-inited", write_pages)
    app.connect("source-read", links.lead_to_pages)
    app.connect("source-read", gallery.show_thumbnails)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(app: Sphinx) -> None:
    """Write all generated pages below ``reference/``."""
    for room in ROOMS:
        room.write(app.srcdir / "reference")
    gallery.draw(app.srcdir)
