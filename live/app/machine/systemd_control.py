"""Control of the user's systemd: commands, and the state of services."""

import getpass
import re
import subprocess
from pathlib import Path

from live.app.machine.systemd_unit import unit_name
from live.app.processes.engine_main import service_label
from live.supervisor.adoption.adoption import end_engines


def stop_service(name: str) -> tuple[list[int], str | None]:
    """Stop the service, then any remaining engines; return their process ids, and systemd's error or None."""
    problem = systemctl("stop", unit_name(name))
    return end_engines(service_label(name)), problem


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
    told = dict(line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
    if done.returncode or "ActiveState" not in told:
        return "installed; systemd does not answer here"
    process = f", process {told['MainPID']}" if told.get("MainPID", "0") != "0" else ""
    return f"{told['ActiveState']} ({told.get('SubState')}){process}, restarted {told.get('NRestarts', '0')} times"


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
