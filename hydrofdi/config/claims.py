"""The ``claims`` list: which sentences of the paper ``hydrofdi report --check`` guards."""

from __future__ import annotations

from typing import Literal

ClaimId = Literal["C1", "C2", "C3", "C4", "C5", "C6"]
"""Identity of a claim, as in docs/report.md."""
