"""The sentences of the paper that are checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hydrofdi.papers.maddahi2015.claims.checks import (
    Check,
    d2_falls_with_bulk_modulus,
    d2_grows_with_leakage,
    d2_is_most_sensitive,
    d3_alone_is_positive,
    d3_leads_above_normal,
    no_level_is_always_largest,
)
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper.

    Attributes
    ----------
    id : str
        C1 … C6.
    sentence : str
        What the paper says.
    rule : str
        What is checked.
    checks : callable
        Grid → the checks that it allows.
    """

    id: str
    sentence: str
    rule: str
    checks: Callable[[ModeGrid], list[Check]]


CLAIMS = (
    Claim(
        "C1",
        "At normal EBM d2 is the most sensitive coefficient.",
        "at β0, for each leakage: δd2 > 0 and the largest",
        d2_is_most_sensitive,
    ),
    Claim(
        "C2",
        "At normal EBM δd2 grows with leakage.",
        "at β0: δd2(q1) < δd2(q2) < δd2(q3)",
        d2_grows_with_leakage,
    ),
    Claim(
        "C3",
        "For a given leakage δd2 falls as EBM rises.",
        "for each leakage: δd2 strictly decreasing over β",
        d2_falls_with_bulk_modulus,
    ),
    Claim(
        "C4",
        "Above normal EBM d3 has the most positive sensitivity.",
        "for each leakage and each β > β0: δd3 > 0 and the largest",
        d3_leads_above_normal,
    ),
    Claim(
        "C5",
        "With the small leakage and EBM above normal, δd3 is the only positive one.",
        "for q1 and each β > β0: δd3 > 0, all others < 0",
        d3_alone_is_positive,
    ),
    Claim(
        "C6",
        "Absolute values lead to no conclusion.",
        "the level with the largest abs(δ) is not the same in all leaky modes",
        no_level_is_always_largest,
    ),
)
"""All claims, in their order."""
