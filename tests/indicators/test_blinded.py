"""What an indicator of any package can see of a record: samples, and nothing that names or describes it."""

from dataclasses import fields, is_dataclass

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.indicators import Indicator, Output, measure
from hydrofdi.indicators.record_measures import measure_sources
from hydrofdi.records import Channel, RecordBatch, RejectedRecord
from hydrofdi.records.measured.source import measured_source

P1 = Channel.CHAMBER_1_PRESSURE

RIG = """\
files: "*.csv"
sampling_frequency: 100 Hz
channels: {chamber_1_pressure: {column: P1, unit: bar}}
path: "{condition}_{unit}.csv"
group: "rig {unit}"
label: "{condition}"
"""


class Curious(Indicator):
    """Keeps every text that it can reach."""

    name, version, summary, source = "curious", 1, "Nothing.", "none"
    channels = frozenset({P1})
    outputs = (Output("mean", "Pa", "mean pressure"),)

    def __init__(self):
        super().__init__()
        self.seen = []

    def obstacle(self, records):
        self.seen.append((records.record_ids, texts_in(records)))

    def measure(self, records):
        self.obstacle(records)
        return {"mean": records[P1].mean(axis=1)}


def texts_in(thing):
    """Every text in a batch but the names of channels."""
    if isinstance(thing, str):
        return set() if isinstance(thing, Channel) else {thing}
    if is_dataclass(thing):
        inner = [getattr(thing, field.name) for field in fields(thing)]
    elif isinstance(thing, dict):
        inner = [*thing, *thing.values()]
    else:
        inner = thing if isinstance(thing, tuple | list | set | frozenset) else []
    return set().union(*map(texts_in, inner))


def test_an_indicator_sees_no_file_name_group_or_label(tmp_path):
    for name in ("Base_7", "Leak_7", "Leak_8"):
        (tmp_path / f"{name}.csv").write_text("P1\n" + "".join(f"{row % 5 + 1}\n" for row in range(20)))
    (tmp_path / "rig.yaml").write_text(RIG)
    curious = Curious()
    _, records = measure_sources([measured_source(tmp_path / "rig.yaml")], {"curious": curious})
    told = list(records)
    assert {record.label for record in told} == {"Base", "Leak"}, "a person sees them"
    assert {record.record_id.partition("#")[0] for record in told} >= {"Base_7.csv", "Leak_8.csv"}
    assert curious.seen
    for ids, texts in curious.seen:
        assert texts - set(ids) <= {""}
        assert all(name.isdecimal() for name in ids)


def test_what_is_rejected_or_remarked_is_not_handed_on_but_counts():
    remark = Issue("Leak_2.csv has a gap", kind="gap", is_unusable=True)
    records = RecordBatch(
        {P1: np.arange(20.0).reshape(2, 10)},
        100.0,
        ("Base_1.csv", "Leak_2.csv"),
        remarks=((), (remark,)),
        rejected=(RejectedRecord("Leak_3.csv", "rig", "unit 3", remark, "Leak"),),
        labels=("Base", "Leak"),
    )
    curious = Curious()
    measures = measure(records, {"curious": curious})
    assert measures.obstacles["curious"] == (None, "Leak_2.csv has a gap")
    np.testing.assert_array_equal(measures.values["curious.mean"], [4.5, np.nan])
    assert {text for _, texts in curious.seen for text in texts} <= {"", "0", "1"}
