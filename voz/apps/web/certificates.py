"""Certificates for HTTPS without a public domain name: an authority of this user's own.

It is made once, and phones are told to trust it. So it may vouch for nothing but computers in
private networks (name constraints): whoever steals its key cannot pretend to be a bank.
"""

from __future__ import annotations

import ipaddress
import os
import socket
import ssl
from collections.abc import Iterable, Sequence
from datetime import datetime, timedelta, timezone
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from voz.errors import ConfigError
from voz.files import atomic_write, os_errors_as_config_error

AUTHORITY_LIFETIME = timedelta(days=3650)
LEAF_LIFETIME = timedelta(days=90)
"""Phones accept at most 398 days."""

RENEWAL_MARGIN = timedelta(days=30)
"""How long before its end a certificate is renewed."""

CLOCK_TOLERANCE = timedelta(days=1)
"""Clocks of phones and robots differ."""

PRIVATE_NETWORKS = (
    "127.0.0.0/8", "10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16", "169.254.0.0/16",
    "100.64.0.0/10", "::1/128", "fc00::/7", "fe80::/10",
)  # fmt: skip
"""Networks without public addresses."""

AUTHORITY_KEY, AUTHORITY_CERTIFICATE, LEAF_CERTIFICATE = (
    "authority.key",
    "authority.crt",
    "leaf.pem",
)


class Certificates:
    """The authority of this user, and a certificate of this computer.

    Attributes:
        context: the TLS context with the newest certificate.
    """

    def __init__(self, folder: Path) -> None:
        """Read the authority from a folder of this user alone, or make it.

        Raises:
            ConfigError: the folder cannot be written, or holds no usable authority.
        """
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        # Tickets come after the handshake. A client whose threads read and write at once, as
        # `voz.Client`, then loses what it sends: OpenSSL is not made for that.
        self.context.num_tickets = 0
        self._folder = folder
        self._names: tuple[str, ...] = ()
        self._until = datetime.min.replace(tzinfo=timezone.utc)
        with os_errors_as_config_error(folder):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.chmod(0o700)
            if not (folder / AUTHORITY_CERTIFICATE).exists():
                _make_authority(folder)
            self._key, self._authority = _read_authority(folder)

    @property
    def authority(self) -> bytes:
        """The certificate that a phone has to trust, PEM."""
        return self._authority.public_bytes(serialization.Encoding.PEM)

    def renew(self, names: Iterable[str], now: datetime) -> bool:
        """Make a certificate if the old one ends soon or has other names; returns whether it did.

        Names and addresses in private networks count. Raises ConfigError if it cannot be written.
        """
        wanted = tuple(sorted(set(names)))
        if wanted == self._names and now < self._until - RENEWAL_MARGIN:
            return False
        key = ec.generate_private_key(ec.SECP256R1())
        leaf = self._signed(key, wanted, now)
        with os_errors_as_config_error(self._folder):
            path = self._folder / LEAF_CERTIFICATE
            _write_private(path, _pem(key) + leaf.public_bytes(serialization.Encoding.PEM))
            self.context.load_cert_chain(path)
        self._names, self._until = wanted, now + LEAF_LIFETIME
        return True

    def _signed(
        self, key: ec.EllipticCurvePrivateKey, names: Sequence[str], now: datetime
    ) -> x509.Certificate:
        usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
        return (
            _certificate_builder("voz", self._authority.subject, key, now, LEAF_LIFETIME)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage(signs_others=False), critical=True)
            .add_extension(usage, critical=False)
            .add_extension(x509.SubjectAlternativeName(_alternatives(names)), critical=True)
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()),
                critical=False,
            )
            .sign(self._key, hashes.SHA256())
        )


def _make_authority(folder: Path) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    name = f"voz operator page on {socket.gethostname()}"[:64]
    networks = [x509.IPAddress(ipaddress.ip_network(each)) for each in PRIVATE_NETWORKS]
    permitted = [x509.DNSName("local"), x509.DNSName("localhost"), *networks]
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    certificate = (
        _certificate_builder(name, subject, key, datetime.now(timezone.utc), AUTHORITY_LIFETIME)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(_usage(signs_others=True), critical=True)
        .add_extension(x509.NameConstraints(permitted, None), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    # The certificate last: if there is one, there is a key.
    _write_private(folder / AUTHORITY_KEY, _pem(key))
    _write_private(
        folder / AUTHORITY_CERTIFICATE, certificate.public_bytes(serialization.Encoding.PEM)
    )


def _read_authority(folder: Path) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    try:
        key = serialization.load_pem_private_key((folder / AUTHORITY_KEY).read_bytes(), None)
        certificate = x509.load_pem_x509_certificate((folder / AUTHORITY_CERTIFICATE).read_bytes())
        if isinstance(key, ec.EllipticCurvePrivateKey) and (
            key.public_key() == certificate.public_key()
        ):
            return key, certificate
    except ValueError:
        pass
    raise ConfigError(
        f"{folder}: holds no usable certificate authority; remove {AUTHORITY_KEY} and "
        f"{AUTHORITY_CERTIFICATE}, and let phones trust the new one"
    )


def _certificate_builder(
    name: str,
    issuer: x509.Name,
    key: ec.EllipticCurvePrivateKey,
    now: datetime,
    lifetime: timedelta,
) -> x509.CertificateBuilder:
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCK_TOLERANCE)
        .not_valid_after(now + lifetime)
    )


def _usage(signs_others: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_others, key_cert_sign=signs_others, crl_sign=signs_others,
        content_commitment=False, key_encipherment=False, data_encipherment=False,
        key_agreement=False, encipher_only=False, decipher_only=False,
    )  # fmt: skip


def _alternatives(names: Iterable[str]) -> list[x509.GeneralName]:
    """The names and addresses that the authority may vouch for."""
    networks = [ipaddress.ip_network(each) for each in PRIVATE_NETWORKS]
    found: list[x509.GeneralName] = []
    for name in names:
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            if name == "localhost" or name.endswith(".local"):
                found.append(x509.DNSName(name))
            continue
        if any(address in network for network in networks):
            found.append(x509.IPAddress(address))
    return found


def _pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )


def _write_private(path: Path, data: bytes) -> None:
    """Write a file that nobody else may read, not even while it is written."""
    mask = os.umask(0o077)
    try:
        with atomic_write(path, "wb") as file:
            file.write(data)
    finally:
        os.umask(mask)
