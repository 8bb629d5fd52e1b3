"""Numbers of things in messages."""

from __future__ import annotations

from numbers import Integral


def counted(count: float, noun: str) -> str:
    """A number and its noun: ``1 run``, ``1,200 runs``, ``2.5 periods``, ``2 entries``."""
    plural = f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2:-1] not in "aeiou" else f"{noun}s"
    number = f"{count:,}" if isinstance(count, Integral) else f"{count:g}"
    return f"{number} {noun if count == 1 else plural}"
