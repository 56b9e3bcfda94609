"""Tests of AudioAnalysis: events from samples, with show times."""

from collections import deque

import numpy as np
import pytest

from live.clock.follower.manual_control import TrackerHint
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.audio.analysis import AudioAnalysis, TrackerName
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from tests.clock.clicks import clicks
from tests.fixtures.mostly_long import mostly_long

RATE = 44_100


@pytest.mark.long
def test_events_have_show_times() -> None:
    sound, times = clicks(120, RATE, 12.0)
    events = AudioAnalysis(RATE, "microphone").feed(sound[:, None], lambda position: 100.0 + position)
    beats = [event for event in events if isinstance(event, BeatHeard)]
    assert len(beats) > 12
    assert all(event.source == "microphone" and abs(event.time - event.beat_time) < 0.1 for event in beats)
    assert min(abs(beats[-1].beat_time - 100.0 - times)) < 0.02


@pytest.mark.long
def test_live_events_are_stamped_with_current_time() -> None:
    sound, _ = clicks(120, RATE, 12.0)
    events = AudioAnalysis(RATE).feed(sound[:, None], lambda position: position, now=77.0)
    assert {event.time for event in events} == {77.0}


@mostly_long("channels", [1, 2, 6], quick=[1])
def test_identical_channels_give_the_mono_events(channels: int) -> None:
    sound, _ = clicks(120, RATE, 8.0)
    many = np.repeat(sound[:, None], channels, axis=1)
    one = AudioAnalysis(RATE).feed(sound[:, None], lambda position: position)
    mixed = AudioAnalysis(RATE).feed(many, lambda position: position)
    assert [type(event) for event in mixed] == [type(event) for event in one]
    assert [event.time for event in mixed] == pytest.approx([event.time for event in one])


@pytest.mark.long
def test_silence_and_return_are_reported_once() -> None:
    sound, _ = clicks(120, RATE, 4.0)
    still = np.zeros(3 * RATE, np.float32)
    analysis = AudioAnalysis(RATE)
    events: list[ControlEvent] = []
    for part in (still, sound, still, still, sound):
        events += analysis.feed(part[:, None], lambda position: position)
    told = [(event.state, event.time) for event in events if isinstance(event, SourceChanged)]
    assert [state for state, _ in told] == ["paused", "silent", "found", "paused", "silent", "found"]
    assert [time for _, time in told] == pytest.approx([0.8, 1.2, 3.3, 7.65, 8.05, 13.3], abs=0.15)


@pytest.mark.long
def test_slow_single_clicks_are_not_silence() -> None:
    sound, times = clicks(40, RATE, 20.0)
    events = AudioAnalysis(RATE).feed(sound[:, None], lambda position: position)
    late = [event for event in events if event.time > 8.0]
    assert not [event for event in late if isinstance(event, SourceChanged)]
    beats = [event.beat_time for event in late if isinstance(event, BeatHeard)]
    assert all(min(abs(time - beat) for beat in beats) < 0.05 for time in times[(times > 8.5) & (times < 18.0)])


@pytest.mark.long
def test_nan_in_one_channel_does_not_stop_beats() -> None:
    sound, _ = clicks(120, RATE, 12.0)
    both = np.stack([sound, sound], axis=1)
    both[::5000, 1] = np.nan
    analysis = AudioAnalysis(RATE)
    events = analysis.feed(both, lambda position: position)
    assert sum(isinstance(event, BeatHeard) for event in events) > 12
    assert analysis.tracker.bad_samples == len(range(0, sound.size - analysis.tracker.wanted + 1, 5000))


def make_seeded_analysis(seeds: deque[TrackerHint]) -> AudioAnalysis:
    """An analysis that has consumed the hints."""
    analysis = AudioAnalysis(RATE, seeds=seeds)
    analysis.feed(np.zeros((1, 1), np.float32), lambda position: position)
    return analysis


@mostly_long("between", ["network", "aubio"], quick=[])
def test_manual_hints_survive_a_new_analysis(between: TrackerName) -> None:
    seeds = deque([TrackerHint("metre", 0.0, 3.0), TrackerHint("tempo", 0.0, 63.0)])
    middle = AudioAnalysis(RATE, tracker=between)
    middle.take_over(make_seeded_analysis(seeds))
    last = AudioAnalysis(RATE)
    last.take_over(middle)
    sound, _ = clicks(126.0, RATE, 10.0, 0.0)
    last.feed(sound[:, None], lambda position: position)
    assert isinstance(last.tracker, BeatTracker)
    assert last.tracker.pointer.tempo == pytest.approx(63.0, rel=0.03)  # every second click, as the hand said
    assert last.tracker.pointer.metre == 3


@pytest.mark.long
def test_forgotten_hints_are_not_restored() -> None:
    former = make_seeded_analysis(
        deque([TrackerHint("metre", 0.0, 3.0), TrackerHint("tempo", 0.0, 38.0), TrackerHint("forget", 0.0)])
    )
    last = AudioAnalysis(RATE)
    last.take_over(former)
    sound, _ = clicks(126.0, RATE, 10.0, 0.0)
    last.feed(sound[:, None], lambda position: position)
    assert isinstance(last.tracker, BeatTracker)
    assert last.tracker.pointer.tempo == pytest.approx(126.0, rel=0.03)
