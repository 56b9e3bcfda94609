"""A supervisor on a busy machine, with real processes: slow engines are not ended and no zombie remains."""

import itertools
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import psutil
import pytest

from live.clock.time_source import ManualClock
from live.supervisor.process import AuxiliaryProcess
from live.supervisor.process_stats import GRACE, Reaper, zombies
from live.supervisor.restart_policy import HANGS_AFTER, MAX_SILENCE
from tests.control.waiting import wait_for
from tests.fixtures.mostly_long import mostly_long
from tests.supervisor.test_supervisor import ENGINE, event_numbers, run_supervisor

PER_PROCESSOR = 3
"""Busy loops beside a show."""


@pytest.fixture
def busy_machine() -> Iterator[None]:
    """Three loops for each processor, each with the same priority as an engine."""
    loop = [sys.executable, "-S", "-c", "while True: pass"]
    count = PER_PROCESSOR * len(os.sched_getaffinity(0))
    loops = [subprocess.Popen(loop, start_new_session=True) for _ in range(count)]
    yield
    for one in loops:
        one.kill()
        one.wait()


@pytest.mark.long
@pytest.mark.usefixtures("busy_machine")
def test_engine_with_quarter_of_processor_is_not_killed(tmp_path):
    """Its frames take 0.8 s of processor time, more than two and a half seconds here."""
    code, lines, supervisor, said = run_supervisor(tmp_path, {"burns": 0.8, "ticks": 4}, spare=False)
    assert (code, said, supervisor.report.restarts) == (0, [], 0)
    assert event_numbers(lines) == [1, 2, 3, 4]
    assert supervisor.report.slowdown > 1.5


@pytest.mark.long
@pytest.mark.usefixtures("busy_machine")
@pytest.mark.parametrize("how", ["hangs", "loops"])
def test_hung_engine_on_busy_machine_is_killed(tmp_path, how):
    """Asleep or in a loop."""
    code, lines, supervisor, said = run_supervisor(tmp_path, {how: 20, "ticks": 30}, spare=False)
    assert (code, supervisor.report.restarts, supervisor.report.calm) == (0, 1, False)
    assert event_numbers(lines) == list(range(1, 31))
    after = float(said[0].partition(" for ")[2].split()[0])
    assert "no sign of life" in said[0]
    assert HANGS_AFTER <= after < MAX_SILENCE + 5.0  # a loop has two seconds of a processor, a sleep lasts eight


@pytest.mark.long
def test_engine_in_loop_is_killed_and_replaced(tmp_path):
    code, lines, supervisor, said = run_supervisor(tmp_path, {"loops": 120, "ticks": 160})
    assert (code, supervisor.report.restarts) == (0, 1)
    assert event_numbers(lines) == list(range(1, 161))
    assert "no sign of life" in said[0]


def test_no_process_is_prepared_during_overload(tmp_path, monkeypatch):
    """Neither a spare nor a nursery: the next engine starts when it is needed, and not before."""
    monkeypatch.setattr("live.supervisor.engine_failover.overload", lambda load, watched: 1.0)
    code, lines, supervisor, _ = run_supervisor(tmp_path, {"kills": [200], "ticks": 220})
    assert code == 0
    assert [(line["went"], line["nursery"]) for line in lines if "went" in line] == [("heir", None)]
    assert supervisor.report.overload == 1.0


