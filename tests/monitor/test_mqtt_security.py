"""Passwords and certificates of MQTT: what is checked, and what no text shows."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.mqtt import MqttAddress, MqttConfig
from hydrofdi.monitor.mqtt.security import credentials_of
from tests.monitor.brokers import SECRET, Broker, needs_mosquitto, running
from tests.monitor.certificates import Authority
from tests.monitor.mqtt_streams import connected, events, source_at, until


@pytest.fixture
def authority(tmp_path):
    return Authority(tmp_path)


@pytest.fixture
def encrypted(tmp_path, authority):
    """A broker with a certificate."""
    certificate, key = authority.signed("broker")
    yield from running(
        Broker(tmp_path, f"cafile {authority.file}", f"certfile {certificate}", f"keyfile {key}")
    )


def password_file(folder, text=SECRET + "\n", mode=0o600):
    file = folder / "password"
    file.write_text(text)
    file.chmod(mode)
    return file


def secure(broker, topic="press/samples"):
    return broker.address(topic).replace("mqtt://", "mqtts://")


def reason(closing, address, config):
    """Why there is no connection."""
    source = closing(source_at(address, config))
    readings = until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    return events(readings, EventKind.DISCONNECTED)[0].text


@needs_mosquitto
def test_a_user_with_the_password_reads(guarded, closing, tmp_path):
    config = MqttConfig(username="press", password_file=password_file(tmp_path))
    readings = connected(closing(source_at(guarded.address(), config)))
    assert [event.kind for event in events(readings)] == ["connected"]


@needs_mosquitto
def test_the_environment_holds_user_and_password_as_well(guarded, closing, monkeypatch):
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    connected(closing(source_at(guarded.address())))


@needs_mosquitto
@pytest.mark.parametrize("password", ["wrong-" + SECRET, None])
def test_a_wrong_password_is_said_without_the_password(guarded, closing, tmp_path, password):
    config = MqttConfig()
    if password:
        config = MqttConfig(username="press", password_file=password_file(tmp_path, password))
    said = reason(closing, guarded.address(), config)
    assert said == f"no connection to {guarded.address()}: it refuses the user or the password; trying again"


@needs_mosquitto
def test_a_renewed_password_is_taken_without_a_restart(guarded, closing, tmp_path):
    file = password_file(tmp_path, "old")
    source = closing(source_at(guarded.address(), MqttConfig(username="press", password_file=file)))
    until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    file.write_text(SECRET)
    connected(source)


@needs_mosquitto
def test_a_topic_that_the_user_may_not_read_is_said(tmp_path, closing):
    """Rules of ``acl_file`` let everyone subscribe and deliver nothing; those of this plugin refuse."""
    plugins = sorted(Path("/usr/lib").glob("*/mosquitto_dynamic_security.so"))
    if not plugins or shutil.which("mosquitto_ctrl") is None:
        pytest.skip("mosquitto has no dynamic security")
    rules = tmp_path / "rules.json"
    setting_up = ["mosquitto_ctrl", "dynsec", "init", rules, "press", SECRET]
    subprocess.run(setting_up, check=True, capture_output=True)
    known = json.loads(rules.read_text())
    for role in known["roles"]:
        role["acls"] = [rule for rule in role["acls"] if rule["topic"] != "#"]
    rules.write_text(json.dumps(known))
    config = MqttConfig(username="press", password_file=password_file(tmp_path))
    lines = (f"plugin {plugins[0]}", f"plugin_opt_config_file {rules}")
    for broker in running(Broker(tmp_path, *lines, anonymous=False)):
        assert "it does not let this user read 'press/samples'" in reason(closing, broker.address(), config)


@needs_mosquitto
def test_a_password_that_all_users_can_read_is_warned_of(guarded, closing, tmp_path):
    config = MqttConfig(username="press", password_file=password_file(tmp_path, mode=0o644))
    readings = connected(closing(source_at(guarded.address(), config)))
    (warning,) = events(readings, EventKind.INSECURE)
    assert "every user of this machine can read it" in warning.text


@needs_mosquitto
def test_no_text_shows_the_password(guarded, closing, tmp_path, monkeypatch, capfd, caplog):
    caplog.set_level(0)
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    config = MqttConfig()
    source = closing(source_at(guarded.address(), config))
    readings = connected(source)
    guarded.stop()
    readings += until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    texts = [repr(readings), source.name, repr(source), repr(config), repr(credentials_of(config))]
    texts += [repr(vars(source._connection)), *capfd.readouterr(), caplog.text]
    assert not [text for text in texts if SECRET in text]


@pytest.mark.parametrize(
    "address", [f"mqtt://press:{SECRET}@host/t", f"mqtts://{SECRET}@host/t", f"mqtt://a:{SECRET}@host"]
)
def test_a_password_in_an_address_is_refused_and_not_repeated(address):
    with pytest.raises(ConfigError, match="password_file") as refusal:
        MqttAddress.parse(address)
    assert SECRET not in str(refusal.value)


@needs_mosquitto
def test_samples_come_over_tls_that_is_verified(encrypted, authority, closing):
    source = closing(source_at(secure(encrypted), MqttConfig(ca_file=authority.file)))
    assert [event.kind for event in events(connected(source))] == ["connected"]


@needs_mosquitto
def test_a_certificate_of_a_stranger_is_refused(encrypted, tmp_path, closing):
    stranger = Authority(tmp_path, "stranger")
    for config in (MqttConfig(), MqttConfig(ca_file=stranger.file)):
        assert "its certificate is refused: " in reason(closing, secure(encrypted), config)


@needs_mosquitto
def test_a_certificate_of_another_machine_is_refused(tmp_path, authority, closing):
    certificate, key = authority.signed("elsewhere", "127.0.0.99")
    for broker in running(Broker(tmp_path, f"certfile {certificate}", f"keyfile {key}")):
        said = reason(closing, secure(broker), MqttConfig(ca_file=authority.file))
        assert "its certificate is refused: IP address mismatch" in said


@needs_mosquitto
def test_a_certificate_is_not_checked_only_where_the_configuration_says_so(encrypted, closing):
    source = closing(source_at(secure(encrypted), MqttConfig(verify=False)))
    readings = connected(source)
    (warning,) = events(readings, EventKind.INSECURE)
    assert "mqtt.verify is false" in warning.text


@needs_mosquitto
def test_a_broker_may_ask_for_a_certificate(tmp_path, authority, closing):
    certificate, key = authority.signed("broker")
    own, own_key = authority.signed("monitor")
    lines = (f"cafile {authority.file}", f"certfile {certificate}", f"keyfile {key}")
    for broker in running(Broker(tmp_path, *lines, "require_certificate true")):
        config = MqttConfig(ca_file=authority.file, certificate=own, key=own_key)
        connected(closing(source_at(secure(broker), config)))
        assert reason(closing, secure(broker), MqttConfig(ca_file=authority.file))


@needs_mosquitto
def test_encryption_that_the_broker_does_not_speak_is_said(broker, closing):
    said = reason(closing, secure(broker), MqttConfig())
    assert "no encrypted connection" in said or "closed the connection" in said


def test_files_that_cannot_be_used_are_named_before_the_start(tmp_path):
    missing, other = tmp_path / "missing", password_file(tmp_path, SECRET)
    own, key = Authority(tmp_path).signed("monitor")
    _, other_key = Authority(tmp_path).signed("other")
    for config, words in (
        (MqttConfig(username="press", password_file=missing), "mqtt.password_file"),
        (MqttConfig(password_file=other), "mqtt.username"),
        (MqttConfig(username="a", password_file=password_file(tmp_path / "..", "")), "one line"),
        (MqttConfig(ca_file=missing), "mqtt.ca_file"),
        (MqttConfig(ca_file=other), "mqtt.ca_file"),
        (MqttConfig(certificate=own, key=other_key), "mqtt.certificate"),
    ):
        with pytest.raises(ConfigError, match=words) as refusal:
            source_at("mqtts://127.0.0.1:1/t", config)
        assert SECRET not in str(refusal.value)
    MqttConfig(certificate=own, key=key)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mqtt:///press", ("localhost", 1883, "press", False)),
        ("mqtts://broker.example/a/b%20c", ("broker.example", 8883, "a/b c", True)),
        ("mqtt://[::1]:9/$odd", ("::1", 9, "$odd", False)),
    ],
)
def test_addresses(text, expected):
    address = MqttAddress.parse(text)
    assert (address.host, address.port, address.topic, address.is_secure) == expected


@pytest.mark.parametrize(
    "text", ["mqtt://host", "mqtt://host/", "mqtt://host:x/t", "mqtt://host:99999/t", "http://host/t",
             "mqtt://host/a/+/b", "mqtt://host/#", "mqtt://[::1/t"],
)  # fmt: skip
def test_addresses_that_are_none(text):
    with pytest.raises(ConfigError):
        MqttAddress.parse(text)
