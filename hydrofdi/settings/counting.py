"""Numbers of things, and values that were found, in messages."""

from __future__ import annotations

from numbers import Integral

_LONGEST = 60
"""Characters of a value that messages show."""


def counted(count: float, noun: str) -> str:
    """A number and its noun: ``1 run``, ``1,200 runs``, ``2.5 periods``, ``2 entries``."""
    plural = f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"
    number = f"{count:,}" if isinstance(count, Integral) else f"{count:g}"
    return f"{number} {noun if count == 1 else plural}"


def brief(found: object) -> str:
    """A value that was found, as Python writes it; only its type if that takes more than a few words."""
    text = repr(found)
    kind = type(found).__name__
    article = "an" if kind[0].lower() in "aeio" else "a"
    return text if len(text) <= _LONGEST and "\n" not in text else f"{article} {kind}"
