"""A session with an OPC UA server, encrypted on request."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

from asyncua import ua
from asyncua.client.client import Client
from asyncua.crypto import security_policies
from asyncua.crypto.uacrypto import CertProperties
from asyncua.ua.uaerrors import UaError

from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.monitor.opcua.files import KeyFiles
from hydrofdi.monitor.opcua.reasons import LostError, plain_reasons

logging.getLogger("asyncua").addHandler(logging.NullHandler())

LIFETIME = 60.0
"""How long the server keeps a lost session [s]; servers have few sessions."""

KEEP_ALIVE = 5.0
"""Interval at which both sides send signs of life [s]."""

_TIMEOUT = 10.0
_FAREWELL = 2.0


@dataclass(frozen=True)
class Server:
    """Address, settings and credentials of a server.

    Attributes
    ----------
    url : str
    config : OpcUaConfig
    credentials : tuple of (str, str), optional
    files : KeyFiles, optional
        Needed if the connection is encrypted.
    """

    url: str
    config: OpcUaConfig
    credentials: tuple[str, str] | None
    files: KeyFiles | None


@asynccontextmanager
async def session(server: Server) -> AsyncIterator[Client]:
    """A session, which ends with the block.

    Raises
    ------
    LostError
        The session cannot be opened.
    """
    client = Client(server.url, timeout=_TIMEOUT, watchdog_intervall=KEEP_ALIVE)
    client.name = client.description = "hydrofdi"
    client.session_timeout = int(1000 * LIFETIME)
    if server.credentials is not None:
        client.set_user(server.credentials[0])
        client.set_password(server.credentials[1])
    try:
        with plain_reasons():
            if server.files is not None:
                await _encrypt(client, server.config.security, server.files)
            await client.connect()
        yield client
    finally:
        with suppress(Exception):
            await asyncio.wait_for(client.disconnect(), _FAREWELL)
        client.disconnect_socket()


async def _encrypt(client: Client, policy_name: str, files: KeyFiles) -> None:
    policy = getattr(security_policies, f"SecurityPolicy{policy_name}")
    endpoints: list[ua.EndpointDescription] = []
    with suppress(OSError, UaError):
        endpoints = await client.connect_and_get_server_endpoints()
    if endpoints:
        _check(endpoints, policy.URI, files)
    client.application_uri = files.application_uri
    await client.set_security(
        policy,
        CertProperties(files.certificate, "der"),
        files.private_key,
        server_certificate=CertProperties(files.server_certificate, "der"),
    )


def _check(endpoints: Sequence[ua.EndpointDescription], policy: str, files: KeyFiles) -> None:
    """Check policy and certificate: a server does not answer what is encrypted for another certificate."""
    mode = ua.MessageSecurityMode.SignAndEncrypt
    offered = [each for each in endpoints if (each.SecurityPolicyUri, each.SecurityMode) == (policy, mode)]
    if not offered:
        raise LostError("it does not offer this security policy with signing and encrypting")
    if not any((each.ServerCertificate or b"").startswith(files.server_certificate) for each in offered):
        raise LostError("its certificate is not 'server_certificate'")
