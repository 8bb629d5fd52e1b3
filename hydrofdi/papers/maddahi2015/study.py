"""The numbers of the paper's study, computed once: modes, claims, controls, and scenarios of an ensemble."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.values import shown_values
from hydrofdi.evaluation.rates import Rate
from hydrofdi.papers.maddahi2015 import claims as paper
from hydrofdi.report.composition import Report
from hydrofdi.report.document import Block
from hydrofdi.report.runs import ReportedRuns, joined, modulus_text, normal_bulk_modulus
from hydrofdi.settings.messages import HOLE, counted
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MISSING
from hydrofdi.tables.table import Table

CORE = ("C1", "C2", "C3", "C4")
"""The claims that carry the paper's conclusion."""

_EVERY = tuple(claim.id for claim in paper.CLAIMS)

CLAIM_SETS = {name: (name,) for name in _EVERY} | {"C1–C4": CORE, "C1–C5": _EVERY[:5], "C1–C6": _EVERY}
"""Name → claims: each by itself, then together."""


@dataclass(frozen=True)
class ScenarioStudy:
    """Claims and controls over all scenarios of an experiment with an ``ensemble``.

    Its standings are those as configured; and settled, if any run has settled features.
    """

    data: ExperimentData
    grid: paper.ModeGrid
    standings: tuple[paper.Standing, ...]

    @property
    def configured(self) -> paper.Standing:
        """The records as configured."""
        return self.standings[0]

    @cached_property
    def outcomes(self) -> tuple[str, ...]:
        """``ok`` where all runs of a scenario succeeded, else the status of the first that did not."""
        statuses = self.data.columns[names.STATUS].astype(str)
        own = (statuses[positions[positions != paper.ABSENT]] for positions in self.grid.positions)
        bad = [[status for status in each.tolist() if status != "ok"] for each in own]
        return tuple(MISSING if MISSING in each else next(iter(each), "ok") for each in bad)

    @property
    def is_drawn(self) -> bool:
        """Whether scenarios are drawn independently (``method: random``), so that shares have an interval."""
        sample = self.data.experiment.ensemble.sample
        return sample is not None and sample.method == "random"

    @cached_property
    def draws(self) -> NDArray[np.int64]:
        """The draw of the sample that each scenario was made from; those of one depend on each other."""
        sample = self.data.experiment.ensemble.sample
        if sample is None:
            return np.arange(len(self.grid.scenarios))
        return np.array(_codes([tuple(each[name] for name in sample.over) for each in self.grid.scenarios]))

    @cached_property
    def feasible(self) -> paper.Mask:
        """Scenarios of which all runs succeeded."""
        return np.array([outcome == "ok" for outcome in self.outcomes])

    @property
    def obstacles(self) -> dict[str, int]:
        """Status → number of scenarios that it made infeasible, or that are not computed yet."""
        return dict(sorted(Counter(outcome for outcome in self.outcomes if outcome != "ok").items()))

    def share(self, outcomes: paper.Mask, members: paper.Mask) -> Rate:
        """Share of outcomes among some scenarios; `outcomes` has shape (n_scenario, ...)."""
        kept = outcomes[members]
        per_scenario = kept.size // max(1, len(kept))
        return clustered_share(kept.ravel(), np.repeat(self.draws[members], per_scenario))

    def reproducing(self, claims: Sequence[str]) -> paper.Mask:
        """Feasible scenarios in which all of these claims hold."""
        return self.feasible & self.configured.held(claims)

    def decided(self, claims: Sequence[str]) -> paper.Mask:
        """Feasible scenarios that say whether all of these claims hold: they do, or one of them does not."""
        failed: paper.Mask = np.any([self.configured.margins[claim] <= 0.0 for claim in claims], axis=0)
        return (self.feasible & failed) | self.reproducing(claims)

    def is_open(self, claims: Sequence[str]) -> bool:
        """Whether one of these claims cannot be tested in any feasible scenario, and none fails in all."""
        untested = [np.isnan(self.configured.margins[claim][self.feasible]).all() for claim in claims]
        return any(untested) and not np.array_equal(self.decided(claims), self.feasible)

    def counts(self, claims: Sequence[str]) -> dict[str, int | None]:
        """Feasible scenarios that reproduce claims as configured, at all phases, settled; None if open."""
        configured, is_open = self.configured, self.is_open(claims)
        held = {
            "reproducing": configured.held(claims),
            "reproducing_in_all_phases": configured.phases_held(claims) == configured.n_phase,
        }
        for settled in self.standings[1:]:
            held["reproducing_settled"] = settled.held(claims)
        return {name: None if is_open else int((self.feasible & each).sum()) for name, each in held.items()}

    @cached_property
    def groups(self) -> dict[str, paper.Mask]:
        """Scenarios whose sealed actuators are compared."""
        return {"feasible": self.feasible, "C4": self.reproducing(("C4",)), "C1–C4": self.reproducing(CORE)}


