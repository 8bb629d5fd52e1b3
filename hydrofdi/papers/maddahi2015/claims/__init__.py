"""The sentences of the paper as checks, and whether an experiment reproduces them."""

from hydrofdi.papers.maddahi2015.claims.catalogue import CLAIMS, Claim
from hydrofdi.papers.maddahi2015.claims.checks import D2, D3, Margin
from hydrofdi.papers.maddahi2015.claims.results import (
    CheckResult,
    ClaimResult,
    claim_margins,
    evaluate_claims,
)

__all__ = [
    "CLAIMS",
    "D2",
    "D3",
    "CheckResult",
    "Claim",
    "ClaimResult",
    "Margin",
    "claim_margins",
    "evaluate_claims",
]
