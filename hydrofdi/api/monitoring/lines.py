"""What a monitor says: a line for each window, and one for each event."""

from hydrofdi.monitor.lines import Condition, Event, EventKind, Line, WindowLine

__all__ = ["Condition", "Event", "EventKind", "Line", "WindowLine"]
