"""Two machines on loopback, real processes over TLS: takeover, fencing and access."""

import contextlib
import json
import os
import signal
import socket
import ssl
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from live.supervisor.network.leadership import LEADER_TIMEOUT
from live.supervisor.network.remote_standby import DEPUTY_NOTE
from live.supervisor.network.tls import TrustStore
from tests.control.waiting import BUSY, wait_for
from tests.supervisor.made_machines import Machine, Start, machine, pair_folders, stop_all


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Start]:
    """A leading machine and a standby machine that has received the show and, if it can be ready, is the deputy."""
    started: list[Machine] = []

    def start(plan: dict[str, Any], mine: dict[str, Any] | None = None) -> tuple[Machine, Machine]:
        pair_folders(tmp_path / "config-leader", tmp_path / "config-standby")
        with socket.create_server(("127.0.0.1", 0)) as there:
            leader = Machine(tmp_path, "leader", plan, lead=there)
            other = Machine(tmp_path, "standby", mine or plan, follow=there.getsockname()[1])
        started.extend((leader, other))
        assert wait_for(lambda: len(other.numbers()) > 100, 20), other.said.read_text()
        if not (mine or plan).get("never_ready"):
            assert other.prints(DEPUTY_NOTE), other.said.read_text()
        return leader, other

    yield start
    stop_all(started)


def test_standby_continues_after_dead_leader_without_lost_or_repeated_lines(machines):
    leader, other = machines({})
    leader.signal_all(signal.SIGKILL)
    told = leader.numbers()[-1]
    assert wait_for(lambda: len(other.numbers()) > told + 50, 10), other.said.read_text()
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))
    assert "takes over because its leader has gone (epoch 2)" in other.said.read_text()


@pytest.mark.long
def test_leader_knows_its_standby(machines):
    leader, other = machines({})
    assert wait_for(lambda: len(other.numbers()) > 250, 20)
    [row] = leader.stop()["standbys"]
    assert (row["name"], row["state"], row["why"]) == ("config-standby", "ready", "takes over next")


@pytest.mark.long
def test_silent_leader_is_replaced_and_follows_after_return(machines):
    """It stops at once and stands by from then on: when the other machine dies it takes over in turn."""
    leader, other = machines({})
    leader.signal_all(signal.SIGSTOP)
    assert other.prints("of silence (epoch 2)", 5), other.said.read_text()
    leader.signal_all(signal.SIGCONT)
    assert leader.prints("this one goes dark", 5), leader.said.read_text()
    assert wait_for(lambda: len(leader.numbers()) > 50 and leader.journal.with_name("leader.1").exists(), 10)
    last = other.numbers()[-1]
    assert wait_for(lambda: len(other.numbers()) > last + 20, 10)  # what the old leader still said changed nothing
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))
    assert wait_for(lambda: leader.numbers()[-1] > other.numbers()[-1] - 50, 10)
    os.kill(other.process.pid, signal.SIGKILL)
    assert leader.prints("of silence (epoch 3)", 10), leader.said.read_text()
    last = leader.numbers()[-1]
    assert wait_for(lambda: leader.numbers()[-1] > last + 20, 10)
    heard = leader.numbers()
    assert heard == list(range(heard[0], heard[0] + len(heard)))
    report = leader.stop()
    assert LEADER_TIMEOUT <= report["silent_s"] < LEADER_TIMEOUT + 0.2 * BUSY
    assert not report["fenced"]


@pytest.mark.long
def test_unready_machine_never_takes_over_on_silence(machines):
    """It has not compared a state yet: a command makes it lead, silence does not."""
    leader, other = machines({}, {"never_ready": True})
    leader.signal_all(signal.SIGSTOP)
    began = time.monotonic()
    assert wait_for(lambda: time.monotonic() - began > 2 * LEADER_TIMEOUT, 2 * LEADER_TIMEOUT)
    assert "takes over" not in other.said.read_text()
    assert DEPUTY_NOTE not in other.said.read_text()
    other.process.send_signal(signal.SIGUSR1)
    assert other.prints("on command (epoch 2)", 5), other.said.read_text()
    leader.signal_all(signal.SIGCONT)
    assert leader.prints("this one goes dark", 5)


@pytest.mark.long
def test_machine_that_was_stopped_does_not_take_over_on_silence(machines):
    """It was not receiving: the leader, which did not fail, continues to lead."""
    leader, other = machines({})
    os.kill(other.process.pid, signal.SIGSTOP)
    began, told = time.monotonic(), leader.numbers()[-1]
    assert wait_for(lambda: time.monotonic() - began > 1.3 * LEADER_TIMEOUT and leader.numbers()[-1] > told + 50, 10)
    os.kill(other.process.pid, signal.SIGCONT)
    assert wait_for(lambda: other.numbers()[-1] > leader.numbers()[-1] - 30, 10)
    assert "takes over" not in other.said.read_text()
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))


