"""This machine's key and certificate, and the certificates of the machines it is paired with.

They lie in `network/` of the user's config folder (`LIVE_CONFIG_DIR` overrides its place), mode 700, files 600. A
process that can read the key can act as this machine, so a key that others can read is refused. Certificates are
self-signed. There is no authority: a peer is accepted if its certificate is the one received at the pairing (a pin, as
in RFC 7858 section 4.2). Its name is random, because OpenSSL finds certificates by name and must find only one.
"""

import contextlib
import datetime
import hashlib
import os
import re
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import platformdirs

from live.base.errors import PersonError
from live.base.system.files import create_private, is_private

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

VALID: Final = datetime.timedelta(days=3 * 365)
"""Validity of a certificate. An expired one is reported but still accepted: see `tls`."""
CLOCK_TOLERANCE: Final = datetime.timedelta(days=1)
"""Certificates are valid from this long ago, for machines whose clock is behind."""
KEY_FILE: Final = "identity.pem"
PEERS_FOLDER: Final = "paired"
LONGEST_FILE: Final = 64 * 1024
LONGEST_NAME: Final = 40
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


def network_folder() -> Path:
    """Return the folder of keys and pairings."""
    root = os.environ.get("LIVE_CONFIG_DIR") or platformdirs.user_config_dir("choreographics-live")
    return Path(root) / "network"


def safe_name(name: str) -> str:
    """Return a machine's name reduced to characters safe in a file name: letters, digits, `.`, `_` and `-`."""
    words = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-._")[:LONGEST_NAME]
    return words or "machine"


def fingerprint_of(certificate: bytes) -> str:
    """Return the SHA-256 of a certificate (DER), as hexadecimal digits."""
    return hashlib.sha256(certificate).hexdigest()


@dataclass(frozen=True, slots=True)
class Peer:
    """A paired machine."""

    name: str
    certificate: bytes
    """DER."""

    @property
    def fingerprint(self) -> str:
        """Of its certificate."""
        return fingerprint_of(self.certificate)

    @property
    def expires(self) -> datetime.datetime:
        """When its certificate expires."""
        from cryptography import x509

        return x509.load_der_x509_certificate(self.certificate).not_valid_after_utc

    @property
    def public_key(self) -> "Ed25519PublicKey":
        """The key in its certificate; ValueError if that is none, or of another kind."""
        from cryptography import x509
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

        key = x509.load_der_x509_certificate(self.certificate).public_key()
        if not isinstance(key, Ed25519PublicKey):
            raise ValueError("a certificate with an Ed25519 key expected")
        return key

    def verify(self, signature: bytes, data: bytes) -> bool:
        """Return whether it signed the data."""
        from cryptography.exceptions import InvalidSignature

        try:
            self.public_key.verify(signature, data)
        except InvalidSignature:
            return False
        return True


@dataclass(frozen=True, slots=True)
class Identity:
    """This machine's key and certificate."""

    path: Path
    """File with key and certificate, as `ssl` reads them."""
    certificate: bytes
    """DER."""
    _key: "Ed25519PrivateKey"

    @property
    def fingerprint(self) -> str:
        """Of its certificate."""
        return fingerprint_of(self.certificate)

    def sign(self, data: bytes) -> bytes:
        """Return the signature of the data: 64 bytes (Ed25519, RFC 8032)."""
        return self._key.sign(data)

    def as_peer(self) -> Peer:
        """Return this machine as a peer: a process of the same user on the same machine has the same key."""
        return Peer("this machine", self.certificate)


def load_identity(folder: Path | None = None) -> Identity:
    """Load this machine's key; created on first use. PersonError if it cannot be created, read or kept private."""
    from cryptography import x509
    from cryptography.hazmat.primitives import serialization
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    folder = folder or network_folder()
    path = folder / KEY_FILE
    try:
        _make_private_folder(folder)
        if not path.exists():
            _create_identity(path)
        data = _read_private(path)
    except OSError as error:
        raise PersonError(f"this machine's key {path} cannot be read or made: {error.strerror}") from None
    try:
        key = serialization.load_pem_private_key(data, None)
        certificate = x509.load_pem_x509_certificate(data)
        if isinstance(key, Ed25519PrivateKey) and certificate.public_key() == key.public_key():
            return Identity(path, certificate.public_bytes(serialization.Encoding.DER), key)
    except (ValueError, TypeError):
        pass
    raise PersonError(
        f"{path} does not hold this machine's key and certificate", "remove it, and pair the machines again"
    )


def renew_identity(folder: Path | None = None) -> Identity:
    """Replace key and certificate; every machine has to be paired again."""
    folder = folder or network_folder()
    with contextlib.suppress(OSError):
        (folder / KEY_FILE).unlink(missing_ok=True)
    return load_identity(folder)


