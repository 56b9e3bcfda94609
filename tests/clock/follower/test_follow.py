"""TimelineFollower: response to estimates, taps and losses, in simulated time."""

from collections.abc import Callable

import pytest

from live.clock.follower.phase_correction import SLEW_UNLOCKED
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from tests.fixtures.mostly_long import mostly_long


class Stage:
    """Runs a follower tick by tick against music with known beats."""

    def __init__(self, follower: TimelineFollower) -> None:
        self.follower = follower
        self.tick = 0
        self.states: list[str] = []

    @property
    def now(self) -> float:
        return self.tick * TICK

    def run(
        self,
        seconds: float,
        bpm: float | None = None,
        first: float = 0.0,
        wild: Callable[[int], tuple[float, float]] = lambda beat: (1.0, 0.0),
    ) -> None:
        """Feeds `bpm` with a beat at `first`; `wild` gives each beat's (period factor, time error [s])."""
        end = self.now + seconds
        heard = 0 if bpm is None else int((self.now - first) * bpm / 60.0) + 1
        while self.now < end:
            self.tick += 1
            if bpm is not None and first + heard * 60.0 / bpm <= self.now:
                factor, error = wild(heard)
                time = first + heard * 60.0 / bpm + error
                self.follower.observe(time, 60.0 / bpm * factor, 0.7, self.now)
                heard += 1
            self.follower.advance(self.now)
            self.states.append(self.follower.state)

    def phase_error(self, bpm: float, first: float = 0.0) -> float:
        """Phase error of the follower relative to the music, in beats, ± 0.5."""
        off = self.follower.timeline.beat_at(self.now) - (self.now - first) * bpm / 60.0
        return (off + 0.5) % 1.0 - 0.5


def test_follower_without_input_runs_at_its_own_tempo() -> None:
    stage = Stage(TimelineFollower(tempo=90.0, beats_per_measure=3, one_at=1.0))
    stage.run(7.0)
    assert stage.follower.timeline.beat_at(7.0) == pytest.approx(9.0)
    assert stage.follower.timeline.phase_at(3.0) == pytest.approx(0.0, abs=1e-9)
    assert (stage.follower.state, stage.follower.source) == ("internal", "internal")


@pytest.mark.parametrize("bpm", [60.0, 75.0, 96.0, 112.0, 128.0, 150.0, 180.0])
def test_follower_locks_to_steady_music(bpm: float) -> None:
    stage = Stage(TimelineFollower())
    stage.run(12.0, bpm, first=0.37)
    assert stage.follower.state == "locked"
    assert stage.follower.tempo == pytest.approx(bpm, rel=0.002)
    assert abs(stage.phase_error(bpm, 0.37)) < 0.01
    assert stage.follower.confidence > 0.9


@mostly_long("late", [(k + 0.6) / 20 for k in range(20)], quick=[2, 8, 9, 14])
def test_follower_locks_to_offset_music_and_follows_a_shift(late: float) -> None:
    """At the current tempo, for any initial phase offset and for a later shift."""
    stage = Stage(TimelineFollower(tempo=120.0))
    stage.run(12.0, 120.0, first=late * 0.5)
    assert stage.follower.state == "locked"
    assert abs(stage.phase_error(120.0, late * 0.5)) < 0.01
    stage.run(14.0, 120.0, first=late * 0.5 + 0.08)
    assert stage.follower.state == "locked"
    assert abs(stage.phase_error(120.0, late * 0.5 + 0.08)) < 0.02


def test_outlier_estimates_are_rejected() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    wild = {3: (0.5, 0.0), 7: (2.0, 0.25), 11: (1.5, 0.1), 12: (2.0 / 3.0, -0.2), 17: (1.0, 0.21), 23: (3.1, 0.3)}
    stage.run(15.0, 120.0, wild=lambda beat: wild.get(beat % 29, (1.0, 0.0)))
    assert set(stage.states[-15 * 64 :]) == {"locked"}
    assert stage.follower.tempo == pytest.approx(120.0, rel=0.01)
    assert abs(stage.phase_error(120.0)) < 0.03


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_short_octave_error_does_not_change_tempo(factor: float) -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    stage.run(3.0, 120.0, wild=lambda beat: (factor, 0.0))
    assert stage.follower.tempo == pytest.approx(120.0, rel=0.01)
    assert abs(stage.phase_error(120.0)) < 0.03


