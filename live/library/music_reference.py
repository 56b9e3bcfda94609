"""The music to which a recording was danced, from an audio file: where its beats fall."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.clock.tracking.aubio_tracker import AubioTracker
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.motion.formats.source_motion import Float64

BLOCK: Final = 65536
EVEN: Final = 0.025
"""Beats of which most lie this near [s] to an even grid are from music that keeps its tempo: then that is meant."""
MOST: Final = 0.7
PERIODS: Final = (0.25, 1.5)
"""Seconds per beat that are looked for: 240 to 40 bpm."""
LISTENED: Final = 240.0
"""Seconds of beats by which the grid is found; whoever claps does so at the beginning."""
SHARE_OF_BEST: Final = 0.6
"""Periods whose phase vector is shorter than this share of the longest are not tried."""
TRIED: Final = 12
FEWEST: Final = 6
"""Fewer beats than this are no music."""
AUDIBLE: Final = 0.02
"""The song begins where it first is this loud (share of its loudest 10 ms)."""
EARLY: Final = 0.25
"""A beat may lie this far [beats] before the first sound."""


@dataclass(frozen=True, slots=True, eq=False)
class SongBeats:
    """The beats of a song [s from the start of its file], ascending."""

    beats: Float64
    even: bool
    """True if the song keeps its tempo: then the beats are those of a grid through all that was heard."""

    @property
    def bpm(self) -> float:
        """Tempo over the whole song."""
        return 60.0 * (self.beats.size - 1) / float(self.beats[-1] - self.beats[0])


def song_beats(path: Path) -> SongBeats:
    """All beats of an audio file, from its first sound to its end; PersonError if it cannot be read or has no beat.

    The beat tracker hears the first beats only after some seconds; where the song keeps its tempo the grid is carried
    back to its first sound.
    """
    try:
        music = read_music(path)
    except MusicFileError as error:
        raise PersonError(str(error)) from None
    heard, period = _heard(music)
    if heard.size < FEWEST:
        raise PersonError(f"{path}: no steady beat was heard in {music.duration:.0f} s", "give --click BPM instead")
    grid = _even_grid(heard[heard < heard[0] + LISTENED], period)
    if grid is None:
        return SongBeats(heard, False)
    slope, offset = grid
    begin = _first_sound(music)
    first, last = np.ceil((begin - offset) / slope - EARLY), np.floor((music.duration - offset) / slope)
    return SongBeats(offset + slope * np.arange(first, last + 1), True)


def _heard(music: Music) -> tuple[Float64, float]:
    """Beats as the tracker hears them, ascending and apart, and the period it hears most of the time [s]."""
    tracker = AubioTracker(float(music.sample_rate))
    mono = music.samples.mean(axis=1, dtype=np.float32)
    estimates = [beat for at in range(0, mono.size, BLOCK) for beat in tracker.feed(mono[at : at + BLOCK])]
    if not estimates:
        return np.zeros(0), 0.5
    period = float(np.median([beat.period for beat in estimates]))
    kept: list[float] = []
    for position in sorted(beat.position for beat in estimates if beat.position >= 0.0):
        if not kept or position - kept[-1] > 0.5 * period:
            kept.append(position)
    return np.array(kept, np.float64), period


def _even_grid(heard: Float64, period: float) -> tuple[float, float] | None:
    """Period and offset [s] of the grid on which most beats lie; None where the tempo changes.

    The mean phase vector of the beats is long at the right period and its parts; of those the one nearest to what the
    tracker said is meant.
    """
    step = 0.05 * period / max(float(heard[-1] - heard[0]), 1.0)
    tries = PERIODS[0] * np.exp(np.arange(0.0, np.log(PERIODS[1] / PERIODS[0]), step))
    lengths = np.array([abs(np.mean(np.exp(2j * np.pi * heard / one))) for one in tries])
    peaks = 1 + np.flatnonzero((lengths[1:-1] >= lengths[:-2]) & (lengths[1:-1] > lengths[2:]))
    good = tries[peaks[lengths[peaks] >= SHARE_OF_BEST * lengths[peaks].max(initial=0.0)]]
    for one in sorted(good, key=lambda p: abs(float(np.log(p / period))))[:TRIED]:
        grid = _fitted(heard, float(one))
        if grid is not None:
            return grid
    return None


def _fitted(heard: Float64, slope: float) -> tuple[float, float] | None:
    """Period and offset [s] refined over the beats that lie near the grid; None if too few do."""
    offset = float(np.angle(np.mean(np.exp(2j * np.pi * heard / slope)))) / (2.0 * np.pi) * slope
    for _ in range(4):
        numbers = np.round((heard - offset) / slope)
        near = np.abs(heard - offset - numbers * slope) < EVEN
        if near.mean() < MOST:
            return None
        slope, offset = (float(value) for value in np.polyfit(numbers[near], heard[near], 1))
    return slope, offset


def _first_sound(music: Music) -> float:
    """When the song begins to be heard [s]."""
    step = max(1, round(0.01 * music.sample_rate))
    whole = music.samples.shape[0] // step * step
    if whole == 0:
        return 0.0
    peaks = np.abs(music.samples[:whole]).max(axis=1).reshape(-1, step).max(axis=1)
    return float(np.argmax(peaks >= AUDIBLE * max(float(peaks.max()), 1e-9)) * step / music.sample_rate)
