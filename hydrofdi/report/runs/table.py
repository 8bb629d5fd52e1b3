"""The table of all runs, with its baseline."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from hydrofdi.config.shown_values import ShownParameter, shown_parameter
from hydrofdi.report.runs.rows import TableRow

EXTERNAL = "leakage.external_coefficient"
"""Prefix of the parameters of external leakage."""


@dataclass(frozen=True)
class SensitivityTable:
    """All rows, sealed rows first, with their baseline.

    Attributes
    ----------
    name : str
        Name of the experiment.
    rows : tuple of TableRow
    bands : tuple of (float, float)
        Nominal band of d1, d2, … [Hz].
    normal_bulk_modulus : float
        β of the fixed baseline [Pa].
    baseline : dict
        Dotted parameters of the fixed baseline.
    """

    name: str
    rows: tuple[TableRow, ...]
    bands: tuple[tuple[float, float], ...]
    normal_bulk_modulus: float
    baseline: dict[str, Any]

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return len(self.bands)

    @property
    def label_names(self) -> list[str]:
        """Varied parameters besides leakage and EBM."""
        return list(self.rows[0].labels)

    @cached_property
    def shown_labels(self) -> dict[str, ShownParameter]:
        """Varied parameters besides leakage and EBM → how people read their values."""
        return {
            name: shown_parameter(name, (row.labels[name] for row in self.rows)) for name in self.label_names
        }

    @cached_property
    def has_doubts(self) -> bool:
        """Whether any run that succeeded has a verdict other than ``ok``."""
        return any(row.doubts for row in self.rows)

    @cached_property
    def has_settled(self) -> bool:
        """Whether any run has features of its settled record."""
        return any(math.isfinite(row.settled_details.rms[0]) for row in self.rows)

    @property
    def varies_external(self) -> bool:
        """Whether the runs differ in their external leakage."""
        return any(name.startswith(EXTERNAL) for name in self.label_names)

    @property
    def modes(self) -> dict[float, tuple[float, float]]:
        """β [Pa] → smallest and largest f_h [Hz] of the runs that succeeded, in ascending order."""
        found: dict[float, list[float]] = {}
        for row in sorted(self.rows, key=_bulk_modulus):
            if math.isfinite(row.mode_frequency):
                found.setdefault(row.bulk_modulus, []).append(row.mode_frequency)
        return {beta: (min(frequencies), max(frequencies)) for beta, frequencies in found.items()}


def _bulk_modulus(row: TableRow) -> float:
    return row.bulk_modulus
