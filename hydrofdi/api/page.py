"""Sentences as HTML, which notebooks show."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


def html_sentences(title: str, sentences: Iterable[str]) -> str:
    """A list of sentences below a title."""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return f"<p><strong>{escape(title)}</strong></p><ul>{items}</ul>"
