"""Alignment of recordings with the beat: from claps to a click or a song, else guessed; given values have priority.

Unconfirmed guesses of tempo and first beat are marked by a comment in the TOML file (T017).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.clock.tracking.aubio_tracker import AubioTracker
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.library.motion_file import read_motion
from live.library.recording_file import RecordingEntry
from live.motion.beats.clap_sync import (
    MIN_CLAPS,
    AssignedClap,
    Clap,
    ClapSync,
    find_claps,
    sync_to_claps,
    sync_to_click,
    sync_to_song,
)
from live.motion.beats.music_reference import MusicReference, apply_manual
from live.motion.beats.tempo_estimation import SIMPLE_RATIOS, TempoEstimate, estimate_tempo, feet_contradict
from live.motion.cleanup.frame_rate_check import suspect_frame_rate
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion, UpAxis
from live.motion.retarget.body_tracks import BodyTracks, body_tracks
from live.motion.retarget.retarget import retarget

BLOCK_SAMPLES: Final = 65536
GRID_TOLERANCE: Final = 0.025
"""If most beats lie this near [s] to an even grid, the music keeps its tempo and the grid is used."""
MIN_GRID_SHARE: Final = 0.7
PERIOD_RANGE: Final = (0.25, 1.5)
"""Range of seconds per beat: 240 to 40 bpm."""
GRID_SECONDS: Final = 240.0
"""Seconds of beats from which the grid is fitted; claps are at the beginning."""
SHARE_OF_BEST: Final = 0.6
"""Periods with a phase vector shorter than this share of the longest are not tried."""
MAX_PERIODS_TRIED: Final = 12
MIN_BEATS: Final = 6
"""Least number of beats of a song."""
ONSET_LEVEL: Final = 0.02
"""The song begins where its level first reaches this share of its loudest 10 ms."""
MAX_LEAD_BEATS: Final = 0.25
"""A beat may lie this far [beats] before the first sound."""


@dataclass(frozen=True, slots=True, eq=False)
class SongBeats:
    """The beats of a song [s from the start of its file], ascending."""

    beats: Float64
    steady: bool
    """True if the song keeps its tempo: the beats are then those of a fitted grid."""

    @property
    def bpm(self) -> float:
        """Tempo over the whole song."""
        return 60.0 * (self.beats.size - 1) / float(self.beats[-1] - self.beats[0])


def song_beats(path: Path) -> SongBeats:
    """Return all beats of an audio file, from first sound to end; PersonError if it cannot be read or has no beat.

    The beat tracker finds the first beats only after some seconds. If the song keeps its tempo, the grid is extended
    back to its first sound.
    """
    try:
        music = read_music(path)
    except MusicFileError as error:
        raise PersonError(str(error)) from None
    heard, period = _tracked_beats(music)
    if heard.size < MIN_BEATS:
        raise PersonError(f"{path}: no steady beat was heard in {music.duration:.0f} s", "give --click BPM instead")
    grid = _even_grid(heard[heard < heard[0] + GRID_SECONDS], period)
    if grid is None:
        return SongBeats(heard, False)
    slope, offset = grid
    begin = _first_sound(music)
    first, last = np.ceil((begin - offset) / slope - MAX_LEAD_BEATS), np.floor((music.duration - offset) / slope)
    return SongBeats(offset + slope * np.arange(first, last + 1), True)


def _tracked_beats(music: Music) -> tuple[Float64, float]:
    """The tracker's beats, ascending and without doubles, and its median period [s]."""
    tracker = AubioTracker(float(music.sample_rate))
    mono = music.samples.mean(axis=1, dtype=np.float32)
    estimates = [
        beat for at in range(0, mono.size, BLOCK_SAMPLES) for beat in tracker.feed(mono[at : at + BLOCK_SAMPLES])
    ]
    if not estimates:
        return np.zeros(0), 0.5
    period = float(np.median([beat.period for beat in estimates]))
    kept: list[float] = []
    for position in sorted(beat.position for beat in estimates if beat.position >= 0.0):
        if not kept or position - kept[-1] > 0.5 * period:
            kept.append(position)
    return np.array(kept, np.float64), period


