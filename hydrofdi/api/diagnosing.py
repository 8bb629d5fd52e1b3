"""Which fault records show: hypotheses with probabilities, sizes, and what tells them apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from hydrofdi.api.arguments import Names, Texts, names_of
from hydrofdi.api.detectors.healthy_records import HealthyRecords, experiment_of
from hydrofdi.api.measuring import Indicators, indicators_of
from hydrofdi.api.simulated import SimulatedRecords
from hydrofdi.api.sources import Described, open_records
from hydrofdi.diagnosis.diagnosing import Diagnosed
from hydrofdi.diagnosis.diagnosing import diagnose as diagnose_records
from hydrofdi.diagnosis.judging import Finding
from hydrofdi.errors import ConfigError
from hydrofdi.records import Channel
from hydrofdi.settings.readable import HOLE, number_text, percent, readable_unit, typeset
from hydrofdi.store.experiment_data import StoredRecords
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


def diagnose(
    data: Any,
    history: Any = None,
    indicators: Indicators = "flow_balance",
    *,
    healthy: str | int | Sequence[str | int] = (),
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
) -> Diagnosis:
    """Name the fault that records of a machine show, or say that nothing is wrong.

    Parameters
    ----------
    data : path, results, array_like, mapping, DataFrame, Dataset, or list of these
        Records with P1, x, and u or the spool position; better with P2. As for `hydrofdi.measure`. Of
        labelled records, those that are not healthy. All records are cut into pieces of 20 s, or of the
        shortest record of 10 s or more.
    history : same, optional
        Healthy records of the same machine, at least three, better twelve, of other days. By default the
        healthy ones of labelled records; if there are none, the data sheet takes their place.
    indicators : str, path, or mapping, optional
        A file or mapping of indicators as for `hydrofdi.measure`, of which ``flow_balance`` has the options.
    healthy : str, int, or sequence of them, optional
        Labels of healthy records, besides those that descriptions name.
    sampling_frequency, channel, unit, label : optional
        As for `hydrofdi.measure`.

    Returns
    -------
    Diagnosis

    Raises
    ------
    ConfigError, DataError
        An argument is invalid, or channels are missing.
    """
    said = Described(sampling_frequency, channel, unit)
    sources = open_records(data, tuple(Channel), replace(said, label=label))
    is_own, names = history is None, tuple(names_of("healthy", healthy, "labels of healthy records"))
    history_sources = sources if is_own else open_records(history, tuple(Channel), said)
    for source in (*sources, *history_sources):
        if isinstance(source, SimulatedRecords | StoredRecords) and experiment_of(source).study is not None:
            text = "a study draws another machine for each record; diagnose records of one machine"
            raise ConfigError(f"{source.name}: {text}")
    known = HealthyRecords(history_sources, names)
    is_one = is_own and known.is_unlabelled
    past = [] if is_one else [*known.batches()]
    if is_own and not is_one:
        asked = [*HealthyRecords(sources, names, is_faulty=True).batches()]
    else:
        asked = [batch for source in sources for batch in source.batches()]
    if not asked:
        raise ConfigError(f"{known.name}: all records are healthy; there is none to diagnose")
    used = sources if is_own else [*sources, *history_sources]
    chosen = indicators_of(indicators).values()
    stated = [each.options.model_dump(exclude_unset=True) for each in chosen if each.name == "flow_balance"]
    if len(stated) != 1:
        raise ConfigError(f"diagnose needs one flow_balance; {len(stated)} are among the indicators")
    return Diagnosis(**vars(diagnose_records(asked, past, used, stated[0])))


def visible_text(findings: Sequence[Finding]) -> str:
    """Which faults would have been seen from which size on, and which at no size."""
    sized = sorted((each.title, each.visible, each) for each in findings if not math.isnan(each.visible))
    units = [_unit(each, size) for _, size, each in sized]
    seen = [
        f"{title} {number_text(convert(size, unit), 2)} {typeset(unit)}"
        for (title, size, _), unit in zip(sized, units, strict=True)
        if math.isfinite(size)
    ]
    never = [title for title, size, _ in sized if math.isinf(size)]
    return f"{'; '.join(seen)}." + (f" At no size: {'; '.join(never)}." if never else "")


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
