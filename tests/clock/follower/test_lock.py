"""The lock against an independent model: hysteresis, and slew rate toward the beat of the source.

The model is independent of the follower's code. It is the differential equation of `live docs clock`: an error is
corrected within 0.8 s (0.4 s for a clock of exact times), but the Timeline is never more than 12 % faster or slower
than the music while locked, 20 % while not; a lock is made within 0.1 beats and holds to 0.25.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from tests.clock.follower.hall import Hall, Music, Player

NEAR, FAR = 0.1, 0.25
SLOW, FAST = 0.12, 0.20
FINE = 16
"""Steps of the model for each tick."""


@dataclass
class Model:
    """Phase error of the Timeline behind the music [beats] after a nudge, and the lock state."""

    error: float
    bpm: float
    within: float
    """Time constant [s]."""
    locked: bool = True

    def judge(self) -> None:
        """A lock has hysteresis."""
        self.locked = abs(self.error) < (FAR if self.locked else NEAR)

    def tick(self) -> None:
        """One tick of the show, in small steps."""
        beats = self.bpm / 60.0
        for _ in range(FINE):
            limit = SLOW if self.locked else FAST
            faster = math.copysign(min(abs(self.error) / (self.within * beats), limit), self.error)
            self.error -= faster * beats * TICK / FINE


def locked_hall(bpm: float, source: str) -> tuple[Hall, Music]:
    """A follower that has followed exact music for 20 s."""
    music = Music([(bpm, 60.0 * bpm / 60.0)], start=0.3)
    hall = Hall(TimelineFollower(tempo=bpm), Player(music, name=source, per_beat=1 if source == "audio" else 4))
    hall.until(20.0)
    assert hall.follower.state == "locked"
    return hall, music


def error_of(hall: Hall) -> float:
    """Phase error of the Timeline behind the goal [beats]."""
    return hall.follower._slewed.error(hall.now)


@pytest.mark.parametrize("source", ["audio", "midi"])
@pytest.mark.parametrize(("beats", "limit", "state"), [(0.24, SLOW, "locked"), (0.40, FAST, "following")])
def test_slew_is_limited_to_12_percent_locked_and_20_unlocked(
    source: str, beats: float, limit: float, state: str
) -> None:
    for sign in (-1.0, 1.0):
        hall, _ = locked_hall(80.0, source)
        hall.follower.nudge(-sign * beats * 0.75, hall.now)
        hall.until(hall.now + 2.5 * TICK)
        assert hall.follower.state == state
        bent = hall.follower.timeline.tempo / hall.follower.tempo - 1.0
        assert bent == pytest.approx(sign * limit, abs=1e-6)


@pytest.mark.parametrize("swing", [0.11, 0.15, 0.24])
def test_lock_is_stable_for_errors_below_a_quarter_beat(swing: float) -> None:
    """Alternating nudges keep the error between the thresholds that make and break a lock."""
    hall, _ = locked_hall(120.0, "audio")
    states = set()
    for turn in range(12):
        now = error_of(hall)
        hall.follower.nudge((now - (swing if turn % 2 else -swing)) * 0.5, hall.now)
        hall.until(hall.now + 3.0 * TICK)
        states |= hall.states(hall.now - 3.0 * TICK, hall.now + TICK)
    assert states == {"locked"}


def test_broken_lock_is_regained_only_near_the_beat() -> None:
    hall, _ = locked_hall(120.0, "audio")
    hall.follower.nudge(-0.2, hall.now)  # 0.4 beats
    found = []
    for _ in range(int(3.0 / TICK)):
        hall.until(hall.now + 0.5 * TICK)
        found.append((hall.follower.state, abs(error_of(hall))))
    again = next(place for place, (state, _) in enumerate(found) if state == "locked")
    assert again > 10
    assert found[again][1] == pytest.approx(NEAR, abs=0.01)
    assert {state for state, _ in found[again:]} == {"locked"}
    assert {state for state, _ in found[:again]} == {"following"}


@pytest.mark.long
@given(st.floats(0.05, 20.0))
@settings(max_examples=20, deadline=None)
def test_confidence_decays_with_time_constant_of_eight_seconds(seconds: float) -> None:
    hall, _ = locked_hall(120.0, "audio")
    sure = hall.follower.confidence
    hall.follower.lost(hall.now, "audio")
    hall.players.clear()
    begun = hall.now
    hall.until(begun + seconds)
    assert hall.follower.confidence == pytest.approx(sure * math.exp(-(hall.now - begun) / 8.0), rel=0.01)


@pytest.mark.long
def test_lost_source_hands_over_at_first_measure_line_after_two_seconds() -> None:
    for at in np.arange(20.0, 22.0, 0.17):
        music = Music([(120.0, 120)], start=0.3)
        clock, band = Player(music, name="link", lead=0.2), Player(music)
        hall = Hall(TimelineFollower(tempo=120.0), clock, band).until(at)
        assert hall.follower.source == "link"
        clock.on = False
        hall.follower.lost(hall.now, "link")
        free = hall.now
        line = next(t for t in np.arange(free, free + 6.0, TICK) if t >= free + 2.0 and crosses_measure_line(hall, t))
        while hall.follower.source == "link":
            hall.until(hall.now + 0.5 * TICK)
            assert hall.now < free + 8.0
        assert hall.now == pytest.approx(line, abs=2.0 * TICK), "not earlier and not a measure later"


@pytest.mark.parametrize(("bpm", "seconds"), [(126.0, 3.0), (70.0, 3.0), (45.0, 4.0)])
def test_missing_music_is_detected_after_three_seconds_and_three_beats(bpm: float, seconds: float) -> None:
    music = Music([(bpm, 24)], start=0.3)
    hall = Hall(TimelineFollower(tempo=bpm), Player(music))
    hall.until(music.times[-1] + 6.0)
    last = music.times[-2] - 0.08  # time of the last report
    free = next(row[0] for row in hall.rows if row[0] > last and row[3] == "freewheel")
    assert free - last == pytest.approx(seconds, abs=0.05)


def crosses_measure_line(hall: Hall, time: float) -> bool:
    """Whether a measure line of the Timeline lies in the tick before `time` [s]."""
    timeline = hall.follower.timeline
    return timeline.measure_at(time) != timeline.measure_at(time - TICK)


@pytest.mark.parametrize(
    ("silence", "factor", "leaps"),
    [(1.5, 1.07, True), (3.0, 0.93, True), (0.4, 1.07, False), (3.0, 1.03, False), (3.0, 1.05, True)],
)
def test_new_song_is_another_tempo_after_two_seconds_of_silence(silence: float, factor: float, leaps: bool) -> None:
    """Silence lasts from its start until the new beats are accepted. Any other change is slewed to."""
    first, period = Music([(120.0, 30)], start=0.2), 0.5 / factor
    end = first.times[-1]
    second = Music([(120.0 * factor, 40)], start=end + silence + 0.45 * period)
    hall = Hall(TimelineFollower(tempo=120.0), Player(first), Player(second))
    hall.until(end - 0.1)
    hall.follower.silent(hall.now)
    hall.until(end + silence - 0.1)
    hall.follower.found(hall.now)
    jumps = hall.follower.jumps
    hall.until(hall.now + 8.0)
    found = hall.follower.last_jump if hall.follower.jumps > jumps else None
    assert (found is not None and found.cause == "new song") == leaps


@pytest.mark.parametrize(("beats", "left"), [(0.55, 0.55), (-0.55, -0.55), (0.65, -0.35), (-0.65, 0.35), (0.8, -0.2)])
def test_error_beyond_half_a_beat_wraps_only_above_threshold(beats: float, left: float) -> None:
    hall, _ = locked_hall(168.0, "audio")
    hall.follower.nudge(-beats * 60.0 / 168.0, hall.now)
    hall.until(hall.now + 0.5 * TICK)
    assert error_of(hall) == pytest.approx(left, abs=0.012)
    assert np.diff(hall.beats()).tolist() == [1] * (len(hall.beats()) - 1), "none is skipped"


@pytest.mark.parametrize(("ticks", "leaps"), [(0, False), (4, False), (5, True), (20, True), (35, True)])
def test_manual_downbeat_leaps_forward_unless_error_is_small(ticks: int, leaps: bool) -> None:
    """A tick is 0.025 beats; an error below 0.12 beats is slewed back."""
    hall = Hall(TimelineFollower(tempo=96.0)).until((320 + ticks - 0.5) * TICK)
    before, then = hall.follower.timeline.beat_at(hall.now), hall.now
    late = 0.025 * ticks
    assert before % 1.0 == pytest.approx(late, abs=1e-6)
    hall.follower.set_downbeat(then)
    hall.until(then + 0.5 * TICK)
    leapt = hall.follower.timeline.beat_at(hall.now) - before - 0.025
    assert leapt == pytest.approx(1.0 - late if leaps else 0.0, abs=0.01)
    assert hall.follower.jumps >= leaps
    hall.until(hall.now + 6.0)
    phase = hall.follower.timeline.phase_at(then + 4 * 60.0 / 96.0)
    assert min(phase, 4.0 - phase) < 0.02


@pytest.mark.long
@given(st.floats(-0.45, 0.45), st.floats(70.0, 170.0), st.sampled_from(["audio", "midi", "link"]))
@settings(max_examples=25, deadline=None)
def test_error_and_lock_state_match_the_model(beats: float, bpm: float, source: str) -> None:
    assume(min(abs(abs(beats) - edge) for edge in (NEAR, FAR)) > 0.004)  # both outcomes are valid at the threshold
    hall, _ = locked_hall(bpm, source)
    follower = hall.follower
    model = Model(error_of(hall) - beats, bpm, 0.8 if source == "audio" else 0.4)
    follower.nudge(beats * 60.0 / bpm, hall.now)
    assert error_of(hall) == pytest.approx(model.error, abs=1e-9)
    wrong = 0
    for _ in range(int(4.0 / TICK)):
        # the tick evaluates the lock first, then slews
        beats_of_music = bpm / 60.0
        before = hall.follower.timeline.beat_at(hall.now)
        hall.until(hall.now + 0.5 * TICK)
        after = hall.follower.timeline.beat_at(hall.now)
        assert (after - before) / TICK == pytest.approx(beats_of_music, rel=FAST + 1e-3)
        model.judge()
        wrong += (follower.state == "locked") != model.locked
        assert error_of(hall) == pytest.approx(model.error, abs=0.012)
        model.tick()
    assert wrong <= 3, "only around a change of state"
    assert follower.state == "locked"
    assert abs(error_of(hall)) < 0.02
