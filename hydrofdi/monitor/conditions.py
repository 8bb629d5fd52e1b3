"""Verdicts → the condition of the actuator, by a plain rule with hysteresis."""

from __future__ import annotations

import numpy as np

from hydrofdi.detectors.trained import ChartReading, Verdict
from hydrofdi.monitor.lines import Condition, Event, EventKind
from hydrofdi.records.streams import State
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import plain


class Conditions:
    """Raises an alarm at the first alarm of the chart, or of the threshold if there is no chart. Clears it
    after `patience` judged windows in a row without an alarm. After as many windows that are not judged, the
    condition is unknown.

    Parameters
    ----------
    patience : int
        Number of windows.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience

    def start(self) -> State:
        """The state before the first window: the condition is unknown."""
        counts = {"is_raised": 0, "n_calm": 0, "n_not_judged": self._patience}
        return {"since": np.array(np.nan), **{name: np.array(count) for name, count in counts.items()}}

    def step(
        self, state: State, end: float, verdict: Verdict, chart: ChartReading | None
    ) -> tuple[State, Condition, list[Event]]:
        """The state after a window that ends at an instant [s], the condition, and the events."""
        if verdict.alarm is None:
            n_not_judged = min(int(state["n_not_judged"]) + 1, self._patience)
            state = {**state, "n_not_judged": np.array(n_not_judged)}
            return state, self._condition(state), []
        state = {**state, "n_not_judged": np.array(0)}
        is_alarm, is_raised = verdict.alarm if chart is None else chart.alarm, bool(state["is_raised"])
        n_calm = 0 if is_alarm else min(int(state["n_calm"]) + 1, self._patience)
        state = {**state, "n_calm": np.array(n_calm)}
        events: list[Event] = []
        if is_alarm and not is_raised:
            state = {**state, "is_raised": np.array(1), "since": np.array(end)}
            doubt = f"; doubtful: {verdict.doubt}" if verdict.doubt else ""
            events = [Event(EventKind.ALARM_RAISED, _why(verdict, chart) + doubt, end)]
        elif is_raised and n_calm >= self._patience:
            ago = _ago(end - float(state["since"]))
            text = f"no alarm in {counted(n_calm, 'window')}; the alarm was raised {ago}"
            state = {**state, "is_raised": np.array(0)}
            events = [Event(EventKind.ALARM_CLEARED, text, end)]
        return state, self._condition(state), events

    def _condition(self, state: State) -> Condition:
        if state["n_not_judged"] >= self._patience:
            return Condition.UNKNOWN
        return Condition.ALARM if state["is_raised"] else Condition.HEALTHY


def _ago(duration: float) -> str:
    return f"{plain(duration, 6)} s ago" if duration >= 0.0 else "before the clock was set back"


def _why(verdict: Verdict, chart: ChartReading | None) -> str:
    if chart is not None:
        statistic, limit = (plain(each, 4) for each in (chart.statistic or 0.0, chart.limit))
        return f"the statistic of the chart, {statistic}, reaches its limit, {limit}"
    return f"the score is {plain(-(verdict.margin or 0.0), 4)} healthy spreads beyond its limit"
