"""Certificates and key of an encrypted connection."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from asyncua.crypto.uacrypto import CertProperties
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding, load_der_private_key, load_pem_private_key

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.opcua.configuration import OpcUaConfig


@dataclass(frozen=True)
class KeyFiles:
    """Contents of the files (certificates in DER), and the application URI in the monitor's own."""

    certificate: bytes
    private_key: CertProperties
    server_certificate: bytes
    application_uri: str


def key_files(config: OpcUaConfig) -> KeyFiles | None:
    """The files of a configuration; None if nothing is encrypted.

    Raises
    ------
    ConfigError
        A file cannot be read, is not a certificate or key, or they do not match.
    """
    if config.certificate is None or config.key is None or config.server_certificate is None:
        return None
    certificate = _certificate(config.certificate)
    return KeyFiles(
        certificate.public_bytes(Encoding.DER),
        _private_key(config.key, certificate),
        _certificate(config.server_certificate).public_bytes(Encoding.DER),
        _application_uri(certificate, config.certificate),
    )


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ConfigError(f"opcua: {path}: {error.strerror}") from None


def _is_pem(content: bytes) -> bool:
    return b"-----BEGIN" in content


def _certificate(path: Path) -> x509.Certificate:
    content = _content(path)
    try:
        load = x509.load_pem_x509_certificate if _is_pem(content) else x509.load_der_x509_certificate
        return load(content)
    except ValueError:
        raise ConfigError(f"opcua: {path} is not a certificate") from None


def _private_key(path: Path, certificate: x509.Certificate) -> CertProperties:
    content = _content(path)
    try:
        load = load_pem_private_key if _is_pem(content) else load_der_private_key
        key = load(content, password=None)
    except (ValueError, TypeError):
        raise ConfigError(f"opcua: {path} is not a private key without a passphrase") from None
    if key.public_key() != certificate.public_key():
        raise ConfigError(f"opcua: the private key {path} does not belong to the certificate")
    return CertProperties(content, "pem" if _is_pem(content) else "der")


def _application_uri(certificate: x509.Certificate, path: Path) -> str:
    """The application URI in a certificate; a server compares it with that of the client."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        return str(names.get_values_for_type(x509.UniformResourceIdentifier)[0])
    except (x509.ExtensionNotFound, IndexError):
        raise ConfigError(f"opcua: {path} has no application URI; servers require it") from None
