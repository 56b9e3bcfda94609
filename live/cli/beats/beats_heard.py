"""What `live beats` hears: a tracker fed block by block, with what a musician would do at certain times."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from live.clock.estimate import BeatEstimate, Samples
from live.clock.tracking.beat_tracker import Tracker
from live.control.audio.music_file import Music
from live.control.audio.trackers import TrackerName, make_tracker

if TYPE_CHECKING:
    from live.cli.beats.beats_timeline import TimelineFile

BLOCK = 512


@dataclass(frozen=True, slots=True)
class Seeds:
    """What is told by hand, and when [s]; None: it is not."""

    tap_bpm: float | None = None
    tap_at: float | None = None
    one_at: float | None = None


class Ear:
    """Feeds a tracker and tells it the seeds when their time has come."""

    def __init__(
        self, sample_rate: float, name: TrackerName, seeds: Seeds, timeline: "TimelineFile | None" = None
    ) -> None:
        self.tracker, self.note = make_tracker(name, sample_rate)
        self._tap_at, self._one_at = seeds.tap_at, seeds.one_at
        self._tap_bpm = seeds.tap_bpm or 0.0
        self._timeline = timeline

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """The beats named while these samples, shape (n,), are heard."""
        beats = self.tracker.feed(samples)
        heard = self.tracker.position
        if self._tap_at is not None and heard >= self._tap_at:
            if isinstance(self.tracker, Tracker):
                self.tracker.tap(self._tap_bpm)
            self._tap_at = None
        if self._one_at is not None and heard >= self._one_at:
            if isinstance(self.tracker, Tracker):
                self.tracker.one(self._one_at)
            if self._timeline is not None:
                self._timeline.one(self._one_at)
            self._one_at = None
        if self._timeline is not None:
            self._timeline.heard(beats, self.tracker.level, heard)
        return beats


def hear_file(ear: Ear, music: Music) -> list[BeatEstimate]:
    """All beats of a file in order of time; of one that was named again before it came, the last name."""
    mono = music.samples.mean(axis=1, dtype=np.float32)
    kept: list[BeatEstimate] = []
    for beat in (beat for at in range(0, mono.size, BLOCK) for beat in ear.feed(mono[at : at + BLOCK])):
        if beat.replaces == beat.replaces and kept and kept[-1].position == beat.replaces:
            kept.pop()
        kept.append(beat)
    return sorted(kept, key=lambda beat: beat.position)


def lines_of(beat: BeatEstimate) -> str:
    """The lines that `live beats --stdin` prints for one estimate."""
    text = f"R {beat.replaces:.5f} {beat.heard:.5f}\n" if beat.replaces == beat.replaces else ""
    place = f" {beat.beat + 1}" if beat.beat >= 0 else ""
    return f"{text}B {beat.position:.5f} {beat.heard:.5f}{place}\n"
