"""The ``calibration`` section: how a leakage flow becomes a coefficient."""

from __future__ import annotations

from typing import Literal

from hydrofdi.settings.quantities import Section


class CalibrationConfig(Section):
    """How K_i is solved from ``leakage.internal_flow``."""

    at: Literal["run", "nominal"] = "run"
    """Actuator for which K_i is solved, under the baseline's conditions. ``run``: each run's own, except for
    what the baseline sets. ``nominal``: the experiment's nominal one, in each scenario of an ensemble; K_i is
    then solved once per leakage flow and does not depend on other drawn or swept parameters."""
