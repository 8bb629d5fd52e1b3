"""The configuration of a monitor, and the schemas of what it reads."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hydrofdi.detectors.trained.reading import detector_text
from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import MonitorConfig, load_monitor_config
from hydrofdi.records import Channel
from tests.commands import run
from tests.monitor.streams import made_detector


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


def test_a_text_alone_is_a_column(tmp_path):
    (tmp_path / "monitor.yaml").write_text("channels: {chamber_1_pressure: 'P1 [bar]'}\n")
    config = load_monitor_config(tmp_path / "monitor.yaml")
    assert config.channels[Channel.CHAMBER_1_PRESSURE].column == "P1 [bar]"


@pytest.mark.parametrize("text", ["- a list\n", "mqtt: [1]\n", "channels: {\n", "mqtt: {key: a.pem}\n"])
def test_what_is_no_configuration_is_refused_with_its_line(text, tmp_path):
    (tmp_path / "monitor.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"monitor\.yaml:[12]:"):
        load_monitor_config(tmp_path / "monitor.yaml")


def test_the_printed_schema_of_a_detector_describes_all_of_a_detector_file():
    schema = json.loads(run("schema", "detector", check=0).stdout)
    for file in (made_detector(), made_detector(chart="cusum")):
        assert unknown(json.loads(detector_text(file)), schema, schema["$defs"]) == []
    assert schema["properties"]["schema"]["const"] == "hydrofdi.detector"
    assert schema["properties"]["schema"]["description"]


def test_the_printed_schema_of_a_monitor_has_every_section():
    schema = json.loads(run("schema", "monitor", check=0).stdout)
    assert set(schema["properties"]) == set(MonitorConfig.model_fields)
    assert {"type": "string"} in schema["$defs"]["ChannelConfig"]["anyOf"]


def unknown(value, schema, definitions):
    """Keys of an object that a schema does not know, or that it needs and the object lacks."""
    schema = definitions[schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema
    if not isinstance(value, dict):
        return []
    options = [each for each in schema.get("anyOf", [schema]) if each.get("type") != "null"]
    (schema,) = [definitions[each["$ref"].rpartition("/")[2]] if "$ref" in each else each for each in options]
    properties, others = schema.get("properties", {}), schema.get("additionalProperties", False)
    wrong = [key for key in schema.get("required", ()) if key not in value]
    for key, inner in value.items():
        if key in properties:
            wrong += unknown(inner, properties[key], definitions)
        elif isinstance(others, dict):
            wrong += unknown(inner, others, definitions)
        elif not others:
            wrong.append(key)
    return wrong
