"""The stream that a text on the command line means."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError, without_credentials
from hydrofdi.monitor.configuration import MonitorConfig, MqttAddress
from hydrofdi.monitor.sources.contract import StreamSource
from hydrofdi.records.batch import Channel
from hydrofdi.settings.messages import similar

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*):/")
_KINDS = "'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT"


_SCHEMES = ("mqtt", "mqtts", "opc.tcp")
_RECORDS = (".h5", ".hdf5", ".mat", ".npz", ".parquet", ".yaml", ".yml")
"""Suffixes of files that contain records, but no lines of text."""


def open_stream(
    text: str,
    config: MonitorConfig,
    file: DetectorFile,
    detector: Path,
    *,
    sampling_frequency: float | None = None,
    is_followed: bool = True,
    is_resumed: bool = False,
) -> StreamSource:
    """The stream that a text means; nothing is read or connected yet.

    Parameters
    ----------
    text : str
        ``-``, a file, ``mqtt://…``, ``mqtts://…`` or ``opc.tcp://…``.
    config : MonitorConfig
    file : DetectorFile
                The detector that judges it.
    detector : Path
        File of the detector.
    sampling_frequency : float, optional
        Sampling frequency of text without a time column [Hz].
    is_followed : bool
        Whether a file is expected to grow.
    is_resumed : bool
        Whether a later run continues: it reads a last line without a line end, when it is whole.

    Raises
    ------
    ConfigError
        It is none of these, an option does not fit, or an extra is not installed.
    """
    seen = {*file.channels, file.config.window.channel}
    if channels := {channel: each for channel, each in config.channels.items() if channel in seen}:
        config = config.model_copy(update={"channels": channels})
    scheme = _SCHEME.match(text)
    if scheme is None:
        if sampling_frequency is not None:
            config = config.model_copy(update={"sampling_frequency": sampling_frequency})
        return _lines_of(text, config, file.channels, is_followed, is_resumed)
    kind = scheme[1].lower()
    if kind not in _SCHEMES:
        raise ConfigError(f"{text}: unknown kind of source {kind!r}{_hint(kind, text)}")
    if sampling_frequency is not None:
        raise ConfigError(
            "sampling_frequency: applies only to text; other sources need a time for each sample"
        )
    if kind != "opc.tcp":
        from hydrofdi.monitor.mqtt.source import MqttSource

        return MqttSource(MqttAddress.parse(text), config, detector, file.channels)
    try:
        from hydrofdi.monitor.opcua.source import OpcUaSource
    except ModuleNotFoundError as error:
        if error.name not in ("asyncua", "cryptography"):
            raise
        raise ConfigError("OPC UA needs the extra: pip install 'hydrofdi[monitor]'") from None
    return OpcUaSource(text, config.opcua, config.channels, file.sampling_frequency)


def _hint(kind: str, text: str) -> str:
    if kind == "file":
        return f"; did you mean {text[len('file:') :].replace('//', '', 1)!r}?"
    return similar(kind, [*_SCHEMES]) or f"; a source is {_KINDS}"


def _lines_of(
    text: str, config: MonitorConfig, needed: Sequence[Channel], is_followed: bool, is_resumed: bool
) -> StreamSource:
    from hydrofdi.monitor.sources.growing_file import GrowingFile, StandardInput

    path = Path(text)
    if text != "-" and (path.is_dir() or path.suffix.lower() in _RECORDS):
        raise ConfigError(
            f"{text}: is not a text stream; 'hydrofdi detect' judges it, 'hydrofdi replay' streams it"
        )
    if without_credentials(text) != text and not path.exists():
        raise ConfigError(f"{text}: no such file; a source is {_KINDS}")
    if text == "-":
        return StandardInput(config, needed=needed)
    return GrowingFile(path, config, is_followed, needed, leaves_unended=is_resumed)
