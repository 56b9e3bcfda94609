"""HttpPart: a part of a live show that answers over HTTP, in a process of its own that is told the show's values.

The part of a live show that other programs find by themselves: OSCQuery over HTTP, and zeroconf.

The key of the operator's page: who brings it may do with the show whatever the page can.

It is made once and kept in the user's folder of settings, so that a tablet that was let in yesterday is let in today.

How others in the network reach this machine.

The part of a live show that its operator opens in a browser.
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
from typing import Any, Final

from rich.console import Console

from live.app.option_values import parse_endpoint
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.host_name import HOST_NAME
from live.clock.time_source import Clock
from live.control.helper_process import Helper
from live.control.registry.registry import Changes
from live.show.desk.completions import names_in
from live.show.patch.patch_search_path import user_settings
from live.show.show import Show

AT_ONCE: Final = 64
"""Addresses that are told in one packet."""
BACKLOG: Final = 128
"""Connections that wait until the process accepts them."""


class HttpPart:
    """Between the show and the process that answers. Thread: the one that runs the show."""

    def __init__(
        self, where: tuple[str, int], option: str, module: str, plan: Callable[[], dict[str, Any]], clock: Clock,
        *, needs: Sequence[str] = ("aiohttp",),
    ) -> None:  # fmt: skip
        """`module` is the process, `plan` what it reads first beside its socket (`http`); `needs`: packages."""
        self._where, self._option, self._module, self._plan, self._clock = where, option, module, plan, clock
        self._needs = needs
        self.goes_on = False
        """Whether the show goes on after an engine that may hold the port still."""
        self._socket: socket.socket | None = None
        self._helper: Helper | None = None
        self._all: dict[str, Any] = {}
        self._untold: dict[str, Any] = {}

    def start(self) -> None:
        """Listen, and begin to answer; PersonError if that cannot be."""
        missing = [name for name in self._needs if importlib.util.find_spec(name) is None]
        if missing:
            raise PersonError(f"{self._option} needs the package {' and '.join(missing)}", "make play installs it")
        self._socket = self._listening()
        http = self._socket.fileno()
        self._helper = Helper(self._module, self._clock, self._plan() | {"http": http}, self._anew, http)
        self._helper.start()

    def _listening(self) -> socket.socket:
        try:
            return listening_socket(self._where, BACKLOG, goes_on=self.goes_on)
        except (OSError, OverflowError) as error:
            where = f"{self._where[0]}:{self._where[1]}"
            raise PersonError(f"{self._option} {where}: {error}", "choose another port") from None

    def stop(self) -> None:
        """Answer nobody any more."""
        if self._helper is not None:
            self._helper.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def tell(self, changes: Changes) -> None:
        """These have new values in the show."""
        self._all.update(changes)
        self._untold.update(changes)

    def _anew(self) -> None:
        self._untold = dict(self._all)

    def frame(self) -> None:
        """After each frame: pass on what has changed, a little at a time."""
        if self._helper is None:
            return
        self._helper.frame()
        if self._untold:
            some = {address: self._untold[address] for address in list(self._untold)[:AT_ONCE]}
            if self._helper.send(some):
                for address in some:
                    del self._untold[address]

    @property
    def port(self) -> int:
        """Where it answers."""
        return self._where[1] if self._socket is None else int(self._socket.getsockname()[1])

    @property
    def process(self) -> int | None:
        """The number of the process that answers; None while there is none."""
        return None if self._helper is None else self._helper.process

    def status(self) -> dict[str, Any]:
        """For the status line."""
        return {} if self._helper is None else self._helper.facts()


class OscQueryPart(HttpPart):
    """Between the show and the process that answers OSCQuery."""

    def __init__(
        self, where: tuple[str, int], osc: tuple[str, int], name: str, clock: Clock, *, hosts: Sequence[str] = ()
    ) -> None:
        """`osc`: where the show listens; `hosts`: see `accepted_hosts`."""
        super().__init__(
            where, "--oscquery", "live.control.osc.oscquery_server",
            lambda: {"osc": osc, "name": name, "hosts": list(hosts)}, clock, needs=("aiohttp", "zeroconf"),
        )  # fmt: skip


MADE_BYTES: Final = 16
"""Of chance in a key that is made here."""
SHORTEST: Final = 16
LONGEST: Final = 128
LETTERS: Final = 6
"""A key has so many different characters at least."""
_KEY: Final = re.compile(rf"[A-Za-z0-9._~-]{{{SHORTEST},{LONGEST}}}")
_RULE: Final = f"{SHORTEST} to {LONGEST} letters, digits and . _ ~ - expected, {LETTERS} different ones at least"


@dataclass(frozen=True, slots=True)
class WebAccess:
    """Where the operator's page is served, to whom, and by which names."""

    where: tuple[str, int] | None
    """None: nowhere."""
    key: str = field(default="", repr=False)
    hosts: tuple[str, ...] = ()
    """Names by which this machine is reached beside its addresses; OSCQuery has them, too."""


