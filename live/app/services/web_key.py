"""The key of the operator's page: who brings it may do with the show whatever the page can.

It is made once and kept in the user's folder of settings, so that a tablet that was let in yesterday is let in today.
"""

import contextlib
import errno
import os
import re
import secrets
import stat
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from live.app.option_values import parse_endpoint
from live.base.errors import PersonError
from live.base.host_name import HOST_NAME
from live.show.patch.patch_search_path import user_settings

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
