"""Text files: what comes back is what was written, or a sentence with file and line."""

import gzip

import numpy as np
import pandas
import pytest

from hydrofdi.api.sources import Described, open_records
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import text as formats_text
from hydrofdi.records.source import measured_source, plain_source
from tests.monitor.streams import read_in_pieces, reader
from tests.records.measuring import BOTH, P1, P2, USUAL, described, kinds, one, plain, yaml_of

PRESSURE = np.array([100.0, 101.5, 99.25, 102.125])


@pytest.mark.parametrize("text", [
    "P1 (bar) ; x\n 100,5 ; 1\n 99,25 ; 2\n",
    "# a logger\n\nP1 [bar];x;;\n100,5;1;;\n99,25;2;;\n\n",
    '"P1 [bar]";"x"\r\n"100,5";"1"\r\n"99,25";"2"\r\n',
    "\ufeffP1 [MPa];x\n10,05;a\n9,925;\n",
])  # fmt: skip
def test_other_forms_of_the_same_numbers(tmp_path, text):
    batch = one(tmp_path, yaml_of("P1: P1", 'format: {decimal: ","}'), run_csv=text)
    np.testing.assert_allclose(batch[P1], [[100.5e5, 99.25e5]], rtol=1e-15)


def test_a_packed_text_of_blanks_and_ragged_rows(tmp_path):
    (folder := tmp_path / "a b [1] (x)").mkdir()
    (folder / "run 1.txt.gz").write_bytes(gzip.compress(b"t  P1   note\n0 1 begin\n1 2\n2 3\n"))
    batch = one(tmp_path, yaml_of("P1: {column: P1, unit: counts}", files="a b [1] (x)/*.txt.gz"))
    np.testing.assert_array_equal(batch[P1], [[1.0, 2.0, 3.0]])
    assert (batch.relative, batch.record_ids) == ({P1}, ("a b [1] (x)/run 1.txt.gz",))


@pytest.mark.parametrize(("text", "place"), [
    ("P1;x\n1;2\n100,5;3\n", ":3: .*P1"), ("P1,x\n1,2\n100,5,3\n", ":3: "), ("p1,x\n1,2\n", ": .*P1"),
    ("Press 4\nLine 2 of 3\nP1 [bar] x\n1 2\n3 4\n", "skip"), ("Press 4;v1\n\nP1;P2;x\n1;2;3\n", "skip"),
    ("P1,P1\n1,2\n", ": .*P1"), ("P1 [MPa],x\n1,2\n3,4\n", "MPa.*bar"),
    ("measured in May\nP1,x\n1,2\n", ": .*P1"), ("P1,2\n1,2\n", ":1: "),
    ("P1 [bar],x\nMPa,mm\n1,2\n", ":2: .*P1"), ("P1,T\nbar,degX\n1,2\n", ":2: "),
    (f"P1,x\n{'1' * 2000},2\n", "1,000"), *(
        (f"Time,P1\n{step},1\n{2 * step},1\n", r"run\.csv.*Time") for step in (1, 0.1)
    ),
])  # fmt: skip
def test_a_slip_is_named_with_its_line(tmp_path, monkeypatch, text, place):
    monkeypatch.setattr(formats_text, "_BLOCK", 100)
    monkeypatch.setattr(formats_text, "_LONGEST_LINE", 1000)
    sampling = "time: {column: Time}" if text.startswith("Time") else "sampling_frequency: 1 kHz"
    with pytest.raises(DataError, match=place):
        one(tmp_path, yaml_of("P1: {column: P1, unit: bar}", sampling=sampling), run_csv=text)


TIMED = "time [s],P1 [bar],P2 [bar]\n" + "".join(f"{n / 10},{84 + n},2{n}\n" for n in range(5))


@pytest.mark.parametrize(("text", "pressures", "remarks"), [
    ("0.5,8\n", range(84, 89), {"truncated"}), ("0.5,8", range(84, 89), {"truncated"}),
    ("0.5,8,2", [84, 85, 86, 87, 88, 8], {"unended"}), ("0.5,89,25", range(84, 90), {"unended"}),
    ("0.5,8,25\n", [84, 85, 86, 87, 88, 8], set()),
    ("\n# lost\n0.5,89,1\n\n", range(84, 90), {"interrupted"}),
    ("0.5,8\n0.6,90,26\n", [84, 85, 86, 87, 88, np.nan, 90], {"ragged", "missing"}),
    ("0\n0.6,90,26\n", [84, 85, 86, 87, 88, np.nan, 90], {"ragged", "missing"}),
])  # fmt: skip
def test_no_number_of_a_row_that_was_cut_off_is_believed(tmp_path, text, pressures, remarks):
    batch = plain(tmp_path, TIMED + text)
    np.testing.assert_array_equal(batch[P1], [np.array([*pressures]) * 1e5])
    assert batch.sampling_frequency == pytest.approx(10.0)
    assert kinds(batch) == remarks


