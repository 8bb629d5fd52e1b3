"""The ``detection.online`` section: how long a leak that sets in during operation goes unnoticed."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from hydrofdi.settings.quantities import SI, Section


def _listed(given: Any) -> Any:
    return given if isinstance(given, list) else [given]


class ChartConfig(Section):
    """A control chart: the watched output and the rule."""

    of: str
    """The watched output: ``label.output`` of an indicator that follows records sample by sample and stores
    its trace (option ``trace_duration``), such as ``weak_rls.leakage``."""

    chart: str
    """The rule: ``cusum``, ``ewma``, ``glr`` or ``moving_window``."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the rule, which may also be given next to the other keys."""


class OnlineConfig(Section):
    """Control charts on the traces of a study: false alarms over time, and the delay after the onset."""

    false_alarm_every: Annotated[
        list[Annotated[float, SI("s", above=0, usual=("1 min", "1 year"))]],
        BeforeValidator(_listed),
        Field(min_length=1),
    ] = [24.0 * 3600.0]  # noqa: RUF012 (pydantic copies it)
    """Mean times between false alarms for which limits are set on healthy fit records [s]; one, or several
    for a curve of the delay."""

    charts: dict[str, ChartConfig] = Field(min_length=1)
    """Label → chart."""
