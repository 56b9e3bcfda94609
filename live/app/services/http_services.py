"""Services over HTTP in separate processes: their base, and the access key of the operator's page.

The access key of the web page permits everything that the page can do. It is created once and kept in the user's
settings folder, so that a browser that has it keeps its access.
"""

import contextlib
import errno
import importlib.util
import os
import re
import secrets
import socket
import stat
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from live.app.option_values import parse_endpoint
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.field_types import HOST_NAME_PATTERN
from live.base.system.channel import hand_over
from live.base.system.files import create_private, is_private, open_to_read
from live.clock.time_source import Clock
from live.control.helper_process import HelperProcess
from live.show.patch.patch_search_path import user_settings_folder

if TYPE_CHECKING:
    from live.control.registry.registry import Changes

ADDRESSES_PER_PACKET: Final = 64
"""Maximum number of addresses in one packet."""
BACKLOG: Final = 128
"""Queue of connections that the process has not accepted yet."""


class HttpService:
    """Runs a process that answers over HTTP, and sends it the show's values. Thread: the show's."""

    def __init__(
        self, bind_address: tuple[str, int], option: str, module: str, plan: Callable[[], dict[str, Any]], clock: Clock,
        *, needs: Sequence[str] = ("aiohttp",),
    ) -> None:  # fmt: skip
        """`module`: of the process; `plan`: its first message, besides its socket (`http`); `needs`: packages."""
        self._bind_address, self._option, self._module, self._plan, self._clock = (
            bind_address,
            option,
            module,
            plan,
            clock,
        )
        self._needs = needs
        self.resumes = False
        """Whether the show is resumed after an engine that may still hold the port."""
        self._port = bind_address[1]
        self._socket: socket.socket | None = None
        self._helper: HelperProcess | None = None
        self._values: dict[str, Any] = {}
        self._unsent: dict[str, Any] = {}

    def start(self) -> None:
        """Listen and start the process; raise PersonError if that fails."""
        missing = [name for name in self._needs if importlib.util.find_spec(name) is None]
        if missing:
            raise PersonError(f"{self._option} needs the package {' and '.join(missing)}", "make play installs it")
        self._socket = self._listen()
        self._port = int(self._socket.getsockname()[1])
        plan = self._plan()
        http, inherit = hand_over(self._socket)
        more, also = self._listen_also()
        self._helper = HelperProcess(
            self._module, self._clock, plan | {"http": http} | more, self._on_start, *inherit, *also,
            on_packet=self._on_packet,
        )  # fmt: skip
        self._helper.start()

    def _listen(self) -> socket.socket:
        try:
            return listening_socket(self._bind_address, BACKLOG, resumes=self.resumes)
        except (OSError, OverflowError) as error:
            where = f"{self._bind_address[0]}:{self._bind_address[1]}"
            raise PersonError(f"{self._option} {where}: {error}", "choose another port") from None

    def _listen_also(self) -> tuple[dict[str, Any], tuple[int, ...]]:
        """Listen at further ports; return what the process has to know of them, and the descriptors it inherits."""
        return {}, ()

    def stop(self) -> None:
        """Stop the process and close the port."""
        if self._helper is not None:
            self._helper.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def publish(self, changes: "Changes") -> None:
        """Queue changed values."""
        self._values.update(changes)
        self._unsent.update(changes)

    def _on_start(self) -> None:
        self._unsent = dict(self._values)

    def _on_packet(self, packet: Any) -> None:
        """Take a packet of the process, other than its facts."""

    def frame(self) -> None:
        """Send some of the changed values, after each frame."""
        if self._helper is None:
            return
        self._helper.frame()
        if self._unsent:
            some = {address: self._unsent[address] for address in list(self._unsent)[:ADDRESSES_PER_PACKET]}
            if self._helper.send(some):
                for address in some:
                    del self._unsent[address]

    @property
    def port(self) -> int:
        """The port it listens at."""
        return self._port

    @property
    def pid(self) -> int | None:
        """The id of the process; None while it does not run."""
        return None if self._helper is None else self._helper.pid

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return {} if self._helper is None else self._helper.status()


KEY_BYTES: Final = 16
"""Random bytes in a generated key."""
MIN_KEY_LENGTH: Final = 16
MAX_KEY_LENGTH: Final = 128
MIN_DISTINCT_LETTERS: Final = 6
"""Minimum number of different characters in a key."""
_KEY: Final = re.compile(rf"[A-Za-z0-9._~-]{{{MIN_KEY_LENGTH},{MAX_KEY_LENGTH}}}")
_KEY_RULE: Final = (
    f"{MIN_KEY_LENGTH} to {MAX_KEY_LENGTH} letters, digits and . _ ~ - expected, "
    f"{MIN_DISTINCT_LETTERS} different ones at least"
)


