"""Manual controls of the follower, on music with known beats."""

import math

import numpy as np
import pytest

from live.clock.follower.manual_control import TrackerHint
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from tests.clock.follower.hall import Hall, Music, Player


def band(bpm: float = 120.0, name: str = "audio", **options: float) -> tuple[Music, Hall]:
    """A hall locked to steady music after 8 s."""
    music = Music([(bpm, 120)], start=0.3)
    hall = Hall(TimelineFollower(), Player(music, name=name, **options)).until(8.05)  # type: ignore[arg-type]
    assert hall.follower.state == "locked"
    return music, hall


def measure_line_offset(hall: Hall, time: float) -> float:
    """Distance of the nearest measure line from `time` [s], in beats."""
    timeline = hall.follower.timeline
    phase = timeline.phase_at(time)
    return min(phase, timeline.beats_per_measure - phase)


def beats_are_consecutive(hall: Hall) -> bool:
    return bool(np.all(np.diff(hall.beats()) == 1))


@pytest.mark.parametrize("name", ["audio", "midi"])
def test_nudge_offsets_beats_from_source_permanently(name: str) -> None:
    music, hall = band(name=name)
    for _ in range(3):
        hall.follower.nudge(0.02, hall.now)
    hall.until(24.0)
    assert np.median(hall.off(music, 14.0, 24.0)) == pytest.approx(-0.060, abs=0.002)
    assert beats_are_consecutive(hall)


def test_nudge_shifts_the_internal_clock() -> None:
    hall = Hall().until(3.0)
    hall.follower.nudge(-0.1, hall.now)
    hall.until(8.0)
    assert hall.follower.timeline.beat_at(8.0) == pytest.approx(16.2, abs=0.001)


@pytest.mark.parametrize("beats", [-1.0, 1.0, 2.0])
def test_beat_shift_moves_measure_line_against_the_source(beats: float) -> None:
    music, hall = band()
    hall.follower.shift_beats(beats, hall.now)
    hall.until(30.0)
    downbeat = music.times[40 + round(beats)]
    assert measure_line_offset(hall, downbeat) < 0.05
    assert beats_are_consecutive(hall)
    assert hall.follower.last_jump is not None
    assert hall.follower.last_jump.cause == "hand"


def test_half_beat_shift_moves_beat_to_offbeat() -> None:
    music, hall = band()
    jumps = hall.follower.jumps
    hall.follower.shift_beats(0.5, hall.now)
    hall.until(20.0)
    assert np.abs(hall.off(music, 9.0, 20.0)).min() > 0.24
    assert hall.follower.jumps > jumps


@pytest.mark.parametrize(("factor", "name"), [(0.5, "audio"), (2.0, "audio"), (0.5, "midi"), (2.0, "link")])
def test_half_and_double_tempo_start_on_a_common_beat(factor: float, name: str) -> None:
    music, hall = band(100.0, name)
    hall.follower.scale_tempo(factor, hall.now)
    hall.until(8.05 + 2.0 * 0.6 + 0.1)
    assert hall.follower.tempo == pytest.approx(100.0 * factor, rel=0.01)
    hall.until(30.0)
    assert hall.follower.state == "locked"
    danced = hall.follower.timeline
    positions = [danced.beat_at(time) for time in music.times[40:46:2]]  # every second beat is common to both
    assert all(abs(position - round(position)) < 0.05 for position in positions)
    off = min(measure_line_offset(hall, music.times[40]), measure_line_offset(hall, music.times[44]))
    assert off < 0.05, "every second measure line stays, or all of them"
    assert beats_are_consecutive(hall)
    assert hall.follower.last_jump is None or hall.follower.last_jump.before == hall.follower.last_jump.after


