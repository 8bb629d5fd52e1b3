"""Two controls that the paper does not have: the d3 rule on a sealed actuator, and the matched baseline."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from hydrofdi.papers.maddahi2015.claims import D3
from hydrofdi.papers.maddahi2015.standings import Outcome, Standing
from hydrofdi.report.document import Block
from hydrofdi.report.runs import Levels, RunTable, TableRow, largest_positive, level_name
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import (
    flow_text,
    joined,
    labels_text,
    modulus_column,
    modulus_text,
    signed,
)
from hydrofdi.settings.readable import HOLE
from hydrofdi.units import convert

_WORDS = {True: "alarm", False: "silent", None: "open"}


@dataclass(frozen=True)
class Control:
    """A run without further external leakage, and what else varies: dotted parameter → value in SI."""

    row: TableRow
    labels: dict[str, Any]

    @property
    def conditions(self) -> str:
        """EBM and further parameters in words."""
        return ", ".join(filter(None, [modulus_text(self.row.bulk_modulus), labels_text(self.labels)]))

    def sealed(self, standing: Standing) -> Outcome:
        """Where the d3 rule alarms, by δd3."""
        position = self.row.position
        number = float(standing.shown[position, D3])
        return standing.level(self.conditions, standing.fixed[:, position], D3, number)

    @property
    def best_level(self) -> int | None:
        """The level with the largest positive δ against the matched baseline; None if there is none."""
        return largest_positive(self.row.details.matched)

    @property
    def best_name(self) -> str | None:
        """Its name."""
        return level_name(self.best_level)

    @property
    def best_word(self) -> str:
        """The same in a word; ``open`` if the run is missing or failed."""
        return "open" if math.isnan(sum(self.row.details.matched)) else self.best_name or "none"

    @property
    def best_delta(self) -> float:
        """Its δ [%]."""
        return math.nan if self.best_level is None else self.row.details.matched[self.best_level]

    def _labelled(self, *records: dict[str, Any]) -> dict[str, Any]:
        first, *settled = records
        return first | ({"settled": settled[0]} if settled else {}) | (
            {"labels": self.labels} if self.labels else {}
        )  # fmt: skip

    def alarm_record(self, standings: Sequence[Standing]) -> dict[str, Any]:
        """What the d3 rule says of the run without any leak."""
        records = []
        for standing in standings:
            levels = tuple(standing.shown[self.row.position].tolist())
            phases = self.sealed(standing).phases("delta_d3_percent")
            records.append({"alarm": alarm(levels), "delta_fixed_percent": levels, **phases})
        modulus = {"bulk_modulus_MPa": convert(self.row.bulk_modulus, "MPa")}
        return modulus | self._labelled(*records)

    def best_record(self, standings: Sequence[Standing]) -> dict[str, Any]:
        """The best level of a leaky run."""
        outcomes = (each.level("", each.matched[:, self.row.position], self.best_level) for each in standings)
        return {
            "leakage_L_per_min": convert(self.row.leakage_flow, "L/min"),
            "bulk_modulus_MPa": convert(self.row.bulk_modulus, "MPa"),
            "level": self.best_name,
            "delta_matched_percent": self.best_delta,
        } | self._labelled(*(each.phases("delta_matched_percent") for each in outcomes))


def alarm(levels: Levels) -> bool | None:
    """Whether δd3 is positive and the largest; None if the run is missing or failed."""
    return None if any(map(math.isnan, levels)) else largest_positive(levels) == D3


def controls(table: RunTable) -> tuple[tuple[Control, ...], tuple[Control, ...]]:
    """The sealed runs above the normal EBM, and the leaky runs; by labels, leakage and EBM."""
    rows = [row for row in table.rows if not row.leaks_out_more]
    varied = [name for name in table.label_names if len({row.labels[name] for row in rows}) > 1]
    found = [Control(row, {name: row.labels[name] for name in varied}) for row in rows]
    order = {key: place for place, key in enumerate(dict.fromkeys(tuple(c.labels.values()) for c in found))}
    found.sort(key=lambda c: (order[tuple(c.labels.values())], c.row.leakage_request, c.row.bulk_modulus))
    is_raised = [c.row.is_sealed and c.row.bulk_modulus > table.normal_bulk_modulus for c in found]
    sealed = [c for c, raised in zip(found, is_raised, strict=True) if raised and table.n_level > D3]
    return tuple(sealed), tuple(c for c in found if not c.row.is_sealed)


def controls_block(sealed: Sequence[Control], leaky: Sequence[Control]) -> Block:
    """Does the d3 rule alarm on a sealed actuator; which level is best under a matched baseline."""
    return Block(
        "controls",
        "Controls: no leak, and a matched baseline",
        (
            _counts("The d3 rule on sealed runs above the normal EBM, without any leak", _said(sealed)),
            _counts(
                "The level with the largest positive δ of leaky modes against the matched baseline",
                [each.best_word for each in leaky],
            ),
        ),
        (_alarm_table(sealed), _best_table(leaky)),
        ("spectrum", "mode_plane"),
    )


def _said(sealed: Sequence[Control]) -> list[str]:
    return [_WORDS[alarm(each.row.details.fixed)] for each in sealed]


def _counts(lead: str, words: Sequence[str]) -> str:
    """How often each word occurs."""
    parts = [f"{word} in {count:,}" for word, count in sorted(Counter(words).items())]
    return f"{lead}: {joined(parts) or 'there is none'}."


def _lead(found: Sequence[Control], *more: Column) -> Iterator[Column]:
    """What says which run a row is."""
    yield Column("Parameters", [labels_text(each.labels) for each in found], is_text=True)
    yield from more
    yield modulus_column([each.row.bulk_modulus for each in found])


def _alarm_table(sealed: Sequence[Control]) -> Table:
    deltas = [each.row.details.fixed for each in sealed]
    said = _said(sealed)
    marked = [k for k, word in enumerate(said) if word == _WORDS[True]]
    columns = (
        *_lead(sealed),
        Column("d3 rule", said, is_text=True, strong=marked),
        *(Column(f"δd{level}", each, text=signed) for level, each in enumerate(zip(*deltas, strict=True), 1)),
    )
    title = "The d3 rule on the sealed actuator: δ [%] against the fixed baseline"
    return Table(columns, title, "sealed-alarms")


def _best_table(leaky: Sequence[Control]) -> Table:
    columns = (
        *_lead(leaky, Column("Leakage [L/min]", [flow_text(each.row.leakage_flow) for each in leaky])),
        Column("Best level", [each.best_name or HOLE for each in leaky], is_text=True),
        Column("δ [%]", [each.best_delta for each in leaky], text=signed),
    )
    return Table(columns, "The best level of each mode against the matched baseline", "best-levels")
