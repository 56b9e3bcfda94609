"""Check that what Windows or macOS lacks is named in `live/base/system/` and in listed modules only."""

import ast
import re
import sys
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import pytest

from tests.fixtures.source_trees import parse

LIVE = Path(__file__).resolve().parents[3] / "live"
SYSTEM_FOLDER = "base/system/"

LINUX_MODULES = {
    "app/machine/systemd_unit.py": "systemd of Linux: `live service`",
    "app/machine/machine_check.py": "names of packages of Debian",
    "supervisor/prefork.py": "forks; `become_subreaper` says no elsewhere",
    "supervisor/process_stats.py": "reads /proc; says nothing where there is none",
    "supervisor/cpu_priority.py": "asks the scheduler of Linux; does nothing elsewhere",
    "supervisor/adoption/": "passes descriptors; without them there is no meeting point",
    "supervisor/network/remote_standby.py": "reads its own delay in /proc, as --lead and --standby need Linux",
    "control/realtime_priority.py": "asks the scheduler of Linux; does nothing elsewhere",
    "control/osc/udp_batch.py": "recvmmsg of Linux; one call for each datagram elsewhere",
    "control/audience/arp_table.py": "netlink of Linux",
    "control/midi/": "ALSA and JACK of Linux; other systems have their own ports",
    "render/window/fallback_window.py": "the colour of an X11 window before its first frame",
    "render/window/screensaver.py": "each system's own way to keep the screen on",
    "rehearse/chaos/": "`live chaos` kills and stops the processes of a show on Linux",
}
"""Folders and files below `live` that may name what only Linux has, with what they do on other systems."""

POSIX_MODULES = {"fcntl", "resource", "termios", "tty", "pty", "pwd", "grp", "syslog", "posix", "readline"}
"""Modules of the standard library that Windows lacks."""


def words(text: str) -> set[str]:
    """The words of a text."""
    return set(text.split())


LACKING = {
    "os": words("""
        fork forkpty getuid geteuid getgid getegid getgroups getpgid getpgrp getsid setsid setuid setgid setpgid killpg
        nice getpriority setpriority PRIO_PROCESS sched_getaffinity sched_setaffinity sched_setscheduler sched_param
        SCHED_OTHER SCHED_BATCH SCHED_FIFO SCHED_RR sched_yield getloadavg sysconf confstr uname ttyname ctermid
        memfd_create mkfifo mknod pipe2 posix_spawn posix_spawnp posix_fallocate posix_fadvise sendfile splice
        waitid wait wait3 wait4 WNOHANG WEXITED WNOWAIT P_ALL pidfd_open chown lchown fchown fchdir chroot
        O_NOFOLLOW O_DIRECTORY O_CLOEXEC O_NONBLOCK O_PATH O_TMPFILE O_DSYNC getrandom eventfd pread pwrite readv
        writev preadv pwritev sync fdatasync statvfs fstatvfs getxattr setxattr listxattr tcgetpgrp set_blocking
        get_blocking register_at_fork EX_OK EX_USAGE EX_SOFTWARE fchmod openpty
    """),
    "signal": words("""
        SIGKILL SIGHUP SIGUSR1 SIGUSR2 SIGSTOP SIGCONT SIGCHLD SIGALRM SIGPIPE SIGQUIT SIGTSTP SIGWINCH SIGIO alarm
        setitimer pause pthread_kill pthread_sigmask sigwait sigwaitinfo sigtimedwait pidfd_send_signal siginterrupt
    """),
    "socket": words("""
        AF_UNIX AF_NETLINK AF_PACKET SOCK_SEQPACKET SOCK_CLOEXEC SOCK_NONBLOCK send_fds recv_fds SCM_RIGHTS
        SO_REUSEPORT SO_PEERCRED SO_BINDTODEVICE MSG_NOSIGNAL MSG_DONTWAIT MSG_TRUNC CMSG_SPACE CMSG_LEN
    """),
    "select": words("poll epoll kqueue EPOLLIN POLLIN"),
    "selectors": words("PollSelector EpollSelector KqueueSelector DevpollSelector"),
    "time": words("clock_gettime clock_gettime_ns CLOCK_MONOTONIC CLOCK_REALTIME pthread_getcpuclockid tzset"),
    "asyncio": words("open_unix_connection start_unix_server get_child_watcher"),
    "multiprocessing": words("get_context set_start_method"),
}
"""Names of modules that every system has; Windows or macOS lacks them, or may not be asked so."""
LOOP_METHODS = words("add_signal_handler create_unix_server create_unix_connection recvmsg sendmsg recvmsg_into")
POPEN_ARGUMENTS = words("pass_fds preexec_fn start_new_session process_group")
LOADERS = words("CDLL WinDLL windll")
LINUX_PATHS = ("/proc", "/sys/", "/dev/", "/tmp", "/etc/", "/run/", "/usr/", "/var/")

