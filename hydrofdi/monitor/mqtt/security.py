"""Passwords and certificates. They are read anew at each connection, so that they can be renewed."""

from __future__ import annotations

import os
import ssl
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.mqtt.address import MqttAddress
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.secret_files import exposed, secret_in

_THIS_MACHINE = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class Credentials:
    """A user and a password; their representation shows neither."""

    username: str | None = field(repr=False)
    password: str | None = field(repr=False)


def credentials_of(config: MqttConfig, environment: Mapping[str, str] = os.environ) -> Credentials:
    """User and password from the configuration, or else from the environment.

    Raises
    ------
    ConfigError
        The file of the password cannot be read, or is empty.
    """
    username = config.username or environment.get("HYDROFDI_MQTT_USERNAME") or None
    if config.password_file is None:
        password = environment.get("HYDROFDI_MQTT_PASSWORD") or None
    else:
        password = secret_in(config.password_file, "mqtt.password_file")
    if password and not username:
        raise ConfigError("mqtt.username: is missing; there is a password without a user")
    return Credentials(username, password)


def tls_context(config: MqttConfig) -> ssl.SSLContext:
    """The TLS settings of encrypted connections.

    Raises
    ------
    ConfigError
        A certificate or key cannot be used.
    """
    if config.ca_file is None:
        context = ssl.create_default_context()
    else:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        with _usable("ca_file", config.ca_file):
            context.load_verify_locations(config.ca_file)
    if config.certificate is not None:
        with _usable("certificate", config.certificate):
            context.load_cert_chain(config.certificate, config.key, password="")
    if not config.verify:
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    return context


def doubts(address: MqttAddress, config: MqttConfig) -> Iterator[str]:
    """A sentence for each setting that is less safe than it could be."""
    if address.is_secure and not config.verify:
        yield f"mqtt.verify is false: the certificate of {address.broker} is not checked"
    yield from exposed(config.password_file, config.key)
    if not address.is_secure and address.host not in _THIS_MACHINE and credentials_of(config).password:
        yield f"the password goes to {address.broker} without encryption; use mqtts://"


@contextmanager
def _usable(key: str, file: Path) -> Iterator[None]:
    """Raise errors of a file under its key, never with the content of the file."""
    try:
        yield
    except ssl.SSLError as error:
        raise ConfigError(f"mqtt.{key}: {file}: cannot be used ({error.reason or 'not PEM'})") from None
    except OSError as error:
        raise ConfigError(f"mqtt.{key}: {file}: {error.strerror}") from None
