"""Recordings from disk as clips on the engine's skeleton, each file read once for all its steps."""

from pathlib import Path
from typing import Final

from live.library.motion_file import read_motion
from live.library.recording import RecordingEntry
from live.motion.cleanup.glitch_repair import repair
from live.motion.cleanup.glitches import Glitch, find_glitches
from live.motion.clip import Clip
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget

FRAMES_OFF: Final = 1
"""Programs that count frames wrongly are off by one; a file with fewer than that was cut off."""


class RecordingReader:
    """Reads every file once and retargets it once for each way in which steps ask for it."""

    def __init__(self) -> None:
        self._motions: dict[tuple[object, ...], SourceMotion] = {}
        self._clips: dict[tuple[object, ...], Clip] = {}
        self._glitches: dict[tuple[object, ...], list[Glitch]] = {}

    def clip(self, entry: RecordingEntry) -> Clip:
        """The whole recording on the engine's skeleton; RecordingError that names file, line and field."""
        key = _key(entry)
        if key not in self._clips:
            motion = self.motion(entry)
            if entry.recording.repair:
                _check_frames(entry, motion)
                motion, _ = repair(motion, self._faults(entry, motion), fps=entry.recording.fps)
            self._clips[key] = _retarget(entry, motion)
        return self._clips[key]

    def glitches(self, entry: RecordingEntry) -> list[Glitch]:
        """Tracking faults that remain after a repair, if one is asked for; frames count from the file's first."""
        motion = self.motion(entry)
        faults = self._faults(entry, motion)
        if not entry.recording.repair:
            return faults
        _, repairs = repair(motion, faults, fps=entry.recording.fps)
        return [one.glitch for one in repairs if not one.done]

    def _faults(self, entry: RecordingEntry, motion: SourceMotion) -> list[Glitch]:
        key = _key(entry)
        if key not in self._glitches:
            recording = entry.recording
            try:
                tracks = body_tracks(motion, fps=recording.fps, up=recording.up, unit_m=recording.unit_m)
            except MotionFileError as error:
                raise entry.error("file", str(error)) from None
            self._glitches[key] = find_glitches(tracks, motion.parents, recording.drop_frames)
        return self._glitches[key]

    def motion(self, entry: RecordingEntry) -> SourceMotion:
        """What the file holds; RecordingError that names file, line and field."""
        key = (entry.path, entry.skeleton, entry.recording.up)
        if key not in self._motions:
            try:
                motion = read_motion(entry.path, skeleton=entry.skeleton, up=entry.recording.up)
            except MotionFileError as error:
                raise entry.error("file", str(error)) from None
            except ValueError as error:  # names that no file can have
                raise entry.error("file", f"cannot be read: {error}") from None
            if motion.frame_count < motion.frames_declared - FRAMES_OFF:
                words = (
                    f"{entry.path} is cut off: it says {motion.frames_declared} frames and holds {motion.frame_count}; "
                    "copy it again, or correct its line 'Frames:' if this is all"
                )
                raise entry.error("file", words)
            self._motions[key] = motion
        return self._motions[key]


def _key(entry: RecordingEntry) -> tuple[object, ...]:
    recording = entry.recording
    read = (recording.fps, recording.drop_frames, recording.unit_m, recording.up, recording.repair)
    return (entry.path, entry.skeleton, *read)


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
