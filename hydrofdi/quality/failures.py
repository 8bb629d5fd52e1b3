"""What to do about runs that failed: a remedy for each status."""

from __future__ import annotations

_RETRY = "a sweep with retry_failed computes it again"

_REMEDIES = {
    "diverged": "shorten record.step; 'hydrofdi check' names the longest step that is stable",
    "stroke_exceeded": (
        "lower input.amplitude or input.period, enlarge actuator.chamber_volume, or set actuator.end_stops:"
        " elastic"
    ),
    "unreachable_leakage": "lower leakage.internal_flow; 'hydrofdi calibrate' shows what a flow takes",
    "timeout": f"raise limits.time_per_job, or shorten record.duration; {_RETRY}",
    "killed": f"take fewer workers if memory ran out; {_RETRY}",
    "error": f"'hydrofdi why' shows the traceback; {_RETRY}",
}
"""Status of a run that failed → its remedy."""

FAILURES = tuple(_REMEDIES)
"""The statuses of runs that failed."""


def remedy(status: str) -> str:
    """What to do about a run of a status: a sentence without its full stop, with the keys to set.

    Parameters
    ----------
    status : str
        Empty text for one that is not in `FAILURES`.
    """
    return _REMEDIES.get(status, "")
