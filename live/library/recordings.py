"""Recorded steps as step clips: recordings are read, retargeted and cut at the measure lines (T019, T039, T040).

A stream is a recording that is not divided into steps (T037, T038, T120). Each of its measures is a clip of one step
named after the stream, joined by similarity alone. Consecutive measures join without a seam, because the lead-in of
each is the measure before it.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

from live.library.cut_step import cut_step
from live.library.disk_cache import ClipCache
from live.library.motion_file import MAX_BYTES, read_motion
from live.library.motion_formats import companion_suffix, installed_formats
from live.library.recording_file import (
    Problem,
    Recording,
    RecordingEntry,
    RecordingError,
    StepFiles,
    combine_problems,
)
from live.motion.cleanup.calibration_poses import danced_part
from live.motion.cleanup.foot_planting import PlantedClip, plant_feet
from live.motion.cleanup.glitch_detection import Glitch, find_glitches
from live.motion.cleanup.glitch_repair import repair
from live.motion.clip import Clip
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from live.motion.mirror import mirror_step
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget
from live.motion.step_clip import StepClip

FRAME_COUNT_TOLERANCE: Final = 1
"""Tolerance for the frame count in a header, which some programs get wrong by one; with fewer the file is cut off."""


class RecordingReader:
    """Reads every file once, and retargets it once for each combination of reading options."""

    def __init__(self) -> None:
        self._motions: dict[tuple[object, ...], SourceMotion] = {}
        self._clips: dict[tuple[object, ...], Clip] = {}
        self._glitches: dict[tuple[object, ...], list[Glitch]] = {}
        self._feet: dict[tuple[object, ...], PlantedClip] = {}

    def clip(self, entry: RecordingEntry) -> Clip:
        """Return the whole recording on the engine's skeleton; RecordingError names file, line and field."""
        key = _reading_key(entry)
        if key not in self._clips:
            motion = self.motion(entry)
            if entry.recording.repair:
                _check_frames(entry, motion)
                motion, _ = repair(motion, self._faults(entry, motion), fps=entry.recording.fps)
            clip = _retarget(entry, motion)
            if entry.recording.plant_feet:
                planted = plant_feet(clip)
                clip, self._feet[key] = planted.clip, planted
            self._clips[key] = clip
        return self._clips[key]

    def feet(self, entry: RecordingEntry) -> PlantedClip | None:
        """Return the recording with planted feet, and its faults before and after; None if they are left alone."""
        self.clip(entry)
        return self._feet.get(_reading_key(entry))

    def glitches(self, entry: RecordingEntry) -> list[Glitch]:
        """Return tracking faults, after the repair if requested; frames count from the file's first."""
        motion = self.motion(entry)
        faults = self._faults(entry, motion)
        if not entry.recording.repair:
            return faults
        _, repairs = repair(motion, faults, fps=entry.recording.fps)
        return [one.glitch for one in repairs if not one.done]

    def _faults(self, entry: RecordingEntry, motion: SourceMotion) -> list[Glitch]:
        key = _reading_key(entry)
        if key not in self._glitches:
            recording = entry.recording
            try:
                tracks = body_tracks(motion, fps=recording.fps, up=recording.up, unit_m=recording.unit_m)
            except MotionFileError as error:
                raise entry.error("file", str(error)) from None
            self._glitches[key] = find_glitches(tracks, motion.parents, recording.drop_frames)
        return self._glitches[key]

    def motion(self, entry: RecordingEntry) -> SourceMotion:
        """Return the motion of the file; RecordingError names file, line and field."""
        key = (entry.path, entry.skeleton, entry.recording.up)
        if key not in self._motions:
            try:
                motion = read_motion(entry.path, skeleton=entry.skeleton, up=entry.recording.up)
            except MotionFileError as error:
                raise entry.error("file", str(error)) from None
            except ValueError as error:  # invalid file names
                raise entry.error("file", f"cannot be read: {error}") from None
            if motion.frame_count < motion.frames_declared - FRAME_COUNT_TOLERANCE:
                words = (
                    f"{entry.path} is cut off: it declares {motion.frames_declared} frames and has "
                    f"{motion.frame_count}; copy it again, or correct its line 'Frames:' if this is all"
                )
                raise entry.error("file", words)
            self._motions[key] = motion
        return self._motions[key]


def _reading_key(entry: RecordingEntry) -> tuple[object, ...]:
    recording = entry.recording
    read = (recording.fps, recording.drop_frames, recording.unit_m, recording.up)
    return (entry.path, entry.skeleton, *read, recording.repair, recording.plant_feet)


def _check_frames(entry: RecordingEntry, motion: SourceMotion) -> None:
    if entry.recording.drop_frames >= motion.frame_count:
        words = f"{entry.recording.drop_frames}, but the recording has {motion.frame_count} frames"
        raise entry.error("drop_frames", words)


def _retarget(entry: RecordingEntry, motion: SourceMotion) -> Clip:
    recording = entry.recording
    _check_frames(entry, motion)
    try:
        return retarget(
            motion,
            name=Path(recording.file).stem,
            fps=recording.fps,
            unit_m=recording.unit_m,
            up=recording.up,
            drop_frames=recording.drop_frames,
        )
    except MotionFileError as error:
        raise entry.error("file", str(error)) from None
    except ValueError as error:
        raise entry.error("unit_m" if recording.unit_m is not None else "file", str(error)) from None


