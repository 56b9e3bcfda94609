"""Tests on real third-party music with known beats: steady pieces are followed on the beat."""

import numpy as np
import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.audio.music_file import OfflineMusic, read_music
from live.control.events.events import BeatHeard, SourceChanged
from tests.places import SHARED

BEATS = SHARED / "beats" / "open"


@pytest.mark.long
@pytest.mark.shared
@pytest.mark.parametrize("name", ["o03_band_104", "o12_drums_punk_144", "o16_pop_keys_116", "o28_vinyl_146"])
def test_beats_of_steady_music_are_matched_after_ten_seconds(name: str) -> None:
    if not BEATS.is_dir():
        pytest.skip(f"{BEATS} is not there")
    music = read_music(BEATS / f"{name}.ogg")
    true = np.loadtxt(BEATS / f"{name}.beats")[:, 0]
    follower, offline, danced, last = TimelineFollower(), OfflineMusic(music), [], 0
    for tick in range(1, int(music.duration / TICK)):
        now = tick * TICK
        for event in offline.events_until(now):
            if isinstance(event, BeatHeard):
                follower.observe(event.beat_time, event.period, event.confidence, now)
            elif isinstance(event, SourceChanged):
                getattr(follower, event.state)(now)
        timeline = follower.advance(now)
        beat = int(np.floor(timeline.beat_at(now)))
        if beat > last:
            danced.append(timeline.time_at(beat))
            last = beat
    after = true[(true > 10.0) & (true < music.duration - 0.5)]
    off = np.array([np.min(np.abs(np.array(danced) - time)) for time in after])
    assert np.mean(off <= 0.070) >= 0.95
    assert sum(time > 10.0 for time in danced) == pytest.approx(after.size, abs=3)
