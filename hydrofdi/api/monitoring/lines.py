"""Lines of a monitor: one for each window, one for each event."""

from hydrofdi.monitor.lines import Condition, Event, EventKind, Line, WindowLine

__all__ = ["Condition", "Event", "EventKind", "Line", "WindowLine"]
