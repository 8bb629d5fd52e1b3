"""Passwords and certificates of MQTT: what is checked, and what no text shows."""

import datetime
import ipaddress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, MqttConfig
from hydrofdi.records.streams import EventKind
from tests.monitor.brokers import SECRET, Broker, needs_mosquitto, running
from tests.monitor.test_mqtt import connected, events, source_at, until


@dataclass
class Identity:
    """Files of a certificate and of its key, and what signs others with it."""

    certificate: Path
    key: Path
    name: x509.Name
    private: Any


def identity(folder, name, *extensions, issuer=None, form=Encoding.PEM, private=None):
    """A new identity; signed by itself if there is no issuer."""
    private = private or ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    made = Identity(folder / f"{name}.crt", folder / f"{name}.key", subject, private)
    signer, now = issuer or made, datetime.datetime.now(datetime.UTC)
    builder = (
        x509.CertificateBuilder(signer.name, subject, private.public_key(), x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
    )
    for extension in extensions:
        builder = builder.add_extension(
            extension, critical=not isinstance(extension, x509.SubjectAlternativeName)
        )
    made.certificate.write_bytes(builder.sign(signer.private, hashes.SHA256()).public_bytes(form))
    made.key.write_bytes(private.private_bytes(form, PrivateFormat.PKCS8, NoEncryption()))
    made.key.chmod(0o600)
    return made


def authority_in(folder, name="ca"):
    usage = x509.KeyUsage(
        False, False, False, False, False, key_cert_sign=True, crl_sign=True,
        encipher_only=False, decipher_only=False,
    )  # fmt: skip
    return identity(folder, name, x509.BasicConstraints(ca=True, path_length=0), usage)


def signed(authority, name, address="127.0.0.1"):
    host = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address(address))])
    return identity(authority.certificate.parent, name, host, issuer=authority)


def encrypted_by(own):
    return f"certfile {own.certificate}", f"keyfile {own.key}"


@pytest.fixture
def authority(tmp_path):
    return authority_in(tmp_path)


@pytest.fixture
def encrypted(tmp_path, authority):
    lines = encrypted_by(signed(authority, "broker"))
    yield from running(Broker(tmp_path, f"cafile {authority.certificate}", *lines))


def password_file(folder, text=SECRET + "\n", mode=0o600):
    file = folder / "password"
    file.write_text(text)
    file.chmod(mode)
    return file


def secure(broker, topic="press/samples"):
    return broker.address(topic).replace("mqtt://", "mqtts://")


def reason(closing, address, config):
    source = closing(source_at(address, config))
    readings = until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    return events(readings, EventKind.DISCONNECTED)[0].text


@needs_mosquitto
@pytest.mark.parametrize("password", ["wrong-" + SECRET, None])
def test_a_wrong_password_is_said_without_the_password(guarded, closing, tmp_path, password):
    config = MqttConfig()
    if password:
        config = MqttConfig(username="press", password_file=password_file(tmp_path, password))
    assert SECRET not in reason(closing, guarded.address(), config)


@needs_mosquitto
def test_a_renewed_password_is_taken_without_a_restart_and_one_that_all_can_read_is_warned_of(
    guarded, closing, tmp_path
):
    file = password_file(tmp_path, "old", mode=0o644)
    source = closing(source_at(guarded.address(), MqttConfig(username="press", password_file=file)))
    before = until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    file.write_text(SECRET)
    assert len(events(before + connected(source), EventKind.INSECURE)) == 1


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
    texts = [repr(readings), source.name, repr(source), repr(config)]
    texts += [repr(vars(source)), *capfd.readouterr(), caplog.text]
    assert not [text for text in texts if SECRET in text]


@needs_mosquitto
def test_a_certificate_is_checked_unless_the_configuration_says_otherwise(encrypted, authority, closing):
    source = closing(source_at(secure(encrypted), MqttConfig(ca_file=authority.certificate)))
    assert [event.kind for event in events(connected(source))] == ["connected"]
    source = closing(source_at(secure(encrypted), MqttConfig(verify=False)))
    assert len(events(connected(source), EventKind.INSECURE)) == 1


@needs_mosquitto
def test_a_broker_may_ask_for_a_certificate(tmp_path, authority, closing):
    own, lines = signed(authority, "monitor"), encrypted_by(signed(authority, "broker"))
    lines = (f"cafile {authority.certificate}", *lines, "require_certificate true")
    for broker in running(Broker(tmp_path, *lines)):
        config = MqttConfig(ca_file=authority.certificate, certificate=own.certificate, key=own.key)
        connected(closing(source_at(secure(broker), config)))
        assert reason(closing, secure(broker), MqttConfig(ca_file=authority.certificate))


def test_files_that_cannot_be_used_are_named_before_the_start(tmp_path):
    missing, other = tmp_path / "missing", password_file(tmp_path, SECRET)
    own, stranger = (identity(tmp_path, name) for name in ("monitor", "stranger"))
    for config, words in (
        (MqttConfig(username="press", password_file=missing), "mqtt.password_file"),
        (MqttConfig(password_file=other), "mqtt.username"),
        (MqttConfig(username="a", password_file=password_file(tmp_path / "..", "")), "one line"),
        (MqttConfig(ca_file=missing), "mqtt.ca_file"),
        (MqttConfig(ca_file=other), "mqtt.ca_file"),
        (MqttConfig(certificate=own.certificate, key=stranger.key), "mqtt.certificate"),
    ):
        with pytest.raises(ConfigError, match=words) as refusal:
            source_at("mqtts://127.0.0.1:1/t", config)
        assert SECRET not in str(refusal.value)
    MqttConfig(certificate=own.certificate, key=own.key)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mqtt:///press", ("localhost", 1883, "press", False)),
        ("mqtts://broker.example/a/b%20c", ("broker.example", 8883, "a/b c", True)),
        ("mqtt://[::1]:9/$odd", ("::1", 9, "$odd", False)),
    ],
)
def test_addresses(text, expected):
    address = Address.parse(text)
    assert (address.host, address.port, address.path, address.scheme == "mqtts") == expected


@pytest.mark.parametrize(
    "text", ["mqtt://host", "mqtt://host/", "mqtt://host:x/t", "mqtt://host:99999/t", "http://host/t",
             "mqtt://host/a/+/b", "mqtt://host/#", "mqtt://[::1/t", f"mqtt://press:{SECRET}@host/t",
             f"mqtt://a:{SECRET}@host", "opc.tcp://", "opc.tcp://host:99999", "opc.tcp://host/x?y",
             f"opc.tcp://me:{SECRET}@host"],
)  # fmt: skip
def test_addresses_that_are_none(text):
    with pytest.raises(ConfigError) as refusal:
        Address.parse(text)
    assert SECRET not in str(refusal.value)


@needs_mosquitto
def test_a_certificate_of_a_stranger_or_of_another_machine_is_refused(
    encrypted, tmp_path, authority, closing
):
    stranger = authority_in(tmp_path, "stranger")
    for config in (MqttConfig(), MqttConfig(ca_file=stranger.certificate)):
        assert reason(closing, secure(encrypted), config)
    elsewhere = signed(authority, "elsewhere", "127.0.0.99")
    (tmp_path / "elsewhere").mkdir()
    for broker in running(Broker(tmp_path / "elsewhere", *encrypted_by(elsewhere))):
        assert reason(closing, secure(broker), MqttConfig(ca_file=authority.certificate))
