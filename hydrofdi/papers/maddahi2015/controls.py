"""Two controls that the paper does not have: the d3 rule on a sealed actuator, and the matched baseline."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.shown_values import shown_values
from hydrofdi.papers.maddahi2015.claims import D3, alarms
from hydrofdi.papers.maddahi2015.standings import Outcome, Standing
from hydrofdi.report.runs import (
    Array,
    RunTable,
    best_levels,
    leaks_out_more,
    level_names,
    normal_bulk_modulus,
)
from hydrofdi.report.table import Block, row_records
from hydrofdi.report.wording import joined, modulus_text
from hydrofdi.store.layout import names
from hydrofdi.units import convert

_WORDS = {True: "alarm", False: "silent", None: "open"}


def controls(table: RunTable) -> tuple[RunTable, RunTable]:
    """The sealed runs above the normal EBM, and the leaky runs; by what else varies, leakage and EBM.

    Both without further external leakage.
    """
    kept = table.of(~leaks_out_more(table.data)[table.positions])
    varied = tuple(name for name in table.label_names if len(set(kept.values(name))) > 1)
    kept = replace(kept, label_names=varied)
    labels = [tuple(each.values()) for each in kept.labels]
    order = {key: place for place, key in enumerate(dict.fromkeys(labels))}
    codes = np.array([order[key] for key in labels])
    moduli = kept[names.BULK_MODULUS]
    is_raised = kept.is_sealed & (moduli > normal_bulk_modulus(table.data)) & (table.n_level > D3)
    places = np.lexsort((moduli, kept.leakage_requests, codes))
    return kept.of(places[is_raised[places]]), kept.of(places[~kept.is_sealed[places]])


def alarm_verdicts(delta: Array) -> list[bool | None]:
    """Whether δd3 is positive and the largest of each run; None if it is missing or failed."""
    pairs = zip(alarms(delta), np.asarray(np.isnan(delta).any(axis=1)), strict=True)
    return [None if is_open else bool(is_alarm) for is_alarm, is_open in pairs]


def sealed_outcomes(sealed: RunTable, standing: Standing) -> list[Outcome]:
    """Where the d3 rule alarms, by δd3, at each EBM and further parameters."""
    return [
        standing.level(
            ", ".join(filter(None, [modulus_text(modulus), shown_values(labels)])),
            standing.fixed[:, position],
            D3,
            float(standing.shown[position, D3]),
        )
        for modulus, labels, position in zip(
            sealed[names.BULK_MODULUS].tolist(), sealed.labels, sealed.positions, strict=True
        )
    ]


def best_deltas(leaky: RunTable) -> tuple[NDArray[np.int64], Array]:
    """The level with the largest positive δ against the matched baseline, −1 if none is; and that δ [%]."""
    delta = leaky.changes("matched")
    best = best_levels(delta)
    return best, np.where(best < 0, np.nan, delta[np.arange(len(best)), best])


def controls_record(
    sealed: RunTable, leaky: RunTable, standings: Sequence[Standing]
) -> dict[str, list[dict[str, Any]]]:
    """What the d3 rule says of each run without any leak, and the best level of each leaky run."""
    best, deltas = best_deltas(leaky)

    def alarmed(standing: Standing) -> dict[str, Any]:
        shown = standing.shown[sealed.positions]
        outcomes = sealed_outcomes(sealed, standing)
        phases = [each.phases("delta_d3_percent") for each in outcomes]
        return {"alarm": alarm_verdicts(shown), "delta_fixed_percent": shown, "phases": phases}

    def ranked(standing: Standing) -> dict[str, Any]:
        at = zip(leaky.positions, best.tolist(), strict=True)
        outcomes = (standing.level("", standing.matched[:, position], level) for position, level in at)
        return {"phases": [each.phases("delta_matched_percent") for each in outcomes]}

    leads = {
        "leakage_L_per_min": [convert(flow, "L/min") for flow in leaky.leakage_flows.tolist()],
        "level": level_names(best),
        "delta_matched_percent": deltas,
    }
    return {
        "sealed_alarms": _records(sealed, [*map(alarmed, standings)]),
        "best_level_matched": _records(leaky, [leads | ranked(standings[0]), *map(ranked, standings[1:])]),
    }


def _records(table: RunTable, views: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """A record for each run: what holds as configured, and settled."""
    columns: dict[str, Any] = {
        "bulk_modulus_MPa": [convert(each, "MPa") for each in table[names.BULK_MODULUS].tolist()]
    }
    columns |= views[0]
    if len(views) > 1:
        columns["settled"] = row_records(views[1])
    return row_records(columns | ({"labels": table.labels} if table.label_names else {}))


def controls_block(sealed: RunTable, leaky: RunTable) -> Block:
    """Does the d3 rule alarm on a sealed actuator; which level is best under a matched baseline."""
    alarmed = [_WORDS[verdict] for verdict in alarm_verdicts(sealed.changes("fixed"))]
    is_open = np.asarray(np.isnan(leaky.changes("matched")).any(axis=1))
    best = zip(is_open, level_names(best_deltas(leaky)[0]), strict=True)
    counts = {
        "The d3 rule on sealed runs above the normal EBM, without any leak": Counter(alarmed),
        "The level with the largest positive δ of leaky modes against the matched baseline": Counter(
            "open" if unknown else name or "none" for unknown, name in best
        ),
    }
    said = (
        f"{lead}: {joined([f'{word} in {n:,}' for word, n in sorted(found.items())]) or 'there is none'}."
        for lead, found in counts.items()
    )
    title = "Controls: no leak, and a matched baseline"
    return Block("controls", title, tuple(said), (), ("spectrum", "mode_plane"))