@dataclass(frozen=True, slots=True)
class WebAccess:
    """Address, access key and host names of the operator's web page."""

    bind_address: tuple[str, int] | None
    """None: no web page."""
    key: str = field(default="", repr=False)
    hosts: tuple[str, ...] = ()
    """Host names of this machine besides its addresses."""


def parse_web(
    web: str | None, *, key: str | None, new_key: bool, hosts: Sequence[str],
    note: Callable[[str], None] = lambda words: None,
) -> WebAccess:  # fmt: skip
    """Parse the options of the web page; the default key is the stored one. Raise PersonError for invalid options."""
    for host in hosts:
        if re.fullmatch(HOST_NAME_PATTERN, host) is None:
            raise PersonError(f"--web-host {host[:80]!r}: NAME or NAME:PORT expected", "--web-host show.example")
    if web is None:
        if new_key:
            raise PersonError("--new-web-key: there is no web page without --web", "--web 8010 --new-web-key")
        return WebAccess(None, hosts=tuple(hosts))
    where = parse_endpoint(web, "--web")
    if key is None:
        return WebAccess(where, stored_key(fresh=new_key, note=note), tuple(hosts))
    if new_key:
        raise PersonError("--new-web-key: a key was given (--web-key, LIVE_WEB_KEY)", "leave out one of the two")
    return WebAccess(where, check_key(key, "--web-key"), tuple(hosts))


def key_file() -> Path:
    """Return the path of the key's file."""
    return user_settings_folder() / "web-key"


def check_key(text: str, where: str) -> str:
    """Check and return a key chosen by a person; raise PersonError, which names `where` but not the key."""
    if _KEY.fullmatch(text) is None or len(set(text)) < MIN_DISTINCT_LETTERS:
        raise PersonError(f"{where}: invalid key: {_KEY_RULE}", "leave it out: a key is generated")
    return text


def stored_key(*, fresh: bool = False, note: Callable[[str], None] = lambda words: None) -> str:
    """Return the stored key; generate it if there is none or if `fresh` is set.

    Raise PersonError if other users may read the file, or if it is not a regular file. If the key cannot be stored, it
    is valid for this show only, and `note` is called with the reason.
    """
    path = key_file()
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = None if fresh else _read_key(path)
        return _write_key(path, replace=fresh) if found is None else found
    except OSError as error:
        note(f"the key of the operator's page is valid for this show only: {path}: {error.strerror or error}")
        return secrets.token_urlsafe(KEY_BYTES)


def _read_key(path: Path) -> str | None:
    """Read the key's file; return None if there is none."""
    wrong = PersonError(
        f"{path}: the key of the operator's page has to be a file, no link, owned by you and readable by you only",
        "--new-web-key generates a new one",
    )
    try:
        descriptor = open_to_read(path, follow=False)
    except FileNotFoundError:
        return None
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise wrong from None
        raise
    try:
        facts = os.fstat(descriptor)
        if not stat.S_ISREG(facts.st_mode) or not is_private(facts):
            raise wrong
        text = os.read(descriptor, MAX_KEY_LENGTH + 2)
    finally:
        os.close(descriptor)
    try:
        return check_key(text.decode("ascii").rstrip("\n"), f"{path}, line 1")
    except (PersonError, UnicodeDecodeError):
        raise PersonError(f"{path}, line 1: invalid key: {_KEY_RULE}", "--new-web-key generates a new one") from None


def _write_key(path: Path, *, replace: bool) -> str:
    """Generate a key and write its file atomically; return the key.

    If another show has just written one and `replace` is not set, return that one.
    """
    key = secrets.token_urlsafe(KEY_BYTES)
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    descriptor = create_private(beside)
    try:
        with open(descriptor, "w", encoding="ascii") as file:
            file.write(f"{key}\n")
            file.flush()
            os.fsync(descriptor)
        if replace:
            beside.replace(path)
        else:
            try:
                os.link(beside, path)
            except FileExistsError:
                return _read_key(path) or key
    finally:
        with contextlib.suppress(FileNotFoundError):
            beside.unlink()
    return key


def own_address() -> str:
    """Return this machine's address in its network.

    It is the source address of the default route (nothing is sent), or without a route the first address.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking, contextlib.suppress(OSError):
        asking.connect(("192.0.2.1", 9))
        return str(asking.getsockname()[0])
    with contextlib.suppress(ImportError, OSError):
        import ifaddr

        found = [str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
        return next((address for address in found if not address.startswith("127.")), "127.0.0.1")
    return "127.0.0.1"
