"""The systemd user unit that plays a show, with quoting as in systemd.syntax(7), and control of the user's systemd."""

import getpass
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.show.patch.patch_search_path import show_stem

NAME: Final = re.compile(r"[a-z0-9][a-z0-9_-]{0,39}")
KEPT_ENVIRONMENT: Final = (
    "PYTHONPATH",
    "LIVE_CACHE_DIR",
    "LIVE_CONFIG_DIR",
    "XDG_CACHE_HOME",
    "XDG_CONFIG_HOME",
    "PULSE_SERVER",
)
"""Environment variables copied into the unit when the service is installed."""
SCREEN_ENVIRONMENT: Final = ("DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY")
"""Further variables copied for a show with a window."""
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
{environment}# Start again after any end of the supervisor except by a user or by the ordinary end of the show.
Restart=on-failure
RestartSec=200ms
{steps}# 2: an error in the command line, where another start fails too; 130, 143, 129: SIGINT, SIGTERM, SIGHUP.
RestartPreventExitStatus=2
SuccessExitStatus=130 143 129
# The engine outlives a supervisor that crashes, and the next supervisor adopts it. When the service is stopped, the
# supervisor ends all processes in order.
KillMode=process
TimeoutStopSec=60
# If the kernel kills one process because memory is short, the supervisor replaces it.
OOMPolicy=continue

[Install]
WantedBy={wanted_by}
"""


@dataclass(frozen=True, slots=True)
class SystemdService:
    """A show that runs as a systemd user service."""

    name: str
    arguments: Sequence[str]
    """Arguments of `live play`."""
    folder: Path
    """The working directory of the command."""
    headless: bool
    environment: Mapping[str, str]

    def __post_init__(self) -> None:
        """Raise PersonError for an invalid name."""
        check_name(self.name)

    @property
    def unit(self) -> str:
        """The name of the unit."""
        return unit_name(self.name)

    def command(self) -> list[str]:
        """Return the command line that systemd runs."""
        return [sys.executable, "-m", "live", "play", "--service", self.name, *self.arguments]

    def text(self, *, version: int) -> str:
        """Return the unit's text. `version`: of systemd, because some settings need a newer one."""
        names = KEPT_ENVIRONMENT if self.headless else (*KEPT_ENVIRONMENT, *SCREEN_ENVIRONMENT)
        kept = [
            f"Environment={quote_word(f'{name}={self.environment[name]}')}\n"
            for name in names
            if name in self.environment
        ]
        target = "default.target" if self.headless else "graphical-session.target"
        order = "" if self.headless else f"After={target}\nPartOf={target}\n"
        return UNIT.format(
            name=_plain(self.name),
            order=order,
            command=" ".join(quote_word(each, command=True) for each in self.command()),
            folder=_plain(str(self.folder)).replace("%", "%%"),
            environment="".join(kept),
            steps="RestartSteps=10\nRestartMaxDelaySec=10s\n" if version >= 254 else "",
            wanted_by=target,
        )


def unit_name(name: str) -> str:
    """Return the unit name of the service."""
    return f"live-{check_name(name)}.service"


def check_name(name: str) -> str:
    """Return the name of a service; raise PersonError if it is invalid."""
    if NAME.fullmatch(name) is None:
        raise PersonError(
            f"the service's name {name!r}: 1 to 40 of a-z, 0-9, - and _ expected, a letter or digit first",
            "--name my-show",
        )
    return name


def default_service_name(patch: str | None) -> str:
    """Return a default service name for a patch."""
    return re.sub(r"[^a-z0-9_-]+", "-", show_stem(patch).lower()).strip("-_")[:40] or "show"


def quote_word(text: str, *, command: bool = False) -> str:
    """Quote one word for systemd; `command`: for a command line, where $ is special too."""
    text = _plain(text).replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%")
    if command:
        text = text.replace("$", "$$")
    return text if re.fullmatch(r"[\w@%+=:,./-]+", text, re.ASCII) else f'"{text}"'


def _plain(text: str) -> str:
    """Return the text; raise PersonError if it has characters that a line of a unit cannot hold."""
    if any(ord(mark) < 32 or ord(mark) == 127 or 0xD800 <= ord(mark) < 0xE000 for mark in text):
        raise PersonError(f"{text!r}: a systemd unit cannot contain control characters or bytes that are not text")
    return text


def units_folder() -> Path:
    """Return the folder of the user's systemd units."""
    base = os.environ.get("XDG_CONFIG_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".config") / "systemd" / "user"


def systemctl(*words: str) -> str | None:
    """Run a command of the user's systemd; return None, or the error."""
    try:
        done = subprocess.run(
            ["systemctl", "--user", "--no-ask-password", *words], capture_output=True, text=True, timeout=90
        )
    except FileNotFoundError:
        return "there is no systemctl on this machine"
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return None if done.returncode == 0 else " ".join(done.stderr.split())[:300] or f"exit code {done.returncode}"


def unit_state(unit: str) -> str:
    """Return the state of a unit in words."""
    words = ["show", "--property=ActiveState,SubState,NRestarts,MainPID", unit]
    try:
        done = subprocess.run(["systemctl", "--user", *words], capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return "installed; systemd does not answer here"
    properties = dict(line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
    if done.returncode or "ActiveState" not in properties:
        return "installed; systemd does not answer here"
    process = f", process {properties['MainPID']}" if properties.get("MainPID", "0") != "0" else ""
    state = f"{properties['ActiveState']} ({properties.get('SubState')}){process}"
    return f"{state}, restarted {properties.get('NRestarts', '0')} times"


def systemd_version() -> int:
    """Return the version of systemd; 0 if there is none."""
    try:
        done = subprocess.run(["systemctl", "--version"], capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired):
        return 0
    found = re.match(r"systemd (\d{1,6})", done.stdout)
    return 0 if found is None else int(found[1])


def linger_enabled() -> bool:
    """Whether the services of this user outlive a logout."""
    try:
        return Path("/var/lib/systemd/linger", getpass.getuser()).exists()
    except (OSError, KeyError):
        return False
