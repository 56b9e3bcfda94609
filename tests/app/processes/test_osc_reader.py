"""The OSC reader process of a supervised show: no message is lost when engine, reader or supervisor dies."""

import os
import signal
import socket
import sys
from collections.abc import Iterator
from typing import Any

import pytest
from typer.testing import CliRunner

from live.app.launch_options import LaunchOptions
from live.app.processes import engine_main
from live.base.event_queue import EventQueue
from live.cli.main import app
from live.clock.time_source import SystemClock
from live.control.events import events
from live.control.osc.osc_process import OscRemote
from live.control.osc.osc_socket import bound_socket
from live.supervisor.process import Child
from tests.control.osc.osc_stage import message
from tests.control.waiting import wait_for


class SupervisorSide:
    """Sockets and processes of a supervisor, and the engine's side of them."""

    def __init__(self) -> None:
        self.udp = bound_socket("127.0.0.1", 0)
        self.pair = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.clock = SystemClock()
        self.sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sender.settimeout(0.01)
        self.reader = self.begin()
        self.inbox: EventQueue[events.ControlEvent] = EventQueue()
        self.remote: OscRemote | None = None

    def begin(self) -> Child:
        theirs = (self.pair[1].fileno(), self.udp.fileno())
        command = [sys.executable, "-m", "live.app.processes.osc_reader_main", *map(str, theirs)]
        return Child("OSC", command, inherit=theirs)

    def engine(self) -> OscRemote:
        """Start another engine, without any state of the last one."""
        self.inbox = EventQueue()
        self.remote = OscRemote(
            "", 0, self.inbox.add_queue(), self.clock, inherited=self.udp.fileno(), reader=self.pair[0].fileno()
        )
        self.remote.publish({"/dance/clock/tempo": (("", (96.0,)),)})
        self.remote.start()
        return self.remote

    def send(self, address: str, *values: Any) -> None:
        self.sender.sendto(message(address, *values).dgram, self.udp.getsockname())

    def receives(self, kind: type[events.ControlEvent], count: int = 1) -> bool:
        """Whether the engine receives exactly this number of events of a kind."""
        found: list[events.ControlEvent] = []

        def look() -> bool:
            assert self.remote is not None
            self.remote.frame()
            found.extend(event for event in self.inbox.drain() if isinstance(event, kind))
            return len(found) >= count

        return wait_for(look, 20.0) and len(found) == count

    def answers_query(self) -> bool:
        """Whether a query for the engine's tempo is answered."""

        def look() -> bool:
            assert self.remote is not None
            self.remote.frame()
            self.send("/dance/clock/tempo")
            try:
                return b"/dance/clock/tempo" in self.sender.recv(2000)
            except TimeoutError:
                return False

        return wait_for(look, 20.0)

    def close(self) -> None:
        if self.remote is not None:
            self.remote.stop()
        self.reader.kill()
        self.reader.end()
        for one in (self.udp, *self.pair, self.sender):
            one.close()


@pytest.fixture
def show() -> Iterator[SupervisorSide]:
    made = SupervisorSide()
    yield made
    made.close()


def test_engine_change_loses_no_message_sent_meanwhile(show: SupervisorSide) -> None:
    show.send("/dance/clock/tap")  # before there is any engine, or a time of the show: it waits in the socket
    remote = show.engine()
    assert show.receives(events.Tap)
    assert show.answers_query()
    remote.stop()
    for _ in range(20):  # nobody dances: they wait with the process, or on the way
        show.send("/dance/clock/tap")
    show.engine()
    assert show.receives(events.Tap, 20)
    assert show.answers_query()
    assert show.reader.process.poll() is None


@pytest.mark.long
def test_restarted_reader_receives_all_values_again(show: SupervisorSide) -> None:
    show.engine()
    assert show.answers_query()
    show.reader.kill()
    show.reader.end()
    show.send("/dance/clock/one")  # nobody is there: it waits in the socket
    show.reader = show.begin()
    assert show.receives(events.One)
    assert show.answers_query()
    assert wait_for(lambda: show.reader.phase.name == "RUNNING", 10.0)


def test_engine_outliving_supervisor_starts_own_reader(show: SupervisorSide) -> None:
    remote = show.engine()
    assert show.answers_query()
    show.pair[1].close()  # so it is when a supervisor dies: all that it held is closed,
    show.reader.channel.close()  # its end of the wire as well, and the process that it started ends
    assert wait_for(lambda: show.reader.process.poll() == 0, 10.0)
    show.send("/dance/clock/one")
    assert show.receives(events.One)
    assert show.answers_query()
    assert remote.pid is not None
    assert remote.status()["restarts"] == 1
    os.kill(remote.pid, signal.SIGKILL)
    assert remote._helper is not None
    remote._helper._started_at -= 10.0
    assert show.answers_query()


@pytest.mark.parametrize(
    ("options", "reads"), [((), True), (("--osc-process",), True), (("--no-osc-process",), False)],
    ids=lambda value: " ".join(value) or "nothing said" if isinstance(value, tuple) else "",
)  # fmt: skip
def test_supervised_show_reads_osc_in_process_by_default(
    monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], reads: bool
) -> None:
    made: list[Any] = []

    class Made:
        def __init__(self, orders: Any, *_: Any, **__: Any) -> None:
            made.append(orders)
            orders.osc.close()

        def run(self) -> int:
            return 0

    monkeypatch.setattr(engine_main, "Supervisor", Made)
    done = CliRunner().invoke(app, ["play", "--headless", "--bpm", "120", "--osc", "127.0.0.1:0", *options])
    assert done.exit_code == 0, done.output
    (orders,) = made
    assert bool(orders.osc_reader) is reads
    assert LaunchOptions.decode(orders.show).osc_process is reads


def test_single_process_show_reads_osc_in_thread_by_default(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wishes: list[Any] = []
    monkeypatch.setattr("live.app.machine.kernel_warmup.warm_kernels", lambda console: None)
    monkeypatch.setattr("live.app.headless_loop.play_show", lambda options, **_: wishes.append(options))
    for options in ((), ("--osc-process",)):
        done = CliRunner().invoke(app, ["play", "--headless", "--alone", "--bpm", "120", *options])
        assert done.exit_code == 0, done.output
    assert [options.osc_process for options in wishes] == [None, True]  # only a supervisor starts it unasked
