"""The numbers of the paper's study, computed once: modes, claims, controls and scenarios."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hydrofdi.config.shown_values import shown_values
from hydrofdi.papers.maddahi2015.claims import CLAIMS, D3, ClaimResult, Outcome, Standing, standings
from hydrofdi.papers.maddahi2015.grid import ModeGrid, arrange_modes
from hydrofdi.papers.maddahi2015.scenarios import ScenarioStudy, study_scenarios
from hydrofdi.report.data import ReportData
from hydrofdi.report.runs import RunTable, leaks_out_more, normal_bulk_modulus
from hydrofdi.report.wording import mode_name, modulus_text
from hydrofdi.store.layout import names


@dataclass(frozen=True)
class StudyData(ReportData):
    """The numbers of the paper's study beside those of any experiment."""

    @cached_property
    def grid(self) -> ModeGrid:
        """The leaky modes."""
        return arrange_modes(self.data)

    @cached_property
    def standings(self) -> tuple[Standing, ...]:
        """The ways to look at the records: as configured, and settled if any run is."""
        return tuple(standings(self.grid, self.data))

    @cached_property
    def scenarios(self) -> ScenarioStudy | None:
        """Claims and controls over the scenarios of an ensemble with a grid."""
        is_ensemble = self.data.experiment.has_scenarios and not self.grid.lack
        return study_scenarios(self.grid, self.data, self.standings) if is_ensemble else None

    @cached_property
    def _controls(self) -> tuple[RunTable, RunTable]:
        return controls(self.table)

    @property
    def sealed(self) -> RunTable:
        """The sealed runs that the d3 rule is tried on."""
        return self._controls[0]

    @property
    def leaky(self) -> RunTable:
        """The leaky runs."""
        return self._controls[1]

    @cached_property
    def looked_at(self) -> Sequence[int]:
        """Positions of the scenarios that claims have to hold in: the feasible ones, or all."""
        if self.scenarios is None:
            return range(len(self.grid.scenarios))
        found: list[int] = np.flatnonzero(self.scenarios.feasible).tolist()
        return found

    @cached_property
    def claims(self) -> tuple[ClaimResult, ...]:
        """The result of every claim."""
        return tuple(ClaimResult(claim, claim.checks(self.grid), self.looked_at) for claim in CLAIMS)

    @property
    def guarded(self) -> tuple[ClaimResult, ...]:
        """The claims that the experiment file lists."""
        listed = self.data.experiment.claims
        return tuple(result for result in self.claims if result.claim.id in listed)

    @cached_property
    def claim_outcomes(self) -> list[Outcome]:
        """How claims stand over the start phases, in each way to look at the records."""
        return [each.claim(claim.id, self.looked_at) for each in self.standings for claim in CLAIMS]

    @cached_property
    def alarm_outcomes(self) -> list[Outcome]:
        """How the alarms on the sealed actuator stand over the start phases."""
        return [found for each in self.standings for found in sealed_outcomes(self.sealed, each)]

    def check_records(self, result: ClaimResult) -> Iterator[dict[str, Any]]:
        """Each check of a claim in each scenario; its runs are the healthy one, then the leaky ones."""
        grid, run_ids = self.grid, self.data.columns[names.RUN_ID].astype(str)
        for check in result.checks:
            for scenario in result.scenarios:
                leaky = [int(grid.positions[scenario, 1 + q, b]) for q, b in check.modes]
                runs = [int(self.data.fixed_baseline[leaky[0]]), *leaky]
                margin, labels = float(check.margin[scenario]), grid.scenarios[scenario]
                yield {
                    "runs": run_ids[runs].tolist(),
                    "modes": [mode_name(grid.leakage_flows[q], grid.bulk_moduli[b]) for q, b in check.modes],
                    "holds": None if math.isnan(margin) else margin > 0.0,
                    "margin_percentage_points": margin,
                    "each_may_move_percentage_points": float(check.allowance[scenario]),
                } | ({"labels": labels} if labels else {})


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
