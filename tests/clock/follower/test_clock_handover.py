"""Handover between clock sources that appear, disappear and take over, with measured limits."""

import numpy as np
import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from tests.clock.follower.hall import Hall, Music, Player


def p95(values: "np.ndarray") -> float:
    return float(np.percentile(np.abs(values), 95))


@pytest.mark.parametrize(("bpm", "jitter"), [(60.0, 0.010), (96.0, 0.010), (128.0, 0.010), (174.0, 0.015)])
def test_steady_music_is_followed_within_20_ms(bpm: float, jitter: float) -> None:
    music = Music([(bpm, 40.0 * bpm / 60.0)], start=0.3)
    hall = Hall(TimelineFollower(tempo=110.0), Player(music, jitter=jitter)).until(38.0)
    off = hall.off(music, 8.0, 38.0, whole=4.0)
    assert p95(off) < 0.020
    assert abs(np.mean(off)) < 0.004
    assert hall.states(8.0, 38.0) == {"locked"}
    late = np.abs(hall.off(music, 0.3, 38.0)) > 0.030
    assert np.flatnonzero(late)[-1] * TICK < 5.0, "within a few beats"


@pytest.mark.parametrize("factor", [1.2, 0.8])
def test_midi_clock_tempo_step_is_followed_within_a_beat(factor: float) -> None:
    music = Music([(120.0, 24), (120.0 * factor, 40)], start=0.2)
    player = Player(music, name="midi", lead=0.25, jitter=0.001, per_beat=4)
    hall = Hall(TimelineFollower(), player).until(24.0)
    step = music.times[24]
    slow = [time - step for time, _, tempo, *_ in hall.rows if time > step and abs(tempo / (120.0 * factor) - 1) > 0.02]
    assert max(slow, default=0.0) < music.period(30)
    assert p95(hall.off(music, step + 2.0, 24.0, whole=4.0)) < 0.005


@pytest.mark.parametrize("factor", [1.2, 0.8, 1.06])
def test_audio_tempo_step_is_followed_within_four_seconds(factor: float) -> None:
    music = Music([(120.0, 24), (120.0 * factor, 40)], start=0.2)
    hall = Hall(TimelineFollower(), Player(music, jitter=0.008)).until(24.0)
    step = music.times[24]
    assert p95(hall.off(music, step + 4.0, 24.0, whole=4.0)) < 0.025
    assert all(abs(row[2] / (120.0 * factor) - 1.0) < 0.03 for row in hall.rows if row[0] > step + 4.0)


def test_drum_fills_are_ignored() -> None:
    """One or two beats in eight are displaced or have another period, as in a drum fill."""
    fill = {5: (0.75, -0.11), 6: (1.3, 0.12), 13: (0.5, 0.14), 22: (1.5, 0.09), 23: (0.67, -0.13), 31: (1.0, 0.16)}
    music = Music([(120.0, 90)], start=0.2)
    player = Player(music, jitter=0.006, wild=lambda beat: fill.get(beat % 32, (1.0, 0.0)) if beat > 8 else (1.0, 0.0))
    hall = Hall(TimelineFollower(), player).until(44.0)
    assert p95(hall.off(music, 6.0, 44.0, whole=4.0)) < 0.020
    assert all(abs(row[2] / 120.0 - 1.0) < 0.03 for row in hall.rows if row[0] > 6.0)


def test_handover_from_audio_to_midi_and_back_is_seamless() -> None:
    """MIDI clock 40 ms ahead of the band takes over at a measure line, and audio again when it is lost."""
    band = Music([(120.0, 120)], start=0.3)
    sequencer = Music([(120.0, 120)], start=0.26)
    midi = Player(sequencer, name="midi", lead=0.2, jitter=0.001, per_beat=4, on=False)
    hall = Hall(TimelineFollower(), Player(band, jitter=0.004), midi)
    hall.until(15.1)
    assert hall.follower.source == "audio"
    midi.on = True
    hall.until(17.9)
    taken = next(row for row in hall.rows if row[4] == "midi")
    phase = (taken[1] - hall.follower.timeline.measure_origin) % 4.0
    assert min(phase, 4.0 - phase) < 0.05, "at a measure line"
    hall.until(30.2)
    assert p95(hall.off(sequencer, 20.0, 30.0, whole=4.0)) < 0.005
    midi.on = False
    hall.until(50.0)
    free = [row for row in hall.rows if row[3] == "freewheel"]
    assert 30.2 < free[0][0] < 31.2, "detected within a second without a message"
    assert np.ptp([row[2] for row in free]) / 120.0 < 1e-4
    back = next(row for row in hall.rows if row[0] > 31.0 and row[4] == "audio")
    phase = (back[1] - hall.follower.timeline.measure_origin) % 4.0
    assert 2.0 < back[0] - free[0][0] < 4.2
    assert min(phase, 4.0 - phase) < 0.05
    assert p95(hall.off(band, 36.0, 50.0, whole=4.0)) < 0.015
    assert np.diff(hall.beats()).tolist() == [1] * (len(hall.beats()) - 1), "no beat is skipped or doubled"
    assert hall.follower.last_jump is not None
    assert hall.follower.last_jump.time < 3.0


