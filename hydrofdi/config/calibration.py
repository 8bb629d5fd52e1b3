"""The ``calibration`` section: how a leakage flow becomes a coefficient."""

from __future__ import annotations

from typing import Literal

from hydrofdi.settings.quantities import Section


class CalibrationConfig(Section):
    """How K_i is solved from ``leakage.internal_flow``."""

    at: Literal["run", "nominal"] = "run"
    """The actuator for which K_i is solved, under the baseline's conditions. ``run``: each run's own, but for
    what the baseline names. ``nominal``: the experiment's nominal one, in each scenario of an ensemble; K_i
    is then solved once for each leakage flow, and the same whatever else is drawn or swept."""