def parse_web(
    web: str | None, *, key: str | None, new_key: bool, hosts: Sequence[str],
    note: Callable[[str], None] = lambda words: None,
) -> WebAccess:  # fmt: skip
    """What the command line says of the page, with the key that is kept if it gives none; PersonError otherwise."""
    for host in hosts:
        if re.fullmatch(HOST_NAME, host) is None:
            raise PersonError(f"--web-host {host[:80]!r}: NAME or NAME:PORT expected", "--web-host show.example")
    if web is None:
        if new_key:
            raise PersonError("--new-web-key: there is no page without --web", "--web 8010 --new-web-key")
        return WebAccess(None, hosts=tuple(hosts))
    where = parse_endpoint(web, "--web")
    if key is None:
        return WebAccess(where, kept_key(fresh=new_key, note=note), tuple(hosts))
    if new_key:
        raise PersonError("--new-web-key: a key was given (--web-key, LIVE_WEB_KEY)", "leave out one of them")
    return WebAccess(where, own_key(key, "--web-key"), tuple(hosts))


def key_file() -> Path:
    """Where the key is kept."""
    return user_settings() / "web-key"


def own_key(text: str, where: str) -> str:
    """A key that a person has chosen; PersonError for what is none, which names `where` it stands and not the key."""
    if _KEY.fullmatch(text) is None or len(set(text)) < LETTERS:
        raise PersonError(f"{where}: that is no key: {_RULE}", "leave it out: a good one is made")
    return text


def kept_key(*, fresh: bool = False, note: Callable[[str], None] = lambda words: None) -> str:
    """The key that is kept, made if there is none yet, or if a `fresh` one is wanted.

    PersonError where others than its owner may read it, or something else stands there. Where nothing can be kept it is
    for this show alone, and `note` gets that in words.
    """
    path = key_file()
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = None if fresh else _read(path)
        return _write(path, replace=fresh) if found is None else found
    except OSError as error:
        note(f"the key of the operator's page is for this show alone: {path}: {error.strerror or error}")
        return secrets.token_urlsafe(MADE_BYTES)


def _read(path: Path) -> str | None:
    """The key in the file; None if there is none."""
    wrong = PersonError(
        f"{path}: the key of the operator's page has to be a file, no link, yours, that nobody else may read",
        "--new-web-key makes another one",
    )
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise wrong from None
        raise
    try:
        facts = os.fstat(descriptor)
        if not stat.S_ISREG(facts.st_mode) or facts.st_uid != os.geteuid() or facts.st_mode & 0o077:
            raise wrong
        text = os.read(descriptor, LONGEST + 2)
    finally:
        os.close(descriptor)
    try:
        return own_key(text.decode("ascii").rstrip("\n"), f"{path}, line 1")
    except (PersonError, UnicodeDecodeError):
        raise PersonError(f"{path}, line 1: that is no key: {_RULE}", "--new-web-key makes another one") from None


def _write(path: Path, *, replace: bool) -> str:
    """A new key, whole in its file at once; where another show has just made one and none is to be replaced, that."""
    key = secrets.token_urlsafe(MADE_BYTES)
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
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
                return _read(path) or key
    finally:
        with contextlib.suppress(FileNotFoundError):
            beside.unlink()
    return key


def own_address() -> str:
    """This machine's address in its network: that from which it would send (nothing is sent), or, where no way leads
    out of the hall, the first that it has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking, contextlib.suppress(OSError):
        asking.connect(("192.0.2.1", 9))
        return str(asking.getsockname()[0])
    with contextlib.suppress(ImportError, OSError):
        import ifaddr

        found = [str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
        return next((address for address in found if not address.startswith("127.")), "127.0.0.1")
    return "127.0.0.1"


class WebPart(HttpPart):
    """Between the show and the process that serves the operator's page."""

    def __init__(
        self, where: tuple[str, int], key: str, osc: tuple[str, int], show: Show, clock: Clock, *,
        hosts: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """`key`: without it nobody gets in; `osc`: where the show itself listens; `hosts`: see `accepted_hosts`."""
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(osc[0], osc[0])

        def plan() -> dict[str, Any]:
            stage = show.patch.stage
            return {
                "key": key, "osc": (host, osc[1]), "name": show.patch.name, "names": names_in(show),
                "half": (0.5 * stage.width, 0.5 * stage.depth), "hosts": list(hosts),
            }  # fmt: skip

        super().__init__(where, "--web", "live.control.web.web_server", plan, clock)
        self._key = key

    def start(self) -> None:
        """Listen, begin to answer, and say where; PersonError if that cannot be."""
        super().start()
        link = f"http://{_reached_at(self._where[0])}:{self.port}/#key={self._key}"
        Console(stderr=True, highlight=False).print(f"operator's page: {link}", soft_wrap=True, markup=False)


def _reached_at(host: str) -> str:
    """The address that somebody else would write for a host that means all of this machine's."""
    if host not in ("0.0.0.0", "::"):
        return f"[{host}]" if ":" in host else host
    return own_address()