def test_tempo_scaling_obeyed_by_tracker_is_not_applied_twice() -> None:
    _, hall = band(120.0)
    hall.follower.scale_tempo(0.5, hall.now)
    hall.until(12.1)
    hall.players = [Player(Music([(60.0, 60)], start=0.3), jitter=0.004)]
    hall.until(26.0)
    assert hall.follower.tempo == pytest.approx(60.0, rel=0.01)
    assert hall.follower.state == "locked"
    hall.follower.scale_tempo(0.5, hall.now)
    hall.until(30.5)
    assert hall.follower.tempo == pytest.approx(30.0, rel=0.01)


def test_scaling_below_the_slowest_tempo_is_refused() -> None:
    hall = Hall(TimelineFollower(tempo=30.0)).until(1.0)
    hall.follower.scale_tempo(0.5, hall.now)
    hall.follower.scale_tempo(3.0, hall.now)
    assert hall.follower.rejected == 2
    assert hall.until(5.0).follower.tempo == 30.0


def test_hold_freezes_tempo_and_release_returns_to_source() -> None:
    music = Music([(120.0, 20), (126.0, 80)], start=0.3)
    hall = Hall(TimelineFollower(), Player(music, jitter=0.004)).until(9.0)
    hall.follower.hold(True, hall.now)
    hall.until(15.0)
    assert hall.states(9.02, 15.0) == {"held"}
    assert len({row[2] for row in hall.rows if row[0] > 9.02}) == 1
    line = hall.follower.timeline
    assert line.tempo == pytest.approx(hall.follower.tempo, rel=1e-12)
    hall.follower.hold(False, hall.now)
    hall.until(24.0)
    assert np.abs(hall.off(music, 20.0, 24.0)).max() < 0.02
    assert beats_are_consecutive(hall)


def test_downbeat_without_source_sets_beat_and_measure_line() -> None:
    hall = Hall(TimelineFollower(tempo=100.0)).until(6.23)
    press = hall.now
    hall.follower.set_downbeat(press)
    hall.until(press + 4.0)
    assert measure_line_offset(hall, press) < 0.01
    assert hall.follower.last_jump is not None
    assert hall.follower.last_jump.cause == "one"


def test_downbeat_with_band_is_its_nearest_beat() -> None:
    music, hall = band()
    press = music.times[18] + 0.08
    hall.until(press)
    hall.follower.set_downbeat(press)
    hall.until(30.0)
    assert measure_line_offset(hall, music.times[42]) < 0.05
    assert np.abs(hall.off(music, 9.0, 30.0)).max() < 0.02


def test_manual_measure_line_stays_against_a_persistent_tracker_and_is_taken_back_by_one_press() -> None:
    music, hall = band()
    hall.follower.set_downbeat(music.times[16])  # agrees with the tracker
    hall.until(12.0)
    other = Music([(120.0, 160)], start=0.3 + 2 * 0.5)
    hall.players = [Player(other)]
    hall.until(60.0)
    assert measure_line_offset(hall, music.times[112]) < 0.05
    assert hall.follower.asks
    hall.follower.take_runner_up(60.0)
    hall.until(62.0)
    assert measure_line_offset(hall, other.times[112]) < 0.05


def test_new_metre_starts_at_a_measure_line() -> None:
    hall = Hall(TimelineFollower(tempo=120.0)).until(3.1)
    hall.follower.set_metre(3.0, hall.now)
    hall.until(3.9)
    assert hall.follower.timeline.beats_per_measure == 4
    hall.until(12.0)
    timeline = hall.follower.timeline
    assert timeline.beats_per_measure == 3
    assert timeline.phase_at(4.0) == pytest.approx(0.0, abs=1e-9)
    assert [timeline.measure_at(time) for time in (4.01, 5.49, 5.51)] == [2, 2, 3]
    for beats in (1.0, 13.0, math.nan):
        hall.follower.set_metre(beats, hall.now)
    assert hall.follower.rejected == 3


