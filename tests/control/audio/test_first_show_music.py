"""Tests of the embedded music: loops in whole measures, starts on a downbeat, and can be followed."""

import numpy as np
import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.audio.music_file import Music, OfflineMusic, read_music
from live.control.events.events import BeatHeard
from tests.places import ROOT
from tools import compose_first_show as piece

FILE = ROOT / "patches" / "music" / "first_show.ogg"


@pytest.fixture(scope="module")
def music() -> Music:
    return read_music(FILE)


def test_file_is_small_and_has_whole_measures(music: Music) -> None:
    assert FILE.stat().st_size < 900_000
    measures = music.duration * piece.TEMPO / 60.0 / 4.0
    assert measures == pytest.approx(piece.MEASURES, abs=1e-5)
    assert music.samples.shape == (piece.LENGTH, 2)


def test_first_kick_starts_at_first_sample(music: Music) -> None:
    """The decoded file starts on the score's first beat to a tenth of a millisecond (no encoder delay remains)."""
    kick = piece.kick()
    heard = np.concatenate([music.samples[-2000:], music.samples[:12_000]]).mean(axis=1)
    match = np.correlate(heard, kick[:6000], "valid")
    assert abs(int(np.argmax(match)) - 2000) <= 5


def test_loop_seam_step_is_below_largest_measure_step(music: Music) -> None:
    seam = np.max(np.abs(music.samples[0] - music.samples[-1]))
    lines = [round(measure * piece.MEASURE) for measure in range(1, piece.MEASURES)]
    steps = [np.max(np.abs(np.diff(music.samples[line - 50 : line + 50], axis=0))) for line in lines]
    assert seam < np.max(steps)


def test_loudness_is_in_range_without_clipping(music: Music) -> None:
    assert 0.7 < np.max(np.abs(music.samples)) <= 1.0
    assert -16.0 < 20.0 * np.log10(np.sqrt(np.mean(music.samples**2))) < -8.0


@pytest.mark.long
@pytest.mark.parametrize("told", [True, False])
def test_follower_stays_locked_through_break_and_seam(music: Music, told: bool) -> None:
    follower = TimelineFollower(known_tempo=112.0, one_at=0.0) if told else TimelineFollower(one_at=0.0)
    offline = OfflineMusic(music)
    locked, errors = 0.0, []
    for tick in range(1, int(120.0 / TICK)):
        now = tick * TICK
        for event in offline.events_until(now):
            if isinstance(event, BeatHeard):
                follower.observe(event.beat_time, event.period, event.confidence, now)
        timeline = follower.advance(now)
        if follower.state == "locked":
            locked = locked or now
        if now > 8.0:
            assert follower.state == "locked"
            off = (timeline.phase_at(now) - now * 112.0 / 60.0) % 4.0
            errors.append(min(off, 4.0 - off) * 60.0 / 112.0)
    assert locked < 5.0
    assert np.percentile(errors, 95) < 0.015
