"""The JSON Schema of detector files."""

from __future__ import annotations

from typing import Any

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.settings.schema import described_schema


def detector_schema() -> dict[str, Any]:
    """The JSON Schema of a detector file, with the texts of its fields."""
    return described_schema(DetectorFile, "hydrofdi detector")