@pytest.mark.parametrize("name", ["midi", "link", "audio"])
def test_source_lost_for_ten_seconds_is_rejoined_without_jump(name: str) -> None:
    """The clock of the source runs 50 ppm fast and returns after 10 s."""
    music = Music([(126.0 * (1.0 + 50e-6), 130)], start=0.2)
    player = Player(music, name=name, lead=0.1, jitter=0.0005)
    hall = Hall(TimelineFollower(), player).until(20.0)
    player.on = False
    jumps, tempo = hall.follower.jumps, hall.follower.tempo
    hall.until(30.0, (20.1, lambda follower: follower.lost(20.1, name)))
    assert hall.states(20.2, 30.0) == {"freewheel"}
    assert hall.follower.tempo == tempo
    assert p95(hall.off(music, 20.0, 30.0, whole=4.0)) < 0.010
    player.on = True
    hall.until(40.0)
    assert hall.follower.source == name
    assert hall.follower.state == "locked"
    assert p95(hall.off(music, 32.0, 40.0, whole=4.0)) < 0.005
    assert hall.follower.jumps == jumps
    assert np.diff(hall.beats()).tolist() == [1] * (len(hall.beats()) - 1)


def test_pause_freewheels_and_relocks_at_once() -> None:
    music = Music([(126.0, 130)], start=0.2)
    player = Player(music, jitter=0.002)
    hall = Hall(TimelineFollower(), player).until(20.0)
    player.on = False
    before = hall.follower.jumps
    hall.until(21.5, (20.3, lambda follower: follower.paused(20.3)))
    assert hall.states(20.4, 21.5) == {"freewheel"}
    player.on = True
    hall.until(26.0, (21.5, lambda follower: follower.found(21.5)))
    assert hall.states(21.6, 26.0) == {"locked"}, "at once, without an observation"
    assert p95(hall.off(music, 20.3, 26.0, whole=4.0)) < 0.012
    assert hall.follower.jumps == before
    assert np.diff(hall.beats()).tolist() == [1] * (len(hall.beats()) - 1)


def test_pause_without_end_message_is_ended_by_beats() -> None:
    """The analysis was restarted during the pause: it reports beats, but never the end of the pause."""
    player = Player(Music([(126.0, 130)], start=0.2), jitter=0.002)
    hall = Hall(TimelineFollower(), player).until(20.0)
    hall.until(26.0, (20.0, lambda follower: follower.paused(20.0)))
    assert hall.states(21.0, 26.0) == {"locked"}


def test_midi_start_is_followed_at_once_and_announced() -> None:
    music = Music([(120.0, 60)], start=7.37)
    hall = Hall(TimelineFollower(tempo=100.0), Player(music, name="midi", lead=0.0, per_beat=4, jump_at=0))
    hall.until(7.42)
    assert hall.follower.last_jump is not None
    assert hall.follower.last_jump.cause in ("start", "lines")
    assert hall.follower.source == "midi"
    assert np.abs(hall.off(music, 7.39, 7.42)).max() < 0.002
    hall.until(20.0)
    assert p95(hall.off(music, 7.5, 20.0, whole=4.0)) < 0.005


