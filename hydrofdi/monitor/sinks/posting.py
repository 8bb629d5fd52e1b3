"""One JSON document posted to one address."""

from __future__ import annotations

import http.client
import ssl
import urllib.error
import urllib.request
from typing import Any

import hydrofdi
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.network_reasons import network_reason
from hydrofdi.monitor.sinks.webhook_config import WebhookConfig, bearer_token, checked_url

_AGAIN = (408, 425, 429)


class NotTakenError(Exception):
    """A server refuses a post permanently; the text says why."""


class NotReachedError(Exception):
    """A server may accept the post later; the text says why."""


class Poster:
    """Posts documents; redirects are not followed, because the secret is for one server only.

    Parameters
    ----------
    config : WebhookConfig

    Raises
    ------
    ConfigError
        Address, secret or certificates cannot be used.
    """

    def __init__(self, config: WebhookConfig) -> None:
        self._url, self._timeout = checked_url(config), config.timeout
        self._headers = {"Content-Type": "application/json", "User-Agent": f"hydrofdi/{hydrofdi.__version__}"}
        if token := bearer_token(config):
            self._headers["Authorization"] = f"Bearer {token}"
        handler = urllib.request.HTTPSHandler(context=_tls_context(config))
        self._opener = urllib.request.build_opener(handler, _NoRedirect())

    def post(self, document: bytes, number: str) -> None:
        """Post once.

        Parameters
        ----------
        document : bytes
            JSON.
        number : str
            The same for each attempt, so that a receiver can recognise a repetition.

        Raises
        ------
        NotTakenError, NotReachedError
        """
        headers = {**self._headers, "Idempotency-Key": number}
        request = urllib.request.Request(self._url, document, headers, method="POST")
        try:
            with self._opener.open(request, timeout=self._timeout):
                return
        except urllib.error.HTTPError as error:
            error.close()
            raise _refusal(error.code) from None
        except urllib.error.URLError as error:
            reason = error.reason
            text = network_reason(reason) if isinstance(reason, OSError) else "the connection failed"
            raise NotReachedError(text) from None
        except OSError as error:
            raise NotReachedError(network_reason(error)) from None
        except http.client.HTTPException:
            raise NotReachedError("its response is not HTTP") from None


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any) -> None:
        return None


def _refusal(status: int) -> Exception:
    text = f"it answers {status} {http.client.responses.get(status, '')}".rstrip()
    if status >= 500 or status in _AGAIN:
        return NotReachedError(text)
    return NotTakenError(f"{text}, and redirects are not followed" if status < 400 else text)


def _tls_context(config: WebhookConfig) -> ssl.SSLContext:
    try:
        return ssl.create_default_context(cafile=config.ca_file)
    except ssl.SSLError:
        raise ConfigError(f"webhook.ca_file: {config.ca_file}: is not a certificate in PEM") from None
    except OSError as error:
        raise ConfigError(f"webhook.ca_file: {config.ca_file}: {error.strerror}") from None
