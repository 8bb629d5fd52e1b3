"""Why an OPC UA server is not read, in plain words."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from asyncua import ua
from asyncua.ua.uaerrors import UaStatusCodeError

from hydrofdi.monitor.network_reasons import network_reason

_REASONS = {
    "BadUserAccessDenied": "it refuses the user name or password",
    "BadIdentityTokenRejected": "it refuses the user name or password",
    "BadIdentityTokenInvalid": "it refuses the user name or password, or requires one",
    "BadSecurityChecksFailed": "it does not trust the certificate of this monitor, or the policy",
    "BadCertificateUntrusted": "it does not trust the certificate of this monitor",
    "BadCertificateUriInvalid": "the application URI in the certificate of this monitor does not match",
    "BadCertificateTimeInvalid": "it says that the certificate of this monitor has expired",
    "BadTooManySessions": "it has too many sessions",
    "BadTooManySubscriptions": "it has too many subscriptions",
    "BadShutdown": "it is shutting down",
    "BadTimeout": "it has ended the subscription",
    "BadMonitoredItemFilterUnsupported": "it cannot report each new time stamp of a value",
}


class LostError(Exception):
    """A server cannot be reached, refuses, or is lost; the text is the reason in plain words."""


@contextmanager
def plain_reasons() -> Iterator[None]:
    """Turn every exception of the library into `LostError`: a reason to try again.

    Raises
    ------
    LostError
    """
    try:
        yield
    except LostError:
        raise
    except Exception as error:
        raise LostError(reason_of(error)) from error


def reason_of(error: BaseException) -> str:
    """The reason behind an error of a connection, for a sentence that begins with the server."""
    if isinstance(error, UaStatusCodeError):
        status = ua.StatusCode(error.code)
        return _REASONS.get(status.name, f"{status.doc.rstrip('.')} ({status.name})")
    if isinstance(error, OSError):
        return network_reason(error)
    text = " ".join(str(error).split())
    if "No matching endpoints" in text:
        return "it does not offer this security policy with signing and encrypting"
    if "certificate mismatch" in text:
        return "its certificate is not 'server_certificate'"
    return f"{text or type(error).__name__} ({type(error).__name__})"
