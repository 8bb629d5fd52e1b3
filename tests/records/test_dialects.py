"""What programs write is read right, or a description is proposed that reads it as it stands."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hydrofdi.errors import HydrofdiError
from hydrofdi.records.source import measured_source, plain_source, write_description
from tests.conftest import REPOSITORY
from tests.records.dialects import RATE, ROWS, TEXTS, TIME, TITLES, WITHOUT_UNITS, content, lines
from tests.records.exports import table
from tests.records.measuring import P1, P2, POSITION, one, read, yaml_of

PLAIN = {"plain.csv", "sep_point.csv", "exponents.csv", "underscores.csv", "units_row.csv", "groups.csv",
         "time_of_day.csv", "date_and_time.csv", "basic.csv"}  # fmt: skip
"""Texts that need no description."""


def proposal(file):
    """The description that is proposed for a file, with the units that only its writer knows."""
    text = write_description(file, description := file.with_suffix(".yaml"))
    if file.name in WITHOUT_UNITS:
        assert text.count("…") == 2
        description.write_text(text.replace("unit: …", "unit: bar"), encoding="utf-8")
    return description


def written(folder, name, text=None):
    file = folder / name
    file.write_bytes(content(name) if text is None else text.encode())
    return file


def require_right(batch, name):
    assert batch.sampling_frequency == pytest.approx(RATE, rel=1e-6)
    n_time = batch.n_time
    assert n_time >= 0.98 * TIME.size
    for channel, column in ((P1, 1), (P2, 2)):
        if channel is P1 or P2 in batch.channels:
            expected = ROWS[:n_time, column] * 1e5
            np.testing.assert_allclose(batch[channel][0][: TIME.size], expected, rtol=2e-9)
    if POSITION in batch.channels and "groups" not in name:
        np.testing.assert_allclose(batch[POSITION][0][: TIME.size], ROWS[:n_time, 3] * 1e-3, atol=1e-12)
    allowed = {"missing"} if name == "missing.csv" else set()
    assert {each.kind for each in batch.remarks[0] if each.is_unusable} == allowed


@pytest.mark.parametrize("name", TEXTS)
def test_a_file_is_read_right_or_refused_and_what_is_proposed_reads_it_as_it_stands(tmp_path, name):
    file = written(tmp_path, name)
    try:
        batch = read(plain_source(file))
    except HydrofdiError:
        assert name not in PLAIN
    else:
        require_right(batch, name)
        assert name in PLAIN
    description = proposal(file)
    assert "…" not in description.read_text(encoding="utf-8")
    batch = read(measured_source(description))
    require_right(batch, name)
    if "groups" in name:  # slow ones are interpolated and remarked
        (remark, *_) = (each for each in batch.remarks[0] if each.where == POSITION)
        assert (remark.kind, "100 Hz" in remark.message) == ("held", True)
        np.testing.assert_allclose(batch[POSITION][0][::5], ROWS[: batch.n_time : 5, 3] * 1e-3, atol=1e-12)


def test_dates_may_have_a_stated_format(tmp_path):
    text = "time,P1 [bar]\n" + "".join(f"05/06/2026 01:00:0{n}.5 PM,{n}\n" for n in range(9))
    form = "time: {column: time, format: '%d/%m/%Y %I:%M:%S.%f %p'}"
    batch = one(tmp_path, yaml_of("P1: 'P1 [bar]'", sampling=form), run_csv=text)
    assert (batch.sampling_frequency, batch.dates) == (1.0, (1_780_664_400.5,))


@pytest.mark.parametrize("cell", ["8,60.0", "86,000,0", "8,600,00", "1,0000.0"])
def test_thousands_in_the_wrong_place_are_no_number(tmp_path, cell):
    form = yaml_of("P1: P1", 'format: {thousands: ","}', sampling="time: {column: time}")
    with pytest.raises(HydrofdiError, match=r"run\.csv:2"):
        one(tmp_path, form, run_csv=f'time [s];P1 [kPa]\n0;"{cell}"\n1;"8,600.0"\n')


def test_a_cell_with_another_unit_is_refused(tmp_path):
    text = TEXTS["units_in_cells.csv"]
    place = text.index("bar", 3_000)
    file = written(tmp_path, "run.csv", text[:place] + "psi" + text[place + 3 :])
    with pytest.raises(HydrofdiError, match=r"run\.csv:\d+"):
        read(measured_source(proposal(file)))


SEPARATORS = st.sampled_from([";", ",", "\t", "|"])
UNIT_PLACES = st.sampled_from(["bracket", "round", "row", "underscore"])


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_a_random_dialect_is_read_right_or_refused(tmp_path_factory, data):
    sep, decimal, place = data.draw(SEPARATORS), data.draw(st.sampled_from(".,")), data.draw(UNIT_PLACES)
    quote = '"' if sep == decimal else data.draw(st.sampled_from(["", '"']))
    units, names = ("s", "bar", "bar", "mm", "V"), ("time", "P1", "P2", "x", "u")
    titles = {
        "bracket": list(TITLES),
        "round": [title.replace("[", "(").replace("]", ")") for title in TITLES],
        "row": names,
        "underscore": [f"{name}_{unit}" for name, unit in zip(names, units, strict=True)],
    }[place]
    head = [sep.join(titles)] + [sep.join(units)] * (place == "row")
    above = data.draw(
        st.lists(st.sampled_from(["Rig 7", "", "operator\tA. B.", "2026-05-05", "# x"]), max_size=4)
    )
    stated = [f"sep={sep}"] * (not above and data.draw(st.booleans()))
    text = lines([*stated, *above, *head], sep, decimal, quote, rows=ROWS[:60])
    folder = tmp_path_factory.mktemp("dialect")
    for reading in (plain_source, lambda file: measured_source(proposal(file))):
        try:
            batch = read(reading(written(folder, "run.csv", text)))
        except HydrofdiError:
            continue
        np.testing.assert_allclose(batch[P1][0], ROWS[:60, 1] * 1e5, rtol=2e-9)
        np.testing.assert_allclose(batch[POSITION][0], ROWS[:60, 3] * 1e-3, atol=1e-12)
        assert batch.sampling_frequency == pytest.approx(RATE)


def test_the_table_of_the_docs_says_what_becomes_of_exports():
    page = REPOSITORY / "docs" / "tables" / "exports.csv"
    assert page.read_text(encoding="utf-8") == table(), (
        "python -m tests.records.exports > docs/tables/exports.csv"
    )


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
