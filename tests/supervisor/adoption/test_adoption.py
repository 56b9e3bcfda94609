"""Supervisors that are killed: the engine goes on, its journal too, and the next supervisor takes it over."""

import contextlib
import itertools
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from live.supervisor.adoption import adoption, rendezvous
from live.supervisor.adoption import hung_engine as orphan
from live.supervisor.adoption.adoption import CannotAdopt, EngineHung, end_engines, find_engine
from live.supervisor.adoption.journal_resume import read_interrupted
from live.supervisor.adoption.rendezvous import RendezvousListener, private_folder
from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import LineChannel
from live.supervisor.supervisor_link import SupervisorLink
from live.supervisor.watchdog import Usage
from tests.control.waiting import BUSY, wait_for
from tests.supervisor.made_show import LABEL


@dataclass
class Made:
    """A journal, and the supervisors that were started for it one after another."""

    journal: Path
    plan: dict[str, Any]
    supervisors: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start one more."""
        with self._told(len(self.supervisors)).open("w") as out:
            self.supervisors.append(
                subprocess.Popen(
                    [sys.executable, "-m", "tests.supervisor.made_show", str(self.journal), json.dumps(self.plan)],
                    stdout=out,
                )
            )

    def told(self) -> list[str]:
        """What the last one has said."""
        return self._told(len(self.supervisors) - 1).read_text().splitlines()

    def _told(self, number: int) -> Path:
        return self.journal.with_name(f"told{number}")

    def kill(self) -> None:
        """Kill the last one."""
        self.supervisors[-1].kill()
        self.supervisors[-1].wait()

    def lines(self) -> list[dict[str, Any]]:
        """The whole lines of the journal."""
        text = self.journal.read_text() if self.journal.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def numbers(self) -> list[int]:
        """Those of its events."""
        return [line["event"]["number"] for line in self.lines() if "event" in line]

    def until(self, number: int) -> None:
        """Wait until the journal has come so far."""
        assert wait_for(lambda: (self.numbers() or [0])[-1] >= number, 20), self.numbers()[-3:]


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Made]]:
    """Begins a show; whoever is left is ended after the test."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    shows: list[Made] = []

    def begin(**plan: Any) -> Made:
        show = Made(tmp_path / "j", {"alone": 60.0, "journal": str(tmp_path / "j"), "pace": 0.01, **plan})
        shows.append(show)
        show.start()
        return show

    yield begin
    for show in shows:
        for process in show.supervisors:
            process.kill()
            process.wait()
    end_engines(LABEL)
    assert wait_for(lambda: not engines_of(tmp_path), 20)


