"""Music whose measures are known: its beats come from the map, everything else is still heard."""

import numpy as np
import pytest

from live.clock.map_clock import MapClock
from live.clock.measure_map import steady_map
from live.control.audio.analysis import AudioAnalysis
from live.control.audio.music_file import Music, OfflineMusic
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard, SourceChanged

RATE = 22_050


def clicks(bpm: float, seconds: float) -> Music:
    """Return noise bursts at a tempo that the map contradicts."""
    sound = np.random.default_rng(1).normal(0.0, 0.01, round(seconds * RATE)).astype(np.float32)
    for start in range(0, sound.size - 2000, round(60.0 / bpm * RATE)):
        sound[start : start + 800] += np.random.default_rng(2).normal(0.0, 0.5, 800)
    return Music(sound[:, np.newaxis], RATE)


@pytest.mark.long
def test_beats_are_those_of_the_map() -> None:
    music, measures = clicks(140.0, 12.0), steady_map(100.0, 0.8, 4, 6)

    def analysis(rate: float) -> AudioAnalysis:
        return AudioAnalysis(rate, energy=True, measures=MapClock(measures, music.duration))

    events = OfflineMusic(music, begin=3.0, analysis=analysis).events_until(14.0)
    beats = [event for event in events if isinstance(event, BeatHeard)]
    assert {event.source for event in beats} == {"map"}
    assert [event.beat_time for event in beats] == pytest.approx([3.0 - 0.4 + 0.6 * k for k in range(len(beats))])
    assert len(beats) > 15
    assert any(isinstance(event, MusicHeard) for event in events)


def test_an_analysis_that_begins_later_knows_where_it_is() -> None:
    measures = steady_map(120.0, 0.0, 4, 20)
    analysis = AudioAnalysis(RATE, measures=MapClock(measures, 60.0))
    analysis.origin = 10.1
    sound = clicks(120.0, 2.0).samples
    beats = [event for event in analysis.feed(sound, lambda position: position) if isinstance(event, BeatHeard)]
    assert beats[0].beat_time == pytest.approx(-0.1)
    assert beats[0].beat == 0


@pytest.mark.long
def test_lines_may_come_and_go_while_the_music_plays() -> None:
    clock = MapClock(None, 60.0)
    analysis = AudioAnalysis(RATE, measures=clock)
    sound, at = clicks(120.0, 24.0).samples, 0

    def heard(seconds: float) -> list[ControlEvent]:
        nonlocal at
        at, start = at + round(seconds * RATE), at
        return analysis.feed(sound[start:at], lambda position: position)

    assert {event.source for event in heard(8.0) if isinstance(event, BeatHeard)} == {"audio"}
    clock.replace(steady_map(90.0, 0.0, 4, 40))
    assert {event.source for event in heard(6.0) if isinstance(event, BeatHeard)} == {"map"}
    clock.replace(None)
    events = heard(6.0)
    assert [(one.source, one.state) for one in events if isinstance(one, SourceChanged)] == [("map", "lost")]
    assert {event.source for event in events if isinstance(event, BeatHeard)} == {"audio"}