def _even_grid(heard: Float64, period: float) -> tuple[float, float] | None:
    """Period and offset [s] of the grid on which most beats lie; None if the tempo changes.

    The mean phase vector of the beats is long at the right period and its fractions; of those the one nearest to the
    tracker's period is taken.
    """
    step = 0.05 * period / max(float(heard[-1] - heard[0]), 1.0)
    tries = PERIOD_RANGE[0] * np.exp(np.arange(0.0, np.log(PERIOD_RANGE[1] / PERIOD_RANGE[0]), step))
    lengths = np.array([abs(np.mean(np.exp(2j * np.pi * heard / one))) for one in tries])
    peaks = 1 + np.flatnonzero((lengths[1:-1] >= lengths[:-2]) & (lengths[1:-1] > lengths[2:]))
    good = tries[peaks[lengths[peaks] >= SHARE_OF_BEST * lengths[peaks].max(initial=0.0)]]
    for one in sorted(good, key=lambda p: abs(float(np.log(p / period))))[:MAX_PERIODS_TRIED]:
        grid = _refine_grid(heard, float(one))
        if grid is not None:
            return grid
    return None


def _refine_grid(heard: Float64, slope: float) -> tuple[float, float] | None:
    """Period and offset [s] refined over the beats near the grid; None if they are too few."""
    offset = float(np.angle(np.mean(np.exp(2j * np.pi * heard / slope)))) / (2.0 * np.pi) * slope
    for _ in range(4):
        numbers = np.round((heard - offset) / slope)
        near = np.abs(heard - offset - numbers * slope) < GRID_TOLERANCE
        if near.mean() < MIN_GRID_SHARE:
            return None
        slope, offset = (float(value) for value in np.polyfit(numbers[near], heard[near], 1))
    return slope, offset


def _first_sound(music: Music) -> float:
    """Time of the song's first sound [s]."""
    step = max(1, round(0.01 * music.sample_rate))
    whole = music.samples.shape[0] // step * step
    if whole == 0:
        return 0.0
    peaks = np.abs(music.samples[:whole]).max(axis=1).reshape(-1, step).max(axis=1)
    return float(np.argmax(peaks >= ONSET_LEVEL * max(float(peaks.max()), 1e-9)) * step / music.sample_rate)


CONFIRMED_SOURCES: Final = {"click": "from claps to the click", "song": "from claps to the song"}
"""Sources that count as confirmed; claps alone may be other hand movements, so a person confirms them like a guess."""
MIN_CONFIDENCE: Final = 0.3
"""Claps with less confidence contradict each other: their result counts as a guess."""
GUESS_COMMENT: Final = "guess: confirm"
"""The comment behind an unconfirmed number in a TOML file."""


@dataclass(frozen=True, slots=True)
class SyncRequest:
    """What the user gives about a recording and its music; None: to be found."""

    file: Path
    skeleton: Path | None = None
    fps: float | None = None
    up: UpAxis | None = None
    drop_frames: int | None = None
    click_bpm: float | None = None
    count: int | None = None
    """Number of beats clapped to the click."""
    song: Path | None = None
    anchor_s: float | None = None
    """First beat of the first measure, from the first frame that is kept [s]."""
    bpm: float | None = None
    beats_per_measure: int = 4


@dataclass(frozen=True, slots=True)
class SyncResult:
    """The music reference that was found, and the claps."""

    reference: MusicReference
    claps: tuple[AssignedClap, ...]
    drop_frames: int
    fps: float
    """The frame rate that was used."""
    doubt: str = ""
    """Why the frame rate in the file's header is doubtful; empty if it is not, or was given."""

    @property
    def guessed(self) -> bool:
        """Whether values not set by hand are guesses, not from at least four claps that fit a click or a song."""
        clapped = sum(one.beat is not None for one in self.claps)
        return (
            self.reference.source not in CONFIRMED_SOURCES
            or self.reference.confidence < MIN_CONFIDENCE
            or clapped < MIN_CLAPS
        )

    @property
    def comment(self) -> str:
        """Comment for a TOML file behind tempo and first beat, if they were not set by hand."""
        if self.guessed:
            return GUESS_COMMENT
        return f"{CONFIRMED_SOURCES[self.reference.source]}, confidence {self.reference.confidence:.2f}"


