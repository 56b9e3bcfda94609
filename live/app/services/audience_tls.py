"""TLS certificate of the server for phones: reading, checks and warnings about its expiry."""

import stat
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from live.base.errors import PersonError
from live.library.disk_cache import read_regular_file

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from live.show.venue.venue_audience import VenueAudience

MAX_FILE_BYTES: Final = 24_000
"""Maximum size of each file [bytes]: both are sent to the gateway process in one packet."""
EXPIRY_WARNING: Final = timedelta(days=7)
OPTION: Final = "--audience-tls"


@dataclass(frozen=True, slots=True)
class TlsIdentity:
    """A certificate with its key."""

    certificate: bytes
    key: bytes
    names: tuple[str, ...]
    """The host names and addresses it is valid for."""
    valid_from: datetime
    valid_until: datetime
    file_warnings: tuple[str, ...]
    """Warnings about its files."""

    def warnings(self, now: datetime, host: str) -> list[str]:
        """Return the warnings at `now`, if phones are given `host`."""
        found = list(self.file_warnings)
        if now < self.valid_from:
            found.append(
                f"the certificate is valid from {self.valid_from:%Y-%m-%d %H:%M} UTC: phones refuse it until then"
            )
        if now >= self.valid_until:
            found.append(
                f"the certificate expired on {self.valid_until:%Y-%m-%d %H:%M} UTC: phones show a warning; renew it"
            )
        elif self.valid_until - now < EXPIRY_WARNING:
            found.append(f"the certificate expires on {self.valid_until:%Y-%m-%d %H:%M} UTC: renew it soon")
        if not any(_matches(name, host) for name in self.names):
            names = ", ".join(self.names) or "no host"
            found.append(f"the certificate is for {names}, but phones are given {host}: set --audience-link")
        return found

    @property
    def host(self) -> str | None:
        """The host name to give to phones; None if all are wildcards."""
        return next((name for name in self.names if "*" not in name), None)


def _matches(name: str, host: str) -> bool:
    """Whether a name of a certificate matches a host; `*` is one label (RFC 9525)."""
    name, host = name.casefold(), host.casefold().strip("[]")
    if name.startswith("*."):
        return host.partition(".")[2] == name[2:]
    return name == host


def venue_tls_files(venue: "VenueAudience", name: str | None) -> tuple[Path, Path] | None:
    """Return certificate and key of a venue, relative to its file; None if it has none. `name`: of the venue."""
    if venue.certificate is None or venue.key is None:
        return None
    from live.show.venue.venue import venue_path

    folder = Path() if name is None else venue_path(name).parent
    return folder / Path(venue.certificate).expanduser(), folder / Path(venue.key).expanduser()


def parse_tls(text: str | None, option: str = OPTION) -> tuple[Path, Path] | None:
    """Parse two files as CERT,KEY; raise PersonError for anything else."""
    if text is None:
        return None
    words = [word.strip() for word in text.split(",")]
    if len(words) != 2 or not all(words):
        raise PersonError(f"{option} {text!r}: two files expected, CERT,KEY", f"{option} fullchain.pem,privkey.pem")
    return Path(words[0]).expanduser(), Path(words[1]).expanduser()


def read_identity(certificate: Path, key: Path, name: str = OPTION) -> TlsIdentity:
    """Read a certificate and its key from PEM files; raise PersonError if they are invalid.

    `name`: the option or setting that named them, for messages.
    """
    from cryptography import x509
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat, load_pem_private_key

    chain, secret = _read(certificate, name), _read(key, name)
    try:
        found = x509.load_pem_x509_certificates(chain)[0]
    except ValueError:
        raise PersonError(f"{name}: {certificate} holds no certificate in PEM", _order_hint(chain, secret)) from None
    try:
        private = load_pem_private_key(secret, password=None)
    except TypeError:
        raise PersonError(
            f"{name}: the key {key} is encrypted with a password",
            f"openssl pkey -in {key} -out open.key; chmod 600 open.key",
        ) from None
    except Exception:  # the library raises several classes for an unknown or damaged key
        raise PersonError(f"{name}: {key} holds no key in PEM", _order_hint(chain, secret)) from None
    shapes = [each.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)
              for each in (found.public_key(), private.public_key())]  # fmt: skip
    if shapes[0] != shapes[1]:
        raise PersonError(
            f"{name}: the key {key} does not belong to the certificate {certificate}",
            "put the certificate itself first in its file, then the intermediate certificates",
        )
    identity = TlsIdentity(
        chain,
        secret,
        _hosts(found),
        found.not_valid_before_utc,
        found.not_valid_after_utc,
        tuple(_permission_warnings(key)),
    )
    _check(identity, certificate, name)
    return identity


def _check(identity: TlsIdentity, certificate: Path, name: str) -> None:
    """Raise PersonError for keys that TLS refuses: too short, or of an unknown kind."""
    import ssl

    from live.control.tls import server_context

    try:
        server_context(identity.certificate, identity.key)
    except (ssl.SSLError, OSError) as error:
        raise PersonError(f"{name}: {certificate} cannot be served: {error}", "have a new one issued") from None


def _read(path: Path, name: str) -> bytes:
    try:
        data = read_regular_file(path, MAX_FILE_BYTES)
    except OSError as error:
        remedy = f"chown it to the show's user, and chmod 600 {path}" if isinstance(error, PermissionError) else None
        raise PersonError(f"{name}: cannot read {path}: {error.strerror}", remedy) from None
    except ValueError:
        raise PersonError(f"{name}: cannot read {path}: not a valid file name") from None
    if len(data) > MAX_FILE_BYTES:
        raise PersonError(f"{name}: {path} is larger than {MAX_FILE_BYTES} bytes: too large for a certificate or key")
    return data


def _order_hint(chain: bytes, secret: bytes) -> str:
    if b"PRIVATE KEY" in chain and b"BEGIN CERTIFICATE" in secret:
        return "give the certificate first, then its key"
    return "use files as from Let's Encrypt: fullchain.pem and privkey.pem"


def _hosts(certificate: "Certificate") -> tuple[str, ...]:
    from cryptography import x509

    try:
        found: Any = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, ValueError):
        return ()
    return (*found.get_values_for_type(x509.DNSName), *map(str, found.get_values_for_type(x509.IPAddress)))


def _permission_warnings(key: Path) -> list[str]:
    mode = stat.S_IMODE(key.stat().st_mode)
    return [f"other users can read the key {key} (mode {mode:o}): chmod 600 {key}"] if mode & 0o077 else []
