"""A private JACK server without a sound card, which provides MIDI ports where the kernel has none."""

import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest

from live.control.midi.midi_ports import MidiUnavailable, rtmidi
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


@pytest.fixture(scope="module")
def jack_server() -> Iterator[JackServer]:
    """A private JACK server; skipped where jackd or python-rtmidi is missing."""
    if shutil.which("jackd") is None or shutil.which("jack_lsp") is None:
        pytest.skip("jackd is not installed (apt install jackd2)")
    try:
        module = rtmidi()
    except MidiUnavailable as error:
        pytest.skip(str(error))
    if module.API_UNIX_JACK not in module.get_compiled_api():
        pytest.skip("this python-rtmidi knows no JACK")
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
