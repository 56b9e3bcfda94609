"""Adoption after a supervisor is killed: engine and journal continue, and the next supervisor adopts them."""

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
from tests.fixtures.mostly_long import mostly_long
from tests.supervisor.made_show import LABEL


@dataclass
class SupervisedShow:
    """A journal and the supervisors started for it one after another."""

    journal: Path
    plan: dict[str, Any]
    supervisors: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def start(self) -> None:
        """Start another supervisor."""
        with self._output_path(len(self.supervisors)).open("w") as out:
            self.supervisors.append(
                subprocess.Popen(
                    [sys.executable, "-m", "tests.supervisor.made_show", str(self.journal), json.dumps(self.plan)],
                    stdout=out,
                )
            )

    def output(self) -> list[str]:
        """Output lines of the last supervisor."""
        return self._output_path(len(self.supervisors) - 1).read_text().splitlines()

    def _output_path(self, number: int) -> Path:
        return self.journal.with_name(f"output{number}")

    def kill(self) -> None:
        """Kill the last supervisor."""
        self.supervisors[-1].kill()
        self.supervisors[-1].wait()

    def lines(self) -> list[dict[str, Any]]:
        """Complete lines of the journal."""
        text = self.journal.read_text() if self.journal.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def numbers(self) -> list[int]:
        """Numbers of the events in the journal."""
        return [line["event"]["number"] for line in self.lines() if "event" in line]

    def until(self, number: int) -> None:
        """Wait until the journal contains this event number."""
        assert wait_for(lambda: (self.numbers() or [0])[-1] >= number, 20), self.numbers()[-3:]


@pytest.fixture
def start_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., SupervisedShow]]:
    """Starts a show; remaining processes are ended after the test."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    shows: list[SupervisedShow] = []

    def begin(**plan: Any) -> SupervisedShow:
        show = SupervisedShow(tmp_path / "j", {"alone": 60.0, "journal": str(tmp_path / "j"), "pace": 0.01, **plan})
        shows.append(show)
        show.start()
        return show

    yield begin
    for show in shows:
        for process in show.supervisors:
            process.kill()
            process.wait()
    end_engines(LABEL)
    assert wait_for(lambda: not running_engines(tmp_path), 20)


def running_engines(folder: Path) -> list[int]:
    """Engines whose plan is in that folder: those started by this test."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            mine = f"XDG_RUNTIME_DIR={folder}\0".encode() in (path / "environ").read_bytes()
            if mine and b"made_engine" in (path / "cmdline").read_bytes():
                found.append(int(path.name))
        except OSError:
            continue
    return found


def engine_pid(show: SupervisedShow) -> int:
    """Process number of the engine that began the show."""
    return int(show.lines()[0]["pid"])


@pytest.mark.long
def test_killed_supervisor_ends_no_engine_and_loses_no_journal_line(start_show):
    show = start_show(ticks=400)
    show.until(100)
    show.kill()
    show.until(400)
    assert wait_for(lambda: show.lines()[-1].get("end", False), 10)
    assert show.numbers() == list(range(1, 401))


def test_next_supervisor_adopts_engine_and_survives_its_death(start_show, tmp_path):
    """Three supervisors, two of them killed, then the engine killed: one show and one journal throughout."""
    show = start_show()
    for _ in range(2):
        show.until((show.numbers() or [0])[-1] + 80)
        show.kill()
        show.until(show.numbers()[-1] + 50)
        show.start()
        assert wait_for(lambda: bool(show.output()), 20)
        assert show.output()[0] == "adopted"
    engine = engine_pid(show)
    assert wait_for(lambda: len(running_engines(tmp_path)) == 3, 20)  # with a nursery and a spare
    show.until(show.numbers()[-1] + 80)
    os.kill(engine, signal.SIGKILL)
    assert wait_for(lambda: any("went" in line for line in show.lines()), 20)
    show.until(show.numbers()[-1] + 20)
    assert [line["went"] for line in show.lines() if "went" in line] == ["spare"]
    show.supervisors[-1].send_signal(signal.SIGTERM)
    assert show.supervisors[-1].wait(20) in (0, 128 + signal.SIGTERM)
    assert (heard := show.numbers()) == list(range(1, heard[-1] + 1))  # read once: it is being written
    assert not running_engines(tmp_path)
    assert not list(tmp_path.glob("*/*.sock"))


@pytest.mark.long
def test_adopted_show_that_ends_gives_supervisor_exit_code_zero(start_show):
    show = start_show(ticks=500)
    show.until(100)
    show.kill()
    show.until(150)
    show.start()
    assert show.supervisors[-1].wait(30) == 0
    assert show.numbers() == list(range(1, 501))
    assert show.lines()[-1] == {"tick": 500, "end": True}


@pytest.mark.long
def test_torn_line_is_cut_and_removed_journal_is_restarted(start_show):
    show = start_show()
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


