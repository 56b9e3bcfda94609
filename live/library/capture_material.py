"""Reader for whole motion capture recordings with their beats, from files and folders, as texture material."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.library.disk_cache import ClipCache
from live.library.motion_file import read_bytes, read_motion
from live.library.motion_formats import installed_formats, is_readable_name, readable_suffixes
from live.library.recording_file import Recording, read_step_files
from live.motion.beats.tempo_estimation import estimate_tempo
from live.motion.cleanup.calibration_poses import trim_calibration_poses
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.clip import Clip
from live.motion.formats.file_error import MotionFileError
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget
from live.motion.step_clip import StepClip

MIN_SECONDS: Final = 1.0
"""Recordings shorter than this [s] are too short for texture matching."""
NO_BEAT_TAG: Final = "no beat"
"""Tag of a recording in which no beat was found: it cannot be cut at beats."""
CACHE: Final = ClipCache("material", max_entries=400, max_bytes=1_000_000_000)


@dataclass(frozen=True, slots=True, eq=False)
class CaptureMaterial:
    """The recordings of files and folders."""

    clips: tuple[StepClip, ...]
    """Whole recordings, `first` at the first beat of measure 1, `step` named after the file."""
    skipped: tuple[str, ...]
    """Files of folders that were skipped, with the reason, a line each."""


def read_material(
    places: Sequence[Path], *, fps: float | None = None, drop_frames: int | None = None
) -> CaptureMaterial:
    """Read the recordings at `places`, files or folders of them, of all formats with a reader.

    TOML files in a folder state how to read its recordings, and their beats. For others `fps` overrides a wrong header
    rate, T-poses (or `drop_frames`) are removed, and beats are guessed from the feet. An unusable file in a folder is
    skipped and listed. PersonError for an unusable file that was named, or if nothing is left.
    """
    clips: list[StepClip] = []
    passed: list[str] = []
    for place in places:
        if not place.exists():
            raise PersonError(f"there is no file and no folder {place}", "--with DIR_OR_FILES")
        files = _motion_files(place) if place.is_dir() else [place]
        if place.is_dir() and not files:
            endings = ", ".join(readable_suffixes())
            raise PersonError(f"no motion files in {place}", f"files that end in {endings} expected")
        known = _descriptions(place if place.is_dir() else place.parent)
        for file in files:
            try:
                clips.append(_cached_recording(file, known.get(file.resolve()), fps, drop_frames))
            except PersonError as error:
                if not place.is_dir():
                    raise
                passed.append(error.message)
    if not clips:
        raise PersonError(f"none of {len(passed)} files can be used: {passed[0]}", "give recordings of a body")
    return CaptureMaterial(tuple(clips), tuple(passed))


def _motion_files(folder: Path) -> list[Path]:
    try:
        return sorted(one for one in folder.iterdir() if is_readable_name(one) and one.is_file())
    except OSError as error:
        raise PersonError(f"{folder} cannot be read: {error.strerror}", "--with DIR_OR_FILES") from None


def _descriptions(folder: Path) -> dict[Path, Recording]:
    """Descriptions of recordings in the folder's TOML files, by file; empty if they cannot be read."""
    try:
        found = read_step_files(folder)
    except PersonError:
        return {}
    entries = [entry for group in found.recordings.values() for entry in group]
    return {entry.path.resolve(): entry.recording for entry in reversed(entries)}


def _cached_recording(file: Path, known: Recording | None, fps: float | None, drop: int | None) -> StepClip:
    told = "" if known is None else known.model_dump_json()
    try:
        sources = [file.name.encode(), read_bytes(file), told.encode(), f"{fps} {drop}".encode()]
        sources.append(installed_formats().code)
        return CACHE.load_or_build(sources, lambda: [_build_recording(file, known, fps, drop)])[0]
    except ValueError as error:  # MotionFileError is one; the others are arguments out of range
        raise PersonError(" ".join(str(error).split()), "leave it out, or export it again") from None


def _build_recording(file: Path, known: Recording | None, fps: float | None, drop: int | None) -> StepClip:
    skeleton = None if known is None or known.skeleton is None else file.parent / known.skeleton
    up = None if known is None else known.up
    motion = read_motion(file, skeleton=skeleton, up=up)
    if known is not None:
        fps, drop = known.fps, known.drop_frames
    if drop is None:
        drop = find_recording_start(body_tracks(motion, fps=fps, up=up)).drop_frames
    if drop >= motion.frame_count:
        raise MotionFileError(str(file), None, f"drop_frames {drop} of {motion.frame_count} frames", "fewer expected")
    clip = retarget(motion, name=file.stem, fps=fps, up=up, drop_frames=drop)
    if known is None:  # described beats count from the first frame kept, so nothing may be removed then
        clip = trim_calibration_poses(clip)
    if clip.seconds < MIN_SECONDS:
        what = f"{clip.seconds:.2f} s are too short to find movements in"
        raise MotionFileError(str(file), None, what, f"{MIN_SECONDS:g} s expected, 10 s and more are useful")
    return _with_beats(file.stem, clip, known)


def _with_beats(name: str, clip: Clip, known: Recording | None) -> StepClip:
    if known is not None:
        bpm, first_s, beats = known.bpm, known.first_beat_s, known.beats_per_measure
    else:
        guess = estimate_tempo(clip)
        bpm, first_s = (120.0, 0.0) if guess is None else (guess.reference.bpm, guess.reference.first_beat_s)
        beats = 4
    first, measure = first_s * clip.sample_rate, beats * 60.0 / bpm * clip.sample_rate
    whole = int((clip.sample_count - 1 - first) / measure + 1e-9)
    if whole < 1 or (known is None and guess is None):
        return StepClip(name, clip, 0.0, clip.sample_count - 1.0, beats_per_measure=beats, bpm=bpm, tags=(NO_BEAT_TAG,))
    return StepClip(name, clip, first, measure, whole, beats, bpm)
