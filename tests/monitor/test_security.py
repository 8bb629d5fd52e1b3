"""Passwords and certificates of MQTT and OPC UA: what is checked, and what no text shows."""

import datetime
import ipaddress
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.crypto.uacrypto import der_from_x509
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, MqttConfig, OpcUaConfig
from hydrofdi.monitor.opcua import OpcUaSource
from hydrofdi.records.streams import EventKind
from tests.monitor import test_opcua_source as plant
from tests.monitor.brokers import SECRET, Broker
from tests.monitor.streams import Reader
from tests.monitor.test_mqtt import connected, source_at


class Identity(NamedTuple):
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
    signer, now, day = issuer or made, datetime.datetime.now(datetime.UTC), datetime.timedelta(days=1)
    builder = x509.CertificateBuilder(
        signer.name, subject, private.public_key(), x509.random_serial_number(), now - day, now + day
    )
    for each in extensions:
        builder = builder.add_extension(each, critical=not isinstance(each, x509.SubjectAlternativeName))
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


def encrypted_by(authority, name="broker", address="127.0.0.1"):
    """Lines of a broker that has a certificate of this authority."""
    host = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address(address))])
    own = identity(authority.certificate.parent, name, host, issuer=authority)
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


def test_a_certificate_is_checked_unless_the_configuration_says_otherwise(tmp_path, authority, closing):
    """That of a stranger and that of another machine are refused; a broker may ask for one, too."""
    stranger, known = authority_in(tmp_path, "stranger"), {"ca_file": authority.certificate}
    lines = encrypted_by(authority)
    with Broker(tmp_path, *lines) as broker:
        reader = connected(closing(source_at(secure(broker), MqttConfig(**known))))
        assert [event.kind for event in reader.events] == ["connected"]
        reader = connected(closing(source_at(secure(broker), MqttConfig(verify=False))))
        assert len(reader.said(EventKind.INSECURE)) == 1
        assert refused(closing, broker)
        assert refused(closing, broker, ca_file=stranger.certificate)
    with Broker(tmp_path, *encrypted_by(authority, "elsewhere", "127.0.0.99")) as broker:
        assert refused(closing, broker, **known)
    own = identity(tmp_path, "monitor", issuer=authority)
    with Broker(tmp_path, *lines, f"cafile {authority.certificate}", "require_certificate true") as broker:
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


@pytest.mark.parametrize("text", [
    "mqtt://host", "mqtt://host/", "mqtt://host:x/t", "mqtt://host:99999/t", "http://host/t", "mqtt://host/a/+/b",
    "mqtt://host/#", "mqtt://[::1/t", f"mqtt://press:{SECRET}@host/t", f"mqtt://a:{SECRET}@host", "opc.tcp://",
    "opc.tcp://host:99999", "opc.tcp://host/x?y", f"opc.tcp://me:{SECRET}@host",
])  # fmt: skip
def test_addresses_that_are_none(text):
    with pytest.raises(ConfigError) as refusal:
        Address.parse(text)
    assert SECRET not in str(refusal.value)
    for usual, expected in (
        ("mqtt:///press", ("mqtt", "localhost", 1883, "press")),
        ("mqtts://broker.example/a/b%20c", ("mqtts", "broker.example", 8883, "a/b c")),
        ("mqtt://[::1]:9/$odd", ("mqtt", "::1", 9, "$odd")),
    ):
        assert Address.parse(usual) == Address(*expected)


class OneUser:
    def get_user(self, iserver, username=None, password=None, certificate=None):
        return User(role=UserRole.User) if (username, password) == ("press", SECRET) else None


@pytest.fixture(scope="module")
def identities(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("identities"), {}
    for name, form in {"server": Encoding.DER, "monitor": Encoding.PEM, "stranger": Encoding.DER}.items():
        uri = x509.SubjectAlternativeName([x509.UniformResourceIdentifier(f"urn:hydrofdi:{name}")])
        made[name] = identity(folder, name, uri, form=form, private=rsa.generate_private_key(65537, 2048))
    return made


@pytest.fixture(scope="module")
def server(identities):
    """It trusts one certificate, and knows one user."""
    trusted = x509.load_pem_x509_certificate(identities["monitor"].certificate.read_bytes())

    async def only_the_monitor(certificate, description):
        if der_from_x509(certificate) != der_from_x509(trusted):
            raise ServiceError(ua.StatusCodes.BadCertificateUntrusted)

    async def set_up(server):
        server.set_security_policy([ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt])
        server.set_identity_tokens([ua.UserNameIdentityToken])
        server.set_certificate_validator(only_the_monitor)
        await server.load_certificate(identities["server"].certificate)
        await server.load_private_key(identities["server"].key)

    with plant.LoopbackServer(plant.NODES, set_up=set_up, user_manager=OneUser()) as running:
        yield running


@pytest.fixture
def config(identities, tmp_path):
    (tmp_path / "password").write_text(SECRET + "\n")

    def made(own="monitor", pinned="server", key=None, **more):
        usual = {
            "certificate": identities[own].certificate, "key": identities[key or own].key,
            "server_certificate": identities[pinned].certificate, "security": "Basic256Sha256",
            "username": "press", "password_file": tmp_path / "password", "publishing_interval": 0.05,
        }  # fmt: skip
        return OpcUaConfig(**usual | more)

    return made


def test_samples_come_encrypted_from_the_server_that_is_meant(server, config):
    with plant.opened(server.url, config()) as source:
        reader = plant.connected(source)
        for name in plant.NODES:
            server.write(name, [1.0, 2.0], [0.0, 0.01])
        _, samples = plant.whole(reader, 4)
    assert samples[plant.P1].tolist() == [1e5, 2e5]
    assert not [text for text in reader.said(EventKind.INSECURE) if "not encrypted" in text]


def test_what_cannot_be_used_or_would_send_a_password_unencrypted_is_refused(config, tmp_path, monkeypatch):
    (empty := tmp_path / "empty").touch()
    monkeypatch.setenv("HYDROFDI_OPCUA_PASSWORD", SECRET)
    for refused, key in (
        (config(certificate=tmp_path / "none"), "none"), (config(server_certificate=empty), "empty"),
        (config(key="stranger"), "certificate"), (OpcUaConfig(username="press"), "unencrypted"),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match=key) as error:
            OpcUaSource(Address.parse("opc.tcp://127.0.0.1"), refused, plant.CHANNELS, plant.RATE)
        assert SECRET not in str(error.value)
    for half in ({"security": "Basic256Sha256"}, {}):
        with pytest.raises(ValueError, match="certificate"):
            OpcUaConfig(certificate=tmp_path, **half)


def test_strangers_and_wrong_passwords_are_refused_and_shown_nowhere(server, config, tmp_path, caplog, capfd):
    wrong = tmp_path / "wrong"
    wrong.write_text("not-" + SECRET)
    for refused, blamed in (
        (config(pinned="stranger"), "server_certificate"), (config(own="stranger"), "Untrusted"),
        (config(password_file=wrong), "UserAccessDenied"),
    ):  # fmt: skip
        with plant.opened(server.url, refused) as source:
            said = Reader(source).has(EventKind.DISCONNECTED).said(EventKind.DISCONNECTED)[0]
        assert blamed in said
        assert SECRET not in said + caplog.text + "".join(capfd.readouterr())
