"""The watchdog with simulated machines: starved processes are never ended, hung ones are, as soon as possible."""

import math
import os
import random
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.clock.time_source import ManualClock
from live.supervisor.process import ROUND
from live.supervisor.process_stats import read_machine, usage_of
from live.supervisor.restart_policy import HANGS_AFTER, MAX_SILENCE
from live.supervisor.watchdog import (
    MAX_SLOWDOWN,
    NOTICEABLE_GAP,
    MachineLoad,
    MachineReading,
    Usage,
    Verdict,
    Watchdog,
    overload,
)

BLIND = Usage("S", 0.0, None)
"""What a system says that counts no waiting."""


class SimulatedProcess:
    """A process that needs `work` [s] of the processor for a frame and gets a share of each step."""

    def __init__(self, work: float, *, threads: bool = False, counted: bool = True) -> None:
        """`threads`: worker threads do the work and the main one waits; `counted`: the system counts waiting."""
        self.clock, self.work, self._threads, self._counted = ManualClock(1000.0), work, threads, counted
        self.beat, self._left = self.clock.now(), work
        self.run = self.delay = 0.0
        self.state = "R"

    def step(self, seconds: float, share: float) -> None:
        """Run for a share of these seconds and wait for the rest."""
        self.clock.advance(seconds)
        self.run += share * seconds
        self.delay += (1.0 - share) * seconds
        self._left -= share * seconds
        if self._left <= 0.0:
            self.beat, self._left = self.clock.now(), self.work

    def usage(self) -> Usage:
        if not self._counted:
            return Usage(self.state, self.run, None)
        return Usage("S", 0.0, 0.0, self.run, self.delay) if self._threads else Usage("R", self.run, self.delay)


class SimulatedHang:
    """A process without further heartbeats: asleep, or in a loop with a share of the processor."""

    def __init__(self, state: str, *, share: float = 0.0, counted: bool = True) -> None:
        self.clock, self._state, self._share, self._counted = ManualClock(1000.0), state, share, counted
        self.beat = self.clock.now()

    def usage(self) -> Usage:
        seconds = self.clock.now() - self.beat
        run, delay = self._share * seconds, (1.0 - self._share) * seconds if self._state == "R" else 0.0
        return Usage(self._state, run, delay if self._counted else None)

    def ended_after(self, slowdown: float, *, look_every: float = ROUND, watchdog: Watchdog | None = None) -> float:
        """Lifetime [s] until the watchdog reports a hang."""
        watchdog = watchdog or Watchdog()
        while self.clock.now() - self.beat < 1000.0:
            if watchdog.update(self.clock.now(), self.beat, self.usage, slowdown) is Verdict.HUNG:
                return self.clock.now() - self.beat
            self.clock.advance(look_every)
        return math.inf


@pytest.mark.long
@given(st.integers(0, 1 << 32), st.floats(0.01, 1.5), st.floats(0.1, 1.0), st.booleans(), st.booleans())
@settings(max_examples=60, deadline=None)
def test_starved_process_is_never_ended_before_ceiling(seed, work, share, threads, counted):
    """Frames of 10 ms to 1.5 s of work; a loaded machine does a tenth to all of it in each second, in bursts with
    pauses of up to three seconds; the watchdog itself wakes late.
    """
    chance = random.Random(seed)
    process, watchdog = SimulatedProcess(work, threads=threads, counted=counted or threads), Watchdog()
    load = MachineLoad(ROUND)
    until = process.clock.now() + 120.0
    while process.clock.now() < until:
        pause = chance.uniform(0.0, 3.0) if chance.random() < 0.02 else 0.0
        steps = [(ROUND, 0.0)] * int(pause / ROUND) or [(ROUND + chance.expovariate(20.0), share)]
        for seconds, given_share in steps:
            process.step(seconds, given_share)
            load.record_wakeup(seconds - ROUND, seconds)
            verdict = watchdog.update(process.clock.now(), process.beat, process.usage, load.slowdown)
            assert verdict is not Verdict.HUNG or process.clock.now() - process.beat > MAX_SILENCE


@pytest.mark.parametrize("process", [
    SimulatedHang("S"), SimulatedHang("R", share=1.0), SimulatedHang("S", counted=False),
    SimulatedHang("R", share=1.0, counted=False), SimulatedHang("T"),
])  # fmt: skip
def test_hung_process_on_quiet_machine_is_ended_within_2500_ms(process):
    """Asleep, in a loop, stopped; on kernels that count waiting, and on others."""
    assert HANGS_AFTER <= process.ended_after(1.0) <= HANGS_AFTER + 0.5


def test_hung_process_without_usage_data_is_ended_as_soon():
    process, watchdog = SimulatedHang("S"), Watchdog()
    found: list[float] = []
    while not found:
        process.clock.advance(ROUND)
        if watchdog.update(process.clock.now(), process.beat, lambda: None, 1.0) is Verdict.HUNG:
            found.append(process.clock.now() - process.beat)
    assert HANGS_AFTER <= found[0] <= HANGS_AFTER + 0.5


@given(st.floats(1.0, 1000.0), st.sampled_from("SRD"), st.floats(ROUND, 0.4))
@settings(deadline=None)
def test_hung_process_on_overloaded_machine_is_ended_within_grown_bound(crowd, state, look_every):
    """`crowd` processes compete for each processor: a loop gets its share of one, a sleeper waits for others."""
    process = SimulatedHang(state, share=1.0 / crowd if state == "R" else 0.0)
    load = MachineLoad(ROUND)
    load.record_reading(0.0, MachineReading(crowd, 0.0))
    load.record_reading(100.0, MachineReading(crowd, 100.0))  # some thread waited all the time
    grown = {"R": load.slowdown, "S": min(load.slowdown, 4.0), "D": 4.0}[state]
    bound = min(HANGS_AFTER * grown * max(look_every / 0.1, 1.0), MAX_SILENCE)
    lived = process.ended_after(load.slowdown, look_every=look_every)
    assert HANGS_AFTER <= lived <= bound + 0.6 + 2 * look_every