def test_engine_with_live_supervisor_is_not_adopted(start_show, tmp_path):
    show = start_show()
    show.until(20)
    assert find_engine(LABEL) is None
    show.until(40)


@pytest.mark.long
def test_orphaned_engine_ends_on_request(start_show, tmp_path):
    show = start_show()
    show.until(20)
    assert end_engines(LABEL) == []  # it has a supervisor
    show.kill()
    assert wait_for(lambda: end_engines(LABEL) == [engine_pid(show)], 10)
    assert wait_for(lambda: not running_engines(tmp_path), 20)
    assert find_engine(LABEL) is None
    assert not list(tmp_path.glob("*/*.sock"))  # whoever found that nobody listens has removed it


@pytest.mark.long
def test_show_without_processes_resumes_from_journal(start_show, tmp_path):
    show = start_show(origin=time.perf_counter())
    show.until(100)
    show.kill()
    for pid in running_engines(tmp_path):
        os.kill(pid, signal.SIGKILL)
    assert wait_for(lambda: not running_engines(tmp_path), 20)
    last = show.numbers()[-1]
    with show.journal.open("a") as file:
        file.write('{"tick":51,"ev')
    show.start()
    show.until(last + 50)
    assert show.output()[0] == "resumed"
    assert [line["went"] for line in show.lines() if "went" in line] == ["heir"]
    assert (heard := show.numbers()) == list(range(1, heard[-1] + 1))  # read once: it is being written
    assert not list(tmp_path.glob("j.*"))


@mostly_long("waiting", [0, 8], ids=["alone", "with a full queue of those who asked"], quick=[0])
def test_hung_orphaned_engine_is_ended_by_next_supervisor(start_show, tmp_path, monkeypatch, waiting):
    monkeypatch.setattr(adoption, "ANSWERS_WITHIN", 1.0)
    show = start_show(origin=time.perf_counter())
    show.until(100)
    show.kill()
    show.until(show.numbers()[-1] + 20)
    engine = engine_pid(show)
    os.kill(engine, signal.SIGSTOP)
    path = next(tmp_path.glob("*/*.sock"))
    with contextlib.ExitStack() as asked:
        folder = os.open(path.parent, os.O_DIRECTORY)  # the path of a socket has at most 107 bytes
        asked.callback(os.close, folder)
        for _ in range(waiting):
            sock = asked.enter_context(socket.socket(socket.AF_UNIX))
            sock.setblocking(False)
            with contextlib.suppress(BlockingIOError):
                sock.connect(f"/proc/self/fd/{folder}/{path.name}")
        with pytest.raises(EngineHung, match=str(engine)):
            find_engine(LABEL)
    assert engine not in running_engines(tmp_path)
    assert read_interrupted(show.journal) is not None


@pytest.mark.long
def test_engine_starved_of_processor_is_not_ended(start_show, tmp_path, monkeypatch):
    """The process only waits for a processor: none of the elapsed seconds is its own processor time."""
    show = start_show(origin=time.perf_counter())
    show.until(50)
    show.kill()
    show.until(show.numbers()[-1] + 20)
    engine, delays = engine_pid(show), itertools.count()
    monkeypatch.setattr(orphan, "usage_of", lambda pid: Usage("R", 0.0, 0.1 * next(delays)))
    monkeypatch.setattr(orphan, "MAX_SILENCE", 4.0)
    [name] = [path.name for path in tmp_path.glob("*/*.sock")]
    assert orphan.socket_holders(name) == [engine]
    assert orphan.kill_if_hung(name, lambda: False) == []
    assert engine in running_engines(tmp_path)


def write_journal(path: Path, *lines: dict[str, Any], **header: Any) -> Path:
    first = {"journal": 2, "origin": time.perf_counter() - 20.0, **header}
    path.write_text("".join(json.dumps(line, separators=(",", ":")) + "\n" for line in (first, *lines)))
    return path


def test_only_recently_interrupted_journal_of_same_boot_is_resumed(tmp_path, monkeypatch):
    tap = {"tick": 64, "event": {"type": "Tap"}}
    path = write_journal(tmp_path / "j", tap)
    left = read_interrupted(path)
    assert left is not None
    assert left.interrupted_s == pytest.approx(19.0, abs=5.0 * BUSY)
    assert [json.loads(line) for line in left.lines[1:]] == [tap, {"tick": 64}]
    assert read_interrupted(tmp_path / "none") is None
    assert read_interrupted(write_journal(tmp_path / "j", tap, {"tick": 99, "end": True})) is None
    assert read_interrupted(write_journal(tmp_path / "j", tap, origin=None)) is None
    assert read_interrupted(write_journal(tmp_path / "j")) is None
    assert read_interrupted(write_journal(tmp_path / "j", tap, origin=time.perf_counter() - 400.0)) is None
    assert (
        read_interrupted(write_journal(tmp_path / "j", {"tick": 64 * 60, "event": {}})) is None
    )  # it lies in the future
    path = write_journal(tmp_path / "j", tap)
    os.utime(path, (0.0, time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) - 10.0))  # of the start before
    assert read_interrupted(path) is None
    path.write_bytes(b"\xff" * 500 + b"\n[1]\n" + b"[" * 9000 + b"\n")
    assert read_interrupted(path) is None


