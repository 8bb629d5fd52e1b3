"""A broker of MQTT on this machine, for as long as a test runs."""

import getpass
import shutil
import socket
import subprocess
from contextlib import contextmanager

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from tests.commands import wait_until

PROGRAM = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")

SECRET = "hunter2-of-the-press"
"""A password."""


class Broker:
    """mosquitto, with what it keeps in a folder of its own."""

    def __init__(self, folder, *lines, anonymous=True):
        if PROGRAM is None:
            pytest.skip("mosquitto is not installed: apt install mosquitto")
        self.port = free_port()
        self.folder = folder
        self._config = folder / "mosquitto.conf"
        own = (
            f"listener {self.port} 127.0.0.1",
            f"user {getpass.getuser()}",
            f"allow_anonymous {str(anonymous).lower()}",
            "persistence true",
            f"persistence_location {folder}/",
            "max_queued_messages 0",
        )
        self._config.write_text("\n".join((*own, *lines)) + "\n", encoding="utf-8")

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        with (self.folder / "mosquitto.log").open("ab") as log:
            command = [PROGRAM, "-c", str(self._config), "-v"]
            self._process = subprocess.Popen(command, stdout=log, stderr=log)
        try:
            wait_until(self._answers, self._process)
        except BaseException:
            self.stop()
            raise

    def _answers(self):
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self):
        """As the system does it: what waits is written to the disk."""
        self._process.terminate()
        try:
            self._process.wait(10)
        finally:
            self._process.kill()
            self._process.wait()

    @property
    def log(self):
        return (self.folder / "mosquitto.log").read_text(encoding="utf-8", errors="replace")

    def address(self, topic="press/samples"):
        return f"mqtt://127.0.0.1:{self.port}/{topic}"


@contextmanager
def client_at(broker, client_id="", user=None):
    """A client of its own, connected; with a name, the broker keeps what it misses."""
    client = Client(CallbackAPIVersion.VERSION2, client_id, protocol=MQTTProtocolVersion.MQTTv5)
    if user is not None:
        client.username_pw_set(user, SECRET)
    client.max_inflight_messages_set(1000)
    client.max_queued_messages_set(0)
    wishes = Properties(PacketTypes.CONNECT)
    wishes.SessionExpiryInterval = 600 if client_id else 0
    client.connect("127.0.0.1", broker.port, clean_start=not client_id, properties=wishes)
    client.loop_start()
    try:
        wait_until(client.is_connected)
        yield client
    finally:
        client.disconnect()
        client.loop_stop()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
