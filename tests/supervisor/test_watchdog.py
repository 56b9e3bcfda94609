"""The watchdog with made-up machines: who is starved is never ended, who hangs is, as soon as the machine allows."""

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


class MadeProcess:
    """A process that needs `work` [s] of the processor for a frame, and gets the processor for a share of each step."""

    def __init__(self, work: float, *, threads: bool = False, told: bool = True) -> None:
        """`threads`: others do the work, and the main one waits for them; `told`: the system counts waiting."""
        self.clock, self.work, self._threads, self._told = ManualClock(1000.0), work, threads, told
        self.beat, self._left = self.clock.now(), work
        self.run = self.delay = 0.0
        self.state = "R"

    def step(self, seconds: float, share: float) -> None:
        """Let it run for a share of so many seconds; the rest of them it waits."""
        self.clock.advance(seconds)
        self.run += share * seconds
        self.delay += (1.0 - share) * seconds
        self._left -= share * seconds
        if self._left <= 0.0:
            self.beat, self._left = self.clock.now(), self.work

    def usage(self) -> Usage:
        if not self._told:
            return Usage(self.state, self.run, None)
        return Usage("S", 0.0, 0.0, self.run, self.delay) if self._threads else Usage("R", self.run, self.delay)


class MadeHang:
    """A process that never beats again: it sleeps, or is in a loop and gets a share of the processor."""

    def __init__(self, state: str, *, share: float = 0.0, told: bool = True) -> None:
        self.clock, self._state, self._share, self._told = ManualClock(1000.0), state, share, told
        self.beat = self.clock.now()

    def usage(self) -> Usage:
        seconds = self.clock.now() - self.beat
        run, delay = self._share * seconds, (1.0 - self._share) * seconds if self._state == "R" else 0.0
        return Usage(self._state, run, delay if self._told else None)

    def ended_after(self, slowdown: float, *, look_every: float = ROUND, watchdog: Watchdog | None = None) -> float:
        """How long it lived [s]."""
        watchdog = watchdog or Watchdog()
        while self.clock.now() - self.beat < 1000.0:
            if watchdog.update(self.clock.now(), self.beat, self.usage, slowdown) is Verdict.HUNG:
                return self.clock.now() - self.beat
            self.clock.advance(look_every)
        return math.inf


@given(st.integers(0, 1 << 32), st.floats(0.01, 1.5), st.floats(0.1, 1.0), st.booleans(), st.booleans())
@settings(max_examples=60, deadline=None)
def test_who_is_starved_is_never_ended_before_the_ceiling(seed, work, share, threads, told):
    """Frames of 10 ms to 1.5 s of work, of which a loaded machine does a tenth to all in each second, in bursts between
    which there is nothing for up to three seconds; the watcher itself wakes late."""
    chance = random.Random(seed)
    process, watchdog = MadeProcess(work, threads=threads, told=told or threads), Watchdog()
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


@pytest.mark.parametrize("process", [MadeHang("S"), MadeHang("R", share=1.0), MadeHang("S", told=False),
                                     MadeHang("R", share=1.0, told=False), MadeHang("T")])  # fmt: skip
def test_who_hangs_on_a_quiet_machine_is_ended_within_two_and_a_half_seconds(process):
    """Asleep, in a loop, stopped; on kernels that count waiting, and on others."""
    assert HANGS_AFTER <= process.ended_after(1.0) <= HANGS_AFTER + 0.5


def test_who_hangs_where_the_system_says_nothing_is_ended_as_soon():
    process, watchdog = MadeHang("S"), Watchdog()
    found: list[float] = []
    while not found:
        process.clock.advance(ROUND)
        if watchdog.update(process.clock.now(), process.beat, lambda: None, 1.0) is Verdict.HUNG:
            found.append(process.clock.now() - process.beat)
    assert HANGS_AFTER <= found[0] <= HANGS_AFTER + 0.5


@given(st.floats(1.0, 1000.0), st.sampled_from("SRD"), st.floats(ROUND, 0.4))
@settings(deadline=None)
def test_who_hangs_on_an_overloaded_machine_is_ended_within_the_grown_bound(crowd, state, look_every):
    """`crowd` processes want each processor: a loop gets its part of one, who sleeps waits for others that do."""
    process = MadeHang(state, share=1.0 / crowd if state == "R" else 0.0)
    load = MachineLoad(ROUND)
    load.record_reading(0.0, MachineReading(crowd, 0.0))
    load.record_reading(100.0, MachineReading(crowd, 100.0))  # some thread waited all the time
    grown = {"R": load.slowdown, "S": min(load.slowdown, 4.0), "D": 4.0}[state]
    bound = min(HANGS_AFTER * grown * max(look_every / 0.1, 1.0), MAX_SILENCE)
    lived = process.ended_after(load.slowdown, look_every=look_every)
    assert HANGS_AFTER <= lived <= bound + 0.6 + 2 * look_every


