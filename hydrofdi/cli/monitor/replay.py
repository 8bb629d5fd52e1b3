"""``hydrofdi replay``."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hydrofdi.cli.options import SamplingFrequency, Settings
from hydrofdi.errors import ConfigError

if TYPE_CHECKING:
    from hydrofdi.records.streams import Chunk

Send = Callable[["Chunk"], None]


class Form(StrEnum):
    """Forms of samples."""

    csv = "csv"
    json = "json"


def replay(
    source: Annotated[
        Path,
        typer.Argument(
            help="An experiment file (.yaml to be simulated, or .h5), a results folder, a description of"
            " measured files, or one data file."
        ),
    ],
    rate: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY|max",
            help="Samples sent in a second, e.g. 500Hz, or 'max': as fast as they are taken"
            " [default: as measured].",
        ),
    ] = None,
    to: Annotated[
        str, typer.Option(metavar="-|mqtt://HOST/TOPIC", help="Standard output, or a topic of a broker.")
    ] = "-",
    form: Annotated[
        Form | None, typer.Option("--format", help="Form on standard output [default: csv].")
    ] = None,
    record: Annotated[
        str, typer.Option(metavar="N|NAME", help="One record, by its number from 1 or its name.")
    ] = "",
    now: Annotated[
        bool, typer.Option("--now", help="Time starts at the present one, in seconds since 1970.")
    ] = False,
    config: Annotated[
        Path | None,
        typer.Option(metavar="FILE.yaml", help="How the broker is reached: the file of 'hydrofdi monitor'."),
    ] = None,
    settings: Settings = None,
    sampling_frequency: SamplingFrequency = None,
) -> int:
    """Play records as a stream, for trying a monitor out.

    Samples are in SI, written so that they are read again to the bit. Several records follow each other with
    a short gap.
    """
    from hydrofdi.api.replaying import replay as played
    from hydrofdi.cli.terminal import tell

    chunks = played(
        source,
        rate=rate,
        record=record,
        now=now,
        settings=settings or (),
        sampling_frequency=sampling_frequency,
    )
    n_sample = 0
    try:
        with _target(to, form, config) as send:
            for chunk in chunks:
                send(chunk)
                n_sample += chunk.n_time
    except KeyboardInterrupt:
        tell(f"stopped after {n_sample:,} samples")
        return 0
    except BrokenPipeError:
        return 0
    tell(f"played {n_sample:,} samples")
    return 0


@contextmanager
def _target(to: str, form: Form | None, config: Path | None) -> Iterator[Send]:
    """What takes blocks of samples; at the end it has taken all."""
    from hydrofdi.monitor.mqtt.address import is_mqtt

    if to == "-":
        if config is not None:
            raise ConfigError("--config: is for a broker; give its topic with --to")
        yield _standard_output(form or Form.csv)
    elif not is_mqtt(to):
        raise ConfigError(f"--to {to}: expected '-' for standard output, or mqtt://host:port/topic")
    elif form is not None:
        raise ConfigError("--format: is for standard output; messages are JSON")
    else:
        with _broker(to, config) as send:
            yield send


def _standard_output(form: Form) -> Send:
    from hydrofdi.cli.terminal import write_out
    from hydrofdi.pipeline.sample_text import CsvText, JsonText

    text = CsvText() if form is Form.csv else JsonText()

    def send(chunk: Chunk) -> None:
        write_out(text(chunk))
        sys.stdout.flush()

    return send


@contextmanager
def _broker(to: str, config: Path | None) -> Iterator[Send]:
    from hydrofdi.cli.terminal import tell
    from hydrofdi.monitor.configuration import load_monitor_config
    from hydrofdi.monitor.mqtt.address import MqttAddress
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
