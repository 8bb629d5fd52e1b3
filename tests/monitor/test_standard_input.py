"""Standard input as a stream: pipes and files, waiting, the end."""

import os
import threading
import time

import pytest

from hydrofdi.monitor.sources.growing_file import StandardInput
from tests.monitor.streams_of_text import config_of, samples


@pytest.fixture
def pipe():
    ends = [os.fdopen(end, mode, buffering=0) for end, mode in zip(os.pipe(), ("rb", "wb"), strict=True)]
    yield ends
    for end in ends:
        end.close()


def opened(file, position=(), **options):
    source = StandardInput(config_of(**options), file.fileno())
    source.open(dict(position))
    return source


def test_without_anything_new_it_waits(pipe):
    source = opened(pipe[0])
    begin = time.monotonic()
    reading = source.read(0.2)
    assert time.monotonic() - begin >= 0.19
    assert (reading.chunk, reading.events, reading.is_over) == (None, (), False)


def test_the_end_of_input_ends_the_stream_with_its_last_line(pipe):
    reader, writer = pipe
    source = opened(reader)
    writer.write(b'{"time": 1, "P1 [Pa]": 2}')
    writer.close()
    assert not source.read(1.0).is_over
    last = source.read(1.0)
    assert last.is_over
    assert samples(last.chunk) == {"time": [1.0], "P1": [2.0]}
    assert source.read(1.0).is_over
    assert source.read(1.0).chunk is None


def test_a_writer_that_is_faster_waits(pipe):
    reader, writer = pipe
    rows = b"time [s],P1 [Pa]\n" + b"".join(b"%d,1\n" % n for n in range(100_000))

    def write():
        writer.write(rows)
        writer.close()

    thread = threading.Thread(target=write)
    thread.start()
    source, n_time = opened(reader), 0
    while not (reading := source.read(1.0)).is_over:
        n_time += reading.chunk.n_time if reading.chunk else 0
    thread.join()
    assert n_time == 100_000


def test_counted_samples_go_on_behind_a_gap_after_a_restart(pipe):
    reader, writer = pipe
    first = opened(reader, sampling_frequency=10)
    writer.write(b"P1 [Pa]\n1\n2\n")
    first.read(1.0)
    second = opened(reader, first.position, sampling_frequency=10)
    writer.write(b"P1 [Pa]\n3\n")
    assert second.read(1.0).chunk.time.tolist() == [0.4]
