"""A broker for a test, and things that are closed behind it."""

import shutil
import subprocess
from contextlib import ExitStack

import pytest

from hydrofdi.monitor import sources
from tests.monitor.brokers import SECRET, Broker, running
from tests.monitor.machines import make_machine


@pytest.fixture(scope="session")
def machine(tmp_path_factory):
    return make_machine(tmp_path_factory.mktemp("machine"))


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """The second attempt to connect comes soon."""
    monkeypatch.setattr(sources, "FIRST_WAIT", 0.05)


@pytest.fixture
def broker(tmp_path):
    yield from running(Broker(tmp_path))


@pytest.fixture
def guarded(tmp_path):
    """A broker that asks for a password: user ``press`` may read nothing but ``press/#``."""
    file, rules = tmp_path / "passwords", tmp_path / "rules"
    program = shutil.which("mosquitto_passwd")
    if program is None:
        pytest.skip("mosquitto is not installed: apt install mosquitto")
    subprocess.run([program, "-b", "-c", file, "press", SECRET], check=True, capture_output=True)
    rules.write_text("user press\ntopic readwrite press/#\n")
    for each in (file, rules):
        each.chmod(0o644)
    yield from running(Broker(tmp_path, f"password_file {file}", f"acl_file {rules}", anonymous=False))


@pytest.fixture
def closing():
    """Calls ``close`` of what a test opened: ``source = closing(source_at(…))``."""
    with ExitStack() as stack:

        def keep(thing):
            stack.callback(thing.close)
            return thing

        yield keep
