"""Claims and controls over the scenarios of an ensemble: how much depends on what is not known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.shown_values import shown_value
from hydrofdi.evaluation.rates import Rate
from hydrofdi.papers.maddahi2015.claims import CLAIMS, D2, Mask, Standing
from hydrofdi.papers.maddahi2015.grid import ABSENT, ModeGrid
from hydrofdi.quality.doubts import DOUBTS
from hydrofdi.report.axes import MOST_VALUES, fifths
from hydrofdi.report.intervals import clustered_share
from hydrofdi.report.runs import Array, best_levels
from hydrofdi.report.table import Block, Table, group_breaks
from hydrofdi.report.wording import joined, modulus_text, share_text
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.layout import names

CORE = ("C1", "C2", "C3", "C4")
"""The claims that carry the paper's conclusion."""

_EVERY = tuple(claim.id for claim in CLAIMS)

CLAIM_SETS = {name: (name,) for name in _EVERY} | {"C1–C4": CORE, "C1–C5": _EVERY[:5], "C1–C6": _EVERY}
"""Name → claims: each by itself, then together."""


class ValueShare(NamedTuple):
    """The scenarios with one value of a parameter, or of several that vary together, or with one range.

    `values` are in SI, one for each parameter, or the ends of the range; `members` has shape (n_scenario,).
    """

    parameters: tuple[str, ...]
    values: tuple[Any, ...]
    is_range: bool
    members: Mask


@dataclass(frozen=True)
class ScenarioStudy:
    """Claims and controls over all scenarios.

    Attributes
    ----------
    standings : tuple of Standing
        As configured; and settled, if any run has settled features.
    outcomes : tuple of str, length n_scenario
        ``ok`` where all runs of a scenario succeeded, else the status of the first that did not.
    doubts : dict
        Word of a verdict → the scenarios with a run that it was given to, shape (n_scenario,).
    draws : ndarray of int, shape (n_scenario,)
        The draw of the sample that a scenario was made from; those of one draw depend on each other.
    is_drawn : bool
        Whether scenarios are drawn independently (``method: random``), so that shares have an interval.
    """

    grid: ModeGrid
    standings: tuple[Standing, ...]
    outcomes: tuple[str, ...]
    doubts: dict[str, Mask]
    draws: NDArray[np.int64]
    is_drawn: bool

    @property
    def configured(self) -> Standing:
        """The records as configured."""
        return self.standings[0]

    @property
    def margins(self) -> dict[str, Array]:
        """Claim → margin in every scenario, as configured [percentage points]."""
        return self.configured.margins

    @cached_property
    def feasible(self) -> Mask:
        """Scenarios of which all runs succeeded."""
        return np.array([outcome == "ok" for outcome in self.outcomes])

    @property
    def obstacles(self) -> dict[str, int]:
        """Status → number of scenarios that it made infeasible, or that are not computed yet."""
        return dict(sorted(Counter(outcome for outcome in self.outcomes if outcome != "ok").items()))

    def share(self, outcomes: Mask, members: Mask) -> Rate:
        """Share of outcomes among some scenarios; `outcomes` has shape (n_scenario, ...)."""
        kept = outcomes[members]
        per_scenario = kept.size // max(1, len(kept))
        return clustered_share(kept.ravel(), np.repeat(self.draws[members], per_scenario))

    def reproducing(self, claims: Sequence[str]) -> Mask:
        """Feasible scenarios in which all of these claims hold."""
        return self.feasible & self.configured.held(claims)

    def decided(self, claims: Sequence[str]) -> Mask:
        """Feasible scenarios that say whether all of these claims hold: they do, or one of them does not."""
        failed: Mask = np.any([self.margins[claim] <= 0.0 for claim in claims], axis=0)
        return (self.feasible & failed) | self.reproducing(claims)

    def is_open(self, claims: Sequence[str]) -> bool:
        """Whether one of these claims cannot be tested in any feasible scenario, and none fails in all."""
        untested = [np.isnan(self.margins[claim][self.feasible]).all() for claim in claims]
        return any(untested) and not np.array_equal(self.decided(claims), self.feasible)

    def count(self, claims: Sequence[str], members: Mask) -> int | None:
        """How many of these scenarios reproduce claims; None if they are open."""
        return None if self.is_open(claims) else int((members & self.reproducing(claims)).sum())

    def count_always(self, claims: Sequence[str]) -> int | None:
        """Feasible scenarios that reproduce claims at every start phase; None if they are open."""
        always = self.configured.phases_held(claims) == self.configured.n_phase
        return None if self.is_open(claims) else int((self.feasible & always).sum())

    def count_settled(self, claims: Sequence[str]) -> int | None:
        """Feasible scenarios that reproduce claims in their settled records; None if there are none."""
        found = [int((self.feasible & each.held(claims)).sum()) for each in self.standings[1:]]
        return found[0] if found else None

    @property
    def is_d2_best(self) -> Mask:
        """Whether d2 is the best level of the leaky modes above the normal EBM under the matched baseline.

        Shape (n_scenario, n_raised_mode).
        """
        modes = [(q, b) for q, b in self.grid.modes() if b in self.grid.raised]
        found = [best_levels(self.grid.matched[:, 1 + q, b]) == D2 for q, b in modes]
        return np.stack(found, axis=1) if found else np.empty((len(self.outcomes), 0), bool)

    @cached_property
    def value_shares(self) -> tuple[ValueShare, ...]:
        """The scenarios by the values of each parameter; parameters that vary together count as one."""
        groups: dict[tuple[int, ...], list[str]] = {}
        for name in self.grid.scenarios[0]:
            codes = _codes([scenario[name] for scenario in self.grid.scenarios])
            is_few = max(codes) < MOST_VALUES
            groups.setdefault(codes if is_few else (len(groups), -1), []).append(name)
        return tuple(share for group in groups.values() for share in self._shares(tuple(group)))

    def _shares(self, group: tuple[str, ...]) -> list[ValueShare]:
        rows = [tuple(scenario[name] for name in group) for scenario in self.grid.scenarios]
        different = sorted(set(rows), key=_order)
        if len(different) <= MOST_VALUES:
            return [ValueShare(group, row, False, np.array([r == row for r in rows])) for row in different]
        parts = fifths(np.array([row[0] for row in rows], dtype=float))
        return [ValueShare(group, (low, high), True, members) for low, high, members in parts]


