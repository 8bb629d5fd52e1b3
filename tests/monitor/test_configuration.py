"""The configuration of a monitor, and the schemas of what it reads."""

import json
import re
import shlex
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import typer

from hydrofdi.cli.app import application
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.monitor.configuration import MonitorConfig, load_monitor_config
from hydrofdi.monitor.payload import PayloadReader
from hydrofdi.monitor.text_lines import TextLines
from hydrofdi.records import Channel
from hydrofdi.records.description import ChannelConfig
from hydrofdi.records.source import measured_source
from tests.commands import run
from tests.monitor.streams import config_of, read_in_pieces, reader


def test_paths_start_at_the_folder_of_the_file_unless_they_are_absolute(tmp_path):
    file = tmp_path / "monitor.yaml"
    file.write_text("# nothing yet\n")
    assert load_monitor_config(None) == load_monitor_config(file) == MonitorConfig()
    file.write_text("mqtt: {username: u, password_file: secrets/mqtt, ca_file: /etc/ca.pem}\n")
    config = load_monitor_config(file)
    assert (config.mqtt.username, config.mqtt.ca_file) == ("u", Path("/etc/ca.pem"))
    assert config.mqtt.password_file == tmp_path / "secrets" / "mqtt"


@pytest.mark.parametrize("text", [
    "- a list", "mqtt: [1]", "channels: {", "mqtt: {key: a.pem}", "zone: Europe/Berln", "format: {kind: mat}",
    "format: {encoding: cp125}", "format: {encoding: utf-16}",
])  # fmt: skip
def test_what_is_no_configuration_is_refused_with_its_line(text, tmp_path):
    (tmp_path / "monitor.yaml").write_text(f"{text}\n")
    with pytest.raises(ConfigError, match=r"monitor\.yaml:[12]:"):
        load_monitor_config(tmp_path / "monitor.yaml")


def test_the_printed_schema_of_a_monitor_has_every_section():
    schema = json.loads(run("schema", "monitor", check=0).stdout)
    assert set(schema["properties"]) == set(MonitorConfig.model_fields)


def test_one_description_serves_files_and_streams(tmp_path):
    (tmp_path / "rig.csv").write_text("t,a\n0,50\n1,51\n2,52\n")
    (tmp_path / "rig.yaml").write_text(
        "files: rig.csv\nlabel: healthy\nchannels: {P1: {column: a, unit: bar}}\ntime: {column: t, unit: s}\n"
        "limits: {payload: 2048, hum: 0.4}\nmqtt: {username: u}\nzone: UTC\n"
    )
    (batch,) = measured_source(tmp_path / "rig.yaml").batches(labels=True)
    stream = TextLines(load_monitor_config(tmp_path / "rig.yaml"), "the stream", {})
    chunk = stream.read((tmp_path / "rig.csv").read_bytes())
    assert batch.labels == ("healthy",)
    assert chunk.time.tolist() == batch.time.tolist()
    assert {channel: [row.tolist()] for channel, row in chunk.channels.items()} == {
        channel: samples.tolist() for channel, samples in batch.channels.items()
    }
    (tmp_path / "rig.yaml").write_text("files: rig.csv\ntrim: {start: 1 s}\n")
    with pytest.raises(ConfigError, match=r"rig\.yaml:2: trim"):
        load_monitor_config(tmp_path / "rig.yaml")


@pytest.mark.parametrize(("zone", "date", "expected"), [
    ("UTC", "2026-07-01 12:00:00.010", (7, 1, 12, 0, 0, 10_000)),
    ("Europe/Berlin", "2026-01-31T12:00:00", (1, 31, 11)),
    ("Europe/Berlin", "2026-07-01 12:00:00.000Z", (7, 1, 12)),
    ("Europe/Berlin", "2026-10-25 02:30:00", (10, 25, 0, 30)),  # the first pass of the hour
    ("-03:00", "2026-07-01 12:00:00", (7, 1, 15)),
])  # fmt: skip
def test_dates_without_a_zone_are_in_the_stated_one(zone, date, expected):
    payload = json.dumps({"time": date, "P1 [bar]": 1}).encode()
    texts = payload + b"\n", f"Zeit,P1 [bar]\n{date},50\n".encode()
    chunks = [read_in_pieces(reader(zone=zone), text)[0] for text in texts]
    for chunk in (*chunks, PayloadReader(config_of(zone=zone)).read_all([payload])):
        instant = datetime(2026, *expected, tzinfo=UTC).timestamp()
        assert chunk.time.tolist() == pytest.approx([instant], abs=1e-6)


def test_a_stated_encoding_reads_the_names_of_columns():
    data = "time [s];Weg Stößel (mm)\n0;1\n1;2\n".encode("cp1252")
    position = {Channel.PISTON_POSITION: ChannelConfig(column="Weg Stößel (mm)", unit="mm")}
    chunk, _ = read_in_pieces(reader(channels=position, encoding="cp1252"), data)
    np.testing.assert_allclose(chunk.channels[Channel.PISTON_POSITION], [1e-3, 2e-3])
    for text in (data, "Prüfstand 4\n".encode("cp1252") + data):
        with pytest.raises(DataError, match="is not text in utf-8"):
            read_in_pieces(reader(), text)


ROOT = Path(__file__).parent.parent.parent
UNIT, CONTAINER = (ROOT / "docs" / "deploy" / name for name in ("hydrofdi-monitor.service", "Containerfile"))


def parsed(arguments):
    """What the command understands of its arguments; unknown ones raise."""
    (name, *rest) = arguments
    return typer.main.get_command(application()).commands[name].make_context(name, rest).params


def test_the_commands_of_the_systemd_unit_and_of_the_container_file_are_understood():
    command = re.search(r"^ExecStart=((?:.*\\\n)*.*)", UNIT.read_text(), re.MULTILINE)[1]
    program, *arguments = shlex.split(command.replace("\\\n", " "))
    assert program.endswith("/hydrofdi")
    params = parsed(arguments)
    assert params["source"].startswith("mqtts://")
    assert Path(params["state"]).parent == Path("${STATE_DIRECTORY}")
    comment = " ".join(line.strip("# \\") for line in CONTAINER.read_text().splitlines() if line[:1] == "#")
    words = shlex.split(comment.partition("podman run")[2].partition("docker takes")[0])
    assert parsed(words[words.index("monitor") :])["state"] == "/state/press-1.state"