def _create_identity(path: Path) -> None:
    """Create key and certificate atomically; if two processes do so, the first one wins."""
    from cryptography import x509
    from cryptography.hazmat.primitives import serialization
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.x509.oid import NameOID

    key = Ed25519PrivateKey.generate()
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"choreographics-live {secrets.token_hex(8)}")])
    now = datetime.datetime.now(datetime.UTC)
    known = x509.SubjectKeyIdentifier.from_public_key(key.public_key())
    certificate = (
        x509.CertificateBuilder(
            name, name, key.public_key(), x509.random_serial_number(), now - CLOCK_TOLERANCE, now + VALID
        )
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(known, critical=False)
        .sign(key, None)
    )
    pem = serialization.Encoding.PEM
    private = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    _write_private(path, private + certificate.public_bytes(pem), replace=False)


class Pairings:
    """Machines that this one is paired with, one file each. Thread: one."""

    def __init__(self, folder: Path | None = None) -> None:
        """Reads nothing yet."""
        self._folder = (folder or network_folder()) / PEERS_FOLDER

    def version(self) -> object:
        """Return a value that differs once a pairing has been added or removed."""
        found = []
        with contextlib.suppress(OSError):
            for entry in os.scandir(self._folder):
                told = entry.stat()
                found.append((entry.name, told.st_mtime_ns, told.st_ino))
        return sorted(found)

    def read(self) -> list[Peer]:
        """Return all paired machines, sorted by name. PersonError for a file that is no certificate or not private."""
        found = []
        for path in sorted(self._folder.glob("*.pem"), key=lambda path: path.stem):
            from cryptography import x509
            from cryptography.hazmat.primitives import serialization

            try:
                certificate = x509.load_pem_x509_certificate(_read_private(path))
            except OSError as error:
                raise PersonError(f"{path} cannot be read: {error.strerror}") from None
            except ValueError:
                raise PersonError(
                    f"{path} is no certificate of a paired machine", f"live pair --forget {path.stem}"
                ) from None
            found.append(Peer(path.stem, certificate.public_bytes(serialization.Encoding.DER)))
        return found

    def add(self, name: str, certificate: bytes) -> Peer:
        """Store the pairing with a machine, under a safe name that is free. PersonError if it cannot be stored.

        ValueError if it is not a certificate with an Ed25519 key.
        """
        from cryptography import x509
        from cryptography.hazmat.primitives import serialization
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

        parsed = x509.load_der_x509_certificate(certificate)
        if not isinstance(parsed.public_key(), Ed25519PublicKey):
            raise ValueError("a certificate with an Ed25519 key expected")
        known = {peer.name: peer for peer in self.read()}
        same = next((peer for peer in known.values() if peer.certificate == certificate), None)
        if same is not None:
            return same
        wanted = safe_name(name)
        numbered = (f"{wanted}-{number}" for number in range(2, 1 << 20))
        free = wanted if wanted not in known else next(each for each in numbered if each not in known)
        try:
            _make_private_folder(self._folder.parent)
            _make_private_folder(self._folder)
            pem = parsed.public_bytes(serialization.Encoding.PEM)
            _write_private(self._folder / f"{free}.pem", pem, replace=True)
        except OSError as error:
            raise PersonError(f"the pairing with {free} cannot be kept in {self._folder}: {error.strerror}") from None
        return Peer(free, certificate)

    def forget(self, name: str) -> bool:
        """Remove a paired machine; return whether there was one of that name."""
        path = self._folder / f"{name}.pem"
        if _NAME.fullmatch(name) is None or not path.exists():
            return False
        try:
            path.unlink()
        except OSError as error:
            raise PersonError(f"{path} cannot be removed: {error.strerror}") from None
        return True


def _make_private_folder(folder: Path) -> None:
    """Create a folder if needed and make sure that no other user has access."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    _check_private(folder, "chmod 700")


def _read_private(path: Path) -> bytes:
    with path.open("rb") as file:
        _check_private(path, "chmod 600", os.fstat(file.fileno()))
        return file.read(LONGEST_FILE)


def _check_private(path: Path, remedy: str, status: os.stat_result | None = None) -> None:
    status = status or path.stat()
    if not is_private(status):
        mode = stat.S_IMODE(status.st_mode)
        raise PersonError(f"{path} is not this user's alone (mode {mode:o}): others could be this machine",
                          f"{remedy} {path}")  # fmt: skip


def _write_private(path: Path, data: bytes, *, replace: bool) -> None:
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    descriptor = create_private(beside)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        if replace:
            os.replace(beside, path)
        else:
            with contextlib.suppress(FileExistsError):
                os.link(beside, path)
    finally:
        beside.unlink(missing_ok=True)