@pytest.mark.long
def test_lasting_overload_delays_spare_engine_for_limited_time(tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.engine_failover.overload", lambda load, watched: 1.0)
    monkeypatch.setattr("live.supervisor.engine_failover.MAX_SPARE_DELAY", 0.1)
    _, lines, _, _ = run_supervisor(tmp_path, {"kills": [300], "ticks": 320})
    assert [line["went"] for line in lines if "went" in line] == ["spare"]


@pytest.mark.long
def test_engines_ended_during_overload_get_growing_time_limits(tmp_path, monkeypatch):
    """Three hang one after another, the last two in the same tick: each time the silence limit doubles."""
    monkeypatch.setattr("live.supervisor.engine_failover.overload", lambda load, watched: 1.0)
    plan = {"stage": 9, "hangs": 20, "hangs_again": True, "ticks": 40}
    code, lines, supervisor, said = run_supervisor(tmp_path, plan, spare=False)
    after = [float(line.partition(" for ")[2].split()[0]) for line in said if "no sign of life" in line]
    assert len(after) == supervisor.report.restarts == 3
    for number, seconds in enumerate(after):
        assert seconds >= HANGS_AFTER * 2.0**number
    assert (code, supervisor.report.calm) == (0, False)
    assert event_numbers(lines) == list(range(1, 20)) + list(range(20, 41))


SHOW = """
import sys
from live.supervisor.supervisor_config import SupervisorConfig
from live.supervisor.supervisor import Supervisor
orders = SupervisorConfig(engine=sys.argv[2:], show=sys.argv[1], spare_after=0.1)
sys.exit(Supervisor(orders, lambda line: print(line, flush=True)).run())
"""


def zombie_children(process: int) -> list[int]:
    """The zombies of another process."""
    found = []
    for child in psutil.Process(process).children():
        try:
            if child.status() == psutil.STATUS_ZOMBIE:
                found.append(child.pid)
        except psutil.NoSuchProcess:
            continue
    return found


@mostly_long("seed", [21, pytest.param(22, marks=pytest.mark.long)], quick=[])
def test_random_kills_leave_no_zombies(seed):
    """Engines, spares, the nursery, starting processes, and the helpers of each: helpers have no waiting parent once
    their engine is gone, and the supervisor has adopted them.
    """
    chance = random.Random(seed)
    command = [sys.executable, "-c", SHOW, json.dumps({"helpers": 3}), *ENGINE]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as show:
        adopted = 0
        try:
            for _ in range(14):
                assert wait_for(lambda: len(psutil.Process(show.pid).children(recursive=True)) > 4, 10)
                everyone = psutil.Process(show.pid).children(recursive=True)
                victim = chance.choice(everyone)
                adopted += victim.ppid() == show.pid
                victim.kill()
                threading.Event().wait(chance.uniform(0.0, 0.4))
            assert wait_for(lambda: not zombie_children(show.pid), 3 * GRACE)
            assert show.poll() is None
            assert adopted > 2  # engines among them
        finally:
            show.send_signal(signal.SIGTERM)
            show.communicate(timeout=60)


def test_awaited_child_keeps_exit_code():
    """A started process is reaped only after a time in which its exit code was not asked for."""
    reaper, clock = Reaper(), ManualClock(time.monotonic())
    asked = subprocess.Popen([sys.executable, "-S", "-c", "raise SystemExit(7)"])
    forgotten = os.posix_spawn(sys.executable, [sys.executable, "-S", "-c", ""], {})
    assert wait_for(lambda: {asked.pid, forgotten} <= set(zombies()), 10)
    reaper.update(clock.now())
    clock.advance(0.9 * GRACE)
    reaper.update(clock.now())
    assert asked.wait() == 7
    clock.advance(0.3 * GRACE)
    reaper.update(clock.now())
    assert forgotten not in set(zombies())
    assert reaper.count > 0


class ExitingChild:
    """A process that ends at once."""

    role, killed = "made", False

    def __init__(self) -> None:
        self.process, self.channel = self, self

    def hangs(self, now: float, slowdown: float) -> bool:
        return False

    def poll(self) -> int:
        return 1

    def end(self) -> int:
        return 1


def test_failing_auxiliary_process_is_restarted_ever_more_rarely_without_end():
    clock, starts = ManualClock(100.0), list[float]()

    def start() -> Any:
        starts.append(clock.now())
        if len(starts) == 5:
            raise OSError("out of processes")
        return ExitingChild()

    said: list[str] = []
    side = AuxiliaryProcess(start, said.append, child=start())
    while clock.now() < 1100.0:
        clock.advance(1.0)
        side.update(clock.now(), 1.0)
    gaps = [b - a for a, b in itertools.pairwise(starts)]
    assert gaps[:3] == [2.0, 2.0, 2.0]  # it is found dead in one second, and started in the next
    assert gaps[4:7] == [10.0, 21.0, 41.0]
    assert set(gaps[7:]) == {61.0}
    assert "started once more in 5 s" in said[3]