def engines_of(folder: Path) -> list[int]:
    """Engines whose plan lies in that folder: those that this test began."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            mine = f"XDG_RUNTIME_DIR={folder}\0".encode() in (path / "environ").read_bytes()
            if mine and b"made_engine" in (path / "cmdline").read_bytes():
                found.append(int(path.name))
        except OSError:
            continue
    return found


def dancing(show: Made) -> int:
    """The process number of the engine that began the show."""
    return int(show.lines()[0]["pid"])


def test_a_killed_supervisor_ends_nothing_and_no_line_of_the_journal_is_lost(made):
    show = made(ticks=400)
    show.until(100)
    show.kill()
    show.until(400)
    assert wait_for(lambda: show.lines()[-1].get("end", False), 10)
    assert show.numbers() == list(range(1, 401))


def test_the_next_supervisor_takes_the_engine_over_and_its_death_is_survived_as_before(made, tmp_path):
    """Three supervisors, two killed; then the engine is. It is one show all the time, and one journal."""
    show = made()
    for _ in range(2):
        show.until((show.numbers() or [0])[-1] + 80)
        show.kill()
        show.until(show.numbers()[-1] + 50)
        show.start()
        assert wait_for(lambda: bool(show.told()), 20)
        assert show.told()[0] == "adopted"
    engine = dancing(show)
    assert wait_for(lambda: len(engines_of(tmp_path)) == 3, 20)  # with a nursery and a spare
    show.until(show.numbers()[-1] + 80)
    os.kill(engine, signal.SIGKILL)
    assert wait_for(lambda: any("went" in line for line in show.lines()), 20)
    show.until(show.numbers()[-1] + 20)
    assert [line["went"] for line in show.lines() if "went" in line] == ["spare"]
    show.supervisors[-1].send_signal(signal.SIGTERM)
    assert show.supervisors[-1].wait(20) in (0, 128 + signal.SIGTERM)
    assert (heard := show.numbers()) == list(range(1, heard[-1] + 1))  # read once: it is being written
    assert not engines_of(tmp_path)
    assert not list(tmp_path.glob("*/*.sock"))


def test_a_show_that_ends_after_it_was_taken_over_ends_the_supervisor_well(made):
    show = made(ticks=500)
    show.until(100)
    show.kill()
    show.until(150)
    show.start()
    assert show.supervisors[-1].wait(30) == 0
    assert show.numbers() == list(range(1, 501))
    assert show.lines()[-1] == {"tick": 500, "end": True}


def test_the_end_of_a_line_that_was_torn_is_cut_and_a_removed_journal_is_begun_anew(made):
    show = made()
    show.until(50)
    os.kill(show.supervisors[-1].pid, signal.SIGSTOP)  # it writes no more, and all that comes is kept
    with show.journal.open("a") as file:
        file.write('{"tick":51,"ev')
    show.kill()
    show.until(120)
    assert (heard := show.numbers()) == list(range(1, heard[-1] + 1))  # read once: it is being written
    show.journal.unlink()
    show.until(200)
    assert show.lines()[0]["journal"] == 2
    assert show.lines()[1]["gap"] > 0


def test_who_comes_while_a_supervisor_lives_is_sent_away_and_begins_a_show_of_its_own(made, tmp_path):
    show = made()
    show.until(20)
    assert find_engine(LABEL) is None
    show.until(40)


def test_an_engine_that_is_alone_can_be_told_to_end(made, tmp_path):
    show = made()
    show.until(20)
    assert end_engines(LABEL) == []  # it has a supervisor
    show.kill()
    assert wait_for(lambda: end_engines(LABEL) == [dancing(show)], 10)
    assert wait_for(lambda: not engines_of(tmp_path), 20)
    assert find_engine(LABEL) is None
    assert not list(tmp_path.glob("*/*.sock"))  # whoever found that nobody listens has removed it


def test_a_show_of_which_no_process_is_left_goes_on_from_its_journal(made, tmp_path):
    show = made(origin=time.perf_counter())
    show.until(100)
    show.kill()
    for pid in engines_of(tmp_path):
        os.kill(pid, signal.SIGKILL)
    assert wait_for(lambda: not engines_of(tmp_path), 20)
    last = show.numbers()[-1]
    with show.journal.open("a") as file:
        file.write('{"tick":51,"ev')
    show.start()
    show.until(last + 50)
    assert show.told()[0] == "resumed"
    assert [line["went"] for line in show.lines() if "went" in line] == ["heir"]
    assert (heard := show.numbers()) == list(range(1, heard[-1] + 1))  # read once: it is being written
    assert not list(tmp_path.glob("j.*"))


@pytest.mark.parametrize("waiting", [0, 8], ids=["alone", "with a full queue of those who asked"])
def test_an_engine_that_hangs_without_a_supervisor_is_ended_by_the_next_one(made, tmp_path, monkeypatch, waiting):
    monkeypatch.setattr(adoption, "ANSWERS_WITHIN", 1.0)
    show = made(origin=time.perf_counter())
    show.until(100)
    show.kill()
    show.until(show.numbers()[-1] + 20)
    engine = dancing(show)
    os.kill(engine, signal.SIGSTOP)
    with contextlib.ExitStack() as asked:
        for _ in range(waiting):
            sock = asked.enter_context(socket.socket(socket.AF_UNIX))
            sock.setblocking(False)
            with contextlib.suppress(BlockingIOError):
                sock.connect(str(next(tmp_path.glob("*/*.sock"))))
        with pytest.raises(EngineHung, match=str(engine)):
            find_engine(LABEL)
    assert engine not in engines_of(tmp_path)
    assert read_interrupted(show.journal) is not None


def test_an_engine_that_only_gets_no_processor_is_not_ended(made, tmp_path, monkeypatch):
    """It waits for one all the time: none of the seconds is its own."""
    show = made(origin=time.perf_counter())
    show.until(50)
    show.kill()
    show.until(show.numbers()[-1] + 20)
    engine, delays = dancing(show), itertools.count()
    monkeypatch.setattr(orphan, "usage_of", lambda pid: Usage("R", 0.0, 0.1 * next(delays)))
    monkeypatch.setattr(orphan, "MAX_SILENCE", 4.0)
    [name] = [path.name for path in tmp_path.glob("*/*.sock")]
    assert orphan.socket_holders(name) == [engine]
    assert orphan.kill_if_hung(name, lambda: False) == []
    assert engine in engines_of(tmp_path)


def journal_of(path: Path, *lines: dict[str, Any], **header: Any) -> Path:
    first = {"journal": 2, "origin": time.perf_counter() - 20.0, **header}
    path.write_text("".join(json.dumps(line, separators=(",", ":")) + "\n" for line in (first, *lines)))
    return path


def test_only_what_was_cut_off_lately_on_this_machine_is_gone_on_with(tmp_path, monkeypatch):
    tap = {"tick": 64, "event": {"type": "Tap"}}
    path = journal_of(tmp_path / "j", tap)
    left = read_interrupted(path)
    assert left is not None
    assert left.interrupted_s == pytest.approx(19.0, abs=5.0 * BUSY)
    assert [json.loads(line) for line in left.lines[1:]] == [tap, {"tick": 64}]
    assert read_interrupted(tmp_path / "none") is None
    assert read_interrupted(journal_of(tmp_path / "j", tap, {"tick": 99, "end": True})) is None
    assert read_interrupted(journal_of(tmp_path / "j", tap, origin=None)) is None
    assert read_interrupted(journal_of(tmp_path / "j")) is None
    assert read_interrupted(journal_of(tmp_path / "j", tap, origin=time.perf_counter() - 400.0)) is None
    assert read_interrupted(journal_of(tmp_path / "j", {"tick": 64 * 60, "event": {}})) is None  # it lies in the future
    path = journal_of(tmp_path / "j", tap)
    os.utime(path, (0.0, time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) - 10.0))  # of the start before
    assert read_interrupted(path) is None
    path.write_bytes(b"\xff" * 500 + b"\n[1]\n" + b"[" * 9000 + b"\n")
    assert read_interrupted(path) is None


def test_a_show_whose_steps_have_changed_is_gone_on_with_from_the_snapshot_before(tmp_path, monkeypatch):
    """Whoever begins with the first line has read the steps of then."""
    shots = [json.dumps({"snapshot": 3, "tick": tick}).encode() + b"\n" + bytes(64) for tick in (10, 30, 50)]
    monkeypatch.setattr("live.supervisor.adoption.journal_resume.read_snapshots", lambda path, problems: iter(shots))
    lines = [{"tick": tick, "event": {"type": "Tap"}} for tick in range(5, 65, 5)]
    left = read_interrupted(journal_of(tmp_path / "j", *lines))
    assert left is not None
    told = [json.loads(line) for line in left.lines]
    assert [line["tick"] for line in told[1:]] == [50, 50, 55, 60, 60]
    assert left.snapshots_kept == sum(map(len, shots))
    lines[6]["event"]["type"] = "StepsChanged"  # tick 35
    left = read_interrupted(journal_of(tmp_path / "j", *lines))
    assert left is not None
    told = [json.loads(line) for line in left.lines]
    assert "snapshot" in told[1]
    assert [line["tick"] for line in told[1:]] == [30, 30, 35, 40, 45, 50, 55, 60, 60]


# -- the engine's side, without processes ----------------------------------------------------------------------------


@pytest.fixture
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SupervisorLink]:
    """An engine whose supervisor has gone."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    meeting = RendezvousListener(LABEL)
    mine, theirs = socket.socketpair()
    supervisor = LineChannel(mine)
    supervisor.send_json(alive="engine", show="{}", rendezvous=os.dup(meeting.socket.fileno()))
    lifeline = SupervisorLink(LineChannel(theirs), Heartbeat())
    lifeline.receive_brief()
    supervisor.close()
    lifeline.receive()
    assert lifeline.orphaned
    meeting.socket.close()
    yield lifeline
    assert lifeline._rendezvous is not None
    lifeline._rendezvous._socket.close()
    lifeline.channel.close()
    lifeline.heartbeat.close()