def test_who_wakes_after_a_night_ends_nobody_for_it():
    process, watchdog = MadeProcess(0.01), Watchdog()
    for _ in range(50):
        process.step(ROUND, 1.0)
        watchdog.update(process.clock.now(), process.beat, process.usage, 1.0)
    process.clock.advance(8 * 3600.0)
    assert watchdog.update(process.clock.now(), process.beat, process.usage, 1.0) is Verdict.FINE
    process.clock.advance(ROUND)
    assert watchdog.update(process.clock.now(), process.beat, process.usage, 1.0) is not Verdict.HUNG


def test_a_slow_frame_and_a_loop_are_told_apart_by_the_processor_they_used():
    """On three loops for each processor a frame of 1.5 s of work takes six: it is spared, and told to be overloaded. A
    loop is ended once it has used two seconds."""
    slow, watchdog = MadeProcess(1.5), Watchdog()
    verdicts = []
    for _ in range(1000):
        slow.step(ROUND, 0.25)
        verdicts.append(watchdog.update(slow.clock.now(), slow.beat, slow.usage, 4.0))
    assert set(verdicts) == {Verdict.FINE, Verdict.OVERLOADED}
    assert (watchdog.late, watchdog.overload_silences) == (4, 3)  # the fourth frame is not over yet
    assert watchdog.slowdown == pytest.approx(4.0)
    assert MadeHang("R", share=0.25).ended_after(4.0) == pytest.approx(4.0 * HANGS_AFTER, abs=0.5)


def test_a_heart_is_late_once_however_often_it_is_looked_at():
    clock, watchdog, beat = ManualClock(10.0), Watchdog(), 10.0
    for silence in (0.4, 0.7, 1.9, 0.1, 0.6):
        beat = clock.now()
        while clock.now() - beat < silence:
            clock.advance(ROUND)
            assert watchdog.update(clock.now(), beat, lambda: BLIND, 1.0) is not Verdict.HUNG
    assert watchdog.late == 3


def test_who_was_ended_on_an_overloaded_machine_gives_the_next_one_longer():
    watchdog = Watchdog()
    watchdog.limit_factor = 4.0
    assert MadeHang("S").ended_after(1.0, watchdog=watchdog) == pytest.approx(4.0 * HANGS_AFTER, abs=0.5)
    starved = MadeHang("R", share=0.001)
    watchdog = Watchdog()
    watchdog.limit_factor = 4.0
    assert starved.ended_after(1000.0, watchdog=watchdog) == pytest.approx(4.0 * MAX_SILENCE, abs=0.5)


def _read(load: MachineLoad, seconds: float, reading: Callable[[float], MachineReading]) -> None:
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
def test_what_a_machine_is_slowed_down_by_is_measured(reading, slowdown):
    load = MachineLoad(ROUND)
    _read(load, 60.0, reading)
    assert load.slowdown == pytest.approx(slowdown, rel=0.01)


def test_a_watcher_that_wakes_late_knows_it_and_forgets_it():
    load = MachineLoad(ROUND)
    for _ in range(200):
        load.record_wakeup(0.08, 0.1)
    assert load.slowdown == pytest.approx(5.0, rel=0.01)
    assert load.lateness == 0.08
    for _ in range(2000):
        load.record_wakeup(0.0, ROUND)
    assert load.slowdown == pytest.approx(1.0, abs=0.01)
    assert load.lateness < 0.001


def test_an_overload_that_nobody_feels_is_none():
    """A machine that is full of other work, and beats come in time all the same."""
    load, watchdog, clock = MachineLoad(ROUND), Watchdog(), ManualClock(5.0)
    _read(load, 60.0, lambda at: MachineReading(4.0, at))
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


def test_this_system_says_what_it_is_asked():
    """Linux: this very process has run, and something on this machine can run."""
    usage = usage_of(os.getpid())
    assert usage is not None
    assert usage.state in "RS"
    assert usage.run > 0.0
    assert usage_of(1 << 30) is None
    assert read_machine().runnable is not None
