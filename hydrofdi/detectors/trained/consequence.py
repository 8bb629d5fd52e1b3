"""What an alarm comes to: alarms that chance explains, flow, drift of the cylinder, and what to do next."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import count_text, number_text, shown_quantity
from hydrofdi.units import convert

_ORIFICE, _FLOW = "leakage", "m^3/s"
"""Output that is the flow of an orifice at a reference pressure, and the unit of flows."""

_CHANCE, _FAR = 0.01, 10.0
"""Probability of as many false alarms below which they are not chance, and healthy spreads beyond the limit
from which on a single alarm is not."""

_PAGE = "docs/how-to/after-an-alarm.md"


@dataclass(frozen=True)
class Consequence:
    """Numbers in SI; None if they are not known.

    Attributes
    ----------
    windows_judged, alarms : int
        Windows or estimates that were judged, and alarms among them.
    false_alarms_expected : float
        Alarms among as many of a healthy machine.
    flow, pressure_difference : float or None
        Leakage flow [m³/s], of a compensated score its increase; and the pressure difference that it is
        stated for [Pa]: the supply pressure of the data sheet, else that of the score. None: the mean over
        the window.
    drift : float or None
        Speed of the piston if this flow passes it while both ports are closed [m/s]: flow over piston area.
    recommendation : str
        What to do next.
    """

    windows_judged: int
    alarms: int
    false_alarms_expected: float
    flow: float | None
    pressure_difference: float | None
    drift: float | None
    recommendation: str

    @property
    def sentences(self) -> str:
        """What is known, and the recommendation."""
        expected = count_text(self.false_alarms_expected)
        texts = [f"{counted(self.alarms, 'alarm')} until now, {expected} expected of a healthy machine"]
        if self.flow is not None:
            where = "on average over the window"
            if self.pressure_difference is not None:
                where = f"at {shown_quantity(self.pressure_difference, 'Pa')}"
            drift = "" if self.drift is None else f", a drift of {number_text(6e4 * self.drift, 3)} mm/min"
            texts.append(f"a leak of {number_text(convert(self.flow, 'L/min'), 3)} L/min {where}{drift}")
        return f"{'; '.join(texts)}; {self.recommendation}"

    def to_dict(self) -> dict[str, Any]:
        """All of it for JSON, with units in the names."""
        record = asdict(self)
        return {
            "windows_judged": record["windows_judged"],
            "alarms": record["alarms"],
            "false_alarms_expected": record["false_alarms_expected"],
            "flow_L_per_min": None if self.flow is None else convert(self.flow, "L/min"),
            "pressure_difference_MPa": self.pressure_difference and self.pressure_difference / 1e6,
            "drift_mm_per_min": None if self.drift is None else 6e4 * self.drift,
            "recommendation": record["recommendation"],
        }


def consequence(
    file: DetectorFile,
    windows_judged: int,
    alarms: int,
    score: float | None,
    margin: float | None = None,
    doubt: str = "",
) -> Consequence:
    """What alarms come to, of which one, or the median, has a score."""
    flow = pressure = drift = None
    area = _constant(file, "piston_area")
    if score is not None and file.unit == _FLOW and score > 0.0:
        flow = score
        if file.feature.described.name == _ORIFICE:
            stated = float(file.feature.indicator.options.reference_pressure)
            pressure = _constant(file, "supply_pressure", is_stated=True) or stated
            flow *= math.sqrt(pressure / stated)
        drift = flow / area if area else None
    expected = windows_judged * false_alarms_per_window(file)
    advice = _advice(file, alarms, expected, margin, doubt)
    return Consequence(windows_judged, alarms, expected, flow, pressure, drift, advice)


def false_alarms_per_window(file: DetectorFile) -> float:
    """Expected alarms of a healthy machine for each window or estimate; with a chart, at least its own."""
    if file.chart is None or file.config.chart is None:
        return file.limits.false_alarm_rate
    frequency, indicator = file.sampling_frequency, file.feature.indicator
    if isinstance(indicator, RecursiveIndicator) and not file.n_sample:
        n_every = indicator.samples_per_estimate(frequency)
    else:
        n_every = file.config.window.n_every(file.n_sample, frequency)
    return n_every / frequency / file.config.chart.false_alarm_every


def _constant(file: DetectorFile, name: str, *, is_stated: bool = False) -> float | None:
    """A constant of the data sheet, or of the options unless it was left at its default."""
    options = file.feature.indicator.options
    own = None if is_stated or name in file.assumed else getattr(options, name, None)
    found = file.data_sheet.get(name, own)
    return float(found) if found is not None else None


def _advice(file: DetectorFile, alarms: int, expected: float, margin: float | None, doubt: str) -> str:
    from scipy.special import pdtrc

    if doubt:
        return f"look at the signals first ('hydrofdi inspect'): the verdict is doubtful ({_PAGE})"
    is_far = margin is not None and margin < -_FAR
    if file.chart is not None or is_far or (alarms and pdtrc(alarms - 1, expected) < _CHANCE):
        return f"more than chance explains: check the signals, then 'hydrofdi diagnose' ({_PAGE})"
    noun = "windows" if file.n_sample else "estimates"
    return f"this may be chance: wait and see whether most of the next ten {noun} alarm, too ({_PAGE})"