def _codes(values: Sequence[Any]) -> tuple[int, ...]:
    """Numbers of values in the order of their first occurrence."""
    order: dict[Any, int] = {}
    return tuple(order.setdefault(value, len(order)) for value in values)


def wilson_interval(share: float, n: float) -> tuple[float, float]:
    """95 % score interval of a share of `n` independent draws.

    Wilson, Journal of the American Statistical Association 22 (1927) 209.
    """
    z = 1.959963984540054
    centre = share + z * z / (2.0 * n)
    spread = z * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    scale = 1.0 + z * z / n
    return max(0.0, (centre - spread) / scale), min(1.0, (centre + spread) / scale)


def clustered_share(outcomes: NDArray[np.bool_], clusters: Sequence[int] | NDArray[np.int64]) -> Rate:
    """The share of true outcomes; those of one cluster depend on each other.

    The interval is Wilson's for the effective number of draws: the number of independent ones that would
    give the share the variance that it has between clusters, at most the number of outcomes. Where all
    clusters agree it is the number of clusters. After Rao and Scott, Biometrics 48 (1992) 577.
    """
    total = int(outcomes.size)
    if not total:
        return Rate(0, 0, 0, math.nan, math.nan, 0.95)
    _, cluster = np.unique(np.asarray(clusters), return_inverse=True)
    hits, sizes = np.bincount(cluster, outcomes), np.bincount(cluster)
    n_cluster, count, share = hits.size, int(outcomes.sum()), float(outcomes.mean())
    effective = float(n_cluster)
    if n_cluster > 1:
        variance = n_cluster / (n_cluster - 1) * float(np.sum((hits - share * sizes) ** 2)) / total**2
        if variance >= 1e-24:
            effective = min(float(total), share * (1.0 - share) / variance)
    low, high = wilson_interval(count / total, effective)
    return Rate(count, total, 0, low, high, 0.95)


def scenarios_record(study: ScenarioStudy) -> dict[str, Any]:
    """Counts over all scenarios, and each scenario by itself, for programs."""
    counts = {name: study.counts(claims) for name, claims in CLAIM_SETS.items()}
    everywhere = study.configured.alarms_everywhere.items()
    return {
        "scenarios": len(study.outcomes),
        "feasible": int(study.feasible.sum()),
        "infeasible": study.obstacles,
        "phases": study.configured.n_phase,
        "reproducing_settled": None,
        **{key: {name: own[key] for name, own in counts.items()} for key in counts["C1"]},
        "sealed_alarms": {
            name: {key: _share_record(study, outcomes, members) for key, outcomes in everywhere}
            for name, members in study.groups.items()
        },
        "members": _members(study),
    }


def _share_record(study: ScenarioStudy, outcomes: paper.Mask, members: paper.Mask) -> dict[str, Any]:
    share = study.share(outcomes, members)
    interval = [share.low, share.high] if study.is_drawn else None
    return {"count": share.count, "of": share.total, "interval_95": interval}


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
    """How many scenarios are feasible and reproduce each claim; the controls."""
    reasons = joined([f"{status} in {count}" for status, count in study.obstacles.items()])
    rest = f"; the others have runs without results: {reasons}" if reasons else ""
    n_feasible, n_scenario = int(study.feasible.sum()), counted(len(study.outcomes), "different scenario")
    title = "Scenarios: how much depends on what is not known"
    said = f"{n_feasible:,} of {n_scenario} are feasible{rest}."
    return (
        Block("scenarios", title, (said,), (_claims_table(study),), is_answer=True),
        Block("scenarios-controls", "Controls over the scenarios", (), (_alarms_table(study),)),
    )


def _share(study: ScenarioStudy, outcomes: paper.Mask, members: paper.Mask) -> str:
    """A share in percent, with the interval of independent draws; a hole if there is nothing to share."""
    share = study.share(outcomes, members)
    interval = f" ({100.0 * share.low:.1f}–{100.0 * share.high:.1f})" if study.is_drawn else ""
    return f"{100.0 * share.value:.1f} %{interval}" if share.total else HOLE


def _claims_table(study: ScenarioStudy) -> Table:
    rows, sentences = [], {claim.id: claim.sentence for claim in paper.CLAIMS}
    for name, claims in CLAIM_SETS.items():
        held, counts = study.reproducing(claims), study.counts(claims)
        phases, n_phase = study.configured.phases_held(claims)[held], study.configured.n_phase
        is_open = counts["reproducing"] is None
        rows.append(
            {
                "claim": name,
                "sentence": sentences.get(name, "all of them"),
                "scenarios": counts["reproducing"],
                "share": None if is_open else _share(study, held, study.decided(claims)),
                "in all phases": counts["reproducing_in_all_phases"],
                "phases kept": f"{float(np.median(phases)):g} of {n_phase}" if held.any() else None,
                "settled": counts.get("reproducing_settled"),
            }
        )
    note = (
        "Scenarios and share: at the configured start phase, of the feasible scenarios that decide a claim;"
        " –: none does. Phases kept: in how many it holds, median over the scenarios that reproduce it."
        " Intervals, of random draws alone: 95 %, Wilson's, for dependent scenarios of one draw."
    )
    title = "Scenarios that reproduce the claims"
    breaks = (len(_EVERY),)
    return Table.of_records(rows, title=title, key="scenarios-claims", notes=(note,), breaks=breaks)


