"""Half an hour of one groove, made minute by minute: does the clock slip, does its measure line move?"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bench._beat_scores import TOLERANCE
from bench._clock_pieces import BLOCK, RATE, Sound, add_beat
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.silence import PauseDetector, SoundState
from live.control.audio.analysis import make_tracker

BPM = 121.3
FIRST = 0.2
METRE = 4
PIECE = 60.0
"""Seconds of sound made at once."""

TAIL = 0.25
"""A hit sounds on for less than this [s]."""

HUMAN = 0.004
"""How exactly players play: standard deviation [s]."""

LEFT_OUT = 20.0
"""Nobody counts what the clock does in the first seconds [s]."""


@dataclass(frozen=True, slots=True)
class Slips:
    """What went wrong after the first seconds, and the Timeline's error on the way."""

    missed: int
    """Beats that no named beat met within 70 ms."""
    extra: int
    """Named beats that met none."""
    lines_moved: int
    """How often the measure line of the Timeline lay on another beat than before."""
    timeline_p95: float
    """Seconds."""


def slips(minutes: float) -> Slips:
    """Stream so many minutes through tracker and follower."""
    tracker, _ = make_tracker("network", RATE)
    follower, pauses = TimelineFollower(), PauseDetector()
    hearing: SoundState = "sound"
    named: dict[int, float] = {}
    extra, places, errors, tick = 0, [], [], 0
    for block, part in enumerate(_blocks(60.0 * minutes)):
        now = (block + 1) * BLOCK / RATE
        found = tracker.feed(part)
        while tick / 64.0 < now:
            timeline = follower.advance(tick / 64.0)
            if tick % 16 == 0 and tick / 64.0 > LEFT_OUT:
                true = (tick / 64.0 - FIRST) * BPM / 60.0
                off = timeline.beat_at(tick / 64.0) - timeline.measure_origin - true
                places.append(round(off) % METRE)
                errors.append(abs(off - round(off)) * 60.0 / BPM)
            tick += 1
        before, hearing = hearing, pauses.step(tracker.level, now)
        if hearing != before:
            {"sound": follower.found, "pause": follower.paused, "silence": follower.silent}[hearing](now)
        for beat in found:
            number = round((beat.position - FIRST) * BPM / 60.0)
            if abs(FIRST + number * 60.0 / BPM - beat.position) <= TOLERANCE:
                named[number] = beat.position
            elif beat.position > LEFT_OUT:
                extra += 1
            if hearing == "sound":
                follower.observe(
                    beat.position, beat.period, beat.confidence, now,
                    beat=beat.beat, beats_per_measure=beat.beats_per_measure,
                )  # fmt: skip
    first, last = int((LEFT_OUT - FIRST) * BPM / 60.0) + 1, int((60.0 * minutes - 1.0) * BPM / 60.0)
    missed = sum(number not in named for number in range(first, last))
    moved = int(np.count_nonzero(np.diff(places)))
    return Slips(missed, extra, moved, float(np.percentile(errors, 95)) if errors else float("nan"))


def _blocks(seconds: float) -> Iterator[Sound]:
    """The groove in blocks: a fill, or a measure without drums, every eighth measure; hits as people play them."""
    rng = np.random.default_rng(7)
    over = np.zeros(int(TAIL * RATE))
    rest = np.zeros(0, np.float32)
    begin, number = 0.0, 0
    while begin < seconds:
        length = int(PIECE * RATE)
        sound = rng.normal(0.0, 1e-4, length + over.size)
        sound[: over.size] += over
        while (moment := FIRST + number * 60.0 / BPM) < begin + PIECE - 0.5 * 60.0 / BPM:
            measure, beat = divmod(number, METRE)
            at = max(moment - begin + rng.normal(0.0, HUMAN), 0.0)
            if measure % 16 != 15:
                add_beat(sound, at, beat, 60.0 / BPM, rng)
            if measure % 16 == 7 and beat >= 2:
                for part in (0.25, 0.5, 0.75):
                    add_beat(sound, at + part * 60.0 / BPM, 1, 60.0 / BPM, rng)
            number += 1
        over = sound[length:]
        whole = np.concatenate([rest, sound[:length].astype(np.float32)])
        kept = whole.size // BLOCK * BLOCK
        yield from whole[:kept].reshape(-1, BLOCK)
        rest = whole[kept:]
        begin += PIECE