@pytest.mark.parametrize("rows", ["0.3,1,2", "0.4,1,2\n\n0.35,1,2"])
def test_a_time_that_does_not_rise_is_named_with_file_line_and_remedy(tmp_path, rows):
    (rejected,) = plain(tmp_path, TIMED + rows + "\n").rejected
    assert rejected.remark.kind == "time"
    assert rejected.remark.message.startswith(f"{tmp_path / 'run.csv'}:7: ")
    assert "sampling_frequency: 10 Hz" in rejected.remark.message


def test_missing_values_make_a_channel_unusable_and_the_rest_goes_on(tmp_path):
    text = "P1,P2\n1,5\n-9999,6\nNaN,7\n,8\ninf,9\n2,10\n"
    batch = one(tmp_path, BOTH + "format: {missing: -9999}\n", run_csv=text)
    (remark,) = [remark for remark in batch.remarks[0] if remark.is_unusable]
    assert (remark.kind, remark.where) == ("missing", P1)
    assert "4 of 6 samples" in remark.message
    np.testing.assert_array_equal(batch[P2], [np.arange(5.0, 11.0) * 1e5])


@pytest.mark.parametrize("size", [1, 17])
@pytest.mark.parametrize("text", [
    "# Prüfstand\r\ntime;P1;note\r\ns;bar;-\r\n" + "".join(f"{n}.5;{n};é\r\n" for n in range(40)) + "41;4",
    "time [s],P1 [bar]\n" + "".join(f"{n},{n + n / 7!r}{'e' * (n == 20)}1\n" for n in range(30)),
    "time,P1 [bar]\n" + "".join(f"2026-01-31 12:00:{n:02},{n}\n# {n}\n\n" for n in range(30)) + "2026-\n",
])  # fmt: skip
def test_the_blocks_in_which_a_file_is_read_do_not_matter(tmp_path, monkeypatch, text, size):
    (tmp_path / "run.csv").write_text(text, encoding="utf-8", newline="")

    def read():
        (batch,) = plain_source(tmp_path / "run.csv").batches()
        return batch[P1].tobytes(), batch.sampling_frequency, batch.remarks

    whole = read()
    monkeypatch.setattr(formats_text, "_BLOCK", size)
    assert read() == whole
    assert len(whole[0]) >= 8 * 30


@pytest.mark.parametrize(("form", "text", "expected"), [
    ("", "0.5,1\n1.5,2\n", [1.0, 2.0]), ('delimiter: ","', "1,5,2,5\n3,5,4,5\n", [5.0, 5.0]),
    ('decimal: ",", delimiter: tab', "1,5\t2,5\n3,5\t4,5\n", [2.5, 4.5]), ("", "1,5,2,5\n3,5,4,5\n", None),
])  # fmt: skip
def test_numbers_without_header_are_found_by_their_column(tmp_path, form, text, expected):
    counted = yaml_of("P1: {column: 2, unit: Pa}", f"format: {{{form}}}")
    if expected is None:
        with pytest.raises(DataError, match=r"run.csv:1: "):
            one(tmp_path, counted, run_csv=text)
    else:
        np.testing.assert_array_equal(one(tmp_path, counted, run_csv=text)[P1], [expected])


@pytest.mark.parametrize(("text", "places"), [
    ("""\
files: "*.csv"
channels:
  chamber1_pressure: {column: P1}
  chamber_2_pressure: {column: P2, unti: bar}
samplingfrequency: 1 kHz
""", [":3: channels.chamber1_", ":4: channels.chamber_2_pressure.unti", ":5: samplingfrequency"]),
    ("""\
files: "*.csv"
channels:
  chamber_1_pressure: {column: P1, unit: mm}
  supply_pressure: {column: PS, unit: bar, range: [4 bar, 3 bar]}
segment: {part: hold}
group: "{untit}"
path: "{unit}.csv"
format: {delimiter: "\\n", encoding: latin-0}
""", [
        ":3: channels.chamber_1_pressure.unit", ":4: channels.supply_pressure.range", ":5: segment",
        ":6: group", ":8: format.delimiter", ":8: format.encoding", "sampling_frequency",
    ]),
    (USUAL, [":1: files"]),
])  # fmt: skip
def test_all_mistakes_of_a_description_are_listed_with_their_lines(tmp_path, text, places):
    with pytest.raises(ConfigError) as mistakes:
        measured_source(described(tmp_path, text))
    assert [place for place in places if place not in str(mistakes.value)] == []


def text_of(form, name="time", step=4, n_time=6):
    return f"{name};P1 [bar]\n" + "".join(f"{form.format(n * step)};{n}\n" for n in range(n_time))


UTC = "2026-01-31T12:00:00.{:03}Z"


