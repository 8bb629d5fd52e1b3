"""Storage of solved leakage coefficients, so that a resumed sweep does not solve them again."""

from __future__ import annotations

import json
from pathlib import Path

from hydrofdi.store.files import write_whole_text

_FILE = "calibrations.json"


def read_calibrations(directory: Path) -> dict[str, float]:
    """Identity of a calibration → K_i [m^3.5/kg^0.5]; empty if no readable file exists."""
    try:
        return {str(key): float(value) for key, value in json.loads((directory / _FILE).read_text()).items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def write_calibrations(directory: Path, coefficients: dict[str, float]) -> None:
    """Store solved coefficients.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    write_whole_text(directory / _FILE, json.dumps(coefficients, indent=0, sort_keys=True))
