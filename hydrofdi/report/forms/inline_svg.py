"""SVG figures as parts of a page: own ids, the page's colours, and a name for screen readers."""

from __future__ import annotations

import re
from html import escape

_BEFORE_ROOT = re.compile(r".*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_IDENTITY = re.compile(r'\bid="([^"]+)"')
_REFERENCE = re.compile(r'(url\(#|href="#)([^")]+)')


def inline_svg(svg: str, name: str, label: str, colors: dict[str, str]) -> str:
    """An SVG file as an element of a page.

    Parameters
    ----------
    svg : str
        The text of the file.
    name : str
        Put before all ids, so that figures of one page do not share any.
    label : str
        What the figure shows, in words.
    colors : dict
        Colour in the file → CSS colour in the page.
    """
    text = _METADATA.sub("", _BEFORE_ROOT.sub("", svg, count=1))
    text = re.sub(r'\s(?:width|height)="[\d.]+pt"', "", text, count=2)
    text = _IDENTITY.sub(rf'id="{name}-\1"', text)
    text = _REFERENCE.sub(rf"\g<1>{name}-\2", text)
    for old, new in colors.items():
        text = text.replace(old, new)
    return text.replace("<svg", f'<svg role="img" aria-label="{escape(label)}"', 1).strip()