def test_new_song_after_silence_is_followed_at_once() -> None:
    first, second = Music([(120.0, 30)], start=0.2), Music([(97.0, 40)], start=22.31)
    hall = Hall(TimelineFollower(), Player(first, jitter=0.003), Player(second, jitter=0.003))
    hall.until(36.0, (15.5, lambda f: f.silent(15.5)), (22.2, lambda f: f.found(22.2)))
    assert hall.follower.last_jump is not None
    songs = [row[0] for row in hall.rows if row[0] > 16.0 and row[3] in ("following", "locked")]
    assert songs[0] - second.times[0] < 1.5
    assert p95(hall.off(second, songs[0] + 0.1, 36.0)) < 0.025, "without slewing"
    assert p95(hall.off(second, 26.0, 36.0, whole=4.0)) < 0.025


def test_source_priority_and_operator_selection_are_obeyed() -> None:
    music, other = Music([(120.0, 120)], start=0.3), Music([(120.0, 120)], start=0.37)
    players = Player(music), Player(other, name="link", lead=0.2)
    assert Hall(TimelineFollower(), *players).until(6.0).follower.source == "link"
    hall = Hall(TimelineFollower(priority=("audio", "link")), Player(music), Player(other, name="link", lead=0.2))
    assert hall.until(8.0).follower.source == "audio"
    hall.follower.select_source("link")
    assert hall.until(11.0).follower.source == "link"
    hall.players[1].on = False
    hall.until(20.0)
    assert (hall.follower.source, hall.follower.state) == ("link", "freewheel"), "selected by hand: no other source"
    hall.follower.select_source("auto")
    assert hall.until(24.0).follower.source == "audio"
    hall.follower.select_source("nobody")
    assert hall.follower.refused == 1
    hall = Hall(TimelineFollower(priority=("link",)), Player(music))
    assert hall.until(6.0).follower.source == "internal"


def test_unstarted_clock_sets_tempo_but_not_phase() -> None:
    follower = TimelineFollower(tempo=120.0)
    hall = Hall(follower)
    for k in range(60):
        time = 2.13 + k * 0.5 * 0.99
        hall.until(time)
        follower.observe(time, 0.495, 0.9, hall.now, source="midi", anchored=False)
    hall.until(32.0)
    assert follower.source == "midi"
    assert follower.tempo == pytest.approx(120.0 / 0.99)
    follower.set_downbeat(hall.now)
    hall.until(hall.now + 0.1)
    phase = follower.timeline.phase_at(32.0)
    assert min(phase, 4.0 - phase) < 0.13


def test_waltz_sets_three_beats_when_metre_is_followed() -> None:
    music = Music([(150.0, 120)], start=0.3, metre=3)
    hall = Hall(TimelineFollower(), Player(music)).until(20.0)
    assert hall.follower.timeline.beats_per_measure == 4
    hall = Hall(TimelineFollower(follow_metre=True), Player(music)).until(20.0)
    assert hall.follower.timeline.beats_per_measure == 3
    assert p95(hall.off(music, 10.0, 20.0, whole=3.0)) < 0.01


def test_tempo_out_of_range_is_halved() -> None:
    music = Music([(220.0, 120)], start=0.3)
    hall = Hall(TimelineFollower(tempo_range=(60.0, 140.0)), Player(music)).until(15.0)
    assert hall.follower.tempo == pytest.approx(110.0, rel=0.005)
    assert hall.follower.state == "locked"


@pytest.mark.parametrize("level", [0.5, 2.0])
def test_change_of_tempo_level_is_followed_only_after_persistence(level: float) -> None:
    """For four seconds the tracker reports half or twice the tempo, then the original: the tempo stays."""
    music, other = Music([(110.0, 90)], start=0.3), Music([(110.0 * level, 180)], start=0.3)
    steady, wrong = Player(music, jitter=0.005), Player(other, jitter=0.005, on=False)
    hall = Hall(TimelineFollower(), steady, wrong).until(16.0)
    steady.on, wrong.on = False, True
    hall.until(20.0)
    steady.on, wrong.on = True, False
    hall.until(30.0)
    assert all(abs(row[2] / 110.0 - 1.0) < 0.03 for row in hall.rows if row[0] > 6.0)
    assert p95(hall.off(music, 10.0, 30.0, whole=4.0)) < 0.02
    steady.on, wrong.on = False, True
    hall.until(46.0)
    assert hall.follower.tempo == pytest.approx(110.0 * level, rel=0.01), "a persistent tracker is followed"
    assert hall.follower.state == "locked"
