"""The configuration of a monitor, and the schemas of what it reads."""

import json
from pathlib import Path

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig, load_monitor_config
from hydrofdi.monitor.sources.text_lines import TextLines
from hydrofdi.records.measured.source import measured_source
from tests.commands import run


def test_an_empty_file_and_none_are_the_default(tmp_path):
    (tmp_path / "monitor.yaml").write_text("# nothing yet\n")
    assert load_monitor_config(None) == MonitorConfig()
    assert load_monitor_config(tmp_path / "monitor.yaml") == MonitorConfig()


def test_paths_start_at_the_folder_of_the_file_unless_they_are_absolute(tmp_path):
    mqtt = "mqtt: {username: u, password_file: secrets/mqtt, ca_file: /etc/ca.pem}"
    (tmp_path / "monitor.yaml").write_text(f"{mqtt}\n")
    config = load_monitor_config(tmp_path / "monitor.yaml")
    assert config.mqtt.password_file == tmp_path / "secrets" / "mqtt"
    assert config.mqtt.ca_file == Path("/etc/ca.pem")
    assert config.mqtt.username == "u"


@pytest.mark.parametrize("text", ["- a list\n", "mqtt: [1]\n", "channels: {\n", "mqtt: {key: a.pem}\n"])
def test_what_is_no_configuration_is_refused_with_its_line(text, tmp_path):
    (tmp_path / "monitor.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"monitor\.yaml:[12]:"):
        load_monitor_config(tmp_path / "monitor.yaml")


def test_the_printed_schema_of_a_monitor_has_every_section():
    schema = json.loads(run("schema", "monitor", check=0).stdout)
    assert set(schema["properties"]) == set(MonitorConfig.model_fields)
    assert {"type": "string"} in schema["$defs"]["ChannelConfig"]["anyOf"]


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
