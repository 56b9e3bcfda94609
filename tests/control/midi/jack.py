"""A private JACK server without a sound card, which provides MIDI ports where the kernel has none, and its programs."""

import contextlib
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Literal

import pytest

from tests.control.waiting import wait_for

PERIOD = "256"


class JackServer:
    """The running server; the environment of this process names it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Starts the server and waits until it answers."""
        for priority in (("-R", "-P", "20"), ("--no-realtime",)):  # without it a busy machine loses messages
            command = ["jackd", "-n", self.name, *priority, "--no-mlock", "-d", "dummy", "-r", "48000", "-p", PERIOD]
            self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            if wait_for(self._answers, 10.0):
                return
            self.stop()
        pytest.skip("jackd does not start here")

    def _answers(self) -> bool:
        listing = subprocess.run(["jack_lsp"], capture_output=True, timeout=10.0)
        return listing.returncode == 0

    def crash(self) -> None:
        """Kills the server; a server of the same name must be started and stopped afterwards to clean up."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None

    def stop(self) -> None:
        """Stops the server; this frees one of the eight server slots of a machine."""
        if self.process is not None:
            self.process.terminate()
            try:
                self.process.wait(timeout=10.0)
            except subprocess.TimeoutExpired:
                self.crash()
            self.process = None


class JackPeer:
    """Another program with one MIDI port; a process of its own, so that this one may be busy."""

    def __init__(
        self, name: str, port: str, does: Literal["sends", "receives"],
        receive: Callable[[list[int]], None] = lambda message: None,
    ) -> None:  # fmt: skip
        self.receive = receive
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.control.midi.jack_peer", name, port, does],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
        )  # fmt: skip
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def send(self, *messages: list[int]) -> None:
        """Sends messages, each in JACK's next cycle that has room."""
        assert self._process.stdin is not None
        self._process.stdin.write("".join(f"{bytes(message).hex()}\n" for message in messages))

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.receive(list(bytes.fromhex(line)))

    def close(self) -> None:
        """Leaves JACK as a program that crashes does."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()


@pytest.fixture(scope="module")
def jack_server() -> Iterator[JackServer]:
    """A private JACK server; skipped where jackd or JACK-Client is missing."""
    if shutil.which("jackd") is None or shutil.which("jack_lsp") is None:
        pytest.skip("jackd is not installed (apt install jackd2)")
    try:
        import jack  # noqa: F401
    except (ImportError, OSError) as error:
        pytest.skip(f"JACK-Client does not work here: {error}")
    name = f"live-test-{os.getpid()}"
    before = {key: os.environ.get(key) for key in ("JACK_DEFAULT_SERVER", "JACK_NO_START_SERVER")}
    os.environ.update(JACK_DEFAULT_SERVER=name, JACK_NO_START_SERVER="1")
    server = JackServer(name)
    server.start()
    try:
        yield server
    finally:
        server.stop()
        for key, value in before.items():
            os.environ.pop(key, None) if value is None else os.environ.update({key: value})
