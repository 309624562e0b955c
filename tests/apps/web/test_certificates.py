"""The authority for HTTPS: who believes in it, for what, and for how long."""

from __future__ import annotations

import socket
import ssl
import stat
import threading
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from voz.apps.web.certificates import (
    AUTHORITY_CERTIFICATE,
    AUTHORITY_KEY,
    AUTHORITY_LIFETIME,
    LEAF_CERTIFICATE,
    LEAF_LIFETIME,
    Certificates,
)
from voz.errors import ConfigError

NOW = datetime.now(timezone.utc)
NAMES = ["localhost", "127.0.0.1", "::1", "robot.local", "192.168.1.7"]


def shake_hands(certificates: Certificates, trusted: bytes, name: str) -> ssl.SSLSession | None:
    """Let a client that trusts an authority ask for a name; raises what it does not believe."""
    client = ssl.create_default_context(cadata=trusted.decode())
    here, there = socket.socketpair()

    def serve() -> None:
        try:
            with certificates.context.wrap_socket(there, server_side=True) as shaken:
                shaken.unwrap()  # it stays open until the client is done, which may still write
        except OSError:  # the client does not believe it, or has closed without a farewell
            there.close()

    server = threading.Thread(target=serve)
    server.start()
    try:
        with client.wrap_socket(here, server_hostname=name) as shaken:
            assert not shaken.recv(1)  # what comes after the handshake
            return shaken.session
    finally:
        here.close()
        server.join()


@pytest.mark.parametrize("name", NAMES)
def test_who_trusts_the_authority_believes_the_robot(name: str, tmp_path: Path) -> None:
    certificates = Certificates(tmp_path / "made")
    assert certificates.renew(NAMES, NOW)
    session = shake_hands(certificates, certificates.authority, name)
    assert session
    assert not session.has_ticket  # it comes while the client begins to send


def test_it_is_made_once_and_by_this_user_alone(tmp_path: Path) -> None:
    first = Certificates(tmp_path)
    first.renew(NAMES, NOW)
    again = Certificates(tmp_path)
    again.renew(NAMES, NOW)
    assert again.authority == first.authority
    shake_hands(again, first.authority, "robot.local")
    for name in (AUTHORITY_KEY, AUTHORITY_CERTIFICATE, LEAF_CERTIFICATE):
        assert stat.S_IMODE((tmp_path / name).stat().st_mode) == 0o600
    other = Certificates(tmp_path / "other")
    other.renew(NAMES, NOW)
    with pytest.raises(ssl.SSLCertVerificationError):
        shake_hands(other, first.authority, "robot.local")


def test_it_vouches_for_nobody_in_the_world(tmp_path: Path) -> None:
    certificates = Certificates(tmp_path)
    certificates.renew([*NAMES, "example.org", "93.184.216.34"], NOW)
    leaf = x509.load_pem_x509_certificate((tmp_path / LEAF_CERTIFICATE).read_bytes())
    names = leaf.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert "example.org" not in names.get_values_for_type(x509.DNSName)
    assert [str(a) for a in names.get_values_for_type(x509.IPAddress)] == [
        "127.0.0.1", "192.168.1.7", "::1",
    ]  # fmt: skip


def test_who_steals_its_key_cannot_vouch_for_others_either(
    tmp_path: Path,
) -> None:
    certificates = Certificates(tmp_path)
    key = serialization.load_pem_private_key((tmp_path / AUTHORITY_KEY).read_bytes(), None)
    assert isinstance(key, ec.EllipticCurvePrivateKey)
    forged = (
        x509.CertificateBuilder()
        .subject_name(x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "example.org")]))
        .issuer_name(x509.load_pem_x509_certificate(certificates.authority).subject)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(NOW - timedelta(days=1))
        .not_valid_after(NOW + timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("example.org")]), critical=False)
        .add_extension(
            x509.AuthorityKeyIdentifier.from_issuer_public_key(key.public_key()), critical=False
        )
        .sign(key, hashes.SHA256())
    )
    chain = tmp_path / "forged.pem"
    chain.write_bytes(forged.public_bytes(serialization.Encoding.PEM))
    certificates.context.load_cert_chain(chain, tmp_path / AUTHORITY_KEY)
    with pytest.raises(ssl.SSLCertVerificationError, match="permitted subtree"):
        shake_hands(certificates, certificates.authority, "example.org")


def test_it_renews_itself_a_month_before_its_end_and_for_another_address(tmp_path: Path) -> None:
    certificates = Certificates(tmp_path)
    assert certificates.renew(NAMES, NOW)
    assert not certificates.renew(reversed(NAMES), NOW + timedelta(days=1))
    assert certificates.renew(NAMES, NOW + LEAF_LIFETIME - timedelta(days=29))
    assert certificates.renew([*NAMES, "192.168.1.8"], NOW + LEAF_LIFETIME - timedelta(days=29))
    certificates.renew([*NAMES, "10.0.0.1"], NOW)
    shake_hands(certificates, certificates.authority, "10.0.0.1")
    assert LEAF_LIFETIME < timedelta(days=398) < AUTHORITY_LIFETIME


@pytest.mark.parametrize("broken", [b"", b"nonsense"])
@pytest.mark.parametrize("name", [AUTHORITY_KEY, AUTHORITY_CERTIFICATE])
def test_a_broken_one_is_one_line(name: str, broken: bytes, tmp_path: Path) -> None:
    Certificates(tmp_path)
    (tmp_path / name).write_bytes(broken)
    with pytest.raises(ConfigError, match="holds no usable certificate authority"):
        Certificates(tmp_path)


def test_two_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    Certificates(tmp_path / "one")
    Certificates(tmp_path / "two")
    (tmp_path / "one" / AUTHORITY_KEY).write_bytes((tmp_path / "two" / AUTHORITY_KEY).read_bytes())
    with pytest.raises(ConfigError, match="holds no usable certificate authority"):
        Certificates(tmp_path / "one")


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be written"):
        Certificates(tmp_path / "file" / "folder")
