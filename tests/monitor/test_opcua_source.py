import time
from threading import enumerate as threads

import numpy as np
import pytest
from asyncua import ua

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import EventKind, WindowLine
from hydrofdi.monitor.opcua.source import OpcUaSource
from hydrofdi.monitor.watch import Watch
from hydrofdi.records.measured.description.sections import ChannelConfig
from tests.detectors.trained.made import FREQUENCY
from tests.monitor.opcua_server import LoopbackServer
from tests.monitor.opcua_streams import CHANNELS, FAST, NODES, P1, RATE, Reader, X, connected, opened
from tests.monitor.streams import lines_of, made_detector, stream

CODES = ua.StatusCodes


@pytest.fixture(scope="module")
def server():
    with LoopbackServer({**NODES, "P1s": [0.0], "xs": [0.0], "text": ""}) as running:
        yield running


def test_samples_are_those_of_the_server_to_the_bit(server):
    rng = np.random.default_rng(1)
    pressure, position = rng.normal(50.0, 1.0, 200), np.repeat(rng.normal(0.0, 9.0, 4), 50)
    times = np.arange(200) / RATE
    with opened(server.url) as source:
        reader = connected(source)
        server.write("P1", pressure.tolist(), times)
        server.write("x", position.tolist(), times)
        reader.samples(200)
    np.testing.assert_array_equal(reader.channel(P1), pressure * 1e5)
    np.testing.assert_array_equal(reader.channel(X), -(2.0 * position + 1.0) / 1e3)
    np.testing.assert_allclose(reader.time, times, atol=1e-6)


def test_a_value_whose_status_is_not_good_is_missing(server):
    times = 10.0 + np.arange(4) / RATE
    with opened(server.url) as source:
        reader = connected(source)
        server.write(
            "P1",
            [1.0, 2.0, 3.0, 4.0],
            times,
            [CODES.Good, CODES.Bad, CODES.UncertainLastUsableValue, CODES.Good],
        )
        server.write("x", [1.0, 2.0, 3.0, 4.0], times)
        reader.samples(4)
    assert np.isnan(reader.channel(P1)).tolist() == [False, True, True, False]
    assert not np.isnan(reader.channel(X)).any()


def test_a_queue_of_the_server_that_was_full_is_said(server):
    overflow = ua.StatusCode(0x480)
    with opened(server.url) as source:
        reader = connected(source)
        server.write("P1", [1.0, 2.0], [30.0, 30.01], [CODES.Good, overflow.value])
        server.write("x", [1.0, 2.0], [30.0, 30.01])
        reader.samples(2).has(EventKind.DROPPED)
    assert not np.isnan(reader.channel(P1)).any()


def test_windows_of_the_stream_are_judged_as_in_a_file(server):
    file = made_detector()
    samples = stream(3, leaking=[1])
    config = {P1: ChannelConfig(column="ns=1;s=P1", unit="Pa")}
    with opened(server.url, channels=config, rate=FREQUENCY) as source:
        reader = connected(source)
        server.write("P1", samples.channels[P1].tolist(), 40.0 + samples.time)
        reader.samples(samples.n_time)
    lines = lines_of(Watch(file), reader.chunks)
    expected = lines_of(Watch(file), [samples])
    verdicts = [line.verdict for line in lines if isinstance(line, WindowLine)]
    assert verdicts == [line.verdict for line in expected if isinstance(line, WindowLine)]
    assert [verdict.alarm for verdict in verdicts] == [False, True, False]


def test_a_node_may_hold_an_array_of_consecutive_samples(server):
    channels = {P1: ChannelConfig(column="ns=1;s=P1s", unit="bar"), X: CHANNELS[X]}
    channels[X] = channels[X].model_copy(update={"column": "ns=1;s=xs"})
    with opened(server.url, channels=channels) as source:
        reader = connected(source)
        for block in range(3):
            values = np.arange(50.0) + 50 * block
            for name in ("P1s", "xs"):
                server.write(name, [values.tolist()], [60.0 + 0.5 * (block + 1)])
        reader.samples(150)
    np.testing.assert_array_equal(reader.channel(P1), np.arange(150) * 1e5)
    np.testing.assert_allclose(np.diff(reader.time), 1 / RATE, atol=1e-6)


def test_a_server_that_vanishes_is_found_again(server):
    with opened(server.url) as source:
        reader = connected(source)
        for count in (1, 2):
            for name in NODES:
                server.write(name, [2.0 * count, 3.0 * count], [50 + count, 50.01 + count])
            reader.samples(2 * count)
            server.vanish()
            reader.has(EventKind.DISCONNECTED, times=count)
            server.appear()
            reader.has(EventKind.CONNECTED, times=count + 1)
            time.sleep(0.2)
    assert reader.channel(P1).tolist() == [2e5, 3e5, 4e5, 6e5]


def test_an_absent_server_is_waited_for_and_said_once(server):
    server.vanish()
    with opened(server.url) as source:
        reader = Reader(source).has(EventKind.DISCONNECTED)
        time.sleep(0.5)
        server.appear()
        reader.has(EventKind.CONNECTED)
    (said,) = reader.said(EventKind.DISCONNECTED)
    assert "connection refused" in said
    assert "not encrypted" in reader.said(EventKind.INSECURE)[0]


def test_a_source_that_is_closed_leaves_no_thread_and_no_subscription(server):
    with opened(server.url) as source:
        connected(source)
        during = server.n_subscription
    assert not [thread for thread in threads() if thread.name == "opcua"]
    assert server.n_subscription < during


@pytest.mark.parametrize(
    ("config", "named"),
    [
        ({"column": "P1", "unit": "bar"}, "P1"),
        ({"column": "ns=1;s=P1"}, "unit"),
        ({"column": "ns=1;s=P1", "unit": "mm"}, "Pa"),
    ],
)
def test_a_channel_that_cannot_be_read_is_refused_before_it_is_connected(config, named):
    with pytest.raises(ValueError, match=named):
        OpcUaSource("opc.tcp://127.0.0.1", FAST, {P1: ChannelConfig(**config)}, RATE)


@pytest.mark.parametrize(
    "url",
    ["opc.tcp://", "http://host", "opc.tcp://host:99999", "opc.tcp://host/x?y", "opc.tcp://me:secret@host"],
)
def test_what_is_no_address_is_refused_and_credentials_are_not_repeated(url):
    with pytest.raises(ConfigError) as error:
        OpcUaSource(url, FAST, CHANNELS, RATE)
    assert "secret" not in str(error.value)