def test_count_in_from_taps_ends_on_the_downbeat() -> None:
    hall = Hall(TimelineFollower(tempo=120.0)).until(5.0)
    hall.follower.count_in(1.0, hall.now)
    taps = [5.2 + 0.6 * k for k in range(4)]
    for tap in taps:
        hall.until(tap)
        hall.follower.tap(hall.now)
    hall.until(taps[-1] + 0.7)
    assert hall.follower.counting_in == 4
    hall.until(taps[-1] + 0.6 * 4.5)
    assert hall.follower.counting_in == 1
    hall.until(taps[-1] + 0.6 * 5.0 + 0.1)
    assert hall.follower.counting_in == 0
    assert hall.follower.last_jump is not None
    assert hall.follower.last_jump.cause == "one"
    assert hall.follower.last_jump.time == pytest.approx(taps[-1] + 3.0, abs=2.0 * TICK + 0.01)
    assert measure_line_offset(hall, taps[-1] + 3.0) < 0.03
    assert hall.follower.tempo == pytest.approx(100.0, rel=0.01)


def test_count_in_with_band_starts_at_its_next_beat() -> None:
    music, hall = band()
    hall.follower.count_in(2.0, hall.now)
    first = next(time for time in music.times if time > hall.now)
    hall.until(first + 0.1)
    assert hall.follower.counting_in == 8
    assert measure_line_offset(hall, first) < 0.05


def test_count_in_while_held_starts_at_next_beat() -> None:
    music, hall = band()
    hall.follower.hold(True, hall.now)
    hall.players.clear()
    hall.until(hall.now + 3.1)
    hall.follower.count_in(1.0, hall.now)
    first = hall.follower.timeline.time_at(math.floor(hall.follower.timeline.beat_at(hall.now)) + 1)
    hall.until(first + 0.02)
    assert hall.follower.counting_in == 4
    hall.until(first + 4.0 * music.period(0) + 0.1)
    assert hall.follower.counting_in == 0
    assert measure_line_offset(hall, first) < 0.02
    assert hall.follower.state == "held"


def test_taps_and_tempo_do_not_override_midi_clock_but_are_reported() -> None:
    _, hall = band(120.0, "midi", per_beat=4)
    hints: list[TrackerHint] = []
    hall.follower.on_hint = hints.append
    for k in range(4):
        hall.until(9.0 + 0.6 * k)
        hall.follower.tap(hall.now)
    hall.follower.set_tempo(90.0, hall.now)
    hall.until(14.0)
    assert hall.follower.source == "midi"
    assert hall.follower.tempo == pytest.approx(120.0, rel=1e-3)
    assert "midi" in hall.follower.refusal
    assert hall.follower.refused == 3
    assert hall.follower.manual_tempo == (3, 90.0)
    assert [seed.kind for seed in hints] == ["tempo"] * 3
    hall.follower.select_source("tap")
    hall.until(16.5)
    assert (hall.follower.source, hall.follower.state) == ("tap", "held")
    hall.follower.set_tempo(90.0, hall.now)
    assert hall.until(18.0).follower.tempo == 90.0


def test_taps_set_level_and_phase_against_the_tracker() -> None:
    music, hall = band(140.0)
    for k in range(5):  # half as fast, on the off-beats
        hall.until(music.times[20 + 2 * k] + 0.5 * music.period(0))
        hall.follower.tap(hall.now)
    hall.until(40.0)
    assert hall.follower.source == "audio"
    assert hall.follower.tempo == pytest.approx(70.0, rel=0.01)
    beat = hall.follower.timeline.beat_at(music.times[80] + 0.5 * music.period(0))
    assert abs(beat - round(beat)) < 0.06


def test_invalid_controls_are_counted_and_change_nothing() -> None:
    _, hall = band()
    follower = hall.follower
    before = follower.timeline
    for bad in (math.nan, math.inf, -1e30):
        follower.nudge(bad, hall.now)
        follower.shift_beats(bad, hall.now)
        follower.count_in(bad, hall.now)
        follower.scale_tempo(bad, hall.now)
        follower.hold(True, bad)
        follower.tap(bad)
    assert follower.rejected == 18
    assert follower.timeline == before
    assert follower.state == "locked"
