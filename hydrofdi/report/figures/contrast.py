"""How well a colour can be read on another, after WCAG 2.2, success criterion 1.4.3."""

from __future__ import annotations

from typing import Any

WHITE, BLACK = "#ffffff", "#000000"
"""Text on coloured cells; on any colour, one of them has a contrast of at least 4.58."""


def contrast(color: Any, ground: Any) -> float:
    """Contrast ratio of two colours, from 1 to 21; text needs 4.5, lines and marks need 3.

    Parameters
    ----------
    color, ground : color
        As matplotlib takes them; transparency is ignored.
    """
    low, high = sorted((luminance(color), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


def luminance(color: Any) -> float:
    """Relative luminance, from 0 (black) to 1 (white)."""
    from matplotlib.colors import to_rgb

    red, green, blue = map(_linear, to_rgb(color))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def text_on(ground: Any) -> str:
    """Black or white, whichever reads better on a ground."""
    return max((BLACK, WHITE), key=lambda color: contrast(color, ground))


def _linear(channel: float) -> float:
    """A channel of sRGB without its gamma."""
    return channel / 12.92 if channel <= 0.04045 else float(((channel + 0.055) / 1.055) ** 2.4)
