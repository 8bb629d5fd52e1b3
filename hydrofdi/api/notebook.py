"""What notebooks show: figures and sentences."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def shown(figure: Figure) -> Figure:
    """The figure, as a picture in notebooks: IPython shows figures without pyplot by this method alone."""
    from hydrofdi.report.figures.style import figure_bytes

    figure.__dict__["_repr_png_"] = partial(figure_bytes, figure, "png")
    return figure


def html_sentences(title: str, sentences: Iterable[str]) -> str:
    """A list of sentences below a title."""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f"<p><strong>{escape(title)}</strong></p><ul>{items}</ul>"
