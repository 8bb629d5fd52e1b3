"""Dates with times of day as the time of measured files."""

import numpy as np
import pytest

from hydrofdi.errors import DataError
from hydrofdi.records.dates import unix_seconds
from hydrofdi.records.measured.source import measured_source, plain_source
from tests.records.measuring import P1, described, kinds

FORMS = [
    "2026-01-31T12:00:00.{:03}Z",
    "2026-01-31 12:00:00.{:03}+01:00",
    "2026-01-31 12:00:00,{:03}",
    "31.01.2026 12:00:00,{:03}",
    "1.2.2026 8:00:00.{:03}",
]


def text_of(form, name="time", step=4, n_time=6):
    return f"{name};P1 [bar]\n" + "".join(f"{form.format(n * step)};{n}\n" for n in range(n_time))


def plain(folder, text, sampling_frequency=None):
    (folder / "run.csv").write_text(text, encoding="utf-8")
    (batch,) = plain_source(folder / "run.csv", sampling_frequency).batches()
    return batch


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["time", "Time [UTC]", "Timestamp", "Zeit"])
def test_a_plain_file_may_have_dates_as_its_time(tmp_path, form, name):
    batch = plain(tmp_path, text_of(form, name))
    assert (batch.sampling_frequency, batch.start_time) == (250.0, 0.0)
    np.testing.assert_array_equal(batch[P1], [np.arange(6) * 1e5])
    assert kinds(batch) == set()


@pytest.mark.parametrize("time", ["{column: When}", "{column: When, unit: s}"])
def test_a_description_may_name_a_column_of_dates(tmp_path, time):
    description = f"files: run.csv\ntime: {time}\nchannels: {{chamber_1_pressure: P1}}\n"
    (batch,) = measured_source(described(tmp_path, description, run_csv=text_of(FORMS[0], "When"))).batches()
    assert batch.sampling_frequency == 250.0


def test_dates_are_exact_to_the_nanosecond(tmp_path):
    form = "2026-01-31T12:00:00.000{:06}Z"
    assert plain(tmp_path, text_of(form, step=12_500)).sampling_frequency == 80_000.0
    assert "uneven" not in kinds(plain(tmp_path, text_of(form, step=1_250)))


def test_the_rate_that_is_given_wins_over_dates(tmp_path):
    batch = plain(tmp_path, text_of(FORMS[0]), 1000.0)
    assert (batch.sampling_frequency, kinds(batch)) == (1000.0, {"unused"})


@pytest.mark.parametrize(("text", "sentence"), [
    (text_of("12:00:00.{:03}"), r"run.csv:2: column 'time': '12:00:00.000' is not a date and time such as"),
    (text_of("01/31/2026 12:00:00.{:03}"), "is not a date and time such as 2026-01-31T12:00:00.25Z"),
    (text_of(FORMS[0]) + "soon;7\n", r"run.csv:8: column 'time': 'soon' is not a date"),
    (text_of(FORMS[0]) + "2026-01-31T12:00:00.024;7\n", "some dates have a zone and others have none"),
    (text_of(FORMS[0]).replace(" [bar]", ""), "(?s)'P1': has no unit.*time: {column: 'time'}"),
])  # fmt: skip
def test_other_times_are_refused_with_a_remedy(tmp_path, text, sentence):
    with pytest.raises(DataError, match=sentence):
        plain(tmp_path, text)


def test_a_missing_date_rejects_the_record(tmp_path):
    (rejected,) = plain(tmp_path, text_of(FORMS[0]) + ";7\n").rejected
    assert "1 sampling instants are missing" in rejected.remark.message


def test_arrays_may_hold_dates(tmp_path):
    time = np.datetime64("2026-01-31T12:00:00", "ns") + np.arange(6) * np.timedelta64(12_500, "ns")
    np.savez(tmp_path / "run.npz", **{"time": time, "P1 [bar]": np.arange(6.0)})
    (batch,) = plain_source(tmp_path / "run.npz").batches()
    assert batch.sampling_frequency == 80_000.0


def test_dates_with_zones_are_unix_times():
    found = unix_seconds(["1970-01-01T00:00:00Z", "2026-01-31T12:00:00.25Z", "31.01.2026 13:00:00,25+01:00"])
    assert found.tolist() == [0.0, 1769860800.25, 1769860800.25]
    with pytest.raises(ValueError, match="has no zone; write it like 2026-01-31T12"):
        unix_seconds(["2026-01-31T12:00:00"])


def test_full_names_and_time_are_in_si(tmp_path):
    batch = plain(tmp_path, "time,chamber_1_pressure,piston_position\n0,1e5,0.1\n0.5,2e5,0.2\n1,3e5,0.3\n")
    assert batch.sampling_frequency == 2.0
    np.testing.assert_array_equal(batch[P1], [[1e5, 2e5, 3e5]])
    assert batch.relative == frozenset()


def test_a_unit_of_the_description_wins_over_a_full_name(tmp_path):
    description = """\
files: run.csv
time: {column: time, unit: ms}
channels: {chamber_1_pressure: {column: chamber_1_pressure, unit: bar}}
"""
    text = "time,chamber_1_pressure\n0,1\n1,2\n2,3\n"
    (batch,) = measured_source(described(tmp_path, description, run_csv=text)).batches()
    assert (batch.sampling_frequency, batch[P1].tolist()) == (1000.0, [[1e5, 2e5, 3e5]])


GERMAN = (
    "Zeit [s];Druck A [bar];Druck B [bar];Weg [mm];Spannung [mV];Druck P [kg]\n0;1;2;3;4;5\n0.5;1;2;3;4;5\n"
)
COMMAS = "Zeit [s];p A [bar];Ventil [V]\n0,000;105,983;0,001\n0,001;105,9;0,01\n0,002;105,8;0,1\n"


@pytest.mark.parametrize(("text", "symbols", "first"), [
    (GERMAN, "P1 P2 x u", 1e5), (COMMAS, "P1 u", 10598300.0),
])  # fmt: skip
def test_a_suggestion_for_german_names_and_commas_can_be_pasted(tmp_path, text, symbols, first):
    with pytest.raises(DataError) as raised:
        plain(tmp_path, text)
    description = tmp_path / "measured.yaml"
    description.write_text(str(raised.value).partition("YAML file:\n")[2], encoding="utf-8")
    (batch,) = measured_source(description).batches()
    assert {channel.symbol for channel in batch.channels} == {*symbols.split()}
    assert batch[P1][0, 0] == first
