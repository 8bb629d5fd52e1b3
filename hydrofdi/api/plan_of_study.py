"""The study in a plan, as plain data: populations, designs, and varied parameters."""

from __future__ import annotations

from typing import Any

from numpy import bincount

from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.pipeline.planning import SweepPlan


def study_record(plan: SweepPlan) -> dict[str, Any] | None:
    """The populations and designs of a study and what it draws, as plain data in SI; None without a study."""
    roles, study = plan.table.study, plan.experiment.study
    if roles is None or study is None:
        return None
    counts = bincount(roles.of_run[roles.design_of_run == 0]).tolist()
    changes = study.shifts | study.confusions
    return {
        "records": len(plan.run_ids) // len(roles.designs),
        "designs": without_contents(list(roles.designs)),
        "populations": [
            {
                "name": each.name,
                "kind": each.kind.value,
                "is_fit": each.is_fit,
                "records": count,
                "sets": changes.get(each.name, {}) if each.kind.value in ("shift", "confusion") else {},
            }
            for each, count in zip(roles.populations, counts, strict=True)
        ],
        "varies": study.population.over,
        "differs_per_record": study.population.per_record,
    }
