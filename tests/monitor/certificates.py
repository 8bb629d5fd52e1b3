"""Certificates of tests, signed by themselves or by an authority."""

import datetime
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID


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
