"""Events, and windows on request, as messages."""

from __future__ import annotations

from collections.abc import Sequence

from hydrofdi.monitor.line_record import line_text
from hydrofdi.monitor.lines import Event, EventKind, Line, WindowLine
from hydrofdi.monitor.mqtt import MqttAddress, MqttConfig, MqttConnection, Outbox
from hydrofdi.monitor.mqtt.session import Session
from hydrofdi.records.streams import Chunk

CAPACITY = 10_000
"""Most messages that wait for the broker; further ones are lost."""


class MqttSink:
    """Sends lines as JSON to a topic; its ``…/status`` is ``online`` or ``offline``, and retained.

    Parameters
    ----------
    address : MqttAddress
    config : MqttConfig
    unit : str
                Unit of scores.
    with_windows : bool
        Whether windows are sent as well as events.
    capacity : int
                Most messages that wait for the broker.
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.
    """

    def __init__(
        self,
        address: MqttAddress,
        config: MqttConfig,
        unit: str = "1",
        *,
        with_windows: bool = False,
        capacity: int = CAPACITY,
        first_wait: float = 1.0,
    ) -> None:
        self._topic, self._unit, self._with_windows = address.topic, unit, with_windows
        self._status = f"{address.topic}/status"
        self._place = str(address)
        self._outbox = Outbox(capacity, greeting=(self._status, b"online"))
        session = Session(will=(self._status, b"offline"))
        self._connection = MqttConnection(address, config, session, self._outbox, first_wait)
        self._is_full = self._is_refused = self._is_closed = False
        self._connection.open()

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Queue the lines to send; never waits."""
        wanted = [line for line in lines if self._is_wanted(line)]
        n_lost = sum(not self._outbox.put(self._topic, self._payload(line)) for line in wanted)
        return [*self._connection.take_events(), *self._losses(n_lost), *self._refusals()]

    def close(self) -> None:
        """Send what is left, within three seconds."""
        if self._is_closed:
            return
        self._is_closed = True
        self._outbox.put(self._status, b"offline", is_retained=True)
        self._outbox.wait_until(0, 3.0)
        self._connection.close()

    def _is_wanted(self, line: Line) -> bool:
        return self._with_windows if isinstance(line, WindowLine) else not line.is_silent

    def _payload(self, line: Line) -> bytes:
        return line_text(line, self._unit).rstrip().encode()

    def _losses(self, n_lost: int) -> list[Line]:
        if not n_lost:
            self._is_full = False
            return []
        was_full, self._is_full = self._is_full, True
        text = f"lines for {self._place} are lost: the broker is too slow, or was unreachable for too long"
        return [Event(EventKind.DROPPED, text, None, n_lost, is_silent=was_full)]

    def _refusals(self) -> list[Line]:
        refusals = self._outbox.take_refusals()
        if not refusals:
            return []
        was_refused, self._is_refused = self._is_refused, True
        text = f"{self._place}: the broker refuses messages: {refusals[-1]}"
        return [Event(EventKind.DROPPED, text, None, len(refusals), is_silent=was_refused)]