@pytest.mark.long
def test_leader_with_hung_engine_is_not_replaced_for_silence(machines):
    """Its own supervisor replaces the engine, or hands the show over if that takes too long on a busy machine."""
    leader, other = machines({"hangs": 300})
    assert wait_for(lambda: other.numbers()[-1] > 320, 20), leader.said.read_text()
    assert "of silence" not in other.said.read_text()
    assert (heard := other.numbers()) == list(range(1, len(heard) + 1))
    assert ("no sign of life" in leader.said.read_text()) or leader.prints("no engine ran here for too long")
    if "takes over" in other.said.read_text():
        assert leader.prints("no engine ran here for too long")


@pytest.mark.long
def test_show_ended_by_leader_ends_on_standby(machines):
    leader, other = machines({"ticks": 400})
    assert leader.process.wait(60) == 0
    assert other.process.wait(30) == 0
    assert "has ended the show" in other.said.read_text()
    assert other.report()["epoch"] == 1


@pytest.mark.long
def test_strangers_at_port_receive_nothing_and_change_nothing(tmp_path):
    """Clients without TLS and clients with an unpaired certificate; one line could once stop a leader."""
    with socket.create_server(("127.0.0.1", 0)) as there:
        leader = Machine(tmp_path, "leader", {"ticks": 1000}, lead=there)
        port = there.getsockname()[1]
    try:
        said = (b"GET / HTTP/1.1\r\n\r\n", b'{"alive":"lead","epoch":99}\n', b"\xff\n", b"\x16\x03\x01\xff\xff\x01")
        for each in said:
            with socket.create_connection(("127.0.0.1", port), timeout=20) as stranger:
                stranger.sendall(each)
                heard = b""
                try:
                    while piece := stranger.recv(65536):
                        heard += piece
                except ConnectionResetError:
                    pass
                assert len(heard) <= 7  # an alert of TLS at most
        own, pairings = machine(tmp_path / "config-stranger")
        pairings.add("leader", machine(tmp_path / "config-leader")[0].certificate)  # which does not know this one
        stranger = socket.create_connection(("127.0.0.1", port), timeout=20)
        with stranger, TrustStore(own, pairings).wrap(stranger, server=False) as secure:
            secure.settimeout(20)
            with contextlib.suppress(ssl.SSLError, OSError):  # in TLS 1.3 a client hears that it is refused later
                secure.do_handshake()
                secure.sendall(b'{"alive":"hello"}\n')
                assert secure.recv(65536) == b""
        assert leader.process.wait(60) == 0
        report = leader.report()
        assert not report["fenced"]
        assert (report["epoch"], report["strangers"] >= len(said) + 1) == (1, True)
        assert leader.numbers() == list(range(1, 1001))
    finally:
        leader.process.kill()


@pytest.mark.long
def test_machine_unable_to_stand_by_ends_and_leader_reports_reason(tmp_path: Path):
    """Its text cannot control a terminal."""
    pair_folders(tmp_path / "config-leader", tmp_path / "config-other")
    with socket.create_server(("127.0.0.1", 0)) as there:
        leader = Machine(tmp_path, "leader", {}, lead=there)
        try:
            other = Machine(tmp_path, "other", {"cannot": "another\x1b[2J\nshow"}, follow=there.getsockname()[1])
            assert other.process.wait(20 * BUSY) == 2
            words = "another machine cannot stand by: another [2J show"
            assert leader.prints(words), leader.said.read_text()
            heard = len(leader.numbers())
            assert wait_for(lambda: len(leader.numbers()) > heard, 20)  # and dances on
        finally:
            leader.process.send_signal(signal.SIGINT)
            leader.process.wait(30)
        assert leader.report()["followers"] == 0


@pytest.mark.long
def test_unpaired_machine_reports_pairing_command(tmp_path: Path):
    with socket.create_server(("127.0.0.1", 0)) as there:
        started = [Machine(tmp_path, "leader", {}, lead=there)]
        started.append(Machine(tmp_path, "other", {}, follow=there.getsockname()[1]))
    try:
        assert started[1].prints("live pair 127.0.0.1"), started[1].said.read_text()
        assert json.dumps(started[1].numbers()) == "[]"
    finally:
        stop_all(started)
