"""A broker of MQTT on this machine, for as long as a test runs."""

import getpass
import shutil
import socket
import subprocess
import time

import pytest

PROGRAM = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")

SECRET = "hunter2-of-the-press"
"""A password."""

needs_mosquitto = pytest.mark.skipif(
    PROGRAM is None, reason="mosquitto is not installed: apt install mosquitto"
)


class Broker:
    """mosquitto, with what it keeps in a folder of its own."""

    def __init__(self, folder, *lines, anonymous=True):
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
        self._process = None

    def start(self):
        with (self.folder / "mosquitto.log").open("ab") as log:
            self._process = subprocess.Popen(
                [str(PROGRAM), "-c", str(self._config), "-v"], stdout=log, stderr=log
            )
        end = time.monotonic() + 30
        while not answers(self.port):
            assert self._process.poll() is None, self.log
            assert time.monotonic() < end, "mosquitto does not listen"
            time.sleep(0.02)

    def stop(self):
        """As the system does it: what waits is written to the disk."""
        if self._process is not None:
            self._process.terminate()
            try:
                self._process.wait(10)
            finally:
                self._process.kill()
                self._process.wait()
            self._process = None

    @property
    def log(self):
        return (self.folder / "mosquitto.log").read_text(encoding="utf-8", errors="replace")

    def address(self, topic="press/samples"):
        return f"mqtt://127.0.0.1:{self.port}/{topic}"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def answers(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def running(broker):
    """The broker while it runs; it is ended whatever happens."""
    try:
        broker.start()
        yield broker
    finally:
        broker.stop()
