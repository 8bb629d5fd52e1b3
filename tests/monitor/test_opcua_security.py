"""Encrypted connections to a server that trusts one certificate and knows one user."""

import pytest
from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.crypto.uacrypto import der_from_x509
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import Encoding

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import Address, OpcUaConfig
from hydrofdi.monitor.opcua import OpcUaSource
from hydrofdi.records.streams import EventKind
from tests.monitor.brokers import SECRET as PASSWORD
from tests.monitor.streams import Reader
from tests.monitor.test_mqtt_security import identity
from tests.monitor.test_opcua_source import (
    CHANNELS,
    NODES,
    P1,
    RATE,
    LoopbackServer,
    connected,
    opened,
    samples,
)


class OneUser:
    def get_user(self, iserver, username=None, password=None, certificate=None):
        return User(role=UserRole.User) if (username, password) == ("press", PASSWORD) else None


@pytest.fixture(scope="module")
def identities(tmp_path_factory):
    folder = tmp_path_factory.mktemp("identities")
    made = {}
    for name, form in {"server": Encoding.DER, "monitor": Encoding.PEM, "stranger": Encoding.DER}.items():
        uri = x509.SubjectAlternativeName([x509.UniformResourceIdentifier(f"urn:hydrofdi:{name}")])
        key = rsa.generate_private_key(65537, 2048)
        made[name] = identity(folder, name, uri, form=form, private=key)
    return made


@pytest.fixture(scope="module")
def server(identities):
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

    with LoopbackServer(NODES, set_up=set_up, user_manager=OneUser()) as running:
        yield running


@pytest.fixture
def config(identities, tmp_path):
    password = tmp_path / "password"
    password.write_text(PASSWORD + "\n")

    def made(own="monitor", pinned="server", key=None, **more):
        files = {
            "certificate": identities[own].certificate,
            "key": identities[key or own].key,
            "server_certificate": identities[pinned].certificate,
        }
        user = {"username": "press", "password_file": password}
        policy = {"security": "Basic256Sha256", "publishing_interval": 0.05}
        return OpcUaConfig.model_validate(policy | files | user | more)

    return made


def test_samples_come_encrypted_from_the_server_that_is_meant(server, config):
    with opened(server.url, config()) as source:
        reader = connected(source)
        for name in NODES:
            server.write(name, [1.0, 2.0], [0.0, 0.01])
        samples(reader, 2)
    assert reader.channel(P1).tolist() == [1e5, 2e5]
    assert not [text for text in reader.said(EventKind.INSECURE) if "not encrypted" in text]


def test_what_cannot_be_used_or_would_send_a_password_unencrypted_is_refused(config, tmp_path, monkeypatch):
    (empty := tmp_path / "empty").touch()
    monkeypatch.setenv("HYDROFDI_OPCUA_PASSWORD", PASSWORD)
    for refused, key in (
        (config(certificate=tmp_path / "none"), "none"), (config(server_certificate=empty), "empty"),
        (config(key="stranger"), "certificate"), (OpcUaConfig(username="press"), "unencrypted"),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match=key) as error:
            OpcUaSource(Address.parse("opc.tcp://127.0.0.1"), refused, CHANNELS, RATE)
        assert PASSWORD not in str(error.value)
    for half in ({"security": "Basic256Sha256"}, {}):
        with pytest.raises(ValueError, match="certificate"):
            OpcUaConfig(certificate=tmp_path, **half)


def test_strangers_and_wrong_passwords_are_refused_and_shown_nowhere(server, config, tmp_path, caplog, capfd):
    wrong = tmp_path / "wrong"
    wrong.write_text("not-" + PASSWORD)
    for refused, blamed in (
        (config(pinned="stranger"), "server_certificate"),
        (config(own="stranger"), "Untrusted"),
        (config(password_file=wrong), "UserAccessDenied"),
    ):
        with opened(server.url, refused) as source:
            said = Reader(source).has(EventKind.DISCONNECTED).said(EventKind.DISCONNECTED)[0]
        assert blamed in said
        assert PASSWORD not in said + caplog.text + "".join(capfd.readouterr())
