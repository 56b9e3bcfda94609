"""Machines made of small scripts for the tests of tools/setup.sh: fixtures `machine` and `debian`."""

import shutil
import stat
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.places import ROOT

SETUP = ROOT / "tools" / "setup.sh"
REAL_TOOLS = [
    "sh",
    "cat",
    "cksum",
    "tr",
    "dirname",
    "grep",
    "find",
    "env",
    "rm",
    "cp",
    "mkdir",
    "chmod",
    "touch",
    "true",
]

# A Python that knows its version, makes a .venv of copies of itself, and "installs" uv, which "installs" live.
PYTHON = """#!/bin/sh
echo "python $*" >>"$LOG"
case "$*" in
  *sys.version_info*) echo "$FAKE_PYTHON" ;;
  *ensurepip,*) [ -e "$INSTALLED/python$FAKE_PYTHON-venv" ] ;;
  "-m venv .venv") mkdir -p .venv/bin && cp "$0" .venv/bin/python ;;
  "-m pip install"*) cp "$MACHINE/fake-uv" .venv/bin/uv ;;
esac
"""
UV = """#!/bin/sh
echo "uv $*" >>"$LOG"
case "$*" in *--extra=link*) [ -z "$FAKE_NO_LINK" ] || exit 1 ;; esac
cp "$MACHINE/fake-live" .venv/bin/live
"""
LIVE = """#!/bin/sh
echo "live $*" >>"$LOG"
mkdir -p "$MACHINE/kernels"
echo "$MACHINE/kernels" >"$3"
"""
APT_GET = """#!/bin/sh
echo "apt-get $*" >>"$LOG"
case "$*" in *update*) touch "$MACHINE/updated"; exit 0 ;; esac
for word in "$@"; do
  case $word in install | -*) continue ;; esac
  case " $FAKE_UNINSTALLABLE " in *" $word "*) exit 100 ;; esac
done
for word in "$@"; do
  case $word in install | -*) ;; *) touch "$INSTALLED/$word" ;; esac
done
"""
# Without lists (before `apt-get update`) apt knows nothing; FAKE_UNKNOWN are names that this release does not have.
APT_CACHE = """#!/bin/sh
[ -e "$MACHINE/updated" ] || exit 100
for word in "$@"; do :; done
case " $FAKE_UNKNOWN " in *" $word "*) exit 100 ;; esac
echo "Package: $word"
echo "Filename: pool/$word.deb"
"""
DPKG_QUERY = """#!/bin/sh
for word in "$@"; do :; done
[ -e "$INSTALLED/$word" ] || exit 1
echo installed
"""
LINK_WHEEL = 'url = "https://files.invalid/linkpython_extern-1.3.0-cp3{minor}-cp3{minor}-manylinux_2_28_x86_64.whl"\n'
"""Lines of the lock."""
ASK_INSTALLED = """#!/bin/sh
for word in "$@"; do :; done
[ -e "$INSTALLED/$word" ]
"""


@dataclass(frozen=True, slots=True)
class Machine:
    """A checkout in `home`/show and a PATH of fakes; `run` returns the stderr of setup.sh."""

    home: Path
    environment: dict[str, str]

    def add(self, name: str, text: str) -> None:
        path = self.home / "bin" / name
        path.write_text(text)
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    def run(self, mode: str, code: int = 0, **environment: str) -> str:
        done = subprocess.run(
            [str(self.home / "show" / "tools" / "setup.sh"), mode],
            env=self.environment | environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == code, done.stderr
        return done.stderr

    def log(self) -> list[str]:
        """Commands with effects since the last call."""
        path = self.home / "log"
        lines = path.read_text().splitlines() if path.exists() else []
        path.unlink(missing_ok=True)
        return [line for line in lines if not line.startswith("python -c")]


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    show = tmp_path / "show"
    for folder in ("bin", "installed", "show/tools", "show/live/base"):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(SETUP, show / "tools" / "setup.sh")
    for name in ("pyproject.toml", "tools/uv-requirements.txt", "live/base/scalar_kernels.py"):
        (show / name).write_text(name)
    (show / "uv.lock").write_text("".join(LINK_WHEEL.format(minor=minor) for minor in (11, 12, 13)))
    for tool in REAL_TOOLS:
        where = shutil.which(tool)
        assert where is not None
        (tmp_path / "bin" / tool).symlink_to(where)
    environment = {
        "PATH": str(tmp_path / "bin"),
        "HOME": str(tmp_path),
        "MACHINE": str(tmp_path),
        "INSTALLED": str(tmp_path / "installed"),
        "LOG": str(tmp_path / "log"),
        "FAKE_PYTHON": "3.11",
        "FAKE_UNKNOWN": "libasound2t64",
        "FAKE_UNINSTALLABLE": "",
        "FAKE_NO_LINK": "",
    }
    made = Machine(tmp_path, environment)
    made.add("python3", PYTHON)
    made.add("id", "#!/bin/sh\necho 1000\n")
    for name, text in (("fake-uv", UV), ("fake-live", LIVE)):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    return made


@pytest.fixture
def debian(machine: Machine) -> Machine:
    for name, text in (("apt-get", APT_GET), ("apt-cache", APT_CACHE), ("dpkg-query", DPKG_QUERY)):
        machine.add(name, text)
    return machine


def make_root(machine: Machine) -> None:
    machine.add("id", "#!/bin/sh\necho 0\n")
