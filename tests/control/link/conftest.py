"""A private network, and processes with Ableton Link that are controlled through pipes."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.places import ROOT

UP = "ip link set lo up; ip link set lo multicast on; ip route replace 224.0.0.0/4 dev lo"
NET = f"{UP}; echo ready; exec cat"


class Process:
    """A program with Link; `ask` sends one command and returns its answer."""

    def __init__(self, command: list[str]) -> None:
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1, cwd=ROOT, env=_environment()
        )

    def wait_until_ready(self) -> None:
        assert json.loads(self._line()) == {"ready": True}

    def ask(self, do: str = "look", **values: Any) -> dict[str, Any]:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps({"do": do, **values}) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self._line())
        assert isinstance(answer, dict)
        return answer

    def until(self, what: Callable[[dict[str, Any]], bool], seconds: float) -> dict[str, Any]:
        """Repeats the request until the answer is right; fails with the last answer after `seconds`."""
        deadline = time.monotonic() + seconds
        while True:
            answer = self.ask()
            if what(answer):
                return answer
            assert time.monotonic() < deadline, f"not within {seconds} s: {answer}"
            time.sleep(0.02)

    def kill(self) -> None:
        """Kills the process without a clean shutdown."""
        self.process.kill()
        self._close()

    def end(self) -> None:
        assert self.process.stdin is not None
        if self.process.poll() is None:
            self.process.stdin.close()
            try:
                self.process.wait(5.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
        self._close()

    def _close(self) -> None:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def _line(self) -> str:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, "the process has ended"
        return line


class Network:
    """A network namespace with only a multicasting loopback, and three programs in it.

    `hut` is another program with Link; `app` and `second` are shows of the project. They are started once and reset by
    `new`.
    """

    def __init__(self, holder: "subprocess.Popen[bytes]") -> None:
        """The network is the namespace of a process that holds it."""
        self._enter = ["nsenter", f"--net=/proc/{holder.pid}/ns/net"]
        started = [
            Process([*self._enter, sys.executable, "-m", f"tests.control.link.{name}"])
            for name in ("peer", "app", "app")
        ]
        for process in started:
            process.wait_until_ready()
        self.hut, self.app, self.second = started

    def new(self, *, hut: float = 120.0, app: float = 120.0, second: float = 120.0, mode: str = "follow") -> None:
        """Resets all programs, with these tempos [bpm] and no peers on the network; `mode` is the app's."""
        self.hut.ask("new", bpm=hut)
        self.second.ask("new", bpm=second)
        self.app.ask("new", bpm=app, mode=mode)

    def cut(self) -> None:
        """Takes the only interface down."""
        subprocess.run([*self._enter, "ip", "link", "set", "lo", "down"], check=True)

    def join(self) -> None:
        """Brings the interface up again."""
        subprocess.run([*self._enter, "sh", "-c", UP], check=True)

    def close(self) -> None:
        for process in (self.hut, self.app, self.second):
            process.end()


@pytest.fixture(scope="session")
def network() -> Iterator[Network]:
    """Link multicasts on every network interface, so the tests run only in a private network."""
    if importlib.util.find_spec("link") is None:
        pytest.skip("Ableton Link is not installed (pip install LinkPython-extern)")
    missing = [name for name in ("unshare", "nsenter", "ip") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed (apt install util-linux iproute2)")
    holder = subprocess.Popen(
        ["unshare", "-n", "sh", "-c", NET], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert holder.stdout is not None
    if holder.stdout.readline() != b"ready\n":
        pytest.skip(f"no private network for Ableton Link: {holder.communicate()[1].decode().strip()}")
    try:
        network = Network(holder)
        yield network
        network.close()
    finally:
        holder.kill()
        holder.communicate()


def _environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT)}
