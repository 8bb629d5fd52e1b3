"""Runs by the beginning of an identity: their own, or that of their record."""

from __future__ import annotations

from collections.abc import Sequence


def rows_identified(beginning: str, run_ids: Sequence[str], record_ids: Sequence[str]) -> list[int]:
    """Rows of the runs whose identity begins so; else the first run of each record whose identity does.

    Parameters
    ----------
    beginning : str
    run_ids, record_ids : sequence of str
        Identities of the runs, as reports list them, and of their records, as `measure` lists them.
    """
    own = [row for row, run_id in enumerate(run_ids) if run_id.startswith(beginning)]
    if own:
        return own
    first: dict[str, int] = {}
    for row, record_id in enumerate(record_ids):
        if record_id.startswith(beginning):
            first.setdefault(record_id, row)
    return list(first.values())
