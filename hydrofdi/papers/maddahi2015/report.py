"""The report of the paper's study: what it says, computed once; its sections, data and figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.config.experiment import ReferenceCell, ReferenceConfig
from hydrofdi.papers.maddahi2015.claims import CLAIMS, ClaimResult, Mask, Standing, alarms
from hydrofdi.papers.maddahi2015.study import CLAIM_SETS, CORE, ScenarioStudy, StudyData, sealed_outcomes
from hydrofdi.quality.doubts import samples_per_period
from hydrofdi.report import sections
from hydrofdi.report.composition import rms_table
from hydrofdi.report.document import Block, FigureKind
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.runs import Array, RunTable
from hydrofdi.report.wording import joined, modulus_text
from hydrofdi.settings.messages import HOLE, counted
from hydrofdi.store.layout import names
from hydrofdi.tables.table import Table, group_breaks, plain
from hydrofdi.units import convert

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

    @property
    def usual_figure(self) -> str:
        """The scenarios where the experiment has any, else δ."""
        return "sensitivity" if self.scenarios is None else "scenarios"

    def blocks(self) -> Iterator[Block | None]:
        """The sections of the report."""
        yield sections.remarks_block(self.data)
        if self.scenarios is not None:
            yield from sections.answers(
                Block("guarded", "Required claims, in all feasible scenarios", required(self))
            )
            yield from sections.doubts_blocks(self.data)
            answer, controls = scenario_blocks(self.scenarios)
            yield from sections.answers(answer)
            yield controls
            yield indicators_block(self.indicators)
            yield sections.provenance_block(self.data)
            return
        yield sections.holes_block(self.data)
        yield from sections.doubts_blocks(self.data)
        yield from (replace(block, is_answer=False) for block, _ in self.views)
        yield from table3_blocks(self)
        yield settled_block(self)
        yield table2_block(self)
        standing, phases = standing_blocks(self) if self.has_baseline else (None, None)
        yield claims_block(self)
        yield from sections.answers(standing)
        yield phases
        yield reference_block(self)
        yield indicators_block(self.indicators)
        figures = ("figure2", "figure3", "figure4")
        yield Block("signals", "Signals and details", figures=figures)
        yield sections.provenance_block(self.data)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that do not exist are None.

        The thousands of runs and controls of an ensemble are left to the tidy forms; what they come
        to in each scenario stands under ``scenarios``.
        """
        is_single = self.scenarios is None
        record = self.general_record(with_rows=is_single)
        for _, data in self.views:
            record |= data
        record |= {
            "claims": [claim_record(self, each) for each in self.claims],
            "guarded_claims": list(self.data.experiment.claims),
            "controls": {"sealed_alarms": alarm_records(self.sealed, self.standings) if is_single else []},
            "reference": deviations(self.table, self.data.experiment.reference) if is_single else [],
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
    records = [claim_record(study, each) for each in study.claims]
    nested = ("phases", "settled")
    table = Table.of_records(plain(records), nested, title="Claims", key="claims", notes=(note,))
    return Block("claims", title, required(study), (table,))


def required(study: StudyReport) -> tuple[str, ...]:
    """Whether the claims that the file lists hold, in all feasible scenarios of an ensemble."""
    if not study.guarded:
        return ()
    lost = joined([each.claim.id for each in study.guarded if not each.reproduced])
    held = f"not so, or open, for {lost}" if lost else "all of them hold, at the configured start phase"
    return (f"The experiment file requires {joined([each.claim.id for each in study.guarded])}: {held}.",)


def standing_blocks(study: StudyReport) -> tuple[Block, Block]:
    """Which claims and sealed alarms survive every start phase, as configured and settled; their numbers."""
    sentences = {claim.id: f"{claim.id}: {claim.sentence}" for claim in CLAIMS}
    named = [] if study.grid.lack else [(sentences[each.name], each) for each in study.claim_outcomes]
    named += [(f"d3 alarm at {each.name} without a leak", each) for each in study.alarm_outcomes]
    rows: dict[str, dict[str, Any]] = {}
    survival: dict[str, dict[str, Any]] = {}
    for name, each in named:
        lead = "" if each.records == study.standings[0].title else f"{each.records} "
        phases = f"{each.held} of {each.of}" if each.of else None
        ends = {"least": each.spread["least"], "largest": each.spread["largest"], "number": each.number}
        row = rows.setdefault(name, {"what": name}) | {f"{lead}phases": phases}
        rows[name] = row | {f"{lead}{key}": number for key, number in ends.items()}
        survival.setdefault(name, {"claim": name})[each.records] = phases
    note = (
        "Phases in which it holds. Least, largest: margins in percentage points, δd3 in percent. Phase p: the"
        " record from its sample p on; phases of settled records repeat if a period has fewer samples."
        " Number: at the configured phase; of settled records that of the undecimated transform, free of"
        " boundaries, which holds all phases."
    )
    title = "Margins of the claims and δd3 of the sealed alarms over the start phases"
    table = Table.of_records([*rows.values()], title=title, key="phases-numbers", notes=(note,))
    has_phases = study.standings[0].n_phase > 1
    said = [] if has_phases else [_ONE_PHASE]
    said += [_UNSETTLED] if len(study.standings) == 1 else []
    held = Table.of_records(
        [*survival.values()] if has_phases else [], title="Start phases at which it holds"
    )
    title = "Claims and the sealed alarm over the start phases"
    return (
        Block("standing", "What survives: start phases and settled records", tuple(said), (held,)),
        Block("phases", title, (), (table,), ("phases",) if has_phases else ()),
    )


def alarm_verdicts(delta: Array) -> list[bool | None]:
    """Whether δd3 is positive and the largest of each run; None if it is missing or failed."""
    pairs = zip(alarms(delta), np.asarray(np.isnan(delta).any(axis=1)), strict=True)
    return [None if is_open else bool(is_alarm) for is_alarm, is_open in pairs]


def alarm_records(sealed: RunTable, standings: Sequence[Standing]) -> list[dict[str, Any]]:
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


NONE_GIVEN = (
    "No published value is compared: the digits of the paper's Tables 2 and 3 are lost in the only text that"
    " hydrofdi was made from. If you have the printed paper, you can enter its numbers under reference: "
    "in the experiment file."
)


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
    is_periodic = samples_per_period(study.data.experiment.nominal_parameters) is not None
    records = (
        "whole periods that agree with the last one, extended periodically"
        if is_periodic
        else "what analysis.discard leaves, whose start may not have settled because the input has no period"
    )
    sentence = (
        f"From the undecimated transform of {records}: independent of the start sample and of an extension."
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


def deviations(table: RunTable, reference: ReferenceConfig) -> list[dict[str, Any]]:
    """Every published value beside the computed one."""
    return [_deviation(table, cell, reference.tolerance) for cell in reference.cells]


def _deviation(table: RunTable, cell: ReferenceCell, general: float) -> dict[str, Any]:
    level, is_delta, computed = int(cell.level[1:]) - 1, cell.delta is not None, math.nan
    rows = np.stack([table.leakage_flows, table[names.BULK_MODULUS]], axis=1)
    is_it = np.isclose(rows, (cell.leakage, cell.bulk_modulus), rtol=1e-6, atol=0.0).all(axis=1)
    if is_it.any() and level < table.n_level:
        levels = table.changes("fixed") if is_delta else table[names.DETAIL_RMS]
        computed = float(levels[is_it.argmax(), level])
    published = cell.delta if cell.delta is not None else cell.rms
    assert published is not None
    deviation = computed - published if is_delta else 100.0 * (computed - published) / published
    tolerance = general if cell.tolerance is None else cell.tolerance
    return {
        "leakage_L_per_min": convert(cell.leakage, "L/min"),
        "bulk_modulus_MPa": convert(cell.bulk_modulus, "MPa"),
        "level": cell.level,
        "quantity": "delta_fixed_percent" if is_delta else "detail_rms_Pa",
        "published": published,
        "computed": computed,
        "deviation": deviation,
        "tolerance": tolerance,
        "agrees": None if math.isnan(deviation) else abs(deviation) <= tolerance,
    }


def reference_block(study: StudyReport) -> Block:
    """Published values beside the computed ones, or the sentence that there are none."""
    reference, title = study.data.experiment.reference, "Published values"
    found = deviations(study.table, reference)
    if not found:
        return Block("reference", title, (NONE_GIVEN,))
    agrees = [each["agrees"] for each in found]
    n_compared = counted(len(agrees) - agrees.count(None), "published value")
    source = f"; source: {reference.source}" if reference.source else ""
    said = f"Within the tolerance: {agrees.count(True)} of {n_compared}{source}."
    note = "Deviation and tolerance: percentage points of δ; percent of a published RMS. –: no such run."
    table = Table.of_records(found, title="Computed and published", key="reference", notes=(note,))
    return Block("reference", title, (said,), (table,))


def scenarios_record(study: ScenarioStudy) -> dict[str, Any]:
    """Counts over all scenarios, and each scenario by itself, for programs."""
    sets, feasible = CLAIM_SETS.items(), study.feasible
    groups = {"feasible": feasible, "C1–C4": study.reproducing(CORE), "C4": study.reproducing(("C4",))}
    settled = {name: study.count_settled(claims) for name, claims in sets}
    everywhere = study.configured.alarms_everywhere.items()
    return {
        "scenarios": len(study.outcomes),
        "feasible": int(feasible.sum()),
        "infeasible": study.obstacles,
        "reproducing": {name: study.count(claims, feasible) for name, claims in sets},
        "values": [
            {
                "parameters": list(value.parameters),
                "range" if value.is_range else "values": list(value.values),
                "scenarios": int(value.members.sum()),
                "feasible": int((value.members & feasible).sum()),
                "reproducing": {name: study.count(claims, value.members) for name, claims in sets},
            }
            for value in study.value_shares
        ],
        "phases": study.configured.n_phase,
        "reproducing_in_all_phases": {name: study.count_always(claims) for name, claims in sets},
        "reproducing_settled": settled if len(study.standings) > 1 else None,
        "doubtful": {word: int((mask & feasible).sum()) for word, mask in study.doubts.items()},
        "sealed_alarms": {
            name: {key: _share_record(study, outcomes, members) for key, outcomes in everywhere}
            for name, members in groups.items()
        },
        "members": _members(study),
    }


def _share_record(study: ScenarioStudy, outcomes: Mask, members: Mask) -> dict[str, Any]:
    found = study.share(outcomes, members)
    interval = [found.low, found.high] if study.is_drawn else None
    return {"count": found.count, "of": found.total, "interval_95": interval}


def _members(study: ScenarioStudy) -> list[dict[str, Any]]:
    margins = {claim: margin.tolist() for claim, margin in study.configured.margins.items()}
    held = {claim: study.configured.phases_held((claim,)).tolist() for claim in margins}
    alarms = study.configured.alarms(study.configured.shown).tolist()
    return [
        {
            "values": study.grid.scenarios[k],
            "outcome": outcome,
            "margins_percentage_points": {
                claim: each[k] if outcome == "ok" else None for claim, each in margins.items()
            },
            "phases_held": {claim: each[k] if outcome == "ok" else None for claim, each in held.items()},
            "sealed_alarms": alarms[k] if outcome == "ok" else None,
        }
        for k, outcome in enumerate(study.outcomes)
    ]


def scenario_blocks(study: ScenarioStudy) -> tuple[Block, Block]:
    """How many scenarios are feasible and reproduce each claim, and which values carry that; the controls."""
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without results: {reasons}" if reasons else ""
    n_feasible, n_scenario = int(study.feasible.sum()), counted(len(study.outcomes), "different scenario")
    title, key = "Scenarios: how much depends on what is not known", "scenarios"
    said, tables = f"{n_feasible:,} of {n_scenario} are feasible{rest}.", (_claims(study), _values(study))
    return (
        Block(key, title, (said,), tables, (key,)),
        Block("scenarios-controls", "Controls over the scenarios", (), (_alarms(study),)),
    )


def _share(study: ScenarioStudy, outcomes: Mask, members: Mask) -> str:
    """A share in percent, with the interval of independent draws; a hole if there is nothing to share."""
    share = study.share(outcomes, members)
    interval = f" ({100.0 * share.low:.1f}–{100.0 * share.high:.1f})" if study.is_drawn else ""
    return f"{100.0 * share.value:.1f} %{interval}" if share.total else HOLE


def _claims(study: ScenarioStudy) -> Table:
    rows, sentences = [], {claim.id: claim.sentence for claim in CLAIMS}
    for name, claims in CLAIM_SETS.items():
        held, is_open = study.reproducing(claims), study.is_open(claims)
        phases, n_phase = study.configured.phases_held(claims)[held], study.configured.n_phase
        rows.append(
            {
                "claim": name,
                "sentence": sentences.get(name, "all of them"),
                "scenarios": study.count(claims, study.feasible),
                "share": None if is_open else _share(study, held, study.decided(claims)),
                "in all phases": study.count_always(claims),
                "phases kept": f"{float(np.median(phases)):g} of {n_phase}" if held.any() else None,
                "settled": None if is_open else study.count_settled(claims),
            }
        )
    note = (
        "Scenarios and share: at the configured start phase, of the feasible scenarios that decide a claim;"
        " –: none does. Phases kept: in how many it holds, median over the scenarios that reproduce it."
        " Intervals, of random draws alone: 95 %, Wilson's, for dependent scenarios of one draw."
    )
    title = "Scenarios that reproduce the claims"
    return Table.of_records(rows, title=title, key="scenarios-claims", notes=(note,), breaks=(len(CLAIMS),))


def _values(study: ScenarioStudy) -> Table:
    rows = []
    for value in study.value_shares:
        row: dict[str, Any] = {
            "parameter": ", ".join(value.parameters),
            "value": value.text,
            "scenarios": int(value.members.sum()),
            "feasible": int((value.members & study.feasible).sum()),
        }
        for name in ("C1–C4", "C1–C6"):
            claims = CLAIM_SETS[name]
            decided = value.members & study.decided(claims)
            row[name] = study.count(claims, value.members)
            share = None if study.is_open(claims) else _share(study, study.reproducing(claims), decided)
            row[f"share of {name}"] = share
        rows.append(row)
    note = "Shares: of the feasible scenarios with this value. Ranges are fifths of the scenarios."
    breaks, title = group_breaks([row["parameter"] for row in rows]), "Which values decide it"
    return Table.of_records(rows, title=title, key="scenarios-values", notes=(note,), breaks=breaks)


def _alarms(study: ScenarioStudy) -> Table:
    fourth = study.reproducing(("C4",))
    groups = {
        "all feasible": study.feasible,
        "C4 holds": fourth,
        "C4 fails": study.decided(("C4",)) & ~fourth,
        "C1–C4 hold": study.reproducing(CORE),
    }
    moduli = [modulus_text(study.grid.bulk_moduli[b]) for b in study.grid.raised]
    outcomes = dict(zip(moduli, study.configured.alarms(study.configured.shown).T, strict=True))
    for standing in study.standings:
        outcomes |= {f"{key}, {standing.title}": mask for key, mask in standing.alarms_everywhere.items()}
    rows = [
        {"scenarios": name, "number": int(members.sum())}
        | {title: _share(study, each, members) for title, each in outcomes.items()}
        for name, members in groups.items()
    ]
    title = "The d3 rule on the sealed actuator: share of scenarios with an alarm at an EBM, or at all"
    return Table.of_records(rows, title=title, key="scenarios-alarms")
