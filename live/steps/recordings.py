"""Recorded steps: a folder of BVH files and what its TOML files say about them, as step clips (`--steps DIR`)."""

import math
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.file_error import MotionFileError
from live.motion.mirror import mirror_step
from live.motion.retarget import retarget
from live.motion.source_motion import SourceMotion
from live.motion.step_clip import StepClip
from live.steps.motion_file import read_motion
from live.steps.recording_file import Recording, RecordingEntry, RecordingError, error_of, read_recordings

__all__ = ["RecordingError", "cut_step", "load_recordings"]

Float = npt.NDArray[np.floating]
Float32 = npt.NDArray[np.float32]

FRAMES_OFF: Final = 1
"""Programs that count frames wrongly are off by one; a file with fewer than that was cut off."""
TAIL_SAMPLES: Final = 8
"""Samples after the last measure, so that reading at its very end needs no special case."""
_Y: Final = np.array((0.0, 1.0, 0.0))
_Z: Final = np.array((0.0, 0.0, 1.0))


def load_recordings(directory: Path) -> list[StepClip]:
    """All steps that the TOML files of `directory` describe, in order, each followed by its mirror image if asked.

    Raises RecordingError with all problems found: file, line, field, what was read and what is allowed.
    """
    clips = _ClipReader()
    steps: list[StepClip] = []
    problems: list[str] = []
    for entry in read_recordings(directory):
        try:
            step = cut_step(entry, clips.read(entry))
        except RecordingError as error:
            if error.message not in problems:
                problems.append(error.message)
            continue
        steps.append(step)
        if entry.recording.mirror:
            steps.append(mirror_step(step))
    if problems:
        raise error_of(problems)
    return steps


class _ClipReader:
    """Reads every file once and retargets it once for each way in which steps ask for it."""

    def __init__(self) -> None:
        self._motions: dict[tuple[Path, object], SourceMotion] = {}
        self._clips: dict[tuple[object, ...], Clip] = {}

    def read(self, entry: RecordingEntry) -> Clip:
        recording = entry.recording
        path = entry.toml.parent / recording.file
        key = (path, recording.fps, recording.drop_frames, recording.unit_m, recording.up)
        if key not in self._clips:
            self._clips[key] = self._retarget(entry, self._motion(entry, path))
        return self._clips[key]

    def _motion(self, entry: RecordingEntry, path: Path) -> SourceMotion:
        key = (path, entry.recording.up)
        if key not in self._motions:
            try:
                motion = read_motion(path, up=entry.recording.up)
            except MotionFileError as error:
                raise RecordingError(entry.problem("file", str(error))) from None
            if motion.frame_count < motion.frames_declared - FRAMES_OFF:
                words = (
                    f"{path} is cut off: it says {motion.frames_declared} frames and holds {motion.frame_count}; "
                    "copy it again, or correct its line 'Frames:' if this is all"
                )
                raise RecordingError(entry.problem("file", words))
            self._motions[key] = motion
        return self._motions[key]

    @staticmethod
    def _retarget(entry: RecordingEntry, motion: SourceMotion) -> Clip:
        recording = entry.recording
        if recording.drop_frames >= motion.frame_count:
            words = f"{recording.drop_frames}, but the recording has {motion.frame_count} frames"
            raise RecordingError(entry.problem("drop_frames", words))
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
            raise RecordingError(entry.problem("file", str(error))) from None
        except ValueError as error:
            field = "unit_m" if recording.unit_m is not None else "file"
            raise RecordingError(entry.problem(field, str(error))) from None


def cut_step(entry: RecordingEntry, clip: Clip) -> StepClip:
    """The measures of one step, cut out of the whole recording's clip.

    A whole measure of lead-in comes before them (where the recording begins later, its first sample is held). At the
    first downbeat the hips stand at x = z = 0 and face +z, so that any step can follow any other. Beats fall where
    they fall between samples: `StepClip.first` is a fraction.
    """
    recording = entry.recording
    measure = recording.beats_per_measure * 60.0 / recording.bpm * clip.sample_rate
    start = recording.first_beat_s * clip.sample_rate + (recording.start_measure - 1) * measure
    end = start + recording.measures * measure
    if end > clip.sample_count - 1 + 1e-6:
        raise RecordingError(_too_long(entry, clip, measure))
    begin = math.floor(start) - math.ceil(measure)
    samples = np.clip(np.arange(begin, math.ceil(end) + TAIL_SAMPLES + 1), 0, clip.sample_count - 1)
    root, rotation = _placed(clip, samples, start)
    name = f"{recording.name}, {clip.name} from measure {recording.start_measure}"
    return StepClip(
        step=recording.name,
        clip=Clip(name, root, rotation, clip.sample_rate, clip.contact[samples]),
        first=start - begin,
        samples_per_measure=measure,
        measures=recording.measures,
        beats_per_measure=recording.beats_per_measure,
        bpm=recording.bpm,
        direction=recording.direction or "",
    )


def _too_long(entry: RecordingEntry, clip: Clip, measure: float) -> str:
    recording: Recording = entry.recording
    whole = max(0, math.floor((clip.sample_count - 1 - recording.first_beat_s * clip.sample_rate) / measure + 1e-9))
    last = recording.start_measure + recording.measures - 1
    field = "first_beat_s" if whole == 0 else "measures" if recording.start_measure <= whole else "start_measure"
    return entry.problem(
        field,
        f"the step ends with measure {last}, but {recording.file} has {whole} whole measures of "
        f"{recording.beats_per_measure} beats at {recording.bpm:g} bpm after {recording.first_beat_s:g} s "
        f"(it lasts {clip.seconds:.2f} s)",
    )


def _placed(clip: Clip, samples: npt.NDArray[np.int64], at: float) -> tuple[Float32, Float32]:
    """Root and rotations of `samples`, moved and turned about y so that the sample `at` stands at 0 facing +z."""
    before = min(int(at), clip.sample_count - 2) if clip.sample_count > 1 else 0
    after, part = min(before + 1, clip.sample_count - 1), at - before
    hips = clip.root_position[before] * (1.0 - part) + clip.root_position[after] * part
    turned = quaternion.slerp(clip.rotation[before, 0], clip.rotation[after, 0], np.asarray(part))
    turn = quaternion.from_axis_angle(_Y, np.asarray(-_heading(turned)))
    root = quaternion.rotate(turn, clip.root_position[samples] - hips * (1.0, 0.0, 1.0))
    rotation = clip.rotation[samples].astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    return np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32)


def _heading(hips: Float) -> float:
    """Heading [rad] of the hips' forward axis, 0 towards +z, positive towards +x; of their left if that is upright."""
    x, _, z = quaternion.rotate(hips, _Z)
    if math.hypot(x, z) < 0.2:
        left_x, _, left_z = quaternion.rotate(hips, np.array((1.0, 0.0, 0.0)))
        return math.atan2(-left_z, left_x)
    return math.atan2(x, z)
