"""The ``analysis`` section: which part of a record is analysed."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

from hydrofdi.config.sections.record import RecordConfig, is_whole
from hydrofdi.settings.quantities import SI, Section

_PERIODS = re.compile(r"\s*((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*periods?\s*")


@dataclass(frozen=True)
class TimeOrPeriods(SI):
    """Annotation of a time from zero on [s], or of a number of periods, held as a text like ``2 periods``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse, and check a time's limit."""
        return core_schema.no_info_plain_validator_function(self._time_or_periods)

    def _time_or_periods(self, value: Any) -> float | str:
        periods = _PERIODS.fullmatch(value) if isinstance(value, str) else None
        if periods is not None:
            number = float(periods[1])
            return f"{number:.15g} {'period' if number == 1.0 else 'periods'}"
        if isinstance(value, str) and value.rstrip().endswith(("period", "periods")):
            raise ValueError(f"must be zero or more periods, such as '1 period'; found {value!r}")
        time = self.parse(value)
        if not 0.0 <= time < math.inf:
            raise ValueError(f"must be zero or a positive time; found {value}")
        return time


class AnalysisConfig(Section):
    """The analysed part of a record. It can change without a new simulation."""

    discard: Annotated[float | str, TimeOrPeriods("s", least=0)] = 0.0
    """Initial part of the record that indicators and features ignore: a time [s], or periods of the input
    such as ``1 period``, for any ``input.period``. Signals still contain it, and so do the values of the
    plant itself: leakage flows, extremes, hydraulic mode, settling."""

    @property
    def discards_periods(self) -> bool:
        """Whether what is left out is stated in periods of the input."""
        return isinstance(self.discard, str)

    def discarded_time(self, period: float) -> float:
        """Start of the record that is left out, for an input of some period [s]."""
        if isinstance(self.discard, str):
            return float(self.discard.split()[0]) * period
        return self.discard

    def shown_discard(self, period: float) -> str:
        """What is left out, for a period of the input [s]: ``4 s``, ``1 period of input.period = 2 s``."""
        if self.discards_periods:
            return f"{self.discard} of input.period = {period:g} s"
        return f"{self.discard:g} s"

    def require_whole_samples(self, record: RecordConfig, period: float) -> None:
        """Check that what is left out is a whole number of samples.

        Raises
        ------
        ValueError
            It is not.
        """
        time = self.discarded_time(period)
        if time and not is_whole(time * record.sampling_frequency):
            raise ValueError(
                f"analysis.discard = {self.shown_discard(period)} is not a multiple of the sampling interval"
            )
