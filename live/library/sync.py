"""Where the beats lie in a recording: by claps to a click or a song, else guessed; what a person says wins."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.library.motion_file import read_motion
from live.library.music_reference import song_beats
from live.motion.beats.clap_sync import FEWEST, ClapSync, PlacedClap, sync_to_claps, sync_to_click, sync_to_song
from live.motion.beats.claps import Clap, find_claps
from live.motion.beats.music_reference import MusicReference, set_by_hand
from live.motion.beats.tempo_guess import guess_tempo
from live.motion.cleanup.trim_start import find_beginning
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion, UpAxis
from live.motion.retarget.body_tracks import BodyTracks, body_tracks
from live.motion.retarget.retarget import retarget

HEARD: Final = {"click": "from claps to the click", "song": "from claps to the song"}
"""What rests on nothing but claps may rest on something else that hands do: it is confirmed, like a guess."""
DOUBTED: Final = 0.3
"""Claps with less confidence contradict each other: what they say is a guess."""
GUESS: Final = "guess: confirm"
"""The comment behind a number in a TOML file that nobody has confirmed."""


@dataclass(frozen=True, slots=True)
class SyncWish:
    """What a person says about a recording and its music; None: find it."""

    file: Path
    skeleton: Path | None = None
    fps: float | None = None
    up: UpAxis | None = None
    drop_frames: int | None = None
    click_bpm: float | None = None
    count: int | None = None
    """Beats that were clapped to the click."""
    song: Path | None = None
    anchor_s: float | None = None
    """First beat of the first measure, from the first frame that is kept [s]."""
    bpm: float | None = None
    beats_per_measure: int = 4


@dataclass(frozen=True, slots=True)
class Sync:
    """What was found."""

    reference: MusicReference
    claps: tuple[PlacedClap, ...]
    drop_frames: int
    fps: float
    """Frames per second, as used."""

    @property
    def guessed(self) -> bool:
        """Whether what no hand has set is a guess: not from at least four claps that agree with a click or a song."""
        clapped = sum(one.beat is not None for one in self.claps)
        return self.reference.source not in HEARD or self.reference.confidence < DOUBTED or clapped < FEWEST

    @property
    def comment(self) -> str:
        """What a TOML file says behind tempo and first beat, where no hand has set them."""
        if self.guessed:
            return GUESS
        return f"{HEARD[self.reference.source]}, confidence {self.reference.confidence:.2f}"


def find_sync(wish: SyncWish) -> Sync:
    """The music reference of a recording.

    In this order: what a person has set; claps to the beats of `song`; claps to a click of `click_bpm`; claps alone;
    the feet (with the tempo of the click, the song or `bpm`, where one is given). Raises PersonError where the file
    cannot be read or nothing is found.
    """
    beats = None if wish.song is None else song_beats(wish.song)
    try:
        motion = read_motion(wish.file, skeleton=wish.skeleton, up=wish.up)
        tracks = body_tracks(motion, fps=wish.fps, up=wish.up)
    except MotionFileError as error:
        raise PersonError(str(error)) from None
    drop = wish.drop_frames
    if drop is None:  # whoever sets the anchor counts from the file's first frame, unless she says what is left out
        drop = find_beginning(tracks).drop_frames if wish.anchor_s is None else 0
    if drop >= tracks.frame_count:
        raise PersonError(f"--drop-frames {drop}: the recording has {tracks.frame_count} frames")
    lasts = (tracks.frame_count - drop) / tracks.rate
    if wish.anchor_s is not None and wish.anchor_s >= lasts:
        raise PersonError(f"--anchor {wish.anchor_s:g}: the recording lasts {lasts:.2f} s")
    claps = find_claps(tracks, drop)
    known = wish.click_bpm or wish.bpm
    if beats is not None:
        found = sync_to_song(claps, beats.beats, wish.beats_per_measure)
        known = known or beats.bpm
    elif known is not None:
        found = sync_to_click(claps, known, wish.count)
        if wish.click_bpm is None and found is not None and sum(one.beat is not None for one in found.claps) < FEWEST:
            found = None  # nobody has said that there are claps: a touch or two on the beat are dancing
    else:
        found = sync_to_claps(claps)
    reference = None if found is None else found.reference
    settled = wish.anchor_s is not None and wish.bpm is not None
    if reference is None and not settled:
        reference = _guess(wish, motion, tracks, drop, known)
    reference = set_by_hand(reference, anchor_s=wish.anchor_s, bpm=wish.bpm)
    if reference is None:
        raise PersonError(
            f"{wish.file}: nobody claps, and {tracks.frame_count / tracks.rate:.1f} s of it are too few or too still "
            "to guess a tempo",
            "say both: --anchor SECONDS --bpm BPM",
        )
    return Sync(reference, _listed(claps, found), drop, tracks.rate)


def _guess(
    wish: SyncWish, motion: SourceMotion, tracks: BodyTracks, drop: int, bpm: float | None
) -> MusicReference | None:
    try:
        clip = retarget(motion, name=wish.file.stem, fps=tracks.rate, up=wish.up, drop_frames=drop)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None
    guess = guess_tempo(clip, wish.beats_per_measure, bpm)
    return None if guess is None else guess.reference


def _listed(claps: list[Clap], found: ClapSync | None) -> tuple[PlacedClap, ...]:
    return found.claps if found is not None else tuple(PlacedClap(clap, None, None) for clap in claps)
