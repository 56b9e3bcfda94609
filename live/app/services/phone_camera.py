"""The port for phones that are cameras: its address, its certificate, the link with its key and the link's code.

A browser opens a camera only on a page that came over https. The certificate is the audience's where there is one. Else
this machine makes one, of which the phone warns once; it is kept, so that the phone's consent lasts.
"""

import contextlib
import ipaddress
import os
import socket
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from live.app.services.audience_service import tls_files
from live.app.services.audience_tls import TlsIdentity, read_identity
from live.app.services.http_services import BACKLOG, own_address
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.system.channel import hand_over
from live.base.system.files import create_private
from live.control.camera.model_files import phone_folder
from live.control.web.camera_pages import CAMERA_PATH, camera_key
from live.control.web.http_protection import mdns_name
from live.show.patch.patch_search_path import user_settings_folder
from live.show.venue.venue_audience import VenueAudience

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions

OPTION: Final = "--phone-camera"
CERTIFICATE_FILE: Final = "phone-camera.pem"
VALID: Final = timedelta(days=800)
"""Validity of an own certificate; some phones refuse more than 825 days."""
RENEW_BEFORE: Final = timedelta(days=14)


class PhoneCameraPort:
    """The port at which phones open the camera page. Thread: the show's."""

    def __init__(self, options: "LaunchOptions", venue: VenueAudience | None, key: str) -> None:
        """`key`: of the operator's page. Raises PersonError where there is no model or no valid certificate."""
        assert options.phone_camera is not None
        self._where, self._key = options.phone_camera, key
        folder = phone_folder()
        if folder is None:
            raise PersonError(
                f"{OPTION}: the pose model for browsers is not on this machine",
                "live camera models gets it once; nothing is loaded during a show",
            )
        self._folder = folder
        files = tls_files(options, venue or VenueAudience())
        self._own = files is None
        host = own_address() if self._where[0] in ("0.0.0.0", "::") else self._where[0]
        self.identity = own_identity(host) if files is None else read_identity(*files, OPTION)
        named = host in self.identity.names or self.identity.host is None
        self._host = host if named else str(self.identity.host)
        self._socket: socket.socket | None = None
        self._port = self._where[1]

    def listen(self, *, resumes: bool) -> tuple[dict[str, Any], tuple[int, ...]]:
        """Listen; return what the web server has to know, and the descriptors that it inherits. PersonError if that
        fails. `resumes`: see `listening_socket`."""
        try:
            self._socket = listening_socket(self._where, BACKLOG, resumes=resumes)
        except (OSError, OverflowError) as error:
            where = f"{self._where[0]}:{self._where[1]}"
            raise PersonError(f"{OPTION} {where}: {error}", "choose another port") from None
        self._port = int(self._socket.getsockname()[1])
        https, inherit = hand_over(self._socket)
        told = {
            "https": https, "certificate": (self.identity.certificate, self.identity.key), "hosts": [self._host],
            "folder": str(self._folder), "link": self.link, "code": link_code(self.link),
        }  # fmt: skip
        return told, inherit

    @property
    def link(self) -> str:
        """The link that a phone opens, with its key."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"https://{host}:{self._port}{CAMERA_PATH}#key={camera_key(self._key.encode())}"

    def print_link(self) -> None:
        """Print the link, and warnings about the certificate."""
        console = Console(stderr=True, highlight=False, soft_wrap=True)
        console.print(f"camera of a phone: {self.link}", markup=False)
        for words in self.identity.warnings(datetime.now(UTC), self._host):
            console.print(f"camera of a phone: {words}", style="bold red", markup=False)
        if self._own:
            words = "its certificate is this machine's own: the phone warns of it once"
            console.print(f"note: camera of a phone: {words} (live docs phone-camera)", style="yellow", markup=False)

    def close(self) -> None:
        """Close the port."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def link_code(link: str) -> str:
    """Return a link's QR code as the address of a picture."""
    import segno

    code: str = segno.make(link, error="m", micro=False).svg_data_uri(scale=4, border=4, light="#fff")
    return code


def own_identity(host: str) -> TlsIdentity:
    """Return this machine's own certificate for browsers, valid for `host`, localhost and the machine's local name.

    It is kept in the user's settings folder, and made anew when it does not name `host` or expires soon. PersonError if
    it cannot be kept.
    """
    path = user_settings_folder() / CERTIFICATE_FILE
    names = list(dict.fromkeys([host, mdns_name(), "localhost", "127.0.0.1"]))
    with contextlib.suppress(PersonError):
        found = read_identity(path, path, OPTION)
        if set(names) <= set(found.names) and datetime.now(UTC) < found.valid_until - RENEW_BEFORE:
            return found
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _write_identity(path, names)
    except OSError as error:
        raise PersonError(f"{OPTION}: {path} cannot be written: {error.strerror or error}") from None
    return read_identity(path, path, OPTION)


def _write_identity(path: Path, names: list[str]) -> None:
    """Write a new key with a certificate for these host names and addresses, atomically."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    key = ec.generate_private_key(ec.SECP256R1())  # browsers do not know Ed25519
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"ChoreoGraphics Live {names[0]}"[:64])])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder(
            name, name, key.public_key(), x509.random_serial_number(), now - timedelta(days=1), now + VALID
        )
        .add_extension(x509.SubjectAlternativeName([_general_name(each) for each in names]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    private = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        beside.unlink()
    try:
        with open(create_private(beside), "wb") as file:
            file.write(private + made.public_bytes(pem))
        beside.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            beside.unlink()


def _general_name(name: str) -> Any:
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
