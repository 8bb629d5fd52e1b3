"""Passwords that somebody types into an address, misspelt or not: no message and no file repeats them."""

import json

import pytest

from hydrofdi.detectors.trained.file import load_detector
from hydrofdi.errors import ConfigError, without_credentials
from hydrofdi.monitor.configuration import MonitorConfig
from hydrofdi.monitor.sources.opening import open_stream
from tests.commands import run

SECRET = "hunter2"

ADDRESSES = (
    f"mqt://press:{SECRET}@broker/samples",
    f"mqtts://press:1/{SECRET}@broker/samples",
    f"mqtt:/press:{SECRET}@broker/samples",
    f"http//press:{SECRET}@broker/samples",
    f"tcp://press:a {SECRET}@broker/samples",
    f"press:{SECRET}@broker",
    f"opc.tcp://press:1/{SECRET}@plc",
)


@pytest.mark.parametrize("address", ADDRESSES)
def test_no_message_repeats_what_stands_before_an_at_sign(machine, address):
    for arguments in (
        ("monitor", machine.detector, address, "--no-follow"),
        ("monitor", address, machine.stream),
        ("monitor", machine.detector, machine.stream, "--no-follow", "--events", address),
        ("monitor", machine.detector, machine.stream, "--no-follow", "--metrics", address),
        ("replay", machine.stream, "--to", address),
        ("replay", address),
        ("monitor", machine.detector, machine.stream, address),
    ):
        done = run(*arguments, check=2)
        assert len(done.stderr.splitlines()) == 1
        assert SECRET not in done.stdout + done.stderr


@pytest.mark.parametrize("address", ADDRESSES)
def test_what_looks_like_an_address_is_not_waited_for_as_a_file(machine, address):
    with pytest.raises(ConfigError):
        open_stream(address, MonitorConfig(), load_detector(machine.detector), machine.detector)


@pytest.mark.parametrize("name", ["runs@night.csv", "a/b@c.csv", "day.csv:3: x@y is no number", "x: y@z"])
def test_names_with_an_at_sign_stay_as_they_are(name):
    assert without_credentials(name) == name


def test_a_file_that_looks_like_an_address_is_read(machine, tmp_path):
    file = tmp_path / "press:1@night.csv"
    file.write_bytes(machine.stream.read_bytes())
    assert run("monitor", machine.detector, file, "--no-follow", check=0).stdout


def test_a_detector_does_not_keep_credentials_of_its_command_line(machine, tmp_path, monkeypatch):
    out = tmp_path / "detector.json"
    arguments = ("--output", "d2", "--direction", "both", "--false-alarm-rate", "20 %", "--window", "2 s")
    monkeypatch.chdir(machine.stream.parent)
    folder = machine.stream.parent / "http:" / f"me:{SECRET}@host"
    folder.mkdir(parents=True)
    healthy = folder / "healthy.csv"
    healthy.write_bytes(machine.stream.with_name("healthy.csv").read_bytes())
    run("train", f"http://me:{SECRET}@host/healthy.csv", *arguments, "--out", out, check=0)
    assert SECRET not in json.loads(out.read_text())["made"]["command"]
