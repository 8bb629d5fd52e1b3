"""What survives: claims and the sealed alarm over the start phases, and in the settled records."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hydrofdi.papers.maddahi2015.claims import CLAIMS, D3
from hydrofdi.papers.maddahi2015.controls import SealedAlarm
from hydrofdi.papers.maddahi2015.standings import PhaseCount, Standing
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.quality.settling import samples_per_period
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.wording import joined, labels_text, modulus_text, signed
from hydrofdi.settings.readable import HOLE

_ONE_PHASE = (
    "Only one start phase was measured. The decimated transform depends on it, so this is not a finding yet: "
    " set wavelet: {phase: all}."
)
_UNSETTLED = (
    "No run has settled features: no record holds two whole periods that agree. Lengthen record.duration."
)
_HEADERS = ("Records", "Phases in which it holds", "Mean phase", "Least", "Largest")


def standing_block(study: Study) -> Block:
    """Which claims and sealed alarms survive every start phase, as configured and settled."""
    return Block("standing", "What survives: start phases and settled records", tuple(_sentences(study)))


def phases_block(study: Study) -> Block:
    """The numbers of claims and sealed alarms over the start phases."""
    return Block(
        "phases",
        "Claims and the sealed alarm over the start phases",
        tuple(_repeated_phases(study)),
        (*([] if study.grid.lack else [_claims_sheet(study)]), _alarms_sheet(study)),
        ("phases",) if study.standings[0].n_phase > 1 else (),
    )


def _sentences(study: Study) -> Iterator[str]:
    if study.standings[0].n_phase == 1:
        yield _ONE_PHASE
    else:
        for standing in study.standings:
            yield from _survivors(study, standing)
    if len(study.standings) == 1:
        yield _UNSETTLED


def _survivors(study: Study, standing: Standing) -> Iterator[str]:
    found: dict[str, list[str]] = {
        "Hold at every start phase": [], "Depend on the start phase": [], "Hold at no start phase": [],
    }  # fmt: skip
    alarms = [f"the d3 alarm on the sealed actuator at {_conditions(alarm)}" for alarm in study.sealed_alarms]
    counts = [*standing.claims.values(), *standing.alarms]
    for name, count in zip([*standing.claims, *alarms], counts, strict=True):
        if count.of:
            turns = 0 < count.held < count.of
            group = list(found)[1 if turns else 0 if count.held else 2]
            found[group].append(f"{name} ({count.held} of {count.of})" if turns else name)
    for where, which in found.items():
        if which:
            yield f"{where} ({standing.title}): {joined(which)}."


def _conditions(alarm: SealedAlarm) -> str:
    labels = labels_text(alarm.labels)
    return modulus_text(alarm.bulk_modulus) + (f", {labels}" if labels else "")


def _repeated_phases(study: Study) -> Iterator[str]:
    """How many different phases a settled record has: its grid repeats from period to period."""
    period = samples_per_period(study.data.experiment.nominal_parameters)
    n_phase = study.standings[0].n_phase
    different = math.gcd(period, n_phase) if period else n_phase
    if different < n_phase:
        yield (
            f"A period holds {period:,} samples: the {n_phase} phases of a settled record are {different}"
            f" different ones, {n_phase // different} times each."
        )


def _claims_sheet(study: Study) -> Sheet:
    rows = [
        (
            Cell(standing.title),
            Cell(claim.id),
            *_count_cells(standing.claims[claim.id]),
            Cell(signed(standing.margins[claim.id], 2), value=standing.margins[claim.id]),
        )
        for standing in study.standings
        for claim in CLAIMS
    ]
    records, *headers = _HEADERS
    return Sheet(
        "claims-phases",
        "Margins of the claims over the start phases [percentage points]",
        (records, "Claim", *headers, "Margin"),
        tuple(rows),
        breaks=group_breaks([standing.title for standing in study.standings for _ in CLAIMS]),
        text_columns=(0, 1, 2),
        note="Phase p: the record from its sample p on. Margin: at the configured phase; of settled records"
        " that of the undecimated transform, which is free of boundaries and holds all phases.",
    )


def _alarms_sheet(study: Study) -> Sheet:
    rows = [
        (
            Cell(standing.title),
            Cell(_conditions(alarm)),
            *_count_cells(count),
            Cell(signed(levels[D3], 2), value=levels[D3]),
        )
        for standing in study.standings
        for alarm, count, levels in zip(
            study.sealed_alarms, standing.alarms, standing.alarm_deltas, strict=True
        )
    ]
    records, *headers = _HEADERS
    return Sheet(
        "sealed-alarms-phases",
        "δd3 [%] of the sealed actuator over the start phases, and in how many the d3 rule alarms",
        (records, "Sealed at", *headers, "δd3"),
        tuple(rows),
        breaks=group_breaks([standing.title for standing in study.standings for _ in standing.alarms]),
        text_columns=(0, 1, 2),
    )


def _count_cells(count: PhaseCount) -> tuple[Cell, ...]:
    held = f"{count.held} of {count.of}" if count.of else HOLE
    numbers = (count.mean, count.least, count.largest)
    return Cell(held, 0 < count.held < count.of, held), *(Cell(signed(n, 2), value=n) for n in numbers)