NAMED = re.compile(
    rf"\b({'|'.join(sorted({*POSIX_MODULES, *LOOP_METHODS, *POPEN_ARGUMENTS, *LOADERS, *chain(*LACKING.values())}))})\b"
    rf"|\bos\.name\b|\bsys\.platform\b|{'|'.join(LINUX_PATHS)}"
)
"""What a text with a foreign name contains; most modules contain nothing of it and are not parsed."""


def foreign_names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield the lines and names of what some system lacks."""
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                yield from ((node.lineno, one.name) for one in names if one.name in POSIX_MODULES)
            case ast.ImportFrom(module=str(module), names=names):
                every = module in POSIX_MODULES
                wrong = LACKING.get(module, set()) | LOADERS
                yield from ((node.lineno, f"{module}.{one.name}") for one in names if every or one.name in wrong)
            case ast.Attribute(value=ast.Name(id=module), attr=name):
                if name in LACKING.get(module, ()) or f"{module}.{name}" in ("os.name", "sys.platform"):
                    yield node.lineno, f"{module}.{name}"
                elif name in LOADERS | LOOP_METHODS:
                    yield node.lineno, name
            case ast.Attribute(attr=name) if name in LOOP_METHODS:
                yield node.lineno, name
            case ast.keyword(arg=str(name)) if name in POPEN_ARGUMENTS:
                yield node.value.lineno, name
            case ast.Constant(value=str(text)) if text.startswith(LINUX_PATHS) and id(node) not in docstrings:
                yield node.lineno, text[:20]


def sources() -> list[Path]:
    """The modules of the program other than those of the system folder and of Linux."""
    found = []
    for path in sorted(path for path in LIVE.rglob("*.py") if not path.is_relative_to(LIVE / "site")):
        name = path.relative_to(LIVE).as_posix()
        if not name.startswith((SYSTEM_FOLDER, *LINUX_MODULES)) and not path.name.startswith("test_"):
            found.append(path)
    return found


def test_only_the_folder_of_systems_names_what_some_system_lacks():
    found = [
        f"{path.relative_to(LIVE)}:{line}: {name}"
        for path in sources()
        if NAMED.search(path.read_text(encoding="utf-8"))
        for line, name in foreign_names(parse(path))
    ]
    assert not found, "through live/base/system/, please:\n" + "\n".join(found)


@pytest.mark.parametrize("source", [
    "import fcntl", "from fcntl import flock", "import os\nos.fork()", "from os import fork", "x = '/proc/self'",
    "import socket\nsocket.AF_UNIX", "import subprocess\nsubprocess.Popen([], pass_fds=[1])",
    "import sys\nsys.platform", "import signal\nsignal.SIGKILL", "import ctypes\nctypes.CDLL(None)",
    "from ctypes import CDLL", "import asyncio\nloop.add_signal_handler(1, f)",
])  # fmt: skip
def test_each_kind_is_seen(source):
    assert NAMED.search(source)
    assert [*foreign_names(ast.parse(source))]


def test_every_module_of_linux_exists_and_needs_its_place():
    for name in LINUX_MODULES:
        path = LIVE / name
        files = [path] if path.suffix else sorted(path.rglob("*.py"))
        assert any([*foreign_names(parse(file))] for file in files), name


@pytest.mark.skipif(sys.platform != "linux", reason="Linux has all of them")
def test_the_names_are_ones_of_the_standard_library():
    """A name that is misspelt would be looked for in vain."""
    import os
    import signal
    import socket

    known = {"os": os, "signal": signal, "socket": socket}
    missing = {name for module, there in known.items() for name in LACKING[module] if not hasattr(there, name)}
    assert not missing, missing
