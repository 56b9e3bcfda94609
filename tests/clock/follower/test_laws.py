"""Invariants of the follower for random inputs: sources, losses, returns, manual controls, invalid values."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.clock.follower.clock_source import PRIORITY
from live.clock.follower.phase_correction import SLEW_UNLOCKED
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM

Action = tuple[str, str, float, float, int]

SOURCES = ("link", "midi", "mtc", "audio")
wild = st.floats(allow_nan=True, allow_infinity=True)
whole = st.integers(-2, 13)
names = st.sampled_from(SOURCES)
no_source = st.just("audio")
kinds = st.one_of(
    st.tuples(st.just("play"), names, st.floats(15.5, 399.0), st.floats(0.5, 6.0), whole),
    st.tuples(st.just("start"), names, st.floats(30.0, 300.0), st.floats(0.5, 4.0), st.integers(0, 8)),
    st.tuples(st.just("count"), st.just("midi"), st.floats(30.0, 300.0), st.floats(0.5, 4.0), st.just(-1)),
    st.tuples(st.just("wait"), no_source, st.just(0.0), st.floats(0.0, 4.0), whole),
    st.tuples(st.sampled_from(["silent", "lost", "found", "paused"]), names, st.floats(-1.0, 0.3), st.just(0.0), whole),
    st.tuples(st.just("taps"), no_source, st.floats(0.2, 1.5), st.floats(0.5, 4.0), whole),
    st.tuples(st.just("said"), names, st.floats(-0.5, 0.5), st.floats(0.15, 2.0), whole),
    st.tuples(st.just("nonsense"), st.sampled_from([*SOURCES, "", "tap"]), wild, wild, st.integers(-(2**40), 2**40)),
    st.tuples(st.sampled_from(["one", "hold", "free", "half", "double"]), no_source, st.floats(-0.4, 0.4), wild, whole),
    st.tuples(st.sampled_from(["tempo", "nudge", "shift", "metre", "count_in", "scale"]), no_source,
              st.one_of(wild, st.floats(-8.0, 300.0)), st.floats(-0.4, 0.4), whole),
    st.tuples(st.just("choose"), st.sampled_from(["auto", *PRIORITY, "nobody"]), st.just(0.0), st.just(0.0), whole),
)  # fmt: skip
action_lists = st.lists(kinds, min_size=1, max_size=12)


class ScenarioRunner:
    """Runs the actions of a scenario and checks the invariants at every tick and after every input."""

    def __init__(self, metre: int = 4, *, follow_metre: bool = False) -> None:
        self.follower = TimelineFollower(beats_per_measure=metre, follow_metre=follow_metre)
        self.ticks = 0
        self.beat = self.follower.advance(0.0).beat_at(0.0)
        self.wholes = 0

    @property
    def now(self) -> float:
        return self.ticks * TICK

    def tick(self) -> None:
        follower, before, last = self.follower, self.follower.timeline, self.beat
        number, jumps = before.measure_at(self.now), follower.jumps
        self.ticks += 1
        timeline = follower.advance(self.now)
        self.beat = timeline.beat_at(self.now)
        leap = self.beat - before.beat_at(self.now)
        if abs(leap) > 1e-9:
            assert follower.jumps > jumps, "a jump is announced"
            assert follower.last_jump is not None
            assert 0.0 < leap < 1.0, "forward by less than a beat"
        speed = (self.beat - leap - last) / TICK * 60.0
        assert TEMPO_MIN_BPM * 0.999 <= speed <= TEMPO_MAX_BPM * 1.001
        assert TEMPO_MIN_BPM <= timeline.tempo <= TEMPO_MAX_BPM
        slew = abs(timeline.tempo / follower.tempo - 1.0)
        assert slew <= SLEW_UNLOCKED * 1.001 or timeline.tempo in (TEMPO_MIN_BPM, TEMPO_MAX_BPM)
        assert math.isclose(timeline.time_at(timeline.beat_at(self.now)), self.now, abs_tol=1e-6)
        counted_back = follower.last_jump is not None and follower.last_jump.cause == "first downbeat"
        if not (follower.jumps > jumps and counted_back):
            assert 0 <= timeline.measure_at(self.now) - number <= 1, "measures advance one by one"
        assert 1 <= timeline.beats_per_measure <= 12
        assert 0.0 <= follower.confidence <= 1.0
        assert follower.state in ("internal", "following", "locked", "freewheel", "held")

    def _beat(self, kind: str, name: str, bpm: float, into: int, *, jump: bool) -> None:
        counted = kind != "count"
        self.follower.observe(
            self.now, 60.0 / bpm, 0.8, self.now, source=name, beat=into % 4 if counted and into >= 0 else -1,
            beats_per_measure=4 * (counted and into >= 0), measure=into // 4 if name != "audio" else -1,
            jump=jump, anchored=counted,
        )  # fmt: skip

    def _last(self, kind: str, name: str, value: float, seconds: float, into: int) -> None:
        """Runs an action for some seconds."""
        end, due, first = self.now + seconds, self.now, kind == "start"
        while self.now < end:
            self.tick()
            if self.now < due or kind == "wait":
                continue
            if kind == "taps":
                self.follower.tap(self.now)
                due += value
            else:
                self._beat(kind, name, value, into, jump=first)
                due, into, first = due + 60.0 / value, into + (into >= 0), False

    def act(self, action: Action) -> None:
        kind, name, a, b, into = action
        follower, time = self.follower, self.now
        if kind in ("play", "start", "count", "wait", "taps"):
            self._last(kind, name, a, b, into)
        elif kind in ("silent", "lost", "found", "paused"):
            getattr(follower, kind)(time + a, name)
        elif kind == "said":
            follower.observe(time + a, b, 0.9, time, source=name, beat=into, beats_per_measure=into)
        elif kind == "nonsense":
            follower.observe(a, b, a, time, source=name, beat=into, beats_per_measure=into, measure=into)
            follower.set_downbeat(a)
        elif kind == "choose":
            follower.select_source(name)
        else:
            self._hand(kind, a, b, time)
        assert abs(follower.timeline.beat_at(self.now) - self.beat) < 1e-9, "no input moves the beat"

    def _hand(self, kind: str, a: float, b: float, time: float) -> None:
        follower = self.follower
        {
            "one": lambda: follower.set_downbeat(time + a), "hold": lambda: follower.hold(True, time),
            "free": lambda: follower.hold(False, time), "half": lambda: follower.scale_tempo(0.5, time),
            "double": lambda: follower.scale_tempo(2.0, time), "tempo": lambda: follower.set_tempo(a, time + b),
            "nudge": lambda: follower.nudge(a, time), "shift": lambda: follower.shift_beats(a, time),
            "metre": lambda: follower.set_metre(a, time), "count_in": lambda: follower.count_in(a, time),
            "scale": lambda: follower.scale_tempo(a, time),
        }[kind]()  # fmt: skip


@pytest.mark.long
@given(action_lists, st.integers(2, 7), st.booleans())
def test_beats_and_measures_advance_for_any_input(actions: list[Action], metre: int, follow_metre: bool) -> None:
    runner = ScenarioRunner(metre, follow_metre=follow_metre)
    for action in actions:
        runner.act(action)
        runner.tick()


@given(action_lists)
@settings(max_examples=6)
def test_same_scenario_gives_the_same_timeline(actions: list[Action]) -> None:
    ends = []
    for _ in range(2):
        runner = ScenarioRunner()
        for action in actions:
            runner.act(action)
        follower = runner.follower
        ends.append((follower.timeline, follower.state, follower.states, follower.confidence, follower.last_jump))
    assert ends[0] == ends[1]


@pytest.mark.long
@given(action_lists, st.sampled_from(["midi", "link", "audio"]), st.floats(60.0, 180.0), st.floats(1.0, 8.0))
@settings(max_examples=12)
def test_freewheel_keeps_a_linear_timeline(actions: list[Action], name: str, bpm: float, seconds: float) -> None:
    runner = ScenarioRunner()
    for action in (*actions, ("free", "", 0.0, 0.0, 0), ("choose", name, 0.0, 0.0, 0), ("found", name, 0.0, 0.0, 0),
                   ("wait", "", 0.0, 9.0, 0), ("play", name, bpm, 25.0, 0)):  # fmt: skip
        runner.act(action)
    assert runner.follower.source == name
    runner.follower.lost(runner.now, name)
    runner.tick()
    line, jumps = runner.follower.timeline, runner.follower.jumps
    runner.act(("wait", "", 0.0, seconds, 0))
    assert runner.follower.state == "freewheel"
    assert abs(runner.beat - line.beat_at(runner.now)) < 1e-6
    assert runner.follower.jumps == jumps


@pytest.mark.long
@given(action_lists, st.floats(60.0, 180.0), st.sampled_from([-1, 0]))
@settings(max_examples=12)
def test_follower_locks_to_steady_music_after_any_scenario(actions: list[Action], bpm: float, into: int) -> None:
    """Observed with (0) or without (-1) measures: locked, at the tempo or another level of it."""
    runner = ScenarioRunner()
    then = [("free", "", 0.0, 0.0, 0), ("choose", "audio", 0.0, 0.0, 0), ("found", "audio", 0.0, 0.0, 0),
            ("wait", "", 0.0, 9.0, 0), ("play", "audio", bpm, 40.0, into)]  # fmt: skip
    for action in (*actions, *then):
        runner.act(action)
    assert runner.follower.state == "locked"
    level = runner.follower.tempo / bpm
    assert min(abs(level - known) / known for known in (0.25, 1.0 / 3.0, 0.5, 1.0, 2.0, 3.0, 4.0)) < 0.02