def reached(tmp_path: Path) -> socket.socket:
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    folder = os.open(tmp_path / rendezvous.FOLDER, os.O_RDONLY)
    sock.connect(f"/proc/self/fd/{folder}/{LABEL}.{os.getpid()}.sock")
    os.close(folder)
    return sock


def answer(guest: socket.socket) -> bytes:
    """What it says until it hangs up, within seconds."""
    guest.settimeout(5.0)
    said = b""
    with contextlib.suppress(ConnectionResetError):  # it had not read everything
        while data := guest.recv(1 << 16):
            said += data
    return said


@pytest.mark.parametrize(
    "words",
    [
        b"GET / HTTP/1.1\r\n\r\n", b"{}\n", b"[1]\n", b'{"alive":"adopt"}\n', b'{"alive":"adopt","version":"0"}\n',
        b"\xff\xfe\n", b"x" * 8192, b"[" * 5000 + b"\n", b"",
    ],
)  # fmt: skip
def test_who_says_something_else_is_sent_away_and_the_show_waits_for_nobody(alone, tmp_path, words):
    with reached(tmp_path) as guest:
        guest.sendall(words)
        guest.shutdown(socket.SHUT_WR)
        longest = 0.0
        for tick in range(3):
            before = time.perf_counter()
            alone.end_frame(tick)
            longest = max(longest, time.perf_counter() - before)
        assert alone.orphaned
        assert longest < 0.1 * BUSY
        assert b"descriptors" not in answer(guest)


