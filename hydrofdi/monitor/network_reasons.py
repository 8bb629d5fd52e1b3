"""Why the other side of a connection cannot be reached, in plain words."""

from __future__ import annotations

import errno
import socket
import ssl

_OF_ERRORS = {
    errno.ECONNREFUSED: "nothing listens there (connection refused)",
    errno.ECONNRESET: "it closed the connection",
    errno.EHOSTUNREACH: "it cannot be reached",
    errno.ENETUNREACH: "there is no network connection",
}


def network_reason(error: OSError) -> str:
    """What an error of the network means. It never contains what the other side sent."""
    match error:
        case ssl.SSLCertVerificationError():
            return f"its certificate is refused: {error.verify_message}"
        case ssl.SSLError():
            return f"no encrypted connection ({(error.reason or 'unknown').lower().replace('_', ' ')})"
        case socket.gaierror():
            return "its name cannot be resolved"
        case TimeoutError():
            return "it does not answer"
        case _ if error.errno in _OF_ERRORS:
            return _OF_ERRORS[error.errno]
        case ConnectionError():
            return "the connection was lost"
    return error.strerror or "the connection failed"