STEP_ONLY_FIELDS: Final = ("leading_foot", "begin_pose", "end_pose", "weight_transfer", "direction", "distance_m")
"""Fields of a step that do not apply to a stream."""


def cut_recording(entry: RecordingEntry, clip: Clip) -> list[StepClip]:
    """Return all clips of an entry: its step, or the measures of its stream; each followed by its mirror image if set.

    RecordingError names file, line and field.
    """
    own = cut_stream(entry, clip) if entry.recording.unstructured else [cut_step(entry, clip)]
    if not entry.recording.mirror:
        return own
    return [both for step in own for both in (step, mirror_step(step))]


def cut_stream(entry: RecordingEntry, clip: Clip) -> list[StepClip]:
    """Return the measures of a stream from `start_measure` on: the number in `measures`, else all whole ones.

    A first measure with less than a beat recorded before it is left out if others follow, and so are measures at
    both ends with a T-pose in them.
    """
    recording = entry.recording
    for field in STEP_ONLY_FIELDS:
        if field in recording.model_fields_set:
            raise entry.error(field, "it belongs to a step, and an unstructured recording has none: leave it out")
    count = recording.measures if "measures" in recording.model_fields_set else _whole_measures(entry, clip)
    cut_step(
        _with_measures(entry, recording.start_measure, count), clip
    )  # raises the error for a stream that is too long as a whole
    first, last = _danced_measures(recording, count, clip)
    return [
        replace(cut_step(_with_measures(entry, recording.start_measure + n, 1), clip), in_stream=True)
        for n in range(first, last)
    ]


def _danced_measures(recording: Recording, count: int, clip: Clip) -> tuple[int, int]:
    """Return the first of `count` measures with a beat recorded before it and no T-pose in it, and the last and one.

    A measure without a beat before it would start from a standstill in every blend into it. All are returned if
    these are none.
    """
    beat, measure = 60.0 / recording.bpm, recording.beats_per_measure * 60.0 / recording.bpm
    begins = recording.first_beat_s + (recording.start_measure - 1) * measure
    posed, ends = (sample / clip.sample_rate for sample in danced_part(clip))
    first = max(0, math.ceil((max(beat, posed) - begins) / measure - 1e-6))
    last = min(count, math.floor((ends - begins) / measure + 1e-6))
    return (first, last) if first < last else (0, count)


def _whole_measures(entry: RecordingEntry, clip: Clip) -> int:
    """Number of whole measures from the first one on, at least 1, so that cutting reports a short recording."""
    recording = entry.recording
    measure = recording.beats_per_measure * 60.0 / recording.bpm * clip.sample_rate
    start = recording.first_beat_s * clip.sample_rate + (recording.start_measure - 1) * measure
    return max(1, math.floor((clip.sample_count - 1 - start) / measure + 1e-9))


def _with_measures(entry: RecordingEntry, start: int, measures: int) -> RecordingEntry:
    return replace(entry, recording=entry.recording.model_copy(update={"start_measure": start, "measures": measures}))


CACHE: Final = ClipCache("recordings", max_entries=1000)
"""One entry for each TOML file, so that a change in one leaves the others valid."""


def recorded_steps(files: StepFiles) -> list[StepClip]:
    """Return the same for files that were already read; unchanged steps come from a cache."""
    problems = list(files.problems)
    steps: list[StepClip] = []
    for toml, entries in files.recordings.items():
        try:
            steps += _cached_steps(files.texts[toml], entries)
        except RecordingError as error:
            problems += error.problems
    if problems:
        raise combine_problems(problems)
    return steps


def _cached_steps(text: str, entries: list[RecordingEntry]) -> list[StepClip]:
    """The steps of one TOML file, from the cache if possible."""
    sources = _sources(text, entries)
    if sources is not None:
        try:
            return CACHE.load_or_build(sources, partial(_build_steps, entries))
        except OSError:  # a file cannot be read: building the steps reports which, and why
            pass
    return _build_steps(entries)


def _sources(text: str, entries: list[RecordingEntry]) -> Iterator[bytes] | None:
    """All that the steps of one TOML file depend on; None if a file is missing, which building them reports."""
    paths: set[Path] = set()
    for entry in entries:
        paths.add(entry.path)
        if entry.skeleton is not None:
            paths.add(entry.skeleton)
        companion = companion_suffix(entry.path)
        if companion is not None:
            paths.update(path for path in entry.path.parent.iterdir() if path.suffix.lower() == companion)
    try:
        if not all(path.is_file() and path.stat().st_size <= MAX_BYTES for path in paths):
            return None
        return _file_contents(text, sorted(paths))
    except (OSError, ValueError):
        return None


def _file_contents(text: str, paths: list[Path]) -> Iterator[bytes]:
    yield text.encode()
    yield installed_formats().code
    for path in paths:
        yield path.read_bytes()


def _build_steps(entries: list[RecordingEntry]) -> list[StepClip]:
    reader = RecordingReader()
    steps: list[StepClip] = []
    problems: list[Problem] = []
    for entry in entries:
        try:
            steps += cut_recording(entry, reader.clip(entry))
        except RecordingError as error:
            problems += error.problems
    if problems:
        raise combine_problems(problems)
    return steps
