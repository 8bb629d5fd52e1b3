"""The ``store`` section: what is kept of each run."""

from __future__ import annotations

from typing import Literal

from hydrofdi.config.quantities import Section


class StoreConfig(Section):
    """What the experiment file holds besides the features."""

    signals: Literal["all", "pressures", "none"] = "all"
    """``all`` signals, the chamber ``pressures`` alone, or ``none``."""
