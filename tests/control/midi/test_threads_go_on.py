"""Tests of exceptions in device threads and tasks: each restarts, is counted and reported."""

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
from live.control.midi.midi_streams import StreamPort
from live.control.osc.osc_codec import encode
from live.control.osc.osc_server import OscInput
from live.control.udp_input import CaptureInput
from live.control.web.task_guard import guarded, keep_task
from live.show.journal.line_writer import WriterThread
from tests.control.waiting import wait_for
from tests.fixtures.source_trees import parse

ROOT = Path(live.__file__).parent


class FirstCallFailure:
    """Fails at the first call, then calls the original function."""

    def __init__(self, then=lambda *values: None):
        self.calls, self._then = 0, then

    def __call__(self, *values, **named):
        self.calls += 1
        if self.calls == 1:
            raise IndexError("made by a test")
        return self._then(*values, **named)


@pytest.fixture
def fault_count():
    """Returns the number of faults since the start of the test."""
    before = FAULTS.total
    return lambda: FAULTS.total - before


def _send(address, data):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.sendto(data, address)


def test_osc_thread_survives_exception(monkeypatch, fault_count):
    inbox = EventQueue()
    osc = OscInput("127.0.0.1", 0, inbox.add_queue(), SystemClock())
    monkeypatch.setattr(osc, "_seconds_to_next", FirstCallFailure(osc._seconds_to_next))
    with osc:
        assert wait_for(lambda: fault_count() == 1, 5.0)
        _send(("127.0.0.1", osc.port), encode("/dance/blackout", (1,)))
        assert wait_for(lambda: osc.handler.accepted == 1, 5.0)
    assert "OSC" in FAULTS.last_notice()


def test_capture_thread_survives_exception(monkeypatch, fault_count):
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
    monkeypatch.setattr(capture, "receive", FirstCallFailure(capture.receive))
    capture.start()
    where = ("127.0.0.1", capture.ports[0])
    _send(where, b"one")
    assert wait_for(lambda: fault_count() == 1, 5.0)
    assert wait_for(lambda: heard == [b"one"], 5.0)
    capture.stop()


def test_midi_stream_thread_survives_exception(fault_count):
    heard = []
    port = StreamPort("input", "tcp:127.0.0.1:0")
    port.listen(FirstCallFailure(heard.append))
    with socket.create_connection(port.address) as out:
        out.sendall(b"\x90\x3c\x07")
        assert wait_for(lambda: fault_count() == 1, 5.0)
        out.sendall(b"\x90\x3e\x07")
        assert wait_for(lambda: len(heard) == 1, 5.0)
    assert port.exists
    port.close()
    assert not port.exists


def test_device_watchdog_survives_exception(fault_count):
    turn, ended = FirstCallFailure(), []
    rounds = DeviceWatchdog("made rounds", SystemClock(), turn, lambda: ended.append(True))
    rounds.start()
    assert wait_for(lambda: turn.calls > 3, 5.0)
    assert fault_count() == 1
    assert not ended
    rounds.stop()
    assert ended == [True]


def test_writer_thread_survives_exception(fault_count):
    written = []

    class Writer(WriterThread):
        _write = FirstCallFailure(written.append)

        def _finish(self):
            written.append("end")

    writer = Writer("made lines", 8)
    writer.put("one")
    writer.put("two")
    writer.close()
    assert written == ["two", "end"]
    assert writer.dropped == 1
    assert fault_count() == 1


def test_server_task_and_callback_survive_exceptions(fault_count):
    turns = []

    async def work():
        turns.append(len(turns))
        if len(turns) < 3:
            raise KeyError("made by a test")

    async def run():
        await asyncio.wait_for(keep_task("made", work), 5.0)
        guarded("made", FirstCallFailure())()
        endless = keep_task("made", lambda: asyncio.sleep(60.0))
        await asyncio.sleep(0)
        endless.cancel()
        with pytest.raises(asyncio.CancelledError):
            await endless

    asyncio.run(run())
    assert turns == [0, 1, 2]
    assert fault_count() == 3


def _threads():
    """Every creation of a thread: the file, its tree, and the target expression."""
    for path in sorted(ROOT.rglob("*.py")):
        if "Thread(" not in path.read_text(encoding="utf-8"):
            continue
        tree = parse(path)
        for call in ast.walk(tree):
            if isinstance(call, ast.Call) and ast.unparse(call.func) in ("threading.Thread", "Thread"):
                target = next(word.value for word in call.keywords if word.arg == "target")
                yield path, tree, target


def _is_guarded(tree, target):
    """Whether a thread's target catches every exception, directly or through a wrapper."""
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


def test_all_threads_catch_exceptions():
    found = list(_threads())
    assert len(found) > 15
    bare = [
        f"{path.relative_to(ROOT)}: {ast.unparse(target)}"
        for path, tree, target in found
        if not _is_guarded(tree, target)
    ]
    assert bare == []
    assert threading.Thread  # the name that is looked for