def test_show_with_changed_steps_resumes_from_snapshot_before_change(tmp_path, monkeypatch):
    """A follower that begins with the first line has read the steps of that time."""
    shots = [json.dumps({"snapshot": 3, "tick": tick}).encode() + b"\n" + bytes(64) for tick in (10, 30, 50)]
    monkeypatch.setattr("live.supervisor.adoption.journal_resume.read_snapshots", lambda path, problems: iter(shots))
    lines = [{"tick": tick, "event": {"type": "Tap"}} for tick in range(5, 65, 5)]
    left = read_interrupted(write_journal(tmp_path / "j", *lines))
    assert left is not None
    told = [json.loads(line) for line in left.lines]
    assert [line["tick"] for line in told[1:]] == [50, 50, 55, 60, 60]
    assert left.snapshots_kept == sum(map(len, shots))
    lines[6]["event"]["type"] = "StepsChanged"  # tick 35
    left = read_interrupted(write_journal(tmp_path / "j", *lines))
    assert left is not None
    told = [json.loads(line) for line in left.lines]
    assert "snapshot" in told[1]
    assert [line["tick"] for line in told[1:]] == [30, 30, 35, 40, 45, 50, 55, 60, 60]


# -- the engine's side, without processes ----------------------------------------------------------------------------


@pytest.fixture
def orphaned_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SupervisorLink]:
    """An engine without its supervisor."""
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


def connect_guest(tmp_path: Path) -> socket.socket:
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    folder = os.open(tmp_path / rendezvous.FOLDER, os.O_RDONLY)
    sock.connect(f"/proc/self/fd/{folder}/{LABEL}.{os.getpid()}.sock")
    os.close(folder)
    return sock


def read_answer(guest: socket.socket) -> bytes:
    """Bytes received until the engine hangs up, within seconds."""
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
def test_invalid_adoption_request_is_refused_without_delaying_show(orphaned_link, tmp_path, words):
    with connect_guest(tmp_path) as guest:
        guest.sendall(words)
        guest.shutdown(socket.SHUT_WR)
        longest = 0.0
        for tick in range(3):
            before = time.perf_counter()
            orphaned_link.end_frame(tick)
            longest = max(longest, time.perf_counter() - before)
        assert orphaned_link.orphaned
        assert longest < 0.1 * BUSY
        assert b"descriptors" not in read_answer(guest)


def test_silent_guests_time_out_and_their_number_is_limited(orphaned_link, tmp_path, monkeypatch):
    guests = []
    for tick in range(6):
        guests.append(connect_guest(tmp_path))
        orphaned_link.end_frame(tick)
    for guest in guests[4:]:
        assert read_answer(guest) == b""
    guests[0].setblocking(False)
    with pytest.raises(BlockingIOError):
        guests[0].recv(1)
    monkeypatch.setattr(rendezvous, "PATIENCE", 0.0)
    orphaned_link.end_frame(9)
    for guest in guests:
        assert read_answer(guest) == b""
        guest.close()


def test_other_user_is_refused(orphaned_link, tmp_path, monkeypatch):
    monkeypatch.setattr(rendezvous.os, "getuid", lambda: os.geteuid() + 1)
    with connect_guest(tmp_path) as guest:
        guest.sendall(b'{"alive":"adopt"}\n')
        orphaned_link.end_frame(1)
        assert read_answer(guest) == b""


def test_folder_accessible_to_others_is_not_used(tmp_path, monkeypatch):
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


def test_engine_of_another_version_is_named_and_left_running(orphaned_link, tmp_path, monkeypatch):
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
        orphaned_link.end_frame(tick)
        if asked:
            break
        thread.join(0.02)
    assert "version" in asked[0]
    assert f"kill {os.getpid()}" in asked[0]
    assert orphaned_link.orphaned


def test_handover_contains_recorded_lines(orphaned_link, tmp_path):
    orphaned_link.log.add_own_line('{"journal":2}')
    orphaned_link.log.add_own_line('{"tick":5,"event":{"type":"Tap"}}')
    found: list[Any] = []
    thread = threading.Thread(target=lambda: found.append(find_engine(LABEL)))
    thread.start()
    for tick in range(6, 500):
        orphaned_link.end_frame(tick)
        orphaned_link.beat(tick, Phase.RUNNING)
        if found:
            break
        thread.join(0.02)
    assert found[0].lines[:2] == ['{"journal":2}', '{"tick":5,"event":{"type":"Tap"}}']
    assert found[0].process.pid == os.getpid()
    assert found[0].process.poll() is None
    assert found[0].heartbeat.phase is Phase.RUNNING
    assert not orphaned_link.orphaned
    found[0].channel.close()
    found[0].heartbeat.close()
