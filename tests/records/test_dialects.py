"""What programs write is read right, or a description is proposed that reads it as it stands."""

import csv
import re

import numpy as np
import pytest

from hydrofdi.errors import HydrofdiError
from hydrofdi.records.source import measured_source, plain_source, write_description
from tests.conftest import REPOSITORY
from tests.records.dialects import RATE, ROWS, TEXTS, TIME, content
from tests.records.measuring import P1, P2, POSITION, one, read, yaml_of


def outcome(reading, file):
    """What the table of the docs says of a file; whose numbers are right if it is read."""
    try:
        batch = read(reading(file))
    except HydrofdiError:
        return "refused"
    assert batch.sampling_frequency == pytest.approx(RATE, rel=1e-6)
    assert batch.n_time >= 0.98 * TIME.size
    rows, has_slow = ROWS[: batch.n_time], "groups" in file.name
    for channel, column in ((P1, 1), (P2, 2)):
        if channel is P1 or P2 in batch.channels:
            np.testing.assert_allclose(batch[channel][0][: TIME.size], rows[:, column] * 1e5, rtol=2e-9)
    if POSITION in batch.channels:
        every = 5 if has_slow else 1  # slow ones are interpolated
        position = batch[POSITION][0][: TIME.size : every]
        np.testing.assert_allclose(position, rows[::every, 3] * 1e-3, atol=1e-12)
    kinds = dict.fromkeys(each.kind for each in batch.remarks[0] if each.kind != "unused")
    assert not has_slow or "100 Hz" in next(each.message for each in batch.remarks[0] if each.kind == "held")
    assert file.name != "am_pm.txt" or batch.dates == (1_793_627_999.5,)
    return "read" + (f", remarks {', '.join(f'`{kind}`' for kind in kinds)}" if kinds else "")


with open(REPOSITORY / "docs" / "tables" / "exports.csv", encoding="utf-8") as PAGE:
    OUTCOMES = [["plain", "read", "read"]] * 2 + list(csv.reader(PAGE))[1:]


@pytest.mark.parametrize(("name", "row"), [*zip(TEXTS, OUTCOMES, strict=True)], ids=TEXTS)
def test_a_file_is_read_right_or_refused_as_the_docs_say_and_its_proposal_reads_it(tmp_path, name, row):
    (file := tmp_path / name).write_bytes(content(name))
    _, plain, with_proposal = row
    assert outcome(plain_source, file) == plain
    text = write_description(file, description := file.with_suffix(".yaml"))
    if with_proposal.startswith("read, after"):
        assert text.count("…") == 2
        description.write_text(text.replace("unit: …", "unit: bar"), encoding="utf-8")
        with_proposal = "read"
    assert "…" not in description.read_text(encoding="utf-8")
    assert outcome(lambda _: measured_source(description), file) == with_proposal


@pytest.mark.parametrize(("decimal", "cell"), [
    *((".", cell) for cell in ("8,60.0", "86,000,0", "8,600,00", "1,0000.0", "1_0", "0x1", "x")),
    (",", "1.000,5"), (",", "1.5"),
])  # fmt: skip
def test_cells_and_thousands_in_the_wrong_place_are_no_numbers(tmp_path, decimal, cell):
    thousands = 'thousands: ","' if decimal == "." else 'decimal: ","'
    form = yaml_of("P1: P1", f"format: {{{thousands}}}", sampling="time: {column: time}")
    with pytest.raises(HydrofdiError, match=r"run\.csv:2"):
        one(tmp_path, form, run_csv=f'time [s];P1 [kPa]\n0;"{cell}"\n1;"8"\n')


def test_a_cell_with_another_unit_is_refused(tmp_path):
    text = TEXTS["units_in_cells.csv"]
    place = text.index("bar", 3_000)
    file = tmp_path / "run.csv"
    file.write_text(text[:place] + "psi" + text[place + 3 :])
    write_description(file, description := tmp_path / "rig.yaml")
    with pytest.raises(HydrofdiError, match=r"run\.csv:\d+"):
        read(measured_source(description))


FOLDER = REPOSITORY.parent / "shared" / "data" / "dialects"
"""Exports as people meet them, of another simulated record, where they are present."""
UNITLESS = {"06_long.csv", "21_wincc.csv", "tdms_df.csv"}
NOT_WHOLE = {
    "held_5.csv": "held", "frozen_half.csv": "stuck", "stuckhalf.csv": "stuck", "union.csv": "uneven",
    "mdf_units.csv": "uneven",
}  # fmt: skip


@pytest.mark.skipif(not FOLDER.is_dir(), reason="the exports are not present")
@pytest.mark.parametrize("file", sorted(FOLDER.glob("[0-9a-z]*.*")), ids=lambda file: file.name)
def test_exports_are_read_right_or_refused(tmp_path, file):
    pytest.importorskip({".mf4": "asammdf", ".tdms": "nptdms"}.get(file.suffix, "numpy"))
    (copy := tmp_path / file.name).write_bytes(file.read_bytes())
    text = write_description(copy, description := tmp_path / "rig.yaml")
    assert ("…" in text) == (file.name in UNITLESS)
    if file.name in UNITLESS:
        text = re.sub(r"(pressure: .*unit: )…", r"\g<1>bar", text)
        text = re.sub(r"(position: .*unit: )…", r"\g<1>mm", text)
        description.write_text(text.replace("unit: …", "unit: V"), encoding="utf-8")
    batch = read(measured_source(description))
    assert batch.sampling_frequency == pytest.approx(RATE, rel=1e-4)
    found = {remark.kind for remark in batch.remarks[0]}
    if expected := NOT_WHOLE.get(file.name):
        assert expected in found
    else:
        first = 82.676815e5 if batch.start_time < 1e-9 or batch.n_time < 400 else batch[P1][0, 3]
        assert batch[P1][0, 3] == pytest.approx(first, rel=1e-5)
        assert not any(remark.is_unusable for remark in batch.remarks[0])
