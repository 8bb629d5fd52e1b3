"""What a text on the command line means as a stream."""

from __future__ import annotations

from pathlib import Path

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.mqtt.address import is_mqtt
from hydrofdi.monitor.sources.contract import StreamSource
from hydrofdi.settings.mistakes import nearest

_ALLOWED = "'-' (standard input), a file, mqtt://HOST/TOPIC, mqtts://HOST/TOPIC or opc.tcp://HOST:PORT"
_SCHEMES = ("mqtt", "mqtts", "opc.tcp")
