"""Figures that notebooks show."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def shown(figure: Figure) -> Figure:
    """The figure, as a picture in notebooks: IPython shows figures without pyplot by this method alone."""
    from hydrofdi.report.figures.style import figure_bytes

    figure.__dict__["_repr_png_"] = partial(figure_bytes, figure, "png")
    return figure