@pytest.mark.parametrize(("before", "after"), [(120.0, 132.0), (102.0, 133.0), (140.0, 112.0), (133.0, 92.0)])
def test_new_tempo_is_followed_within_four_seconds(before: float, after: float) -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, before)
    stage.run(4.0, after, first=10.2)
    assert stage.follower.tempo == pytest.approx(after, rel=0.02)
    stage.run(3.0, after, first=10.2)
    assert abs(stage.phase_error(after, 10.2)) < 0.05


def test_slow_tempo_drift_is_followed() -> None:
    follower = TimelineFollower()
    beat, time, tick = 0, 0.5, 0
    while time < 40.0:
        period = 60.0 / (100.0 + 38.0 * time / 40.0)
        while tick * TICK < time:
            tick += 1
            follower.advance(tick * TICK)
        follower.observe(time, period, 0.7, tick * TICK)
        if time > 8.0:
            off = follower.timeline.beat_at(time) - beat
            assert abs((off + 0.5) % 1.0 - 0.5) < 0.1
        time += period
        beat += 1
    assert follower.tempo == pytest.approx(137.0, rel=0.02)


def test_freewheel_keeps_tempo_and_phase() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 126.0)
    before = stage.follower.timeline.beat_at(stage.now)
    stage.follower.silent(stage.now)
    assert stage.follower.timeline.beat_at(stage.now) == before
    assert stage.follower.state == "freewheel"
    tempo = stage.follower.tempo
    stage.run(60.0)
    assert stage.follower.timeline.beat_at(stage.now) - before == pytest.approx(60.0 * tempo / 60.0, rel=1e-9)
    assert stage.follower.confidence < 0.01


def test_unannounced_end_of_music_causes_freewheel() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 126.0)
    stage.run(4.0)
    assert stage.follower.state == "freewheel"


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.24, -0.2])
def test_follower_slews_to_music_after_silence_without_jump(shift: float) -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    stage.follower.lost(stage.now)
    stage.run(8.0)
    stage.follower.found(stage.now)
    last = stage.follower.timeline.beat_at(stage.now)
    for _ in range(64 * 6):
        stage.run(TICK, 120.0, first=shift)
        beat = stage.follower.timeline.beat_at(stage.now)
        assert 0.0 < (beat - last) / (2.0 * TICK) <= 1.0 + SLEW_UNLOCKED + 0.05
        last = beat
    assert stage.follower.state == "locked"
    assert abs(stage.phase_error(120.0, shift)) < 0.03


def test_estimates_from_before_silence_are_ignored() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    stage.follower.silent(stage.now)
    stage.follower.observe(stage.now - 0.1, 0.5, 1.0, stage.now + 0.05)
    assert stage.follower.state == "freewheel"


def test_taps_set_tempo_and_phase() -> None:
    stage = Stage(TimelineFollower(tempo=120.0))
    for _ in range(4):
        stage.run(0.625)
        stage.follower.tap(stage.now)
    first = stage.now
    assert (stage.follower.state, stage.follower.source) == ("held", "tap")
    assert stage.follower.tempo == pytest.approx(96.0)
    stage.run(5.0)
    assert abs(stage.phase_error(stage.follower.tempo, first)) < 0.02


def test_taps_override_audio_and_keep_offbeat_phase() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    for _ in range(4):
        stage.run(0.5, 120.0)
        stage.follower.tap(stage.now + 0.25)
    stage.run(7.0, 120.0)
    assert stage.follower.state == "held"
    stage.run(10.0, 120.0)
    assert stage.follower.source == "audio"
    assert abs(stage.phase_error(120.0, 0.25)) < 0.05


def test_taps_set_the_tempo_octave() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 150.0)
    for tap in range(4):
        stage.run(0.8, 150.0)
        stage.follower.tap(10.0 + 0.8 * tap)
    stage.run(20.0, 150.0)
    assert stage.follower.source == "audio"
    assert stage.follower.tempo == pytest.approx(75.0, rel=0.01)


def test_manual_tempo_change_is_continuous_in_beat() -> None:
    stage = Stage(TimelineFollower())
    stage.run(3.3)
    before = stage.follower.timeline.beat_at(stage.now)
    stage.follower.set_tempo(90.0, stage.now)
    assert stage.follower.timeline.beat_at(stage.now) == pytest.approx(before)
    stage.run(2.0)
    assert stage.follower.timeline.beat_at(stage.now) - before == pytest.approx(3.0)
    assert stage.follower.state == "internal"


