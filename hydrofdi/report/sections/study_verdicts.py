"""How many records of each population have a verdict to read them with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from hydrofdi.quality.doubts import DOUBTS, Doubt, doubts_of
from hydrofdi.report.document import Block
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout.names import VERDICT
from hydrofdi.studies.reading import study_designs


def verdicts_block(data: ExperimentData) -> Block | None:
    """A sentence on each verdict, with its populations and the remedy; None if all records are ok."""
    verdicts = np.asarray(data.columns.get(VERDICT, ())).astype(str)
    if not verdicts.size:
        return None
    per_population: Counter[str] = Counter()
    with_doubt: dict[str, Counter[str]] = {word: Counter() for word in DOUBTS}
    for records, rows in study_designs(data):
        for place, row in zip(records.of_record.tolist(), rows.tolist(), strict=True):
            name = records.populations[place].name
            per_population[name] += 1
            for doubt in doubts_of(verdicts[row]):
                with_doubt[doubt.word][name] += 1
    sentences = [
        _sentence(data, DOUBTS[word], own, per_population) for word, own in with_doubt.items() if own
    ]
    return Block("doubts", "How reliable the records are", tuple(sentences)) if sentences else None


def _sentence(data: ExperimentData, doubt: Doubt, own: Counter[str], per_population: Counter[str]) -> str:
    n_own, n_record = own.total(), per_population.total()
    where = f"({'; '.join(_places(own, per_population))})" if n_own < n_record else "(all of each population)"
    worst = float(np.nanmax(np.asarray(data.columns[doubt.number], dtype=float)))
    share = f"{100.0 * worst:.2g}" if worst < 0.995 else f"{100.0 * worst:.0f}"
    verb = "is" if n_own == 1 else "are"
    return (
        f"{n_own:,} of {counted(n_record, 'record')} {verb} {doubt.word} {where}:"
        f" {doubt.meaning.format(share)}. Remedy: {doubt.remedy}."
    )


def _places(own: Counter[str], per_population: Counter[str]) -> Iterator[str]:
    for name, total in per_population.items():
        if own[name]:
            yield f"{own[name]:,} of {total:,} '{name}'"
