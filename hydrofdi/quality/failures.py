"""What to do about runs that failed: a remedy for each status."""

from __future__ import annotations

_RETRY = "'hydrofdi sweep … --retry-failed' computes it again"

REMEDIES = {
    "diverged": "shorten record.step; 'hydrofdi check' names the longest step that is stable",
    "stroke_exceeded": (
        "lower input.amplitude or input.period, enlarge actuator.chamber_volume, or set actuator.end_stops:"
        " elastic"
    ),
    "unreachable_leakage": "lower leakage.internal_flow; 'hydrofdi calibrate' shows what a flow takes",
    "timeout": f"raise limits.time_per_job, or shorten record.duration; {_RETRY}",
    "killed": f"take fewer --workers if memory ran out; {_RETRY}",
    "error": f"'hydrofdi why' shows the traceback; {_RETRY}",
}
"""Status of a run that failed → what to do: a sentence without its full stop, with the keys to set."""
