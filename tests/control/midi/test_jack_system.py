"""Tests of JACK's ports: what passes through one, and how its process ends; on a private server."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import psutil
import pytest

from live.control.midi import jack_system
from live.control.midi.jack_system import CLOSE_TIMEOUT, PROCESS, JackPort, JackSystem
from live.control.midi.midi_streams import MAX_SYSEX
from live.control.midi.midi_system import MidiUnavailable
from tests.control.midi.jack import JackPeer, JackServer, jack_server  # noqa: F401 - a fixture
from tests.control.waiting import wait_for

pytestmark = pytest.mark.usefixtures("jack_server")

MESSAGES = [[0x90, 36, 127], [0xF8], [0xFE], [0xF0, *[7] * 3000, 0xF7], [0xF2, 1, 2], [0xC0, 5], [0xFA]]


@pytest.fixture
def keyboard() -> Iterator[JackPeer]:
    peer = JackPeer("keyboard", "out", "sends")
    yield peer
    peer.close()


@pytest.mark.long
def test_messages_of_every_kind_arrive_in_order(keyboard: JackPeer) -> None:
    port, received = JackPort("input", "keyboard:out"), list[list[int]]()
    try:
        keyboard.send(*MESSAGES)  # before anybody listens
        port.listen(lambda message: received.append(list(message)))
        assert wait_for(lambda: len(received) >= len(MESSAGES), 10.0)
    finally:
        port.close()
    assert received == MESSAGES


def test_broken_messages_are_dropped_and_good_ones_arrive(keyboard: JackPeer) -> None:
    port, received = JackPort("input", "keyboard:out"), list[list[int]]()
    endless = [[0xF0, *[1] * 3000], *[[1] * 3000] * 3]
    try:
        port.listen(lambda message: received.append(list(message)))
        keyboard.send([0x90], [0xF5], *endless, [0xF7], [0xF7], [0x90, 36, 127])
        assert wait_for(lambda: bool(received), 10.0)
    finally:
        port.close()
    assert sum(map(len, endless)) > MAX_SYSEX
    assert received == [[0x90, 36, 127]]


def test_what_was_sent_before_closing_arrives() -> None:
    received = list[list[int]]()
    synth = JackPeer("synth", "in", "receives", received.append)
    sent = [*MESSAGES, *([0x80, key, 0] for key in range(100))]
    try:
        port = JackPort("output", "synth:in")
        for message in sent:
            port.send(bytes(message))
        port.close()
        assert wait_for(lambda: len(received) >= len(sent), 10.0)
        with pytest.raises(OSError, match="closed"):
            port.send(b"\xf8")
    finally:
        synth.close()
    assert received == sent


def test_port_that_is_not_there_is_told() -> None:
    with pytest.raises(OSError, match="nobody:out"):
        JackPort("input", "nobody:out")


def test_lost_port_is_noticed_at_once_and_its_server_still_runs(keyboard: JackPeer) -> None:
    port = JackPort("input", "keyboard:out")
    try:
        assert port.exists
        keyboard.close()
        assert wait_for(lambda: not port.exists, 2.0)
        assert port.system_runs
    finally:
        port.close()


def test_dead_server_is_noticed_and_told(keyboard: JackPeer, jack_server: JackServer) -> None:  # noqa: F811
    ports = [JackPort("input", "keyboard:out") for _ in range(2)]
    jack_server.crash()
    try:
        for port in ports:
            assert wait_for(lambda port=port: not port.exists and not port.system_runs, 5.0)  # type: ignore[misc]
        with pytest.raises(MidiUnavailable, match="no JACK server runs"):
            JackSystem().port_names("input")
    finally:
        for port in ports:
            port.close()
        jack_server.start()


@pytest.mark.long
def test_server_that_hangs_delays_closing_for_a_bounded_time(
    keyboard: JackPeer,
    jack_server: JackServer,  # noqa: F811
) -> None:
    port = JackPort("input", "keyboard:out")
    assert jack_server.process is not None
    jack_server.process.send_signal(signal.SIGSTOP)
    try:
        began = time.monotonic()
        port.close()
        assert time.monotonic() - began < CLOSE_TIMEOUT + 4.0
        assert not port.exists
    finally:
        jack_server.process.send_signal(signal.SIGCONT)


@pytest.mark.long
def test_server_that_hangs_delays_the_list_of_ports_for_a_bounded_time(
    keyboard: JackPeer,
    jack_server: JackServer,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert "keyboard:out" in JackSystem().port_names("input")
    assert "keyboard:out" not in JackSystem().port_names("output")
    monkeypatch.setattr(jack_system, "LIST_TIMEOUT", 1.0)
    assert jack_server.process is not None
    jack_server.process.send_signal(signal.SIGSTOP)
    try:
        with pytest.raises(MidiUnavailable, match="JACK does not answer"):
            JackSystem().port_names("input")
    finally:
        jack_server.process.send_signal(signal.SIGCONT)


def test_process_whose_show_died_before_it_was_open_ends_at_once(keyboard: JackPeer) -> None:
    reads, writes = os.pipe()
    os.close(reads)
    done = subprocess.run([*PROCESS, "input", "keyboard:out"], stdout=writes, stderr=subprocess.PIPE, timeout=30.0)
    os.close(writes)
    assert (done.returncode, done.stderr) == (
        1,
        b"",
    )  # a traceback: the interpreter would shut down beside JACK's threads


OWNER = """
import sys
from live.control.midi.jack_system import JackPort
port = JackPort("input", "keyboard:out")
print("open", flush=True)
sys.stdin.read()
"""


@pytest.mark.long
def test_the_port_goes_when_its_owner_is_killed(keyboard: JackPeer) -> None:
    with subprocess.Popen([sys.executable, "-c", OWNER], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as owner:
        assert owner.stdout is not None
        assert owner.stdout.readline() == b"open\n"
        (process,) = psutil.Process(owner.pid).children()
        owner.kill()
    assert wait_for(lambda: not process.is_running() or process.status() == psutil.STATUS_ZOMBIE, 5.0)


QUIET = """
import sys
from live.control.midi.jack_system import JackSystem
from live.control.midi.midi_system import MidiUnavailable
try:
    JackSystem().port_names("input")
except MidiUnavailable:
    pass
assert "jack" not in sys.modules, "its threads would run in the show's process"
"""


@pytest.mark.long
def test_jacks_library_prints_nothing_to_the_terminal_and_is_not_in_the_shows_process() -> None:
    for server in (os.environ["JACK_DEFAULT_SERVER"], "live-test-none"):
        done = subprocess.run(
            [sys.executable, "-c", QUIET], capture_output=True, env={**os.environ, "JACK_DEFAULT_SERVER": server}
        )
        assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