def test_long_suspend_ends_no_process():
    process, watchdog = SimulatedProcess(0.01), Watchdog()
    for _ in range(50):
        process.step(ROUND, 1.0)
        watchdog.update(process.clock.now(), process.beat, process.usage, 1.0)
    process.clock.advance(8 * 3600.0)
    assert watchdog.update(process.clock.now(), process.beat, process.usage, 1.0) is Verdict.FINE
    process.clock.advance(ROUND)
    assert watchdog.update(process.clock.now(), process.beat, process.usage, 1.0) is not Verdict.HUNG


def test_slow_frame_and_loop_differ_by_processor_time():
    """With three loops for each processor a frame of 1.5 s of work takes six: it is spared and reported as overloaded.
    A loop is ended once it has used two seconds.
    """
    slow, watchdog = SimulatedProcess(1.5), Watchdog()
    verdicts = []
    for _ in range(1000):
        slow.step(ROUND, 0.25)
        verdicts.append(watchdog.update(slow.clock.now(), slow.beat, slow.usage, 4.0))
    assert set(verdicts) == {Verdict.FINE, Verdict.OVERLOADED}
    assert (watchdog.late, watchdog.overload_silences) == (4, 3)  # the fourth frame is not over yet
    assert watchdog.slowdown == pytest.approx(4.0)
    assert SimulatedHang("R", share=0.25).ended_after(4.0) == pytest.approx(4.0 * HANGS_AFTER, abs=0.5)


def test_late_heartbeat_is_counted_once_per_silence():
    clock, watchdog, beat = ManualClock(10.0), Watchdog(), 10.0
    for silence in (0.4, 0.7, 1.9, 0.1, 0.6):
        beat = clock.now()
        while clock.now() - beat < silence:
            clock.advance(ROUND)
            assert watchdog.update(clock.now(), beat, lambda: BLIND, 1.0) is not Verdict.HUNG
    assert watchdog.late == 3


def test_limit_factor_extends_time_before_process_is_ended():
    watchdog = Watchdog()
    watchdog.limit_factor = 4.0
    assert SimulatedHang("S").ended_after(1.0, watchdog=watchdog) == pytest.approx(4.0 * HANGS_AFTER, abs=0.5)
    starved = SimulatedHang("R", share=0.001)
    watchdog = Watchdog()
    watchdog.limit_factor = 4.0
    assert starved.ended_after(1000.0, watchdog=watchdog) == pytest.approx(4.0 * MAX_SILENCE, abs=0.5)


def record_readings(load: MachineLoad, seconds: float, reading: Callable[[float], MachineReading]) -> None:
    for quarter in range(int(seconds * 4)):
        load.record_reading(quarter / 4, reading(quarter / 4))


@pytest.mark.parametrize(("reading", "slowdown"), [
    (lambda at: MachineReading(), 1.0),
    (lambda at: MachineReading(0.5, 0.0, 0.0, 0.0, 0.0), 1.0),
    (lambda at: MachineReading(4.0, at), 4.0),
    (lambda at: MachineReading(4.0), 4.0),  # no pressure-stall information
    (lambda at: MachineReading(4.0, 0.5 * at), 2.5),
    (lambda at: MachineReading(0.5, 0.0, at, 0.75 * at, 0.0), 4.0),  # it swaps
    (lambda at: MachineReading(0.5, 0.0, 0.0, 0.0, 0.5 * at), 2.0),
    (lambda at: MachineReading(1e9, at, at, at, at), MAX_SLOWDOWN),
])  # fmt: skip
def test_slowdown_is_measured_from_machine_readings(reading, slowdown):
    load = MachineLoad(ROUND)
    record_readings(load, 60.0, reading)
    assert load.slowdown == pytest.approx(slowdown, rel=0.01)


def test_late_watchdog_wakeups_raise_slowdown_and_are_forgotten():
    load = MachineLoad(ROUND)
    for _ in range(200):
        load.record_wakeup(0.08, 0.1)
    assert load.slowdown == pytest.approx(5.0, rel=0.01)
    assert load.lateness == 0.08
    for _ in range(2000):
        load.record_wakeup(0.0, ROUND)
    assert load.slowdown == pytest.approx(1.0, abs=0.01)
    assert load.lateness < 0.001


def test_overload_without_late_heartbeats_is_zero():
    """A machine full of other work on which heartbeats still come in time."""
    load, watchdog, clock = MachineLoad(ROUND), Watchdog(), ManualClock(5.0)
    record_readings(load, 60.0, lambda at: MachineReading(4.0, at))
    for _ in range(100):
        clock.advance(ROUND)
        watchdog.update(clock.now(), clock.now(), lambda: BLIND, load.slowdown)
    assert overload(load, watchdog) == 0.0
    beat = clock.now()
    for _ in range(10):
        clock.advance(ROUND)
        watchdog.update(clock.now(), beat, lambda: BLIND, load.slowdown)
    assert watchdog.gap > NOTICEABLE_GAP
    assert overload(load, watchdog) == pytest.approx(1.0, rel=0.01)
    assert overload(MachineLoad(ROUND), watchdog) == 0.0  # late by itself


def test_system_reports_usage_and_runnable_processes():
    """Linux: this very process has run, and some process on this machine can run."""
    usage = usage_of(os.getpid())
    assert usage is not None
    assert usage.state in "RS"
    assert usage.run > 0.0
    assert usage_of(1 << 30) is None
    assert read_machine().runnable is not None
