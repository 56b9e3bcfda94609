"""A thread or a task of a device that meets an exception is begun again, counted and told; it never dies in silence."""

import ast
import asyncio
import socket
import threading
from pathlib import Path

import pytest

import live
from live.base.event_queue import EventQueue
from live.base.fault_isolation import FAULTS
from live.clock.time_source import SystemClock
from live.control.audio.devices import DeviceWatchdog
from live.control.capture.udp_input import CaptureInput
from live.control.midi.midi_streams import StreamPort
from live.control.midi.rtp_midi import RtpPort
from live.control.osc.osc_codec import encode
from live.control.osc.osc_server import OscInput
from live.control.web.task_guard import guarded, keep_task
from live.show.journal.line_writer import WriterThread
from tests.control.waiting import wait_for

ROOT = Path(live.__file__).parent


class Once:
    """Fails at the first call, then does what was there before."""

    def __init__(self, then=lambda *values: None):
        self.calls, self._then = 0, then

    def __call__(self, *values, **named):
        self.calls += 1
        if self.calls == 1:
            raise IndexError("made by a test")
        return self._then(*values, **named)


@pytest.fixture
def counted():
    """How many faults were counted since."""
    before = FAULTS.total
    return lambda: FAULTS.total - before


def _send(address, data):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.sendto(data, address)


def test_osc(monkeypatch, counted):
    inbox = EventQueue()
    osc = OscInput("127.0.0.1", 0, inbox.add_queue(), SystemClock())
    monkeypatch.setattr(osc, "_seconds_to_next", Once(osc._seconds_to_next))
    with osc:
        assert wait_for(lambda: counted() == 1, 5.0)
        _send(("127.0.0.1", osc.port), encode("/dance/blackout", (1,)))
        assert wait_for(lambda: osc.accepted == 1, 5.0)
    assert "OSC" in FAULTS.last_notice()


def test_capture(monkeypatch, counted):
    heard = []

    class Input(CaptureInput):
        def open(self):
            one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            one.bind(("127.0.0.1", 0))
            one.setblocking(False)
            return [one]

        def handle(self, data, sender, port, now):
            heard.append(data)

    capture = Input("capture", SystemClock(), 512)
    monkeypatch.setattr(capture, "receive", Once(capture.receive))
    capture.start()
    where = ("127.0.0.1", capture.ports[0])
    _send(where, b"one")
    assert wait_for(lambda: counted() == 1, 5.0)
    assert wait_for(lambda: heard == [b"one"], 5.0)
    capture.stop()


def test_a_stream_of_midi(counted):
    heard = []
    port = StreamPort("input", "tcp:127.0.0.1:0")
    port.listen(Once(heard.append))
    with socket.create_connection(port.address) as out:
        out.sendall(b"\x90\x3c\x07")
        assert wait_for(lambda: counted() == 1, 5.0)
        out.sendall(b"\x90\x3e\x07")
        assert wait_for(lambda: len(heard) == 1, 5.0)
    assert port.exists
    port.close()
    assert not port.exists


def test_midi_over_rtp(monkeypatch, counted):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1] & ~1
    port = RtpPort("input", f"rtp:127.0.0.1:{number}")
    monkeypatch.setattr(port.protocol, "handle", Once(port.protocol.handle))
    port.listen(lambda message: None)
    _send(("127.0.0.1", number), b"\xff\xff nonsense")
    assert wait_for(lambda: counted() == 1, 5.0)
    _send(("127.0.0.1", number), b"\xff\xff nonsense")
    assert wait_for(lambda: port.protocol.handle.calls == 2, 5.0)
    assert port.exists
    port.close()


def test_rounds(counted):
    turn, ended = Once(), []
    rounds = DeviceWatchdog("made rounds", SystemClock(), turn, lambda: ended.append(True))
    rounds.start()
    assert wait_for(lambda: turn.calls > 3, 5.0)
    assert counted() == 1
    assert not ended
    rounds.stop()
    assert ended == [True]


def test_a_writer(counted):
    written = []

    class Writer(WriterThread):
        _write = Once(written.append)

        def _finish(self):
            written.append("end")

    writer = Writer("made lines", 8)
    writer.put("one")
    writer.put("two")
    writer.close()
    assert written == ["two", "end"]
    assert writer.dropped == 1
    assert counted() == 1


def test_a_task_of_a_server_and_a_callback_of_its_loop(counted):
    turns = []

    async def work():
        turns.append(len(turns))
        if len(turns) < 3:
            raise KeyError("made by a test")

    async def run():
        await asyncio.wait_for(keep_task("made", work), 5.0)
        guarded("made", Once())()
        endless = keep_task("made", lambda: asyncio.sleep(60.0))
        await asyncio.sleep(0)
        endless.cancel()
        with pytest.raises(asyncio.CancelledError):
            await endless

    asyncio.run(run())
    assert turns == [0, 1, 2]
    assert counted() == 3


def _threads():
    """Every place where a thread is made: the file, and the expression that it runs."""
    for path in sorted(ROOT.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for call in ast.walk(tree):
            if isinstance(call, ast.Call) and ast.unparse(call.func) in ("threading.Thread", "Thread"):
                target = next(word.value for word in call.keywords if word.arg == "target")
                yield path, tree, target


def _is_guarded(tree, target):
    """Whether what a thread runs catches every exception, itself or by what it is handed to."""
    words = ast.unparse(target)
    if "run_once" in words or "keep_running" in words:
        return True
    name = words.rpartition(".")[2]
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and any(ast.unparse(each) == name for each in node.targets):
            return "run_once" in ast.unparse(node.value)
        if isinstance(node, ast.FunctionDef) and node.name == name:
            body = ast.unparse(node)
            if "keep_running(" in body or "run_once(" in body or "except Exception" in body:
                return True
            if "except BaseException" in body:
                return True
    return False


def test_no_thread_of_the_program_can_die_in_silence():
    found = list(_threads())
    assert len(found) > 15
    bare = [
        f"{path.relative_to(ROOT)}: {ast.unparse(target)}"
        for path, tree, target in found
        if not _is_guarded(tree, target)
    ]
    assert bare == []
    assert threading.Thread  # the name that is looked for