def test_manual_downbeat_moves_measures_but_not_beats() -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    before = stage.follower.timeline.beat_at(stage.now)
    stage.follower.set_downbeat(9.02)
    assert stage.follower.timeline.beat_at(stage.now) == before
    assert min(stage.follower.timeline.phase_at(9.0), 4.0 - stage.follower.timeline.phase_at(9.0)) < 0.05
    stage.run(8.0, 120.0)
    assert min(stage.follower.timeline.phase_at(17.0), 4.0 - stage.follower.timeline.phase_at(17.0)) < 0.05


def test_downbeat_set_before_lock_is_counted_back() -> None:
    stage = Stage(TimelineFollower(tempo=120.0))
    stage.run(2.0, 97.0)
    assert stage.follower.state != "locked"
    stage.follower.set_downbeat(2 * 60.0 / 97.0)
    stage.run(12.0, 97.0)
    phase = stage.follower.timeline.phase_at((2 + 16) * 60.0 / 97.0)
    assert min(phase, 4.0 - phase) < 0.05


@pytest.mark.parametrize("bpm", [95.0, 112.0, 131.0])
def test_measures_are_counted_from_known_downbeat(bpm: float) -> None:
    stage = Stage(TimelineFollower(tempo=120.0, one_at=0.5))
    stage.run(12.0, bpm, first=0.5)
    measure = 4 * 60.0 / bpm
    phase = stage.follower.timeline.phase_at(0.5 + 5 * measure)
    assert min(phase, 4.0 - phase) < 0.05


@pytest.mark.parametrize("bpm", [61.0, 97.0, 131.0])
def test_lock_before_known_downbeat_counts_toward_it(bpm: float) -> None:
    stage = Stage(TimelineFollower(tempo=120.0, one_at=12.0))
    stage.run(9.0, bpm, first=12.0 % (60.0 / bpm))
    assert stage.follower.state == "locked"
    phase = stage.follower.timeline.phase_at(12.0)
    assert min(phase, 4.0 - phase) < 0.05, "predicted"
    stage.run(11.0, bpm, first=12.0 % (60.0 / bpm))
    phase = stage.follower.timeline.phase_at(12.0 + 8 * 60.0 / bpm)
    assert min(phase, 4.0 - phase) < 0.05


@pytest.mark.parametrize(("silence", "counted"), [(24.0, True), (34.0, False)])
def test_known_downbeat_is_used_within_half_a_minute(silence: float, counted: bool) -> None:
    """Later the number of beats is uncertain: the measures continue unchanged."""
    stage = Stage(TimelineFollower(tempo=120.0, one_at=0.0))
    stage.run(silence)
    stage.run(4.0, 96.0, first=0.0)
    assert stage.follower.state == "locked"
    jump = stage.follower.last_jump
    assert (jump is not None and jump.cause == "first downbeat") == counted


@pytest.mark.parametrize("name", ["tap", "internal", "nobody", ""])
def test_unknown_beat_source_is_rejected(name: str) -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    before = stage.follower.timeline
    stage.follower.observe(stage.now, 0.6, 1.0, stage.now, source=name)
    for tell in (stage.follower.silent, stage.follower.lost, stage.follower.found, stage.follower.paused):
        tell(stage.now, name)
    assert stage.follower.rejected == 5
    assert stage.follower.timeline == before
    assert stage.follower.state == "locked"


def test_known_tempo_sets_the_tempo_octave() -> None:
    stage = Stage(TimelineFollower(known_tempo=84.0))
    stage.run(12.0, 168.0)
    assert stage.follower.tempo == pytest.approx(84.0, rel=0.01)
    assert stage.follower.state == "locked"


@pytest.mark.parametrize("nonsense", [float("nan"), float("inf"), -float("inf"), 1e30, -1e30])
def test_invalid_input_is_counted_and_changes_nothing(nonsense: float) -> None:
    stage = Stage(TimelineFollower())
    stage.run(10.0, 120.0)
    follower = stage.follower
    before = follower.timeline
    follower.observe(nonsense, 0.5, 0.7, stage.now)
    follower.observe(stage.now, nonsense, 0.7, stage.now)
    follower.observe(stage.now, 0.5, 0.7, nonsense)
    follower.set_tempo(nonsense, stage.now)
    assert follower.rejected == 4
    assert follower.timeline == before
    follower.advance(float("nan"))
    assert follower.timeline == before
