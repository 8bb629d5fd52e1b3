"""Why there is no connection, in plain words."""

from __future__ import annotations

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.network_reasons import network_reason

_OF_CODES = {
    "Not authorized": "it refuses the user or the password",
    "Bad user name or password": "it refuses the user or the password",
    "Unsupported protocol version": "it does not speak MQTT 5",
    "Client identifier not valid": "it refuses the client id",
    "Session taken over": "another client connected under the same client id",
    "Server shutting down": "it is shutting down",
    "Keep alive timeout": "it received nothing for too long",
    "Packet too large": "a message is too large for it",
    "Banned": "it bans this client",
}
"""Reason code of MQTT 5 → words."""


def reason_of_code(code: str) -> str:
    """What a reason code of the broker means."""
    return _OF_CODES.get(code, f"it says {code.lower()!r}")


def reason_of_error(error: Exception) -> str:
    """What an error of a connection means. It never contains what the other side sent."""
    match error:
        case ConfigError():
            return str(error)
        case OSError():
            return network_reason(error)
    return "the connection failed"
