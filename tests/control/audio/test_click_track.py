"""Tests of the click track: each beat once and sample-accurate, for any timeline and block size."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.clock.timeline import Timeline
from live.control.audio.click_output import MAX_LATE, ClickTrack

RATE = 48_000
ACCENT = np.full(960, 1.0, np.float32)
BEAT = np.full(960, 0.5, np.float32)


def render_blocks(track: ClickTrack, timelines: Iterator[tuple[Timeline, float]], sizes: list[int]) -> np.ndarray:
    """The sound of blocks of these sizes from 0 s on, each after the next timeline was set."""
    sound = np.zeros(sum(sizes), np.float32)
    start = 0
    for size in sizes:
        track.set_timeline(*next(timelines))
        track.fill(sound[start : start + size], start / RATE, size / RATE)
        start += size
    return sound


def onsets(sound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frames at which clicks start, and whether they are accents."""
    frames = np.flatnonzero(np.diff(sound, prepend=0.0) > 0.2)
    return frames, sound[frames] > 0.75


def repeat_timeline(timeline: Timeline, one: float = -np.inf) -> Iterator[tuple[Timeline, float]]:
    while True:
        yield timeline, one


@settings(max_examples=20, deadline=None)
@given(
    tempo=st.floats(40.0, 300.0),
    metre=st.integers(2, 7),
    origin=st.floats(-3.0, 3.0),
    sizes=st.lists(st.integers(16, 4000), min_size=20, max_size=60),
)
def test_clicks_are_sample_accurate_with_accented_downbeats(
    tempo: float, metre: int, origin: float, sizes: list[int]
) -> None:
    timeline = Timeline(tempo=tempo, beats_per_measure=metre, beat_origin=origin, measure_origin=1.0)
    frames, accents = onsets(render_blocks(ClickTrack(ACCENT, BEAT), repeat_timeline(timeline), sizes))
    end = sum(sizes) / RATE
    beats = np.arange(np.ceil(timeline.beat_at(0.0)), timeline.beat_at(end) + 1)
    times = np.array([timeline.time_at(beat) for beat in beats])
    expected = times[(times >= 0.0) & (times < end - 1.0 / RATE)]
    assert len(frames) == pytest.approx(len(expected), abs=1)
    assert np.allclose(frames[: len(expected)], expected[: len(frames)] * RATE, atol=1.0)
    for frame, accent in zip(frames, accents, strict=True):
        assert accent == (round(timeline.beat_at(frame / RATE) - 1.0) % metre == 0)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 1000), spread=st.floats(0.0, 0.2))
def test_slewed_timeline_skips_or_doubles_no_beat(seed: int, spread: float) -> None:
    chance = np.random.default_rng(seed)
    line = Timeline(tempo=120.0)

    def slewed() -> Iterator[tuple[Timeline, float]]:
        nonlocal line
        for index in range(400):  # a block of 512: the line changes where the picture is, before what is heard
            line = line.with_tempo(float(120.0 * (1.0 + chance.uniform(-spread, spread))), index * 512 / RATE - 0.03)
            yield line, -np.inf

    track = ClickTrack(ACCENT, BEAT)
    frames, accents = onsets(render_blocks(track, slewed(), [512] * 400))
    passed = int(np.floor(line.beat_at(512 * 400 / RATE - 0.02))) + 1  # beat 0 is at the beginning
    assert abs(len(frames) - passed) <= 1
    assert track.missed == 0
    first = 0 if accents[0] else 1  # the first change may put beat 0 before the beginning
    assert accents.tolist() == [(index + first) % 4 == 0 for index in range(len(frames))]
    assert np.diff(frames).min() > 0.3 * RATE


def test_beat_far_behind_a_jump_is_missed() -> None:
    track, out = ClickTrack(ACCENT, BEAT), np.zeros(480, np.float32)
    track.set_timeline(Timeline(tempo=60.0, beat_origin=0.5))
    track.fill(out, 0.0, 0.01)
    track.set_timeline(Timeline(tempo=60.0, beat_origin=1.0 + 2 * MAX_LATE))
    track.fill(out, 0.01, 0.01)
    assert (track.clicks, track.missed) == (0, 1)
    track.set_timeline(Timeline(tempo=60.0, beat_origin=1.99))
    track.fill(out, 0.02, 0.01)
    assert track.clicks == 1
    assert out[0] == pytest.approx(0.5)  # 10 ms late: at once


def test_count_in_clicks_until_downbeat_with_click_off() -> None:
    timeline = Timeline(tempo=120.0, measure_origin=-1.0)  # lines at 3, 7 … until the one comes
    track = ClickTrack(ACCENT, BEAT, on=False)
    frames, accents = onsets(render_blocks(track, repeat_timeline(timeline, one=6.0), [480] * 500))
    assert [round(frame / RATE * 2.0) for frame in frames] == [0, 1, 2, 3, 4, 5, 6]
    assert [round(frame / RATE * 2.0) for frame in frames[accents]] == [2, 6]
    track = ClickTrack(ACCENT, BEAT, on=False)
    assert not render_blocks(track, repeat_timeline(timeline), [480] * 100).any()


def test_track_without_timeline_is_silent() -> None:
    out = np.ones(64, np.float32)
    ClickTrack(ACCENT, BEAT).fill(out, 0.0, 0.01)
    assert not out.any()
