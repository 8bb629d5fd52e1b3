"""JSON payloads as samples: their forms, and what is refused with one sentence."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.monitor.sources.payload import PayloadError, PayloadReader, SampleClock
from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from tests.monitor.streams import config_of

P1, P2, U = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.INPUT_VOLTAGE


def read(payload, clock=None, **options):
    return PayloadReader(config_of(**options), clock).read(
        payload if isinstance(payload, bytes) else json.dumps(payload).encode()
    )


def test_one_sample_is_converted_to_si():
    chunk = read({"time [ms]": 250, "P1 [bar]": 100, "u [V]": -2.5, "temperature": 40})
    assert chunk.time.tolist() == [0.25]
    assert {channel: samples.tolist() for channel, samples in chunk.channels.items()} == {
        P1: [1e7],
        U: [-2.5],
    }


@pytest.mark.parametrize(
    "payload",
    [
        {"time": [5.0, 5.5, 6.0], "chamber_1_pressure": [1, None, 3]},
        {"time": 5.0, "sampling_frequency": 2, "chamber_1_pressure": [1, None, 3]},
        {"time": 5.0, "sampling_frequency": "2 Hz", "chamber_1_pressure": [1, float("nan"), 3]},
        b'{"time": 5.0, "P1 [Pa]": 1}\n{"time": 5.5, "P1 [Pa]": null}\r\n\n{"time": 6.0, "P1 [Pa]": 3}\n',
        {
            "time": ["1970-01-01T00:00:05Z", "1970-01-01T01:00:05.5+01:00", "1970-01-01T00:00:06Z"],
            "p_chamber_1 (Pa)": [1, None, 3],
        },
    ],
)
def test_a_block_has_many_forms(payload):
    chunk = read(payload)
    np.testing.assert_array_equal(chunk.time, [5.0, 5.5, 6.0])
    np.testing.assert_array_equal(chunk.channels[P1], [1.0, np.nan, 3.0])


def test_a_configuration_names_keys_and_their_way_to_si():
    configured = {
        P2: ChannelConfig(column="ai7", unit="bar", gain=0.5, offset=1.0),
        U: ChannelConfig(column="valve", unit="V", sign=-1),
    }
    chunk = read({"time": 0, "ai7": 18, "valve [V]": 2, "P1 [bar]": 3}, channels=configured)
    assert {channel: samples.tolist() for channel, samples in chunk.channels.items()} == {
        P2: [1e6],
        U: [-2.0],
    }


def test_lines_with_other_keys_miss_samples():
    chunk = read(b'{"time":1,"P1 [Pa]":1}\n{"time":2,"P2 [Pa]":2}')
    np.testing.assert_array_equal(chunk.channels[P1], [1.0, np.nan])
    np.testing.assert_array_equal(chunk.channels[P2], [np.nan, 2.0])


def test_samples_without_time_are_counted_where_that_is_wanted():
    reader = PayloadReader(config_of(), SampleClock(10.0))
    assert reader.read(b'{"P1 [bar]": [1, 2]}').time.tolist() == [0.0, 0.1]
    assert reader.read(b'{"P1 [bar]": 3}').time.tolist() == [0.2]


def test_a_large_payload_is_refused():
    sample = b'{"time": 1, "P1 [bar]": 1}'
    assert read(sample + b" " * 74, largest=100)
    with pytest.raises(PayloadError, match="100"):
        read(sample + b" " * 75, largest=100)


def test_a_refused_payload_takes_no_instants():
    clock = SampleClock(10.0)
    with pytest.raises(PayloadError):
        read(b'{"P1 [bar]": [1, "x"]}', clock=clock)
    assert clock.n_sample == 0


@pytest.mark.parametrize(
    "payload",
    [
        {"time": 0, "P1 [bar]": [1e308]},
        {"time [h]": 1e308, "P1 [bar]": 1},
        {"time": 0, "sampling_frequency": 5e-324, "P1 [bar]": [0, 1]},
    ],
)
def test_what_overflows_is_infinite_without_a_warning(payload):
    chunk = read(payload)
    assert not np.isfinite([*chunk.time, *chunk.channels[P1]]).all()


KEYS = st.sampled_from(
    ["time", "t [s]", "time [ms]", "P1 [bar]", "P2", "u [V]", "sampling_frequency", "x [\ud800]"]
)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.just("2026-01-01T00:00:00Z"),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=2),
    max_leaves=6,
)


@given(st.dictionaries(KEYS | st.text(), VALUES).map(lambda found: json.dumps(found).encode()) | st.binary())
def test_any_payload_is_either_samples_or_refused(payload):
    try:
        chunk = PayloadReader(config_of()).read(payload)
    except PayloadError as error:
        str(error).encode()
    else:
        assert {samples.shape for samples in chunk.channels.values()} == {(chunk.n_time,)}


@pytest.mark.parametrize(
    "payload",
    [
        b"", b"\xff\xfe\x00", b"[" * 100_000, b'{"time": ' + b"1" * 5000 + b', "P1 [bar]": 1}', [1, 2],
        {"status": "ok"},
        {"P1 [bar]": 1}, {"t": 1, "P1 [bar]": 1}, {"time": 1, "P1": 1}, {"time": 1, "P1 [counts]": 1},
        {"time": 1, "P1 [bar]": 1, "pa [bar]": 1}, {"time": 1, "P1 [bar]": "3.5"},
        {"time": 1, "P1 [bar]": True}, {"time": [1], "P1 [bar]": [[1]]}, {"time": 1, "P1 [bar]": 10**400},
        {"time": [1, 2], "P1 [bar]": [1, 2], "P2 [bar]": [1]}, {"time": [1, 2, 3], "P1 [bar]": [1, 2]},
        {"time": 1, "P1 [bar]": [1, 2]}, {"time": 1, "sampling_frequency": 0, "P1 [bar]": [1, 2]},
        {"time": "2026-01-31T12:00:00", "P1 [bar]": 1}, {"time": "noon", "P1 [bar]": 1},
        {"time": 1, "P1 [bar]": 1} | {f"key {n}": 1 for n in range(300)},
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused_in_a_short_sentence(payload):
    with pytest.raises(PayloadError) as refusal:
        read(payload)
    assert len(str(refusal.value)) < 250
