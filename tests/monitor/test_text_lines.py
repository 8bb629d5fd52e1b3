"""Streams of text: CSV and JSON lines in any pieces, and lines that are none."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.errors import DataError
from hydrofdi.monitor.payload import PayloadReader, SampleClock
from hydrofdi.monitor.sources import joined
from hydrofdi.records import Channel
from hydrofdi.records.description import ChannelConfig
from tests.monitor.streams import config_of, read_in_pieces, reader, samples

CSV = b"time [ms],P1 [bar],u [V]\n0,100,1\n1,101.5,\n2,nan,-3\n"
EXPECTED = {"time": [0.0, 0.001, 0.002], "P1": [1e7, 1.015e7, None], "u": [1.0, None, -3.0]}
FORMS = {
    "usual": CSV,
    "units in a row": b"time,P1,u\nms,bar,V\n0,100,1\n1,101.5,\n2,nan,-3\n",
    "carriage returns": CSV.replace(b"\n", b"\r\n"),
    "lone carriage returns": CSV.replace(b"\n", b"\r"),
    "byte order mark": b"\xef\xbb\xbf" + CSV,
    "no last line end": CSV[:-1],
    "header again": CSV.replace(b"\n2", b"\ntime [ms],P1 [bar],u [V]\n2"),
    "header and units again": b"time,P1,u\nms,bar,V\n0,100,1\ntime,P1,u\nms,bar,V\n1,101.5,\n2,nan,-3\n",
    "columns in another order": CSV.replace(b"\n2,nan,-3", b"\nu [V],P1 [MPa],time [s]\n-3,,0.002"),
    "JSON": b'{"time": 0, "P1 [bar]": 100, "u [V]": 1}\n{"time": 0.001, "P1 [bar]": 101.5, "u [V]": null}\n'
    b'{"time": 0.002, "P1 [bar]": NaN, "u [V]": -3}\n',
    "JSON blocks": b'\n{"time": [0, 0.001], "P1 [bar]": [100, 101.5], "u [V]": [1, null]}\n\n'
    b'{"time": 0.002, "u [V]": -3}',
}  # fmt: skip


P1, P2, U = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.INPUT_VOLTAGE
NUMBERED = {P1: ChannelConfig(column="2", unit="bar"), U: ChannelConfig(column="3", unit="V")}
GAINED = {
    P1: ChannelConfig(column="Druck", unit="bar", gain=0.5, offset=0.5),
    U: ChannelConfig(column="Ventil", unit="V"),
}
DESCRIBED = {
    "preamble": (b"logger 7\r\n\r\n1,2,3\r\n" + CSV.replace(b"\n", b"\r\n"), {"skip": 3}),
    "no header": (
        CSV.partition(b"\n")[2],
        {"header": False, "channels": NUMBERED, "time": {"column": "1", "unit": "ms"}},
    ),
    "other signs": (
        b"Zeit;Druck;Ventil\n0,0;199;1,0\n1,0;202;fehlt\n2,0;fehlt;-3,0\n",
        {"decimal": ",", "missing": "fehlt", "time": {"column": "Zeit", "unit": "ms"}, "channels": GAINED},
    ),
    "a row of unknown units": (
        b"time,P1,u\n*,*,*" + CSV[CSV.index(b"\n") :],
        {"units_row": True, "channels": {P1: ChannelConfig(column="P1", unit="bar", gain=1), U: NUMBERED[U]},
         "time": {"column": "time", "unit": "ms"}},
    ),
}  # fmt: skip
DATES = b"2026-02-05T06:00:00.000Z,80\n2026-02-05T06:00:00.5Z,81\n"
DATED = {
    "plain": (b"Zeitstempel,P1 [bar]\n" + DATES, {}),
    "no unit above the dates": (b"t,P1\n,bar\n" + DATES, {}),
    "configured": (
        b"Datum;P1 [bar]\n" + DATES.replace(b",", b";").replace(b".", b","),
        {"delimiter": ";", "decimal": ",", "time": {"column": "Datum"}},
    ),
    "a number in between": (b"Zeitstempel,P1 [bar]\n" + DATES.replace(b"\n", b"\n7,80\n", 1), {}),
    "JSON": (
        b'{"Zeitstempel": "2026-02-05T06:00:00Z", "P1 [bar]": 80}\n'
        b'{"Zeitstempel": ["2026-02-05T06:00:00.5Z"], "P1 [bar]": [81]}\n', {},
    ),
    "JSON, a unit that dates do not need": (
        b'{"time [ms]": "2026-02-05T06:00:00Z", "P1 [bar]": 80}\n'
        b'{"time [ms]": "2026-02-05T06:00:00.5Z", "P1 [bar]": 81}\n', {},
    ),
}  # fmt: skip
ALL = {name: (text, {}) for name, text in FORMS.items()} | DESCRIBED
CASES = [(*case, EXPECTED) for case in ALL.values()] + [
    (*case, {"time": [1770271200.0, 1770271200.5], "P1": [8e6, 8.1e6]}) for case in DATED.values()
]


@pytest.mark.parametrize(("text", "options", "expected"), CASES, ids=[*ALL, *(f"dates: {x}" for x in DATED)])
@given(cuts=st.lists(st.integers(0, 150), max_size=8))
def test_the_pieces_in_which_a_text_comes_do_not_matter(text, options, expected, cuts):
    """Dates need no unit, and are found by their usual names."""
    chunk, unread = read_in_pieces(reader(**options), text, cuts)
    assert samples(chunk) == expected
    assert len(unread) == (b"\n7,80\n" in text)


@pytest.mark.parametrize("form", DESCRIBED)
@given(cut=st.integers(0, 80))
def test_a_described_text_goes_on_anywhere(form, cut):
    text, options = DESCRIBED[form]
    first = reader(**options)
    chunks = [first.read(text[:cut])]
    second = reader(json.loads(json.dumps(first.position)), **options)
    rest = text[cut - first.n_unfinished if cut < len(text) else len(text) - first.n_unfinished :]
    chunks += [second.read(rest), second.read(b"", is_end=True)]
    assert samples(joined([chunk for chunk in chunks if chunk])) == EXPECTED


BAD = [b"2;3", b"1,2", b"1,2,3,4", b"x,2,3", b"1,2,3x", b"1,1_0,3", b"\xff\x00", b'1,"2,3', b"a,b,c"]
GOOD = b'{"time": 1, "P1 [Pa]": 2}\n'


@given(st.lists(st.sampled_from([b"1,2,3", *BAD]), min_size=1), st.lists(st.integers(0, 100), max_size=5))
def test_malformed_lines_are_counted_and_the_others_stay(lines, cuts):
    text = b"time [s],P1 [Pa],u [V]\n1,2,3\n" + b"".join(line + b"\n" for line in lines)
    chunk, unread = read_in_pieces(reader(), text, cuts)
    n_bad = sum(line in BAD for line in lines)
    assert samples(chunk)["u"] == [3.0] * (1 + len(lines) - n_bad)
    assert len(unread) == n_bad
    text = GOOD + b'{"time": 2, "P1 [Pa]": "2"}\n{"time": 3,\n[1]\nhello\n' + GOOD + b'{"a": 1}\n'
    chunk, unread = read_in_pieces(reader(), text, cuts)
    assert samples(chunk) == {"time": [1.0, 1.0], "P1": [2.0, 2.0]}
    assert len(unread) == 5


@pytest.mark.parametrize(("n_byte", "largest"), [(3_000, 1024), (30_000, 1024), (4_000_000, 1 << 20)])
def test_a_line_of_any_length_is_one_loss_with_bounded_memory(n_byte, largest):
    lines = reader(sampling_frequency=10, largest=largest)
    found = [lines.read(b"P1 [Pa]\n1\n")]
    for _ in range(0, n_byte, size := max(700, n_byte // 40)):
        found.append(lines.read(b"9" * size))
        assert lines.n_unfinished <= largest
    chunk = joined([each for each in (*found, lines.read(b"\n3\n")) if each is not None])
    assert samples(chunk.readable) == {"time": [0.0, 0.2], "P1": [1.0, 3.0]}
    assert len(chunk.unread) == 1


@pytest.mark.parametrize("text", [
    b"1,2\n", b"hello\n1\n", b"time [s],P1\n1,2\n", b"time [s],P1 [counts]\n1,2\n", b"P1 [bar]\n1\n",
    b'time [s],"P1\n1,2\n', b"time [s],P1 [bar]\ns,MPa\n1,2\n", CSV.decode().encode("utf-16"),
    CSV.decode().encode("utf-16-le"),
])  # fmt: skip
def test_a_stream_that_does_not_say_what_it_is_is_refused(text):
    with pytest.raises(DataError, match=r"^the stream\b"):
        reader().read(text)


def test_samples_without_time_are_counted_and_lost_lines_leave_a_gap():
    lines = reader(sampling_frequency=10)
    chunk, _ = read_in_pieces(lines, b"P1 [Pa]\n1\n2\nx\n4\n")
    assert chunk.time.tolist() == [0.0, 0.1, 3 / 10]
    assert lines.position == {"header": ["P1 [Pa]"], "n_sample": 4}
    chunk, _ = read_in_pieces(reader(json.loads(json.dumps(lines.position)), sampling_frequency=10), b"3\n")
    assert samples(chunk) == {"time": [0.4], "P1": [3.0]}
    clock = SampleClock(10.0)
    assert read(b'{"P1 [bar]": [1, 2]}', clock).time.tolist() == [0.0, 0.1]
    assert read(b'{"P1 [bar]": [1, "x"]}', clock).unread
    assert read(b'{"P1 [bar]": 3}', clock).time.tolist() == [0.3]
    chunk, _ = read_in_pieces(reader(sampling_frequency=10), b"P1 [Pa]\tu [V]\n\t\n1\t2\n\t\n3\t4\n")
    assert samples(chunk)["P1"] == [None, 1.0, None, 3.0], "delimiters alone are a row of empty cells"


def read(payload, clock=None, **options):
    content = payload if isinstance(payload, bytes) else json.dumps(payload).encode()
    return PayloadReader(config_of(**options), clock).read_all([content])


@pytest.mark.parametrize("payload", [
    b'{"time": [5.0, 5.5, 6.0], "chamber_1_pressure": [1, null, 3]}',
    b'{"time": 5.0, "sampling_frequency": 2, "chamber_1_pressure": [1, null, 3]}',
    b'{"time": 5.0, "sampling_frequency": "2 Hz", "chamber_1_pressure": [1, NaN, 3]}',
    b'{"time": 5.0, "P1 [Pa]": 1}\n{"time": 5.5, "P1 [Pa]": null}\r\n\n{"time": 6.0, "P1 [Pa]": 3}\n',
    b'{"time": ["1970-01-01T00:00:05Z", "1970-01-01T01:00:05.5+01:00", "1970-01-01T00:00:06Z"],'
    b' "p_chamber_1 (Pa)": [1, null, 3]}',
])  # fmt: skip
def test_a_block_has_many_forms(payload):
    assert f"{len(payload) - 1} byte" in read(payload, largest=len(payload) - 1).unread[0]
    assert samples(read(payload, largest=len(payload))) == {"time": [5.0, 5.5, 6.0], "P1": [1.0, None, 3.0]}


def test_keys_may_be_configured_and_differ_from_line_to_line():
    configured = {
        P2: ChannelConfig(column="ai7", unit="bar", gain=0.5, offset=1.0),
        U: ChannelConfig(column="valve", unit="V", sign=-1),
    }
    chunk = read(b'{"time": 0, "ai7": 18, "P1 [bar]": 3}\n{"time": 1, "valve [V]": 2}', channels=configured)
    assert samples(chunk) == {"time": [0.0, 1.0], "P2": [1e6, None], "u": [None, -2.0]}


@pytest.mark.parametrize("payload", [
    b"", b"\xff\xfe\x00", b"[" * 100_000, b'{"time": ' + b"1" * 5000 + b', "P1 [bar]": 1}', [1, 2],
    {"status": "ok"}, {"P1 [bar]": 1}, {"t": 1, "P1 [bar]": 1}, {"time": 1, "P1": 1},
    {"time": 1, "P1 [counts]": 1}, {"time": 1, "P1 [bar]": 1, "pa [bar]": 1}, {"time": 1, "P1 [bar]": "3.5"},
    {"time": 1, "P1 [bar]": True}, {"time": [1], "P1 [bar]": [[1]]}, {"time": 1, "P1 [bar]": 10**400},
    {"time": [1, 2], "P1 [bar]": [1, 2], "P2 [bar]": [1]}, {"time": [1, 2, 3], "P1 [bar]": [1, 2]},
    {"time": 1, "P1 [bar]": [1, 2]}, {"time": 1, "sampling_frequency": 0, "P1 [bar]": [1, 2]},
    {"time": "2026-01-31T12:00:00", "P1 [bar]": 1}, {"time": "noon", "P1 [bar]": 1},
    {"time": 1, "P1 [bar]": 1} | {f"key {n}": 1 for n in range(300)},
])  # fmt: skip
def test_what_is_not_understood_is_refused_in_a_short_sentence(payload):
    chunk = read(payload)
    assert (chunk.n_time, len(chunk.readable.time)) == (1, 0)
    assert len(chunk.unread[0]) < 350
