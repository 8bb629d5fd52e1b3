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
from tests.monitor.streams import Reader
from tests.monitor.test_mqtt import connected, source_at


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


def secure(broker):
    return broker.address().replace("mqtt://", "mqtts://")


def refused(closing, broker, **config):
    """Why a broker cannot be read."""
    reader = Reader(closing(source_at(secure(broker), MqttConfig(**config)))).has(EventKind.DISCONNECTED)
    return reader.said(EventKind.DISCONNECTED)[0]


@needs_mosquitto
def test_a_renewed_password_is_taken_without_a_restart_and_one_that_all_can_read_is_warned_of(
    guarded, closing, tmp_path
):
    file = tmp_path / "password"
    file.write_text("wrong-" + SECRET)
    file.chmod(0o644)
    source = closing(source_at(guarded.address(), MqttConfig(username="press", password_file=file)))
    reader = Reader(source).has(EventKind.DISCONNECTED)
    file.write_text(SECRET + "\n")
    reader.has(EventKind.CONNECTED)
    assert len(reader.said(EventKind.INSECURE)) == 1
    assert SECRET not in repr(reader.events)


@needs_mosquitto
def test_no_text_shows_the_password(guarded, closing, monkeypatch, capfd, caplog):
    caplog.set_level(0)
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    source = closing(source_at(guarded.address()))
    reader = connected(source)
    guarded.stop()
    reader.has(EventKind.DISCONNECTED)
    texts = [repr(reader.events), source.name, repr(vars(source)), *capfd.readouterr(), caplog.text]
    assert not [text for text in texts if SECRET in text]


@needs_mosquitto
def test_a_certificate_is_checked_unless_the_configuration_says_otherwise(tmp_path, authority, closing):
    """That of a stranger and that of another machine are refused."""
    stranger, own = authority_in(tmp_path, "stranger"), signed(authority, "elsewhere", "127.0.0.99")
    known = {"ca_file": authority.certificate}
    for broker in running(Broker(tmp_path, *encrypted_by(signed(authority, "broker")))):
        reader = connected(closing(source_at(secure(broker), MqttConfig(**known))))
        assert [event.kind for event in reader.events] == ["connected"]
        reader = connected(closing(source_at(secure(broker), MqttConfig(verify=False))))
        assert len(reader.said(EventKind.INSECURE)) == 1
        assert refused(closing, broker)
        assert refused(closing, broker, ca_file=stranger.certificate)
    for broker in running(Broker(tmp_path, *encrypted_by(own))):
        assert refused(closing, broker, **known)


@needs_mosquitto
def test_a_broker_may_ask_for_a_certificate(tmp_path, authority, closing):
    own, known = signed(authority, "monitor"), {"ca_file": authority.certificate}
    lines = *encrypted_by(signed(authority, "broker")), f"cafile {authority.certificate}"
    for broker in running(Broker(tmp_path, *lines, "require_certificate true")):
        config = MqttConfig(**known, certificate=own.certificate, key=own.key)
        connected(closing(source_at(secure(broker), config)))
        assert refused(closing, broker, **known)


@pytest.mark.parametrize(("files", "words"), [
    ({"username": "press", "password_file": "missing"}, "mqtt.password_file"),
    ({"password_file": "other"}, "mqtt.username"), ({"username": "a", "password_file": "empty"}, "one line"),
    ({"ca_file": "missing"}, "mqtt.ca_file"), ({"ca_file": "other"}, "mqtt.ca_file"),
    ({"certificate": "monitor.crt", "key": "stranger.key"}, "mqtt.certificate"),
])  # fmt: skip
def test_files_that_cannot_be_used_are_named_before_the_start(files, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("other").write_text(SECRET)
    Path("empty").touch()
    for name in ("monitor", "stranger"):
        identity(Path(), name)
    with pytest.raises(ConfigError, match=words) as refusal:
        source_at("mqtts://127.0.0.1:1/t", MqttConfig(**files))
    assert SECRET not in str(refusal.value)


@pytest.mark.parametrize(("text", "expected"), [
    ("mqtt:///press", ("mqtt", "localhost", 1883, "press")),
    ("mqtts://broker.example/a/b%20c", ("mqtts", "broker.example", 8883, "a/b c")),
    ("mqtt://[::1]:9/$odd", ("mqtt", "::1", 9, "$odd")),
])  # fmt: skip
def test_addresses(text, expected):
    assert Address.parse(text) == Address(*expected)


@pytest.mark.parametrize("text", [
    "mqtt://host", "mqtt://host/", "mqtt://host:x/t", "mqtt://host:99999/t", "http://host/t", "mqtt://host/a/+/b",
    "mqtt://host/#", "mqtt://[::1/t", f"mqtt://press:{SECRET}@host/t", f"mqtt://a:{SECRET}@host", "opc.tcp://",
    "opc.tcp://host:99999", "opc.tcp://host/x?y", f"opc.tcp://me:{SECRET}@host",
])  # fmt: skip
def test_addresses_that_are_none(text):
    with pytest.raises(ConfigError) as refusal:
        Address.parse(text)
    assert SECRET not in str(refusal.value)
