"""Measured records of hydraulic actuators, where they are present; docs/measured.md says what they tell."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from hydrofdi.indicators import make_indicators, measure
from hydrofdi.records.source import measured_source
from tests.conftest import REPOSITORY, VTNSI, needs_vtnsi
from tests.records.measuring import P1, P2, POSITION, SUPPLY, kinds

pytestmark = needs_vtnsi


def description(folder, *changes):
    text = (REPOSITORY / "configs" / "measured" / "vtnsi.yaml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "vtnsi").symlink_to(VTNSI)
    (folder / "vtnsi.yaml").write_text(text, encoding="utf-8")
    return folder / "vtnsi.yaml"


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    (batch,) = measured_source(description(tmp_path_factory.mktemp("vtnsi"))).batches(labels=True)
    return batch


@pytest.fixture(scope="module")
def figures(records):
    ports = {"PG_1": P1, "PG_2": P2}
    chosen = {name: {"kind": "dwt", "channel": str(channel)} for name, channel in ports.items()}
    difference = replace(records, channels={P1: records[P1] - records[P2]})
    values = measure(difference, make_indicators({"dP": {"kind": "dwt"}})).values
    return measure(records, make_indicators(chosen)).values | values


def test_all_records_are_read_with_group_and_label(records):
    assert (records.n_record, records.n_time, records.sampling_frequency) == (70, 3000, 1000.0)
    assert records.relative == {P1, P2, POSITION}
    assert not records.rejected
    sizes = {group: records.groups.count(group) for group in set(records.groups)}
    assert sizes == {
        "unit 1, +": 16, "unit 1, -": 14, "unit 4, +": 15, "unit 4, -": 15, "unit 5, +": 4, "unit 5, -": 6,
    }  # fmt: skip
    assert [records.labels.count(label) for label in ("Base", "Leak")] == [40, 30]
    assert records.record_ids[0].startswith("vtnsi/Act_1/Base_000_2_410")
    assert records.record_ids[8].startswith("vtnsi/Act_1/Base_000_10_418"), "run 2 comes before run 10"


def test_the_direction_is_that_of_the_list_of_runs(records):
    with open(VTNSI / "runs.csv", encoding="utf-8") as file:
        listed = {f"vtnsi/{row['file']}": row["direction"][0] for row in csv.DictReader(file)}
    assert dict(zip(records.record_ids, (group[-1] for group in records.groups), strict=True)) == listed


def test_every_record_says_what_is_wrong_with_it(records):
    for row, remarks in enumerate(records.remarks):
        assert {"inferred_sampling", "clipped"} <= kinds(records, row)
        (clipped,) = [remark for remark in remarks if remark.kind == "clipped"]
        drives = P1 if records.groups[row].endswith("+") else P2
        assert clipped.where in {P1, P2} - {drives}, "the return side is clipped at zero"
    short = [row for row in range(70) if "short_stroke" in kinds(records, row)]
    assert [records.record_ids[row].split("/")[1:] for row in short] == [
        ["Act_5", "Base_000_80_594_9-11-2019-9-31-53 AM.txt.gz"]
    ]


def test_an_open_input_is_hum_and_saturated(tmp_path):
    mapped = ("  piston_position:", "  supply_pressure: {column: PG_3, unit: counts}\n  piston_position:")
    (batch,) = measured_source(description(tmp_path, mapped)).batches()
    found = [{remark.kind for remark in remarks if remark.where is SUPPLY} for remarks in batch.remarks]
    assert all(flags & {"hum", "clipped", "saturated"} for flags in found)
    leaking = [flags for flags, group in zip(found, batch.groups, strict=True) if "unit 4" in group]
    assert all("hum" in flags for flags in leaking)
    flagged = {remark.where for remarks in batch.remarks for remark in remarks if remark.kind == "hum"}
    assert flagged == {SUPPLY}


def area(records, values, first, second):
    """Probability that a record of the second unit reads higher, within equal direction."""
    groups, wins, pairs = np.array(records.groups), 0.0, 0
    for direction in "+-":
        one = values[groups == f"unit {first}, {direction}"]
        other = values[groups == f"unit {second}, {direction}"]
        wins += np.sum(other[:, None] > one) + 0.5 * np.sum(other[:, None] == one)
        pairs += one.size * other.size
    return wins / pairs


@pytest.mark.parametrize(("figure", "leaking", "healthy"), [
    ("PG_1.d2", 0.37, 0.72), ("PG_1.d3", 0.73, 0.62), ("PG_2.d2", 0.98, 0.80), ("PG_2.d3", 0.96, 0.43),
    ("PG_2.d4", 0.72, 0.78), ("PG_2.d5", 0.85, 0.68), ("dP.d3", 0.83, 0.46),
])  # fmt: skip
def test_areas_under_the_curve_are_those_of_an_independent_script(records, figures, figure, leaking, healthy):
    assert area(records, figures[figure], 1, 4) == pytest.approx(leaking, abs=0.0051)
    assert area(records, figures[figure], 1, 5) == pytest.approx(healthy, abs=0.0051)


def test_segments_and_shares_of_the_hold_pressure(tmp_path):
    for number, (part, first, last) in enumerate(
        [("motion", 300, 480), ("hold", 1900, 2200), ("impact, length: 0.512 s", 512, 512)]
    ):
        (tmp_path / str(number)).mkdir()
        file = description(tmp_path / str(number), ("limits:", f"segment: {{part: {part}}}\nlimits:"))
        found = [*measured_source(file).batches()]
        lengths = [batch.n_time for batch in found for _ in range(batch.n_record)]
        assert len(lengths) == 70
        assert first <= np.median(lengths) <= last
    (batch,) = found
    driving = np.where([group.endswith("+") for group in batch.groups], batch[P1].T, batch[P2].T).T
    assert np.median(driving[:, 60:160].max(axis=1) / np.median(driving[:, 400:], axis=1)) > 1.05
    (batch,) = measured_source(description(tmp_path, ("limits:", "normalize: hold\nlimits:"))).batches()
    np.testing.assert_allclose(np.maximum(batch[P1], batch[P2])[:, 2400:].mean(axis=1), 1.0, atol=0.01)
    assert all("normalized" in kinds(batch, row) for row in range(70))
