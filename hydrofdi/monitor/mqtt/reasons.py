"""Why there is no connection, in plain words."""

from __future__ import annotations

import errno
import socket
import ssl

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.mqtt.address import MqttAddress

_OF_CODES = {
    "Not authorized": "it refuses the user or the password",
    "Bad user name or password": "it refuses the user or the password",
    "Unsupported protocol version": "it does not speak MQTT 5",
    "Client identifier not valid": "it refuses the client id",
    "Session taken over": "another client connected under the same client id",
    "Server shutting down": "it shuts down",
    "Keep alive timeout": "it heard nothing for too long",
    "Packet too large": "a message is too large for it",
    "Banned": "it bans this client",
}
"""Reason code of MQTT 5 → words."""

_OF_ERRORS = {
    errno.ECONNREFUSED: "nothing listens there",
    errno.ECONNRESET: "it closed the connection",
    errno.EHOSTUNREACH: "there is no way to it",
    errno.ENETUNREACH: "there is no network",
}


def reason_of_code(code: str) -> str:
    """What a reason code of the broker means."""
    return _OF_CODES.get(code, f"it says {code.lower()!r}")


def reason_of_error(error: Exception, address: MqttAddress) -> str:
    """What an error of the network means. It never holds what the other side sent."""
    match error:
        case ConfigError():
            return str(error)
        case ssl.SSLCertVerificationError():
            return f"its certificate is refused: {error.verify_message}"
        case ssl.SSLError():
            return f"no encrypted connection ({(error.reason or 'unknown').lower().replace('_', ' ')})"
        case socket.gaierror():
            return f"the name {address.host!r} is not known"
        case TimeoutError():
            return "it does not answer"
        case OSError():
            return _OF_ERRORS.get(error.errno or 0) or error.strerror or "the connection failed"
    return "the connection failed"
