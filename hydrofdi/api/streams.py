"""Records that are played as streams, and the streams of many machines that one process monitors."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from hydrofdi.api.arguments import Names, names_of, path_of, positive_of
from hydrofdi.api.sources import Described, open_records
from hydrofdi.detectors.trained.file import is_detector
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.monitor.configuration import Address, is_mqtt, load_monitor_config
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.files import titled
from hydrofdi.records.streams import Chunk

if TYPE_CHECKING:
    from hydrofdi.monitor.loop import Ending

_BLOCK_DURATION = 0.05
"""Time between blocks [s]."""
_MOST_SAMPLES = 4096
"""Samples of a block at most."""
_AHEAD = 20
"""Most messages of samples that the broker has not acknowledged; the next one waits."""
_GAP = 10
"""Sampling periods between records, so that no window holds samples of two."""


def replay(
    data: Any,
    *,
    rate: str | float | None = "max",
    record: str = "",
    now: bool = False,
    settings: Sequence[str] = (),
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> Iterator[Chunk]:
    """Play records as a stream, for trying a detector out.

    Parameters
    ----------
    data : path, Run, Results, array_like, mapping, DataFrame, DataArray, Dataset, or list of these
        Records, as `hydrofdi.measure` takes them. They follow each other with a short gap.
    rate : str or float, optional
        Samples in a second, such as ``"500 Hz"``; ``"max"``, as fast as they are taken; None, as measured.
    record : str, optional
        Replay only one record: its number, from 1, or its name.
    now : bool
        Start time at the present, in seconds since 1970.
    settings : sequence of str, optional
        ``KEY=VALUE`` of an experiment that is simulated.
    sampling_frequency, channel, unit
        Of records in memory, as in `hydrofdi.measure`.

    Yields
    ------
    Chunk
        Up to 4,096 samples, ``time`` [s] and ``channels`` in SI; `Detector.watch` takes them.

    Raises
    ------
    ConfigError, DataError, StoreError
        An argument is invalid, or the records cannot be read.

    Examples
    --------
    >>> import hydrofdi, numpy
    >>> chunks = list(hydrofdi.replay(numpy.zeros(1000), sampling_frequency="1 kHz"))
    >>> sum(chunk.n_time for chunk in chunks)
    1000
    """
    (chosen,) = names_of("record", record, "the number or name of a record") if record != "" else [""]
    stated = names_of("settings", settings, "texts such as 'fluid.bulk_modulus=689 MPa'")
    sources = open_records(
        data, tuple(Channel), Described(sampling_frequency, channel, unit, settings=stated)
    )
    if rate is not None and rate != "max":
        rate = positive_of("rate", rate, "Hz", "a number in Hz, a text such as '500 Hz', or 'max'")
    pace = math.inf if rate == "max" else rate
    start = time.time() if now else None
    return chain.from_iterable(_replayed(source, pace, chosen, start) for source in sources)


def monitor_fleet(
    fleet: str | PathLike[str],
    *,
    state: str | PathLike[str] | None = None,
    log: str | PathLike[str] | None = None,
    metrics: str | None = None,
    events: Sequence[str] = (),
    partition: str | None = None,
    follow: bool = True,
    on_line: Callable[[dict[str, Any]], None] | TextIO | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Ending:
    """Judge the streams of many machines, as ``hydrofdi monitor FLEET`` does.

    Parameters
    ----------
    fleet : path
        YAML with the machines, their detectors, and the description of their samples.
    state, log, metrics, events, partition, optional
        Replace the keys of the same name in the file.
    follow : bool
        Whether to wait for more at the end of files.
    on_line : callable or file object, optional
        Called with each line; to a file, they are written as JSON. The key ``machine`` has the name.
    stop : callable, optional
        Returns whether to end; called several times a second.

    Returns
    -------
    Ending
        The reason why it ended, a text of one sentence.

    Raises
    ------
    ConfigError, StoreError
        The file is wrong, or state or log cannot be used. What goes wrong with a machine is an event.
    """
    from hydrofdi.monitor.fleet_configuration import Pattern, load_fleet_config
    from hydrofdi.monitor.loop import Monitor
    from hydrofdi.monitor.opening import Sources

    file = path_of(fleet)
    if file.is_file() and is_detector(file):
        raise ConfigError(f"{file}: is a detector; state the source that it judges behind it")
    files = {key: str(path_of(each).absolute()) for key, each in (("state", state), ("log", log)) if each}
    stated = files | {
        "metrics": metrics,
        "events": names_of("events", events, "addresses"),
        "partition": partition,
    }
    config = load_fleet_config(file, **{key: value for key, value in stated.items() if value})
    patterns = [Pattern.parse(text, file.parent) for text in config.machines]
    sources = Sources(config, file, patterns, is_followed=follow)
    return Monitor(config, sources, on_line).run(stop)


def _replayed(source: RecordSource, pace: Any, record: str, begin: float | None) -> Iterator[Chunk]:
    """Blocks of samples, each when it is due: lateness is made up for. A short gap is between records."""
    start: float | None = None
    due = 0.0
    for batch, row in _chosen(source, record):
        times = (batch if begin is None else replace(batch, start_time=begin)).time
        begin = float(times[-1]) + _GAP / batch.sampling_frequency
        rate = batch.sampling_frequency if pace is None else pace
        n_block = int(max(1.0, min(_MOST_SAMPLES, rate * _BLOCK_DURATION)))
        for first in range(0, batch.n_time, n_block):
            part = slice(first, first + n_block)
            samples = {channel: values[row, part] for channel, values in batch.channels.items()}
            start, due = start or time.monotonic(), due + times[part].size / rate
            time.sleep(max(0.0, start + due - time.monotonic()))
            yield Chunk(times[part], samples)


def _chosen(source: RecordSource, record: str) -> Iterator[tuple[RecordBatch, int]]:
    number = 0
    reason = ""
    for batch in source.batches():
        reason = next((f"; {rejected.remark.message}" for rejected in batch.rejected), reason)
        for row, record_id in enumerate(batch.record_ids):
            number += 1
            if record in ("", record_id, str(number)):
                for channel in sorted(batch.relative):
                    raise DataError(
                        f"{source.name}: {channel} has no scale, and a stream is in SI; give its 'gain' and"
                        " 'unit' in the description of the files"
                    )
                yield batch, row
                if record:
                    return
    if not number:
        raise DataError(f"{source.name}: contains no records{reason}")
    if record:
        raise DataError(f"{source.name}: has no record {record!r}; it has {number:,}, numbered from 1")


Send = Callable[[Chunk], None]


@contextmanager
def sample_target(
    to: str, form: str | None, config: Path | None, stream: TextIO, tell: Callable[[str], None]
) -> Iterator[Send]:
    """Receiver of blocks of samples; it has received all when it is closed."""
    if to == "-":
        if config is not None:
            raise ConfigError("config: is for a broker; give its topic as 'to'")
        yield _text_sender(form, stream)
    elif not is_mqtt(to):
        expected = "expected '-' for standard output, or mqtt://host:port/topic"
        raise ConfigError(f"to {to}: {expected}")
    elif form is not None:
        raise ConfigError("format: is for standard output; messages are JSON")
    else:
        with _broker(to, config, tell) as send:
            yield send


def _text_sender(form: str | None, stream: TextIO) -> Send:
    """Samples as text, in SI and to the bit: JSON, or CSV with a header that comes again if it changes."""
    written: tuple[Channel, ...] = ()

    def send(chunk: Chunk) -> None:
        nonlocal written
        channels = tuple(chunk.channels)
        rows = zip(chunk.time.tolist(), *(each.tolist() for each in chunk.channels.values()), strict=True)
        if form == "json":
            names = ["time", *(channel.value for channel in channels)]
            finite = ([value if math.isfinite(value) else None for value in row] for row in rows)
            lines = [json.dumps(dict(zip(names, row, strict=True))) for row in finite]
        else:
            titles = [titled("time", "s"), *(titled(each.symbol, each.unit) for each in channels)]
            lines = [] if written == channels else [",".join(titles)]
            lines += [",".join(map(repr, row)) for row in rows]
        written = channels
        stream.writelines(f"{line}\n" for line in lines)
        stream.flush()

    return send


@contextmanager
def _broker(to: str, config: Path | None, tell: Callable[[str], None]) -> Iterator[Send]:
    from hydrofdi.monitor.connections import needing_extra

    with needing_extra():
        from hydrofdi.monitor.mqtt import Publisher, payload_of
    publisher = Publisher(Address.parse(to), load_monitor_config(config).mqtt, _AHEAD)

    def wait_until(n_waiting: int) -> None:
        while not publisher.wait_until(n_waiting, 1.0):
            tell_events()

    def tell_events() -> None:
        while publisher.events:
            if not (event := publisher.events.popleft()).is_silent:
                tell(event.text)

    def send(chunk: Chunk) -> None:
        wait_until(_AHEAD - 1)
        publisher.send(payload_of(chunk))
        tell_events()

    try:
        yield send
        wait_until(0)
    finally:
        publisher.close()
        tell_events()