def test_who_says_nothing_is_sent_away_after_a_while_and_no_more_than_a_few_are_looked_at(alone, tmp_path, monkeypatch):
    guests = []
    for tick in range(6):
        guests.append(reached(tmp_path))
        alone.end_frame(tick)
    for guest in guests[4:]:
        assert answer(guest) == b""
    guests[0].setblocking(False)
    with pytest.raises(BlockingIOError):
        guests[0].recv(1)
    monkeypatch.setattr(rendezvous, "PATIENCE", 0.0)
    alone.end_frame(9)
    for guest in guests:
        assert answer(guest) == b""
        guest.close()


def test_another_user_is_not_let_in(alone, tmp_path, monkeypatch):
    monkeypatch.setattr(rendezvous.os, "getuid", lambda: os.geteuid() + 1)
    with reached(tmp_path) as guest:
        guest.sendall(b'{"alive":"adopt"}\n')
        alone.end_frame(1)
        assert answer(guest) == b""


def test_a_folder_that_others_can_reach_into_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    os.close(private_folder())
    assert (tmp_path / rendezvous.FOLDER).stat().st_mode & 0o777 == 0o700
    (tmp_path / rendezvous.FOLDER).chmod(0o755)
    with pytest.raises(PermissionError):
        private_folder()
    assert find_engine(LABEL) is None
    (tmp_path / rendezvous.FOLDER).rmdir()
    (tmp_path / rendezvous.FOLDER).symlink_to(tmp_path)
    with pytest.raises(NotADirectoryError):
        private_folder()


def test_an_engine_of_another_version_is_named_and_left_alone(alone, tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.adoption.adoption.__version__", "0.0.0")
    asked: list[str] = []

    def ask() -> None:
        try:
            find_engine(LABEL)
        except CannotAdopt as error:
            asked.append(str(error))

    thread = threading.Thread(target=ask)
    thread.start()
    for tick in range(1, 500):
        alone.end_frame(tick)
        if asked:
            break
        thread.join(0.02)
    assert "version" in asked[0]
    assert f"kill {os.getpid()}" in asked[0]
    assert alone.orphaned


def test_the_hand_over_gives_what_was_noted_so_far(alone, tmp_path):
    alone.log.add_own_line('{"journal":2}')
    alone.log.add_own_line('{"tick":5,"event":{"type":"Tap"}}')
    found: list[Any] = []
    thread = threading.Thread(target=lambda: found.append(find_engine(LABEL)))
    thread.start()
    for tick in range(6, 500):
        alone.end_frame(tick)
        alone.beat(tick, Phase.RUNNING)
        if found:
            break
        thread.join(0.02)
    assert found[0].lines[:2] == ['{"journal":2}', '{"tick":5,"event":{"type":"Tap"}}']
    assert found[0].process.pid == os.getpid()
    assert found[0].process.poll() is None
    assert found[0].heartbeat.phase is Phase.RUNNING
    assert not alone.orphaned
    found[0].channel.close()
    found[0].heartbeat.close()
