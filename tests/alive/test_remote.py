"""Two machines on loopback, real processes on both: take-over by silence, by end, by command; and the fence."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.control.waiting import BUSY, wait_for

MACHINE = """
    import signal
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
    import json, socket, sys
    from pathlib import Path
    from live.alive.orders import Orders
    from live.alive.supervisor import Supervisor

    plan, journal, lead, follow = json.loads(sys.argv[1])
    there = None if lead is None else socket.socket(fileno=lead)
    orders = Orders(
        engine=[sys.executable, "-m", "tests.alive.made_engine"], show=json.dumps(plan), journal=Path(journal),
        lead=there, follow=None if follow is None else ("127.0.0.1", follow), spare=False,
    )
    supervisor = Supervisor(orders, lambda line: print(line, flush=True))
    code = supervisor.run()
    print(json.dumps(supervisor.report.facts()), flush=True)
    sys.exit(code)
"""


class Machine:
    """A supervisor with its engine, in a process of its own."""

    def __init__(self, folder: Path, name: str, plan: dict[str, Any], *, lead: Any = None, follow: int | None = None):
        self.journal = folder / name
        self.said = folder / f"{name}.out"
        told = [plan, str(self.journal), None if lead is None else lead.fileno(), follow]
        with self.said.open("w") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-c", textwrap.dedent(MACHINE), json.dumps(told)],
                pass_fds=() if lead is None else (lead.fileno(),), stdout=out, stderr=out, start_new_session=True,
            )  # fmt: skip

    def lines(self) -> list[dict[str, Any]]:
        text = self.journal.read_text() if self.journal.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def numbers(self) -> list[int]:
        return [line["event"]["number"] for line in self.lines() if "number" in line.get("event", {})]

    def engine(self) -> int:
        """The engine's process."""
        return int(self.lines()[0]["pid"])

    def everything(self, number: int) -> None:
        """Send a signal to the supervisor and its engine; it must neither begin another one nor find this one hang."""
        both = (self.engine(), self.process.pid)
        for pid in both[::-1] if number == signal.SIGKILL else both:
            with contextlib.suppress(ProcessLookupError):  # it ends by itself when its supervisor has gone
                os.kill(pid, number)

    def report(self) -> dict[str, Any]:
        """After its end."""
        found: dict[str, Any] = json.loads(self.said.read_text().splitlines()[-1])
        return found


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Callable[..., tuple[Machine, Machine]]]:
    """A machine that leads and one that stands by, which has heard of the show."""
    started: list[Machine] = []

    def start(plan: dict[str, Any], mine: dict[str, Any] | None = None) -> tuple[Machine, Machine]:
        with socket.create_server(("127.0.0.1", 0)) as there:
            leader = Machine(tmp_path, "leader", plan, lead=there)
            other = Machine(tmp_path, "standby", mine or plan, follow=there.getsockname()[1])
        started.extend((leader, other))
        assert wait_for(lambda: len(other.numbers()) > 20, 20), other.said.read_text()
        return leader, other

    yield start
    for machine in started:
        if machine.process.poll() is None:
            machine.process.send_signal(signal.SIGINT)
    for machine in started:
        try:
            machine.process.wait(30)
        except subprocess.TimeoutExpired:
            machine.process.kill()
            machine.process.wait()


def test_a_leader_that_is_gone_is_gone_on_from_without_a_line_lost_or_twice(machines):
    leader, other = machines({})
    leader.everything(signal.SIGKILL)
    told = leader.numbers()[-1]
    assert wait_for(lambda: len(other.numbers()) > told + 50, 10)
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))
    assert "takes over" in other.said.read_text()


def test_a_leader_that_falls_silent_is_replaced_in_time_and_fenced_when_it_comes_back(machines):
    leader, other = machines({})
    leader.everything(signal.SIGSTOP)
    assert wait_for(lambda: "of silence (epoch 2)" in other.said.read_text(), 5), other.said.read_text()
    leader.everything(signal.SIGCONT)
    assert leader.process.wait(30) == 0  # the made engine ends when it is fenced
    assert leader.report()["fenced"]
    assert "this one is dark" in leader.said.read_text()
    last = other.numbers()[-1]
    assert wait_for(lambda: len(other.numbers()) > last + 20, 10)  # what the old leader still said changed nothing
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))
    other.process.send_signal(signal.SIGINT)
    other.process.wait(30)
    silent = other.report()["silent_s"]
    assert 0.3 <= silent < 0.4 * BUSY


def test_a_signal_makes_the_one_that_stands_by_lead(machines):
    leader, other = machines({})
    other.process.send_signal(signal.SIGUSR1)
    assert wait_for(lambda: "on command (epoch 2)" in other.said.read_text(), 5), other.said.read_text()
    assert leader.process.wait(30) == 0
    assert leader.report()["fenced"]


def test_a_show_that_the_leader_ends_is_over_for_who_stands_by_as_well(machines):
    leader, other = machines({"ticks": 400})
    assert leader.process.wait(60) == 0
    assert other.process.wait(30) == 0
    assert "has ended the show" in other.said.read_text()
    assert other.report()["epoch"] == 1


def test_strangers_at_the_port_are_shut_out_and_change_nothing(tmp_path):
    import socket

    with socket.create_server(("127.0.0.1", 0)) as there:
        leader = Machine(tmp_path, "leader", {"ticks": 400}, lead=there)
        port = there.getsockname()[1]
    try:
        for said in (
            b"GET / HTTP/1.1\r\n\r\n",
            b'{"alive":"lead"}\n',
            b'{"alive":"lead","epoch":"9"}\n',
            b"[]\n",
            b"\xff\n",
        ):
            with socket.create_connection(("127.0.0.1", port), timeout=20) as stranger:
                stranger.sendall(said)
                while stranger.recv(65536):
                    pass  # until the door is shut
        with socket.create_connection(("127.0.0.1", port), timeout=20) as stranger:
            stranger.sendall(b'{"alive":"lead","epoch":1}\n')  # no higher than the leader's own
        assert leader.process.wait(60) == 0
        assert not leader.report()["fenced"]
        assert leader.numbers() == list(range(1, 401))
    finally:
        leader.process.kill()


@pytest.mark.long
def test_a_machine_that_cannot_stand_by_ends_and_the_one_that_leads_says_why(tmp_path: Path):
    """Nothing that comes from there does anything to a terminal."""
    with socket.create_server(("127.0.0.1", 0)) as there:
        leader = Machine(tmp_path, "leader", {}, lead=there)
        try:
            other = Machine(tmp_path, "other", {"cannot": "another\x1b[2J\nshow"}, follow=there.getsockname()[1])
            assert other.process.wait(20 * BUSY) == 2
            words = "a machine that wanted to stand by cannot: another [2J show"
            assert wait_for(lambda: words in leader.said.read_text(), 20), leader.said.read_text()
            heard = len(leader.numbers())
            assert wait_for(lambda: len(leader.numbers()) > heard, 20)  # and dances on
        finally:
            leader.process.send_signal(signal.SIGINT)
            leader.process.wait(30)
        assert leader.report()["followers"] == 0
