"""The report of the paper's study: what it says, computed once; its sections, data and figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.papers.maddahi2015.claims import CLAIMS, ClaimResult, Standing, alarms
from hydrofdi.papers.maddahi2015.study import StudyData, scenario_blocks, scenarios_record, sealed_outcomes
from hydrofdi.report.composition import rms_table
from hydrofdi.report.document import Block, FigureKind
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.runs import Array, ReportedRuns, joined
from hydrofdi.settings.messages import convert
from hydrofdi.store import names
from hydrofdi.tables.table import Table, plain

_ONE_PHASE = (
    "Only one start phase was measured. The decimated transform depends on it, so this is not a finding yet: "
    "set wavelet: {phase: all}."
)
_UNSETTLED = (
    "No run has settled features: no record holds two whole periods that agree. Lengthen record.duration."
)


@dataclass(frozen=True)
class StudyReport(StudyData):
    """The general report with the paper's tables, claims, controls and figures."""

    lead = (
        "Change δ of the RMS of the wavelet details of the chamber-1 pressure with internal leakage and with"
        " the EBM of the fluid. After Maddahi et al., CDSR 2015, paper 181; no number comes from the paper."
    )

    def blocks(self) -> Iterator[Block | None]:
        """Its own sections."""
        if self.scenarios is not None:
            title = "Required claims, in all feasible scenarios"
            yield Block("guarded", title, required(self), is_answer=True)
            yield from scenario_blocks(self.scenarios)
            yield indicators_block(self.indicators)
            return
        yield from (block for block, _ in self.views)
        yield from table3_blocks(self)
        yield settled_block(self)
        yield table2_block(self)
        yield claims_block(self)
        yield standing_block(self) if self.has_baseline else None
        yield indicators_block(self.indicators)
        yield Block("signals", "Signals and details", figures=("figure2", "figure3", "figure4"))

    def record(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that do not exist are None.

        The thousands of runs and controls of an ensemble are left to the tidy forms; what they come
        to in each scenario stands under ``scenarios``.
        """
        is_single = self.scenarios is None
        record = self.general_record(with_rows=is_single) | {
            "claims": [claim_record(self, claim) for claim in self.claims],
            "guarded_claims": list(self.data.experiment.claims),
            "controls": {"sealed_alarms": alarm_records(self.sealed, self.standings) if is_single else []},
        }
        if self.scenarios is not None:
            record["scenarios"] = scenarios_record(self.scenarios)
        if self.grid.lack:
            record["claims_not_evaluated"] = self.grid.lack
        finished: dict[str, Any] = plain(record)
        return finished

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        from hydrofdi.papers.maddahi2015.figures import study_figures

        own = study_figures(self) if self.has_results else {}
        return {**super().figures(), **own}

    def checks(self) -> dict[str, bool | None]:
        """The claims that the experiment file lists, and whether they hold."""
        word = {True: "holds", False: "does not hold", None: "is not decided"}
        return {
            f"{result.claim.id} {word[result.reproduced]}: {result.claim.sentence}"
            f" (margin {result.margin:.2f} points)": result.reproduced
            for result in self.guarded
        }


def claim_record(study: StudyReport, result: ClaimResult) -> dict[str, Any]:
    """A claim, and how it stands over the start phases."""
    claim = result.claim
    configured, *settled = (standing.claim(claim.id, study.looked_at) for standing in study.standings)
    record = {
        "id": claim.id,
        "sentence": claim.sentence,
        "rule": claim.rule,
        "reproduced": result.reproduced,
        "margin_percentage_points": result.margin,
        "phases": configured.phases("margin_percentage_points"),
    }
    for outcome in settled:
        record["settled"] = {
            "reproduced": None if math.isnan(outcome.number) else outcome.number > 0.0,
            "margin_percentage_points": outcome.number,
            "phases": outcome.phases("margin_percentage_points"),
        }
    return record


def claims_block(study: StudyReport) -> Block:
    """All claims with their margins; one sentence if there is no grid."""
    title = "Claims: the paper's sentences as checks"
    if study.grid.lack:
        return Block("claims", title, (study.grid.lack, *required(study)))
    note = (
        "At the configured start phase. Margin: how far one δ behind a claim could move before its result"
        " turns; negative if it does not hold. If it is a difference of two δ, both may move, each by half of"
        " it. –: open, cannot be decided (a run is missing, or the actuator does not move)."
    )
    records = [claim_record(study, claim) for claim in study.claims]
    nested = ("phases", "settled")
    table = Table.of_records(plain(records), nested, title="Claims", key="claims", notes=(note,))
    return Block("claims", title, required(study), (table,))


def required(study: StudyReport) -> tuple[str, ...]:
    """Whether the claims that the file lists hold, in all feasible scenarios of an ensemble."""
    if not study.guarded:
        return ()
    lost = joined([result.claim.id for result in study.guarded if not result.reproduced])
    held = f"not so, or open, for {lost}" if lost else "all of them hold, at the configured start phase"
    return (f"The experiment file requires {joined([each.claim.id for each in study.guarded])}: {held}.",)


def standing_block(study: StudyReport) -> Block:
    """At how many start phases claims and sealed alarms hold, as configured and settled."""
    sentences = {claim.id: f"{claim.id}: {claim.sentence}" for claim in CLAIMS}
    named = [] if study.grid.lack else [(sentences[each.name], each) for each in study.claim_outcomes]
    named += [(f"d3 alarm at {outcome.name} without a leak", outcome) for outcome in study.alarm_outcomes]
    rows: dict[str, dict[str, str | None]] = {}
    for name, each in named:
        row = rows.setdefault(name, {"claim": name})
        row[each.records.replace(" ", "_")] = f"{each.held} of {each.of}" if each.of else None
    has_phases = study.standings[0].n_phase > 1
    said = [] if has_phases else [_ONE_PHASE]
    said += [_UNSETTLED] if len(study.standings) == 1 else []
    held = Table.of_records([*rows.values()] if has_phases else [], title="Start phases at which it holds")
    title, figures = "What survives: start phases and settled records", ("phases",) if has_phases else ()
    return Block("standing", title, tuple(said), (held,), figures, is_answer=True)


def alarm_verdicts(delta: Array) -> list[bool | None]:
    """Whether δd3 is positive and the largest of each run; None if it is missing or failed."""
    pairs = zip(alarms(delta), np.asarray(np.isnan(delta).any(axis=1)), strict=True)
    return [None if is_open else bool(is_alarm) for is_alarm, is_open in pairs]


def alarm_records(sealed: ReportedRuns, standings: Sequence[Standing]) -> list[dict[str, Any]]:
    """What the d3 rule says of each run without any leak, as configured, and settled."""

    def alarmed(standing: Standing) -> dict[str, Any]:
        shown = standing.shown[sealed.positions]
        phases = [each.phases("delta_d3_percent") for each in sealed_outcomes(sealed, standing)]
        return {"alarm": alarm_verdicts(shown), "delta_fixed_percent": shown, "phases": phases}

    columns: dict[str, Any] = {
        "bulk_modulus_MPa": [convert(each, "MPa") for each in sealed[names.BULK_MODULUS].tolist()]
    }
    configured, *settled = map(alarmed, standings)
    columns |= configured | ({"settled": [*Table.of(settled[0])]} if settled else {})
    return [*Table.of(columns | ({"labels": sealed.labels} if sealed.label_names else {}))]


def table3_blocks(study: StudyReport) -> tuple[Block, Block]:
    """The table of all runs; the one against the fixed baseline is the answer."""
    block = study.changes_block("Table 3: change of the details with leakage and EBM", "table3")
    reason = study.no_changes
    legend, *bands = (reason, *block.paragraphs) if reason else block.paragraphs
    first, *others = block.tables
    figures = ("sensitivity",) if study.plane else ()
    answer = replace(block, paragraphs=(legend,), tables=(first,), figures=figures, is_answer=True)
    rest = "Table 3 with the matched baseline"
    return answer, Block("table3-matched", rest, tuple(bands), tuple(others))


def settled_block(study: StudyReport) -> Block | None:
    """The same table of the settled records; None if no run has settled."""
    if not (study.table.has_settled and study.baselines):
        return None
    sentence = (
        "From the undecimated transform of whole periods that agree with the last one, extended periodically:"
        " independent of the start sample and of an extension. Without a period, of what analysis.discard"
        " leaves, whose start may not have settled."
    )
    tables = study.delta_tables("settled", names.SETTLED_DETAIL_RMS, "Settled: ")
    return Block("settled", "The same of settled records, all start phases together", (sentence,), tables)


def table2_block(study: StudyReport) -> Block | None:
    """Table 2 and its sealed control; None if more than leakage and EBM varies, or they form no grid."""
    table = study.table
    if table.label_names or study.grid.lack:
        return None
    requests = np.unique(table.leakage_requests)[:2]
    rows = table.of(np.isin(table.leakage_requests, requests))
    return Block(
        "table2", "Table 2: RMS over the EBM, sealed and with the small leakage", (), (rms_table(rows),)
    )