def _alarms_table(study: ScenarioStudy) -> Table:
    moduli = [modulus_text(study.grid.bulk_moduli[b]) for b in study.grid.raised]
    outcomes = dict(zip(moduli, study.configured.alarms(study.configured.shown).T, strict=True))
    for standing in study.standings:
        outcomes |= {f"{key}, {standing.title}": mask for key, mask in standing.alarms_everywhere.items()}
    rows = [
        {"scenarios": name, "number": int(members.sum())}
        | {title: _share(study, each, members) for title, each in outcomes.items()}
        for name, members in study.groups.items()
    ]
    title = "The d3 rule on the sealed actuator: share of scenarios with an alarm at an EBM, or at all"
    return Table.of_records(rows, title=title, key="scenarios-alarms")


@dataclass(frozen=True)
class StudyData(Report):
    """The numbers of the paper's study beside those of any experiment."""

    @cached_property
    def grid(self) -> paper.ModeGrid:
        """The leaky modes."""
        return paper.arrange_modes(self.data)

    @cached_property
    def standings(self) -> tuple[paper.Standing, ...]:
        """The ways to look at the records: as configured, and settled if any run is."""
        return tuple(paper.standings(self.grid, self.data))

    @cached_property
    def scenarios(self) -> ScenarioStudy | None:
        """Claims and controls over the scenarios of an ensemble with a grid."""
        is_ensemble = self.data.experiment.has_scenarios and not self.grid.lack
        return ScenarioStudy(self.data, self.grid, self.standings) if is_ensemble else None

    @cached_property
    def _compared(self) -> ReportedRuns:
        """The runs without further external leakage, by what else varies, leakage and EBM."""
        kept = self.table.of(~paper.leaks_out_more(self.data)[self.table.positions])
        varied = tuple(name for name in kept.label_names if len(set(kept.values(name))) > 1)
        kept = replace(kept, label_names=varied)
        codes = np.array(_codes([tuple(each.values()) for each in kept.labels]))
        return kept.of(np.lexsort((kept[names.BULK_MODULUS], kept.leakage_requests, codes)))

    @cached_property
    def sealed(self) -> ReportedRuns:
        """The sealed runs above the normal EBM, which the d3 rule is tried on."""
        runs = self._compared
        is_raised = runs[names.BULK_MODULUS] > normal_bulk_modulus(self.data)
        return runs.of(runs.is_sealed & is_raised & (runs.n_level > paper.D3))

    @cached_property
    def looked_at(self) -> Sequence[int]:
        """Positions of the scenarios that claims have to hold in: the feasible ones, or all."""
        if self.scenarios is None:
            return range(len(self.grid.scenarios))
        feasible: list[int] = np.flatnonzero(self.scenarios.feasible).tolist()
        return feasible

    @cached_property
    def claims(self) -> tuple[paper.ClaimResult, ...]:
        """The result of every claim."""
        pairs = ((each, each.checks(self.grid, self.standings[0].shown)) for each in paper.CLAIMS)
        return tuple(paper.ClaimResult(each, checks, self.looked_at) for each, checks in pairs)

    @property
    def guarded(self) -> tuple[paper.ClaimResult, ...]:
        """The claims that the experiment file lists."""
        listed = self.data.experiment.claims
        return tuple(result for result in self.claims if result.claim.id in listed)

    @cached_property
    def claim_outcomes(self) -> list[paper.PhaseCount]:
        """How claims stand over the start phases, in each way to look at the records."""
        return [standing.claim(claim, self.looked_at) for standing in self.standings for claim in _EVERY]

    @cached_property
    def alarm_outcomes(self) -> list[paper.PhaseCount]:
        """How the alarms on the sealed actuator stand over the start phases."""
        return [outcome for standing in self.standings for outcome in sealed_outcomes(self.sealed, standing)]


def sealed_outcomes(sealed: ReportedRuns, standing: paper.Standing) -> list[paper.PhaseCount]:
    """Where the d3 rule alarms, by δd3, at each EBM and further parameters."""
    return [
        standing.alarm(", ".join(filter(None, [modulus_text(modulus), shown_values(labels)])), position)
        for modulus, labels, position in zip(
            sealed[names.BULK_MODULUS].tolist(), sealed.labels, sealed.positions, strict=True
        )
    ]
