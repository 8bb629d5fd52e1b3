"""Samples as text, and to a broker."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from hydrofdi.api.detectors.sample_text import CsvText, JsonText
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import load_monitor_config
from hydrofdi.monitor.mqtt.address import MqttAddress, is_mqtt
from hydrofdi.records.streams import Chunk

Send = Callable[[Chunk], None]


@contextmanager
def sample_target(
    to: str, form: str | None, config: Path | None, stream: TextIO, tell: Callable[[str], None]
) -> Iterator[Send]:
    """Receiver of blocks of samples; it has received all when it is closed.

    Parameters
    ----------
    to : str
        ``-`` for the stream of text, or ``mqtt://host:port/topic``.
    form : {"csv", "json"}, optional
        Of text.
    config : Path, optional
        How a broker is reached.
    stream : file object
    tell : callable
        Called with messages on the connection.

    Raises
    ------
    ConfigError
        The target is neither, or a setting does not fit.
    """
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
    text = JsonText() if form == "json" else CsvText()

    def send(chunk: Chunk) -> None:
        stream.write(text(chunk))
        stream.flush()

    return send


@contextmanager
def _broker(to: str, config: Path | None, tell: Callable[[str], None]) -> Iterator[Send]:
    from hydrofdi.monitor.mqtt.publisher import SamplePublisher

    publisher = SamplePublisher(MqttAddress.parse(to), load_monitor_config(config).mqtt)

    def tell_events() -> None:
        for event in publisher.take_events():
            tell(event.text)

    def send(chunk: Chunk) -> None:
        while not publisher.send(chunk):
            tell_events()
        tell_events()

    try:
        yield send
        while not publisher.flush(1.0):
            tell_events()
    finally:
        publisher.close()
        tell_events()