def find_sync(request: SyncRequest) -> SyncResult:
    """Return the music reference of a recording.

    Its sources in this order: values set by the user; claps to the beats of `song`; claps to a click of `click_bpm`;
    four claps or more at an even tempo that the feet do not contradict; the feet (with the tempo of the click, the song
    or `bpm`, if given). PersonError if the file cannot be read or nothing is found.
    """
    beats = None if request.song is None else song_beats(request.song)
    try:
        motion = read_motion(request.file, skeleton=request.skeleton, up=request.up)
        tracks = body_tracks(motion, fps=request.fps, up=request.up)
    except MotionFileError as error:
        raise PersonError(str(error)) from None
    drop = request.drop_frames
    if drop is None:  # a given anchor counts from the file's first frame, unless drop_frames is given
        drop = find_recording_start(tracks).drop_frames if request.anchor_s is None else 0
    if drop >= tracks.frame_count:
        raise PersonError(f"--drop-frames {drop}: the recording has {tracks.frame_count} frames")
    lasts = (tracks.frame_count - drop) / tracks.rate
    if request.anchor_s is not None and request.anchor_s >= lasts:
        raise PersonError(f"--anchor {request.anchor_s:g}: the recording lasts {lasts:.2f} s")
    claps = find_claps(tracks, drop)
    known = request.click_bpm or request.bpm
    if beats is not None:
        found = sync_to_song(claps, beats.beats, request.beats_per_measure)
        known = known or beats.bpm
    elif known is not None:
        found = sync_to_click(claps, known, request.count)
        if (
            request.click_bpm is None
            and found is not None
            and sum(one.beat is not None for one in found.claps) < MIN_CLAPS
        ):
            found = None  # no click was given: one or two touches of the hands on the beat belong to the dance
    else:
        found = sync_to_claps(claps)
    reference = None if found is None else found.reference
    settled = request.anchor_s is not None and request.bpm is not None
    if not settled and (reference is None or reference.source == "claps"):
        guess = _guess_tempo(request, motion, tracks, drop, known)
        if found is None or (guess is not None and _is_dance(found, guess, tracks, drop)):
            reference, found = (None if guess is None else _with_touches(guess.reference, found)), None
    reference = apply_manual(reference, anchor_s=request.anchor_s, bpm=request.bpm)
    if reference is None:
        raise PersonError(
            f"{request.file}: no claps were found, and {tracks.frame_count / tracks.rate:.1f} s of it are too short or "
            "too still to guess a tempo",
            "give both: --anchor SECONDS --bpm BPM",
        )
    suspicion = suspect_frame_rate(tracks, drop) if request.fps is None else None
    doubt = "" if suspicion is None else str(suspicion)
    return SyncResult(reference, _placed_claps(claps, found), drop, tracks.rate, doubt)


STANDING_SPEED: Final = 0.25
"""Mean speed of the ankles [m/s] below which somebody stands and counts."""


def _is_dance(found: ClapSync, guess: TempoEstimate, tracks: BodyTracks, drop: int) -> bool:
    """Whether claps without a click are touches of the dance, because the feet contradict their tempo.

    Who stands and claps is counting: then the feet may dance at any simple ratio to it, else at an octave.
    """
    times = [one.clap.time_s for one in found.claps if one.beat is not None]
    first, last = (drop + round(time * tracks.rate) for time in (min(times), max(times)))
    moved = np.linalg.norm(np.diff(tracks.ankles[first : last + 1], axis=0), axis=-1)
    stands = float(moved.mean()) * tracks.rate < STANDING_SPEED if moved.size else False
    bpm = found.reference.bpm
    return feet_contradict(guess, bpm, SIMPLE_RATIOS) if stands else feet_contradict(guess, bpm)


def _with_touches(reference: MusicReference, found: ClapSync | None) -> MusicReference:
    """Return the feet's reference with a note on claps that it contradicts."""
    if found is None:
        return reference
    words = f"hands that touch at {found.reference.bpm:.1f} bpm are no count: the feet dance at another tempo"
    return replace(reference, note=f"{reference.note}; {words}")


def _guess_tempo(
    wish: SyncRequest, motion: SourceMotion, tracks: BodyTracks, drop: int, bpm: float | None
) -> TempoEstimate | None:
    try:
        clip = retarget(motion, name=wish.file.stem, fps=tracks.rate, up=wish.up, drop_frames=drop)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None
    return estimate_tempo(clip, wish.beats_per_measure, bpm)


def _placed_claps(claps: list[Clap], found: ClapSync | None) -> tuple[AssignedClap, ...]:
    return found.claps if found is not None else tuple(AssignedClap(clap, None, None) for clap in claps)


def guessed_fields(entry: RecordingEntry, text: str) -> list[str]:
    """Return which of bpm and first_beat_s of a step are marked as guesses in its TOML `text`."""
    lines = text.splitlines()
    found = []
    for field in ("bpm", "first_beat_s"):
        line = entry.problem(field, "").line
        if line is not None and line <= len(lines) and GUESS_COMMENT in lines[line - 1].partition("#")[2]:
            found.append(field)
    return found


def guess_warnings(entry: RecordingEntry, text: str) -> list[tuple[str, str]]:
    """Return field and message for each unconfirmed guess in the file."""
    return [
        (
            field,
            f"{getattr(entry.recording, field):g} is a guess; look at the step on the beat (live steps play), correct "
            f"the number, and remove the comment {GUESS_COMMENT!r}",
        )
        for field in guessed_fields(entry, text)
    ]
