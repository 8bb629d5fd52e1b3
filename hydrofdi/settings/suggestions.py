"""What an unknown name probably means; no suggestion rather than a far-fetched one."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import SequenceMatcher

from hydrofdi.settings.computed import computation
from hydrofdi.settings.synonyms import meant, plain_word

_MOST_MEANT, _MOST_LISTED = 3, 12
_ALIKE, _BEGINNING_ALIKE = 0.8, 0.6
"""Least similarity of a known name, and of one with the same first letter."""


def nearest(name: str, known: Sequence[str], elsewhere: Sequence[str] = (), section: str = "") -> str:
    """A hint at the known name that an unknown one probably means, or at all known names if they are few.

    Parameters
    ----------
    name : str
        Dotted where the known names are.
    known : sequence of str
        What may stand there.
    elsewhere : sequence of str
        Dotted names of what stands in other sections.
    section : str
        Where an undotted name stands.

    Returns
    -------
    str
        The end of a sentence; empty if there is nothing to say.
    """
    around, _, word = f"{section}.{name}".strip(".").rpartition(".")
    if keys := meant(word, known, around):
        return _did_you_mean(keys)
    own = [each for each in elsewhere if each.startswith(f"{section}.")]
    if how := computation(word, [*known, *own]):
        return how
    if hint := similar(name, known):
        return hint
    if how := computation(word, elsewhere, around):
        return how
    return _did_you_mean(meant(word, elsewhere, around)) or listed(known)


def similar(name: object, known: Sequence[str]) -> str:
    """A hint at the known name that is spelt alike, or has the same words; empty if there is none."""
    return _did_you_mean([found]) if isinstance(name, str) and (found := _similar(name, known)) else ""


def listed(known: Sequence[str]) -> str:
    """All known names; empty if there are none, or too many to read."""
    return f"; known: {', '.join(known)}" if 0 < len(known) <= _MOST_LISTED else ""


def _did_you_mean(keys: Sequence[str]) -> str:
    if not keys:
        return ""
    others = "" if len(keys) <= _MOST_MEANT else ", or that of another section"
    shown = keys[:1] if others else keys
    return f"; did you mean {' or '.join(map(repr, shown))}{others}?"


def _similar(name: str, known: Sequence[str]) -> str:
    """The known name that is spelt alike, or has the same words; empty if there is none.

    Of a dotted name, only the last word is compared with the names of its own section.
    """
    section, dot, _ = name.rpartition(".")
    own = [each for each in known if each.startswith(section + dot)] if dot else []
    start = len(section + dot) if own else 0
    word, candidates = name[start:], [each[start:] for each in own or known]
    found = _same_letters(word, candidates) or _longer(word, candidates) or _alike(word, candidates)
    return name[:start] + found if found else ""


def _same_letters(word: str, known: Sequence[str]) -> str:
    return next((each for each in known if plain_word(each) == plain_word(word)), "")


def _longer(word: str, known: Sequence[str]) -> str:
    """The one name that begins with a word, or has all its words and more."""
    if len(word) < 3:
        return ""
    longer = sorted((each for each in known if each.startswith(word)), key=len)
    words = set(word.split("_"))
    longer = longer or [each for each in known if words < set(each.split("_"))]
    return longer[0] if longer and all(each.startswith(longer[0]) for each in longer) else ""


def _alike(word: str, known: Sequence[str]) -> str:
    asked = word.lower()
    ranked = [(SequenceMatcher(None, each.lower(), asked).ratio(), each) for each in known if each and asked]
    least = (_BEGINNING_ALIKE if each[0].lower() == asked[0] else _ALIKE for _, each in ranked)
    good = [rank for rank, limit in zip(ranked, least, strict=True) if rank[0] >= limit]
    return max(good, key=lambda rank: rank[0])[1] if good and len(word) > 1 else ""
