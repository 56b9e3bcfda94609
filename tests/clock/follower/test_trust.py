"""Trust in a tracker: what it makes out of talk, a crowd and applause does not move the show."""

import math

import numpy as np
import pytest

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK
from live.control.audio.analysis import make_tracker
from tests.fixtures.mostly_long import mostly_long

RATE, BLOCK = 44_100, 512


def follow(sound, follower=None):
    """Feed a tracker and a follower; return the follower and the timeline's beat at each tick."""
    tracker, _ = make_tracker("network", RATE)
    follower = TimelineFollower(tempo=100.0) if follower is None else follower
    beats, tick = [], 0
    for block in range(sound.size // BLOCK):
        position = (block + 1) * BLOCK / RATE
        for beat in tracker.feed(sound[block * BLOCK : (block + 1) * BLOCK]):
            follower.observe(
                beat.position, beat.period, beat.confidence, position, beat=beat.beat,
                beats_per_measure=beat.beats_per_measure,
            )  # fmt: skip
        while tick * TICK < position:
            beats.append(follower.advance(tick * TICK).beat_at(tick * TICK))
            tick += 1
    return follower, np.array(beats)


def talk(seconds, seed=3):
    """Twelve people who talk at once: syllables of irregular lengths over a hall's noise."""
    rng, count = np.random.default_rng(seed), int(seconds * RATE)
    sound, time = 0.003 * rng.normal(size=count), np.arange(count) / RATE
    for _ in range(12):
        envelope, at, pitch = np.zeros(count), 0.0, rng.uniform(90.0, 240.0)
        while at < seconds:
            length = rng.gamma(4.0, 0.05)
            begin, end = int(at * RATE), min(int((at + length) * RATE), count)
            envelope[begin:end] += rng.uniform() ** 2 * np.hanning(max(end - begin, 1))
            at += length * rng.uniform(1.0, 2.5)
        sound += 0.01 * envelope * np.sign(np.sin(2.0 * np.pi * pitch * time))
    return sound.astype(np.float32)


def applause(seconds, seed=4, rate=150.0):
    """Claps of many hands at any time."""
    rng, count = np.random.default_rng(seed), int(seconds * RATE)
    sound = np.zeros(count + 2000)
    for begin in rng.integers(0, count, int(rate * seconds)):
        sound[begin : begin + 1500] += rng.normal(size=1500) * np.exp(-np.arange(1500) / 250.0) * rng.uniform(0.02, 0.1)
    return sound[:count].astype(np.float32)


@mostly_long("seed", [3, pytest.param(11, marks=pytest.mark.long)], quick=[])
@mostly_long("make", [talk, applause], quick=[])
def test_a_crowd_alone_does_not_move_the_timeline(make, seed):
    _, beats = follow(make(40.0, seed))
    even = np.arange(beats.size) * TICK * 100.0 / 60.0
    assert np.abs(beats - even).max() < 0.02  # beats


def chords(bpm, seconds):
    """A chord on each beat, without drums; another chord in each measure."""
    count, period = int(seconds * RATE), 60.0 / bpm
    sound = np.zeros(count)
    for beat in range(int(seconds / period)):
        begin = int(beat * period * RATE)
        time = np.arange(min(int(1.2 * period * RATE), count - begin)) / RATE
        root = (220.0, 174.6, 196.0, 146.8)[(beat // 4) % 4]
        for part in (1.0, 1.26, 1.5):
            tone = np.sin(2.0 * np.pi * root * part * time) * np.exp(-time / 0.6) * (1.0 - np.exp(-time / 0.02))
            sound[begin : begin + time.size] += (0.05 if beat % 4 == 0 else 0.03) * tone
    return sound.astype(np.float32)


@mostly_long("bpm", [72.0, 90.0, 126.0], quick=[2])
def test_chords_without_drums_are_followed(bpm):
    follower, _ = follow(chords(bpm, 14.0))
    assert follower.states["audio"] in ("following", "locked")
    assert math.log2(follower.tempo / bpm) == pytest.approx(round(math.log2(follower.tempo / bpm)), abs=0.03)


def said(follower, count, confidence, *, begin=0.3, period=0.5):
    """A tracker names beats at this confidence; returns the time of the next one."""
    tick = int(begin / TICK)
    for beat in range(count):
        time = begin + beat * period
        while tick * TICK < time:
            tick += 1
            follower.advance(tick * TICK)
        follower.observe(time, period, confidence, tick * TICK, beat=beat % 4, beats_per_measure=4)
    return begin + count * period


def test_low_confidence_is_not_followed_and_a_followed_band_may_be_less_sure_for_a_while():
    follower = TimelineFollower(tempo=100.0)
    time = said(follower, 20, 0.3)
    assert follower.states["audio"] == "listening"
    assert follower.tempo == pytest.approx(100.0)
    time = said(follower, 12, 0.9, begin=time)
    assert follower.states["audio"] == "locked"
    assert follower.tempo == pytest.approx(120.0, rel=0.01)
    time = said(follower, 6, 0.3, begin=time)  # a quiet bridge
    assert follower.states["audio"] in ("following", "locked")
    said(follower, 24, 0.2, begin=time)  # the band has gone, the hall talks
    assert follower.states["audio"] == "listening"
    assert follower.state == "freewheel"