@pytest.mark.parametrize(("form", "name"), [
    (UTC, "time"), ("2026-01-31 12:00:00.{:03}+01:00", "Time [UTC]"), ("1.2.2026 8:00:00.{:03}", "When"),
    ("2026-01-31 12:00:00,{:03}", "Timestamp"), ("31.01.2026 12:00:00,{:03}", "Zeit"),
])  # fmt: skip
def test_dates_may_be_the_time(tmp_path, form, name):
    dated = yaml_of("P1: P1", sampling="time: {column: When, unit: s}")
    text = text_of(form, name)
    batch = one(tmp_path, dated, run_csv=text) if name == "When" else plain(tmp_path, text)
    assert (batch.sampling_frequency, batch.start_time, kinds(batch)) == (250.0, 0.0, set())
    np.testing.assert_array_equal(batch[P1], [np.arange(6) * 1e5])
    assert form != UTC or batch.dates == (1769860800.0,)


def test_dates_are_exact_to_the_nanosecond_and_a_given_rate_wins(tmp_path):
    for step, rate in ((12_500, 80_000.0), (1_250, 800_000.0)):
        batch = plain(tmp_path, text_of("2026-01-31T12:00:00.000{:06}Z", step=step))
        assert (batch.sampling_frequency, kinds(batch)) == (pytest.approx(rate, rel=1e-3), set())
    batch = plain(tmp_path, text_of(UTC), 1000.0)
    assert (batch.sampling_frequency, kinds(batch)) == (1000.0, {"unused"})
    assert plain(tmp_path, text_of(UTC) + ";7\n").rejected[0].remark.kind == "time"


@pytest.mark.parametrize(("text", "place"), [
    *((text, r"run\.csv") for text in (
        "P1 [bar]\n1\n2\n", "time,P1 [bar]\n1,1\n2,2\n", "Time,P1 [bar]\n0,1\n0.5,2\n", "1.5,2\n3,4\n",
        "t [s],P1\n1,1\n2,2\n", "t [s],foo [bar]\n1,1\n2,2\n", "t [s],P1 [bar],p_1 [Pa]\n1,1,1\n2,2,2\n",
        b"PK\3\4t [s],P1 [bar]\n1,1\n", b"# Pr\xfcfstand\nt [s],P1 [bar]\n0,1\n1,2\n",
        "t [s]\n0\n1\n".encode("utf-16"),
    )),
    (text_of("12:00:00.{:03} PM"), r"run.csv:2: column 'time': '12:00:00.000 PM'.*format"),
    (text_of(UTC) + "soon;7\n", r"run.csv:8: column 'time': 'soon'"),
    (text_of(UTC) + "2026-01-31T12:00:00.024;7\n", "zone"),
    (text_of(UTC).replace(" [bar]", ""), "(?s)'P1': .*time: {column: 'time'}"),
])  # fmt: skip
def test_a_plain_file_that_does_not_say_enough_is_refused_with_a_remedy(tmp_path, text, place):
    with pytest.raises(DataError, match=place):
        plain(tmp_path, text)
    if isinstance(text, bytes):
        with pytest.raises(DataError, match="the stream: is not text"):
            read_in_pieces(reader(), text)


def test_a_column_of_dates_gives_a_record_its_date(tmp_path):
    time = np.datetime64("2026-01-31T12:00:00", "ns") + np.arange(6) * np.timedelta64(4, "ms")
    columns, noon = {"time": time, "P1 [bar]": np.arange(6.0)}, 1769860800.0
    np.savez(tmp_path / "run.npz", **columns)
    for data in (tmp_path / "run.npz", pandas.DataFrame(columns), columns):
        (batch,) = open_records(data, [P1], Described())[0].batches()
        assert (batch.dates, batch.start_time) == ((noon,), 0.0)


def test_plain_columns_are_in_their_unit_or_in_si_by_a_full_name(tmp_path):
    batch = plain(tmp_path, "time [ms];p_1 [bar];Chamber 2 pressure (MPa)\n0;1;2\n2;3;4\n4;5;6\n")
    assert batch.sampling_frequency == 500.0
    np.testing.assert_array_equal(batch[P1], [[1e5, 3e5, 5e5]])
    np.testing.assert_array_equal(batch[P2], [[2e6, 4e6, 6e6]])
    text = "time,chamber_1_pressure,piston_position\n0,1,0.1\n0.5,2,0.2\n1,3,0.3\n"
    stated = yaml_of("P1: {column: chamber_1_pressure, unit: bar}", sampling="time: {column: time, unit: ms}")
    for batch, rate, unit in ((plain(tmp_path, text), 2.0, 1.0), (one(tmp_path, stated), 2000.0, 1e5)):
        assert (batch.sampling_frequency, batch.relative) == (rate, set())
        np.testing.assert_array_equal(batch[P1], [[unit, 2 * unit, 3 * unit]])
