"""The text of a systemd user unit that plays a show, and how words are written in one (systemd.syntax(7))."""

import os
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError

NAME: Final = re.compile(r"[a-z0-9][a-z0-9_-]{0,39}")
PLACES: Final = ("PYTHONPATH", "LIVE_CACHE_DIR", "LIVE_CONFIG_DIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "PULSE_SERVER")
"""What is kept of the environment in which the service is installed, ..."""
SCREEN: Final = ("DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY")
"""... and of a show with a window."""
OWN_JOURNAL: Final = "--journal"

UNIT: Final = """\
# Written by `live service install`; install it again to change it.
[Unit]
Description=Live: {name}
{order}StartLimitIntervalSec=60
StartLimitBurst=30

[Service]
Type=exec
ExecStart={command}
WorkingDirectory={folder}
{environment}# Whatever ends the supervisor but a person and an ordinary end of the show: it is begun again.
Restart=on-failure
RestartSec=200ms
{steps}# 2: an error in the command line, which another start does not mend; 130, 143, 129: SIGINT, SIGTERM, SIGHUP.
RestartPreventExitStatus=2
SuccessExitStatus=130 143 129
# The engine outlives the supervisor, and the next supervisor takes it over; when the service is stopped, the supervisor
# ends all in order.
KillMode=process
TimeoutStopSec=60
# One process that was killed because memory is short is the supervisor's to replace.
OOMPolicy=continue

[Install]
WantedBy={wanted_by}
"""


@dataclass(frozen=True, slots=True)
class Service:
    """A show that the user's systemd plays."""

    name: str
    arguments: Sequence[str]
    """Of `live play`."""
    folder: Path
    """In which the command runs."""
    headless: bool
    environment: Mapping[str, str]

    def __post_init__(self) -> None:
        """PersonError for a name that is none."""
        check_name(self.name)

    @property
    def unit(self) -> str:
        """The name of its unit."""
        return unit_name(self.name)

    def command(self) -> list[str]:
        """What systemd runs."""
        return [sys.executable, "-m", "live", "play", "--service", self.name, *self.arguments]

    def text(self, *, version: int) -> str:
        """The unit; `version`: of systemd, for what is newer."""
        names = PLACES if self.headless else (*PLACES, *SCREEN)
        kept = [
            f"Environment={word(f'{name}={self.environment[name]}')}\n" for name in names if name in self.environment
        ]
        target = "default.target" if self.headless else "graphical-session.target"
        order = "" if self.headless else f"After={target}\nPartOf={target}\n"
        return UNIT.format(
            name=_plain(self.name),
            order=order,
            command=" ".join(word(each, command=True) for each in self.command()),
            folder=_plain(str(self.folder)).replace("%", "%%"),
            environment="".join(kept),
            steps="RestartSteps=10\nRestartMaxDelaySec=10s\n" if version >= 254 else "",
            wanted_by=target,
        )


def unit_name(name: str) -> str:
    """The unit of the service of that name."""
    return f"live-{check_name(name)}.service"


def check_name(name: str) -> str:
    """A service's name; PersonError for what cannot be one."""
    if NAME.fullmatch(name) is None:
        raise PersonError(
            f"the service's name {name!r}: 1 to 40 of a-z, 0-9, - and _ expected, a letter or digit first",
            "--name my-show",
        )
    return name


def name_for(patch: str | None) -> str:
    """A name for the service of a patch."""
    stem = "first-show" if patch is None else Path(patch).stem
    if stem == "show" and patch is not None:
        stem = Path(patch).resolve().parent.name
    return re.sub(r"[^a-z0-9_-]+", "-", stem.lower()).strip("-_")[:40] or "show"


def word(text: str, *, command: bool = False) -> str:
    """One word as systemd reads it again; `command`: in a command line, where $ means something, too."""
    text = _plain(text).replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%")
    if command:
        text = text.replace("$", "$$")
    return text if re.fullmatch(r"[\w@%+=:,./-]+", text, re.ASCII) else f'"{text}"'


def _plain(text: str) -> str:
    """A text without characters that no line of a unit can hold; PersonError otherwise."""
    if any(ord(mark) < 32 or ord(mark) == 127 or 0xD800 <= ord(mark) < 0xE000 for mark in text):
        raise PersonError(f"{text!r}: a control character, or bytes that are no text, cannot be in a unit of systemd")
    return text


def units_folder() -> Path:
    """Where the user's units lie."""
    base = os.environ.get("XDG_CONFIG_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".config") / "systemd" / "user"
