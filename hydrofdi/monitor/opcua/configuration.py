"""Connection to an OPC UA server: address, security, credentials."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import model_validator

from hydrofdi.errors import ConfigError
from hydrofdi.monitor import security
from hydrofdi.settings.quantities import SI, Section

SCHEME = "opc.tcp"
_PORT = 4840


class OpcUaConfig(Section):
    """An OPC UA server: its security and its sampling."""

    publishing_interval: Annotated[float, SI("s", least=0.01, most=60.0)] = 0.5
    """Interval at which the server sends its samples [s]."""

    wait: Annotated[float, SI("s", above=0.0, most=600.0)] = 2.0
    """How long a sample waits for a node that has sent neither a value for its instant nor a later one [s];
    afterwards the channel counts as missing."""

    queue: Annotated[float, SI("s", above=0.0, most=3600.0)] = 60.0
    """Length of the queue of samples waiting for the monitor [s]; beyond it, whole windows are dropped."""

    security: Literal["none", "Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"] = "none"
    """Policy for signing and encryption. ``none``: anyone on the network can read and change samples."""

    certificate: Path | None = None
    """Certificate of this monitor, PEM or DER; the server must trust it."""

    key: Path | None = None
    """Private key of the certificate, PEM or DER, without a passphrase."""

    server_certificate: Path | None = None
    """Certificate of the server, PEM or DER; a server with another certificate is refused."""

    username: str = ""
    """User name; by default from the environment variable HYDROFDI_OPCUA_USERNAME. Anonymous if neither is
    set."""

    password_file: Path | None = None
    """File that contains only the password, readable only by its owner; by default the environment variable
    HYDROFDI_OPCUA_PASSWORD."""

    @model_validator(mode="after")
    def _whole_security(self) -> Self:
        files = {name: getattr(self, name) for name in ("certificate", "key", "server_certificate")}
        given = [name for name, path in files.items() if path is not None]
        missing = [name for name, path in files.items() if path is None]
        if self.security != "none" and missing:
            raise ValueError(f"security {self.security} also needs {', '.join(missing)}")
        if self.security == "none" and given:
            raise ValueError(f"{given[0]} needs a policy; write 'security: Basic256Sha256'")
        return self


def server_url(source: str) -> str:
    """The full address of a server.

    Parameters
    ----------
    source : str
        Such as ``opc.tcp://plc.example:4840/path``; the default port is 4840.

    Raises
    ------
    ConfigError
        It is not such an address, or contains credentials.
    """
    try:
        parts = urlsplit(source)
        host, port = parts.hostname, parts.port or _PORT
    except ValueError:
        host, port = None, 0
    if not host or parts.scheme != SCHEME or parts.query or parts.fragment:
        raise ConfigError(f"write the address of an OPC UA server as {SCHEME}://host:port/path")
    if "@" in source:
        raise ConfigError("write no user or password in an address: others can read it; see 'opcua.username'")
    host = f"[{host}]" if ":" in host else host
    return f"{SCHEME}://{host}:{port}{parts.path}"


def credentials(config: OpcUaConfig) -> tuple[str, str]:
    """User name and password; both empty for an anonymous user.

    Raises
    ------
    ConfigError
        User name or password is missing, the file cannot be read, or the password would not be encrypted.
    """
    username, password = security.credentials("opcua", config.username, config.password_file)
    if username and not password:
        raise ConfigError("opcua.password_file: is missing; there is a user without a password")
    if password and config.security == "none":
        raise ConfigError("opcua.security: none would send the password unencrypted; choose a policy")
    return username, password


def doubts(url: str, config: OpcUaConfig) -> Iterator[str]:
    """A sentence for each setting that is less safe than it could be."""
    if config.security == "none":
        yield f"the connection to {url} is not encrypted, and the server is not checked; see 'opcua.security'"
    yield from security.exposed(config.password_file, config.key)