def _codes(values: Sequence[Any]) -> tuple[int, ...]:
    """Numbers of values in the order of their first occurrence."""
    order: dict[Any, int] = {}
    return tuple(order.setdefault(value, len(order)) for value in values)


def _order(row: tuple[Any, ...]) -> tuple[bool, float, str]:
    is_text = row[0] is None or isinstance(row[0], str)
    return is_text, 0.0 if is_text else float(row[0]), str(row[0])


def study_scenarios(grid: ModeGrid, data: ExperimentData, standings: tuple[Standing, ...]) -> ScenarioStudy:
    """Claims and controls in every scenario of an experiment with an ``ensemble``."""
    statuses, verdicts = (data.columns[name].astype(str) for name in (names.STATUS, names.VERDICT))
    runs = [positions[positions != ABSENT] for positions in grid.positions]
    bad = [[status for status in statuses[own].tolist() if status != "ok"] for own in runs]
    doubts = {}
    for word in DOUBTS:
        found = np.char.find(verdicts, word) >= 0
        if (in_scenario := np.array([found[own].any() for own in runs])).any():
            doubts[word] = in_scenario
    sample = data.experiment.ensemble.sample
    drawn: list[Any] = [*range(len(runs))]
    if sample is not None:
        drawn = [tuple(scenario[name] for name in sample.over) for scenario in grid.scenarios]
    return ScenarioStudy(
        grid,
        standings,
        tuple(MISSING if MISSING in own else next(iter(own), "ok") for own in bad),
        doubts,
        np.array(_codes(drawn)),
        sample is not None and sample.method == "random",
    )


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
        "best_level_d2_matched_above_normal": {
            name: _share_record(study, study.is_d2_best, members) for name, members in groups.items()
        },
        "members": _members(study),
    }


def _share_record(study: ScenarioStudy, outcomes: Mask, members: Mask) -> dict[str, Any]:
    found = study.share(outcomes, members)
    interval = [found.low, found.high] if study.is_drawn else None
    return {"count": found.count, "of": found.total, "interval_95": interval}


def _members(study: ScenarioStudy) -> list[dict[str, Any]]:
    margins = {claim: margin.tolist() for claim, margin in study.margins.items()}
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
    return share_text(study.share(outcomes, members), with_interval=study.is_drawn)


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
            "value": value_text(value),
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


def value_text(value: ValueShare) -> str:
    """The value or range, with its unit."""
    if value.is_range:
        return shown_value(value.parameters[0], {"uniform": value.values})
    return ", ".join(map(shown_value, value.parameters, value.values))


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
