"""The answer of a diagnosis: a table, sentences, plain data."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from hydrofdi.diagnosis.diagnosing import Diagnosed, RecordDiagnosis
from hydrofdi.diagnosis.judging import Finding
from hydrofdi.settings.messages import HOLE, number_text, percent, readable_unit, typeset
from hydrofdi.tables.table import Column, Table
from hydrofdi.units import convert

_HIDDEN = ("low", "high", "size_low", "size_high", "visible")
"""Numbers of a finding that only programs see in the table."""


@dataclass(frozen=True, repr=False)
class Diagnosis(Diagnosed):
    """Which fault each record shows, as `hydrofdi.diagnose` returns it.

    Attributes
    ----------
    records : tuple of RecordDiagnosis
    sensors : str
        Channels that were used, such as ``P1 P2 x u``.
    n_healthy : int
        Healthy records of the same machine that the history rests on; 0 if it rests on the data sheet.
    remarks : tuple of str
        What limits the answer.
    """

    @property
    def table(self) -> Table:
        """A row for each record and named hypothesis, the most probable first.

        ``record``, ``name``, its ``title``, ``probability`` with ``low`` and ``high``; in SI ``size`` with
        ``size_low`` and ``size_high``, and the size from which on the fault is ``visible``.
        """
        rows = [(record, each) for record in self.records for each in record.named]
        findings = [each for _, each in rows]
        shown = [_size_text(each) for each in findings]
        likelihoods = [
            "above 99.9 %" if p > 0.999 else percent(p) for p in (each.probability for each in findings)
        ]
        texts = {
            "record": [record.record_id for record, _ in rows],
            "name": [each.name for each in findings],
            "title": [each.title for each in findings],
        }
        numbers = {
            name: [getattr(each, name) for each in findings] for name in ("probability", "size", *_HIDDEN)
        }
        return Table((
            Column("record", texts["record"], is_text=True, is_shown=len(self.records) > 1),
            Column("title", texts["title"], title="fault", is_text=True),
            Column("probability", numbers["probability"], title="probability", text=likelihoods),
            Column("size", numbers["size"], title="size", text=shown),
            Column("name", texts["name"], is_text=True, is_shown=False),
            *(Column(each, numbers[each], is_shown=False) for each in _HIDDEN),
        ), row="hypothesis")  # fmt: skip

    def visible_text(self, record: RecordDiagnosis) -> str:
        """Which faults would have been seen from which size on, and which at no size."""
        sized = sorted(
            (each.title, each.visible, each) for each in record.findings if not math.isnan(each.visible)
        )
        units = [_unit(each, size) for _, size, each in sized]
        seen = [
            f"{title} {number_text(convert(size, unit), 2)} {typeset(unit)}"
            for (title, size, _), unit in zip(sized, units, strict=True)
            if math.isfinite(size)
        ]
        never = [title for title, size, _ in sized if math.isinf(size)]
        return f"{'; '.join(seen)}." + (f" At no size: {'; '.join(never)}." if never else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as ``hydrofdi diagnose --json`` prints it."""

        def plain(value: Any) -> Any:
            return None if isinstance(value, float) and not math.isfinite(value) else value

        records = [
            {
                "record_id": record.record_id,
                "name": record.name or None,
                "reason": record.reason or None,
                "findings": [{key: plain(v) for key, v in asdict(each).items()} for each in record.findings],
            }
            for record in self.records
        ]
        return {
            "sensors": self.sensors,
            "healthy_records": self.n_healthy,
            "counts": self.counts,
            "records": records,
            "remarks": [*self.remarks],
        }


def _unit(finding: Finding, size: float) -> str:
    return "%" if finding.unit == "1" else readable_unit(finding.unit, size)


def _size_text(finding: Finding) -> str:
    if not math.isfinite(finding.size):
        return HOLE
    unit = _unit(finding, finding.size_high)
    low, size, high = (
        number_text(convert(each, unit), 2) for each in (finding.size_low, finding.size, finding.size_high)
    )
    return f"{size} {typeset(unit)} ({low}–{high})"
