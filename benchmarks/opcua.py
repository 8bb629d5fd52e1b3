"""Cost of an OPC UA stream: processor time of the source per second of stream, by kind of node.

    PYTHONPATH=. python benchmarks/opcua.py

A server in a separate process writes four nodes in real time; this process reads them.
"""

import multiprocessing
import time

from hydrofdi.monitor.configuration import Address, OpcUaConfig
from hydrofdi.monitor.opcua import OpcUaSource
from hydrofdi.records import Channel
from hydrofdi.records.description import ChannelConfig
from tests.monitor.brokers import free_port
from tests.monitor.test_opcua_source import LoopbackServer

CHANNELS = [
    Channel.CHAMBER_1_PRESSURE,
    Channel.CHAMBER_2_PRESSURE,
    Channel.SUPPLY_PRESSURE,
    Channel.RETURN_PRESSURE,
]
SECONDS, STEP = 5, 0.1


def serve(port, rate, n_block, is_over):
    """Serve four nodes in real time; values are arrays if a block has several samples."""
    initial = 0.0 if n_block == 1 else [0.0]
    with LoopbackServer({channel.symbol: initial for channel in CHANNELS}, port) as server:
        began, n_sent = time.time() + 3.0, 0
        while not is_over.is_set():
            time.sleep(STEP)
            due = int((time.time() - began) * rate) // n_block
            if due <= n_sent:
                continue
            times = [(n + 1) * n_block / rate for n in range(n_sent, due)]
            values = [float(n) if n_block == 1 else [float(n)] * n_block for n in range(n_sent, due)]
            for channel in CHANNELS:
                server.write(channel.symbol, values, times)
            n_sent = due


def measure(rate, n_block):
    """Processor time per second of stream, and the fraction of samples received."""
    context = multiprocessing.get_context("spawn")
    port, is_over = free_port(), context.Event()
    process = context.Process(target=serve, args=(port, rate, n_block, is_over))
    process.start()
    channels = {each: ChannelConfig(column=f"ns=1;s={each.symbol}", unit="Pa") for each in CHANNELS}
    address = Address.parse(f"opc.tcp://127.0.0.1:{port}")
    source = OpcUaSource(address, OpcUaConfig(), channels, rate)
    source.open({})
    while not source.read(1.0):
        pass
    times, busy, began = [], time.process_time(), time.monotonic()
    while time.monotonic() - began < SECONDS:
        chunk = source.read(0.2)
        times.extend([] if chunk is None else chunk.time)
    busy = time.process_time() - busy
    source.close()
    is_over.set()
    process.join()
    n_due = round((max(times) - min(times)) * rate) + 1
    return busy / n_due * rate, len({*times}) / n_due


if __name__ == "__main__":
    print("rate [Hz]    samples/value  processor [s/s]         received")
    for rate, n_block in ((100.0, 1), (1000.0, 1), (1000.0, 100)):
        busy, share = measure(rate, n_block)
        print(f"{rate:9.0f}  {n_block:15d}  {busy:15.3f}  {share:15.3f}")
