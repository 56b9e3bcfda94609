"""Trackers over pieces whose beats are known: what they name, what it costs, and made-up pieces for a quick look."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._beat_scores import Named, Truth, read_truth
from live.clock.beat_estimate import BeatEstimate
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.audio.analysis import TrackerName, make_tracker
from live.control.audio.music_file import read_music

RATE = 44_100
BLOCK = 512
SEEDED_AT = 5.0
Sound = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What a tracker named in one piece, the Timeline's beats [s], and the seconds each block took."""

    named: Named
    timeline: npt.NDArray[np.float64]
    costs: npt.NDArray[np.float64]


def listen(sound: Sound, name: TrackerName, truth: Truth | None = None) -> Heard:
    """Feed blocks of 512; with `truth` the true tempo is tapped at 5 s and the next true downbeat is pressed."""
    tracker, _ = make_tracker(name, RATE)
    follower = TimelineFollower(follow_metre=True)
    seeds = _seeds(truth) if truth is not None else []
    beats: list[BeatEstimate] = []
    lines: list[float] = []
    costs = np.zeros(sound.size // BLOCK)
    tick = 0
    for block in range(costs.size):
        part = sound[block * BLOCK : (block + 1) * BLOCK]
        begin = time.perf_counter()
        found = tracker.feed(part)
        costs[block] = time.perf_counter() - begin
        position = (block + 1) * BLOCK / RATE
        while seeds and position >= seeds[0][0]:
            _tell(tracker, follower, *seeds.pop(0))
        tick = _run(follower, tick, position, lines)
        for beat in found:
            _keep(beats, beat)
            if not tracker.silent:
                follower.observe(
                    beat.position,
                    beat.period,
                    beat.confidence,
                    position,
                    beat=beat.beat,
                    beats_per_measure=beat.beats_per_measure,
                )
    named = Named(
        np.array([beat.position for beat in beats]),
        np.array([beat.fed for beat in beats]),
        np.array([beat.beat + 1 for beat in beats], np.int64),
    )
    return Heard(named, np.array(lines), costs)


def excerpt(path: Path) -> tuple[Sound, Truth]:
    """One excerpt and its truth."""
    sound = read_music(path).samples.mean(axis=1, dtype=np.float32)
    return sound, read_truth(path.with_suffix(""), sound.size / RATE)


def made_up(tempi: Sequence[tuple[float, float]], *, metre: int = 4, seed: int = 1) -> tuple[Sound, Truth]:
    """A bass drum, a snare and hats, tempo after tempo: (bpm, seconds) each; bpm 0 is silence (beats run on)."""
    rng = np.random.default_rng(seed)
    seconds = sum(length for _, length in tempi)
    sound = rng.normal(0.0, 1e-4, int((seconds + 1.0) * RATE))
    beats, begin, bpm, ignore = [], 0.2, 120.0, []
    for tempo, length in tempi:
        if tempo == 0.0:
            ignore.append([begin, begin + length])
        bpm = tempo or bpm
        times = begin + np.arange(round(length * bpm / 60.0)) * 60.0 / bpm
        beats += [(t, tempo > 0.0) for t in times.tolist()]
        begin = float(times[-1]) + 60.0 / bpm
    for number, (moment, played) in enumerate(beats):
        if played:
            add_beat(sound, moment, number % metre, 60.0 / bpm, rng)
    starts = np.cumsum([0.2] + [length for _, length in tempi])[1:-1]
    changes = [float(s) for s, (tempo, _) in zip(starts, tempi[1:], strict=True) if tempo > 0.0]
    moments = np.array([moment for moment, _ in beats])
    return sound.astype(np.float32), Truth(moments, np.arange(moments.size) % metre + 1, ignore, changes, True, seconds)


def add_beat(
    sound: npt.NDArray[np.float64], moment: float, number: int, period: float, rng: np.random.Generator
) -> None:
    t = np.arange(int(0.2 * RATE)) / RATE
    kick = 0.6 * np.sin(2.0 * np.pi * (48.0 * t + 3.0 * (1.0 - np.exp(-t / 0.03)))) * np.exp(-t / 0.07)
    noise = rng.normal(0.0, 1.0, t.size)
    snare = 0.25 * noise * np.exp(-t / 0.05) + 0.2 * np.sin(2.0 * np.pi * 190.0 * t) * np.exp(-t / 0.06)
    hat = 0.1 * np.diff(noise, prepend=0.0) * np.exp(-t / 0.02)
    bass = 0.3 * np.sin(2.0 * np.pi * (55.0 if number else 41.2) * t) * np.exp(-t / 0.15)
    # hats, bass and drum of one beat, `number` in the measure
    hits = [(0.0, hat), (0.5, hat), (0.0, bass), (0.0, snare if number % 2 else kick)]
    for offset, hit in hits:
        start = round((moment + offset * period) * RATE)
        part = sound[start : start + hit.size]
        part += hit[: part.size]


def _seeds(truth: Truth) -> list[tuple[float, str, float]]:
    after = int(np.searchsorted(truth.time, SEEDED_AT))
    near = np.diff(truth.time[max(after - 4, 0) : after + 5])
    seeds = [(SEEDED_AT, "tap", 60.0 / float(np.median(near)))]
    ones = truth.time[(truth.beat == 1) & (truth.time >= SEEDED_AT)]
    if truth.downbeats and ones.size:
        seeds.append((float(ones[0]), "one", float(ones[0])))
    return seeds


def _tell(tracker: object, follower: TimelineFollower, at: float, what: str, value: float) -> None:
    if isinstance(tracker, BeatTracker):
        tracker.tap(value) if what == "tap" else tracker.set_downbeat(value)
    if what == "one":
        follower.set_downbeat(at)


def _keep(beats: list[BeatEstimate], beat: BeatEstimate) -> None:
    """A beat that is named again before it comes replaces the first naming."""
    if beats and beat.replaces == beats[-1].position and beat.fed < beat.replaces:
        beats.pop()
    beats.append(beat)


def _run(follower: TimelineFollower, tick: int, until: float, lines: list[float]) -> int:
    """The ticks up to `until`; each whole beat that is crossed goes into `lines`."""
    while tick / 64.0 < until:
        now = tick / 64.0
        before = follower.timeline.beat_at(now)
        timeline = follower.advance(now)
        number = np.floor(timeline.beat_at(now + 1.0 / 64.0))
        if number > np.floor(before):
            lines.append(timeline.time_at(float(number)))
        tick += 1
    return tick
