"""A connection to a broker that reconnects automatically."""

from __future__ import annotations

import random
import time
from threading import Event as Signal
from threading import Thread
from typing import TYPE_CHECKING, Any, Protocol

from hydrofdi.monitor.lines import Event
from hydrofdi.monitor.mqtt.address import MqttAddress
from hydrofdi.monitor.mqtt.announcements import Announcements
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.mqtt.reasons import reason_of_code, reason_of_error
from hydrofdi.monitor.mqtt.security import doubts
from hydrofdi.monitor.mqtt.session import Session, connect, new_client, require_paho, subscribe

if TYPE_CHECKING:
    from paho.mqtt.client import Client, MQTTMessage

LONGEST_WAIT = 120.0
"""Longest wait between attempts [s]."""

_STEADY = 60.0
"""Duration of a stable connection [s]; after it, the first new attempt comes soon."""


class MqttUser(Protocol):
    """The user of a connection. Its methods run in the network thread; nothing is received meanwhile."""

    def connected(self, client: Client, had_session: bool) -> None:
        """The broker has accepted the connection; with a session, it kept messages."""
        ...

    def received(self, client: Client, message: MQTTMessage) -> None:
        """A message has arrived."""
        ...

    def lost(self) -> None:
        """The connection is lost."""
        ...


class MqttConnection:
    """Keeps a connection to a broker, with a new client each time, and reports when it is made or lost.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    session : Session
    user : MqttUser
    first_wait : float
        Wait after the first failure [s]; it doubles up to two minutes, minus a random part.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        session: Session,
        user: MqttUser,
        first_wait: float = 1.0,
    ) -> None:
        self._address, self._config, self._session, self._user = address, config, session, user
        self._first_wait = first_wait
        self._announcements = Announcements(str(address))
        self._is_closed, self._is_over = Signal(), Signal()
        self._client: Client | None = None
        self._reason = ""
        self._n_broken = 0
        self._was_connected = self._is_forgotten = False
        self._thread = Thread(target=self._keep, name=f"mqtt {address.broker}", daemon=True)

    def open(self) -> None:
        """Begin to connect.

        Raises
        ------
        ConfigError
            A file of the configuration cannot be used. A broker that does not answer is not an error.
        """
        require_paho()
        new_client(self._address, self._config, self._session)
        for doubt in doubts(self._address, self._config):
            self._announcements.doubt(doubt)
        self._thread.start()

    def take_events(self) -> tuple[Event, ...]:
        """Events since the last call."""
        return self._announcements.take()

    def close(self, timeout: float = 3.0) -> None:
        """Disconnect and end; wait for an answer for `timeout` seconds at most."""
        self._is_closed.set()
        if client := self._client:
            client.disconnect()
        if self._thread.is_alive():
            self._thread.join(timeout)
        self._is_over.set()

    def _keep(self) -> None:
        n_failed = 0
        while not self._is_closed.is_set():
            began = time.monotonic()
            self._connect_once()
            n_failed = 0 if time.monotonic() - began > _STEADY else n_failed + 1
            longest = min(LONGEST_WAIT, self._first_wait * 2.0 ** min(n_failed, 16))
            self._is_closed.wait(longest * random.uniform(0.5, 1.0))

    def _connect_once(self) -> None:
        self._reason = ""
        self._is_over.clear()
        try:
            client = self._new_client()
            connect(client, self._address, self._config, self._session)
        except (OSError, ValueError) as error:
            self._announcements.lost(reason_of_error(error))
            return
        self._client = client
        client.loop_start()
        self._wait_until_over(client)
        client.loop_stop()
        self._client = None
        self._user.lost()
        if not self._is_closed.is_set():
            self._announcements.lost(self._reason)

    def _wait_until_over(self, client: Client) -> None:
        steady_at = time.monotonic() + _STEADY
        while not self._is_over.wait(1.0):
            if self._is_closed.is_set():
                client.disconnect()
            if time.monotonic() >= steady_at:
                self._n_broken = 0
                self._announcements.steady()

    def _new_client(self) -> Client:
        client = new_client(self._address, self._config, self._session)
        client.on_connect = self._on_connect
        client.on_subscribe = self._on_subscribe
        client.on_disconnect = self._on_disconnect
        client.on_message = lambda client, _, message: self._user.received(client, message)
        return client

    def _broken(self) -> str:
        name, self._n_broken = self._session.client_id, self._n_broken + 1
        asked = f"; perhaps another client has the client id {name!r}" if name and self._n_broken > 1 else ""
        return f"the broker closed the connection, or the network broke it{asked}"

    def _on_connect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        if code.is_failure:
            self._reason = reason_of_code(code.getName())
            return
        self._is_forgotten = self._was_connected and not flags.session_present
        self._was_connected = True
        self._user.connected(client, flags.session_present)
        if self._session.topic:
            subscribe(client, self._session.topic)
        else:
            self._announcements.connected()

    def _on_subscribe(self, client: Client, _: Any, __: int, codes: Any, properties: Any) -> None:
        if codes[0].is_failure:
            self._reason = f"it does not let this user read {self._session.topic!r}"
            client.disconnect()
            return
        remark = ""
        if self._is_forgotten:
            remark += "; the broker kept no messages in the meantime"
        if codes[0].value == 0:
            remark += "; it grants only quality of service 0, so messages can be lost"
        self._announcements.connected(remark)

    def _on_disconnect(self, client: Client, _: Any, flags: Any, code: Any, properties: Any) -> None:
        by_broker = reason_of_code(code.getName()) if flags.is_disconnect_packet_from_server else ""
        self._reason = self._reason or by_broker or self._broken()
        self._is_over.set()
