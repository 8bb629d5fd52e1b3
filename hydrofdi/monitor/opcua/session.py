"""A session with an OPC UA server, encrypted on request, and the changes of nodes that it sends."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

from asyncua import ua
from asyncua.client.client import Client
from asyncua.crypto import security_policies
from asyncua.crypto.uacrypto import CertProperties
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.uaerrors import UaError, UaStatusCodeError
from cryptography import x509
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_der_private_key,
    load_pem_private_key,
)

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import OpcUaConfig
from hydrofdi.monitor.security import credentials, network_reason, usable

logging.getLogger("asyncua").addHandler(logging.NullHandler())

FIRST_HANDLE = 1
"""Client handle of the first node; for some servers 0 means none."""

_LIFETIME, _KEEP_ALIVE = 60.0, 5.0
"""How long the server keeps a lost session, as it has few; interval of signs of life on both sides [s]."""

_HELD = 10.0
"""What the server should queue in addition to a publishing interval while the network is slow [s]."""

_TIMEOUT, _FAREWELL, _SILENCE = 10.0, 2.0, 4 * _KEEP_ALIVE

Changes = list[ua.MonitoredItemNotification]
OnConnected = Callable[[float, float], None]


class LostError(Exception):
    """A server cannot be reached, refuses, or is lost; the text is the reason."""


class _KeyFiles(NamedTuple):
    """Certificates and key in DER, and the application URI in the monitor's certificate."""

    certificate: bytes
    private_key: bytes
    server_certificate: bytes
    application_uri: str


class Server:
    """Address, settings and credentials of a server.

    Parameters
    ----------
    url : str
    config : OpcUaConfig

    Raises
    ------
    ConfigError
        A file cannot be used, or credentials are missing or not encrypted.
    """

    def __init__(self, url: str, config: OpcUaConfig) -> None:
        self.url, self.config = url, config
        self.user, self.password = credentials("opcua", config.username, config.password_file)
        if self.user and not self.password:
            raise ConfigError("opcua.password_file: is missing; there is a user without a password")
        if self.password and config.security == "none":
            raise ConfigError("opcua.security: none would send the password unencrypted; choose a policy")
        self._files = _key_files(config)

    async def changes(
        self, nodes: Sequence[str], period: float, on_connected: OnConnected
    ) -> AsyncGenerator[Changes]:
        """Changes of nodes, with every time stamp, as they are published. They name nodes by client handle.

        Parameters
        ----------
        nodes : sequence of str
            Node ids.
        period : float
            Sampling period [s].
        on_connected : callable
            Takes the longest sampling interval of a node and the publishing interval of the server [s].

        Raises
        ------
        LostError
            The server cannot be reached, has no such node, refuses, is silent or lost.
        """
        results: asyncio.Queue[ua.PublishResult | Exception] = asyncio.Queue(maxsize=64)
        try:
            async with self._session() as client:
                client.connection_lost_callback = results.put
                on_connected(*await self._subscribe(client, nodes, period, results))
                while True:
                    result = await asyncio.wait_for(results.get(), _SILENCE)
                    if isinstance(result, Exception):
                        raise result
                    yield _changes_of(result)
        except Exception as error:  # whatever the library raises is a reason to try again
            raise LostError(_reason(error)) from error

    @asynccontextmanager
    async def _session(self) -> AsyncIterator[Client]:
        client = Client(self.url, timeout=_TIMEOUT, watchdog_intervall=_KEEP_ALIVE)
        client.name = client.description = "hydrofdi"
        client.session_timeout = int(1000 * _LIFETIME)
        if self.user:
            client.set_user(self.user)
            client.set_password(self.password)
        try:
            if self._files is not None:
                await self._encrypt(client, self._files)
            await client.connect()
            yield client
        finally:
            with suppress(Exception):
                await asyncio.wait_for(client.disconnect(), _FAREWELL)
            client.disconnect_socket()

    async def _encrypt(self, client: Client, files: _KeyFiles) -> None:
        """Check policy and certificate: a server does not answer what is encrypted for another one."""
        policy = getattr(security_policies, f"SecurityPolicy{self.config.security}")
        wanted = policy.URI, ua.MessageSecurityMode.SignAndEncrypt
        endpoints = await client.connect_and_get_server_endpoints()
        offered = [each for each in endpoints if (each.SecurityPolicyUri, each.SecurityMode) == wanted]
        if not offered:
            raise LostError("it does not offer this security policy with signing and encrypting")
        if not any((each.ServerCertificate or b"").startswith(files.server_certificate) for each in offered):
            raise LostError("its certificate is not 'server_certificate'")
        client.application_uri = files.application_uri
        own, key, server = (CertProperties(content, "der") for content in files[:3])
        await client.set_security(policy, own, key, server_certificate=server)

    async def _subscribe(
        self,
        client: Client,
        nodes: Sequence[str],
        period: float,
        results: asyncio.Queue[ua.PublishResult | Exception],
    ) -> tuple[float, float]:
        interval = self.config.publishing_interval
        request = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=1000 * interval,
            RequestedLifetimeCount=ceil(_LIFETIME / interval),
            RequestedMaxKeepAliveCount=max(1, ceil(_KEEP_ALIVE / interval)),
        )
        created = await client.uaclient.create_subscription(request, results.put)
        published = created.RevisedPublishingInterval / 1000
        items = [
            _item(node, FIRST_HANDLE + position, period, published) for position, node in enumerate(nodes)
        ]
        wanted = ua.CreateMonitoredItemsParameters(created.SubscriptionId, ua.TimestampsToReturn.Both, items)
        sampled = 0.0
        for node, result in zip(nodes, await client.uaclient.create_monitored_items(wanted), strict=True):
            if not result.StatusCode.is_good():
                raise LostError(f"it does not report {node}: {result.StatusCode.name}")
            sampled = max(sampled, result.RevisedSamplingInterval / 1000)
        return sampled, published


