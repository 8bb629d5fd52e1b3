"""The keys ``paper`` and ``claims``: whose study an experiment is, and which sentences ``--check`` guards."""

from __future__ import annotations

from typing import Literal

Paper = Literal["maddahi2015"]
"""A paper whose study hydrofdi knows: a package in `hydrofdi.papers`."""

ClaimId = Literal["C1", "C2", "C3", "C4", "C5", "C6"]
"""Identity of a claim, as in docs/report.md."""
