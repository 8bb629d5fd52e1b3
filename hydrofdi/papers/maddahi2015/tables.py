"""Tables 2 and 3: RMS and δ of all levels over leakage and EBM; and published values beside computed ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from hydrofdi.config.experiment import ReferenceCell, ReferenceConfig
from hydrofdi.papers.maddahi2015.standings import points
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.changes import changes_block
from hydrofdi.report.runs import RunTable
from hydrofdi.report.table import Block, Column, Table, group_breaks
from hydrofdi.report.wording import kilopascal, leakage_texts, mode_name, modulus_column, signed
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE
from hydrofdi.store.layout import names
from hydrofdi.units import convert

NONE_GIVEN = (
    "No published value is compared: the digits of the paper's Tables 2 and 3 are lost in the only text that"
    " hydrofdi was made from. If you have the printed paper, you can enter its numbers under reference: "
    "in the experiment file."
)


def table3_blocks(study: Study) -> tuple[Block, Block]:
    """The table of all runs; the one against the fixed baseline is the answer."""
    block = changes_block(study, "Table 3: change of the details with leakage and EBM", "table3")
    reason = study.missing_baseline or study.no_changes
    legend, *bands = (reason, *block.paragraphs) if reason else block.paragraphs
    first, *others = block.tables
    answer = replace(block, paragraphs=(legend,), tables=(first,), is_answer=True)
    rest = "Table 3 with the matched baseline"
    return answer, Block("table3-matched", rest, tuple(bands), tuple(others))


def table2_block(study: Study) -> Block | None:
    """Table 2 and its sealed control; None if more than leakage and EBM varies, or they form no grid."""
    table = study.table
    if table.label_names or study.grid.lack:
        return None
    requests = np.unique(table.leakage_requests)[:2]
    tables = [_table2(table.of(table.leakage_requests == each)) for each in reversed(requests)]
    legend = "RMS of the details of P_1; δ against the fixed, δ′ against the matched baseline."
    return Block("table2", "Table 2: the small leakage over the EBM", (legend,), tuple(tables))


def _table2(rows: RunTable) -> Table:
    """One line per level and EBM."""
    levels = [f"d{level + 1}" for level in range(rows.n_level) for _ in range(len(rows))]
    sealed = bool(rows.is_sealed[0])
    return Table(
        (
            Column("Level", levels, is_text=True),
            modulus_column(np.tile(rows[names.BULK_MODULUS], rows.n_level)),
            Column("RMS [kPa]", rows[names.DETAIL_RMS].T.ravel(), text=kilopascal),
            Column("δ [%]", rows.changes("fixed").T.ravel(), text=signed),
            Column("δ′ [%]", rows.changes("matched").T.ravel(), text=signed),
        ),
        "Control: no leakage" if sealed else f"Small leakage: {leakage_texts(rows)[0]} L/min",
        "table2-sealed" if sealed else "table2-leaky",
        (),
        group_breaks(levels),
        n_lead=2,
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


def reference_block(study: Study) -> Block:
    """Published values beside the computed ones, or the sentence that there are none."""
    reference, title = study.data.experiment.reference, "Published values"
    found = deviations(study.table, reference)
    if not found:
        return Block("reference", title, (NONE_GIVEN,))
    agrees = [each["agrees"] for each in found]
    holes, source = agrees.count(None), reference.source
    said = [
        f"Within the tolerance: {agrees.count(True)} of {counted(len(agrees) - holes, 'published value')}"
        f"{f'; source: {source}' if source else ''}."
    ]
    if holes:
        said += [f"{counted(holes, 'value')} could not be compared: there is no such run, or it failed."]
    shows = [signed if "delta" in each["quantity"] else kilopascal for each in found]
    cells = reference.cells
    columns = (
        Column("Mode", [mode_name(cell.leakage, cell.bulk_modulus) for cell in cells], is_text=True),
        Column("Level", [cell.level for cell in cells], is_text=True),
        Column("Quantity", ["δ [%]" if show is signed else "RMS [kPa]" for show in shows], is_text=True),
        *(
            Column(key.title(), [show(each[key]) for show, each in zip(shows, found, strict=True)])
            for key in ("computed", "published")
        ),
        points("Deviation", [each["deviation"] for each in found]),
        Column("Tolerance", [f"{each['tolerance']:g}" for each in found]),
        Column(
            "Agrees",
            [{True: "yes", False: "no", None: HOLE}[each] for each in agrees],
            is_text=True,
            strong=[k for k, each in enumerate(agrees) if each is False],
        ),
    )
    note = "Deviation and tolerance: percentage points of δ; percent of a published RMS."
    table = Table(columns, "Computed and published", "reference", (note,))
    return Block("reference", title, tuple(said), (table,))