def node_id(text: str) -> ua.NodeId:
    """The node id that a text states.

    Raises
    ------
    ConfigError
        The text is not a node id.
    """
    try:
        return ua.NodeId.from_string(text)
    except (UaError, ValueError):
        raise ConfigError(
            f"{text!r} is not a node id; write, for example, 'ns=2;s=P1' or 'ns=2;i=1001'"
        ) from None


def _item(node: str, handle: int, period: float, published: float) -> ua.MonitoredItemCreateRequest:
    parameters = ua.MonitoringParameters(
        ClientHandle=handle,
        SamplingInterval=1000 * period,
        Filter=ua.DataChangeFilter(Trigger=ua.DataChangeTrigger.StatusValueTimestamp),
        QueueSize=ceil((published + _HELD) / period),
        DiscardOldest=True,
    )
    read = ua.ReadValueId(node_id(node), AttributeIds.Value)
    return ua.MonitoredItemCreateRequest(read, ua.MonitoringMode.Reporting, parameters)


def _changes_of(result: ua.PublishResult) -> Changes:
    changes: Changes = []
    for data in result.NotificationMessage.NotificationData or ():
        if isinstance(data, ua.DataChangeNotification):
            changes += data.MonitoredItems
        elif isinstance(data, ua.StatusChangeNotification):
            data.Status.check()
    return changes


def _reason(error: Exception) -> str:
    if isinstance(error, LostError):
        return str(error)
    if isinstance(error, UaStatusCodeError):
        status = ua.StatusCode(error.code)
        return f"{status.doc.rstrip('.')} ({status.name})"
    if isinstance(error, OSError):
        return network_reason(error)
    return f"{' '.join(str(error).split())} ({type(error).__name__})"


def _key_files(config: OpcUaConfig) -> _KeyFiles | None:
    """The files of a configuration; None if nothing is encrypted."""
    if config.security == "none":
        return None
    own, server = (_read(f"{each}certificate", config, _CERTIFICATE) for each in ("", "server_"))
    key = _read("key", config, _KEY, password=None)
    if key.public_key() != own.public_key():
        raise ConfigError(f"opcua.key: {config.key}: does not belong to the certificate")
    try:
        names = own.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        uri = str(names.get_values_for_type(x509.UniformResourceIdentifier)[0])
    except (x509.ExtensionNotFound, IndexError):
        message = "has no application URI; servers require it"
        raise ConfigError(f"opcua.certificate: {config.certificate}: {message}") from None
    content = key.private_bytes(Encoding.DER, PrivateFormat.PKCS8, NoEncryption())
    return _KeyFiles(own.public_bytes(Encoding.DER), content, server.public_bytes(Encoding.DER), uri)


_CERTIFICATE = x509.load_pem_x509_certificate, x509.load_der_x509_certificate
_KEY = load_pem_private_key, load_der_private_key


def _read(key: str, config: OpcUaConfig, loaders: tuple[Any, Any], **more: None) -> Any:
    """What the file of a setting contains, in PEM or DER."""
    path: Path = getattr(config, key)
    with usable(f"opcua.{key}", path):
        content = path.read_bytes()
        return loaders[b"-----BEGIN" not in content](content, **more)
