"""The ``store`` section: what is kept of each run, and how."""

from __future__ import annotations

from typing import Literal

from hydrofdi.settings.quantities import Section


class StoreConfig(Section):
    """What the experiment file holds besides the features."""

    signals: Literal["all", "pressures", "none"] = "all"
    """``all`` signals, the chamber ``pressures`` alone, or ``none``."""

    compression: Literal["none", "lzf", "gzip"] = "none"
    """Compression of the signals."""

    dtype: Literal["float32", "float64"] = "float64"
    """Precision of the stored signals; features are always computed and stored in double precision."""
