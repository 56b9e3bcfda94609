"""Cutting of a step out of a recording: whole measures, a measure of lead-in, and its attributes (T039, T040)."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float32
from live.library.recording_file import RecordingEntry, RecordingError
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.sketch.sketch_attributes import hand_shapes, mood_values
from live.motion.step_clip import StepClip, measured_direction, measured_distance

TAIL_SAMPLES: Final = 8
"""Samples after the last measure, so that sampling at its very end needs no special case."""
_Y: Final = np.array((0.0, 1.0, 0.0))
_Z: Final = np.array((0.0, 0.0, 1.0))


def cut_step(entry: RecordingEntry, clip: Clip) -> StepClip:
    """Cut the measures of one step out of the whole recording's clip.

    A measure of lead-in precedes them (if the recording begins later, its first sample is held). At the first
    downbeat the hips stand at x = z = 0 and face +z, so that any step can follow any other. Beats may fall between
    samples: `StepClip.first` is fractional.
    """
    recording = entry.recording
    measure = recording.beats_per_measure * 60.0 / recording.bpm * clip.sample_rate
    start = recording.first_beat_s * clip.sample_rate + (recording.start_measure - 1) * measure
    end = start + recording.measures * measure
    if end > clip.sample_count - 1 + 1e-6:
        raise _length_error(entry, clip, measure)
    begin = math.floor(start) - math.ceil(measure)
    samples = np.clip(np.arange(begin, math.ceil(end) + TAIL_SAMPLES + 1), 0, clip.sample_count - 1)
    root, rotation = _align_to_origin(clip, samples, start)
    name = f"{recording.name}, {clip.name} from measure {recording.start_measure}"
    step = StepClip(
        step=recording.name,
        clip=Clip(name, root, rotation, clip.sample_rate, clip.contact[samples]),
        first=start - begin,
        samples_per_measure=measure,
        measures=recording.measures,
        beats_per_measure=recording.beats_per_measure,
        bpm=recording.bpm,
        leading_foot=recording.leading_foot or "",
        begin_pose=recording.begin_pose or "",
        end_pose=recording.end_pose or "",
        weight_transfer=bool(recording.weight_transfer),
        author=recording.author or "",
        style=recording.style or "",
        tags=tuple(recording.tags),
        mood=mood_values(recording.mood),
        hands=hand_shapes(recording.hand_shape),
        recorded=True,
    )
    return replace(
        step,
        direction=recording.direction or measured_direction(step),
        distance_m=measured_distance(step) if recording.distance_m is None else recording.distance_m,
    )


def _length_error(entry: RecordingEntry, clip: Clip, measure: float) -> RecordingError:
    recording = entry.recording
    whole = max(0, math.floor((clip.sample_count - 1 - recording.first_beat_s * clip.sample_rate) / measure + 1e-9))
    last = recording.start_measure + recording.measures - 1
    field = "first_beat_s" if whole == 0 else "measures" if recording.start_measure <= whole else "start_measure"
    return entry.error(
        field,
        f"the step ends with measure {last}, but {recording.file} has {whole} whole measures of "
        f"{recording.beats_per_measure} beats at {recording.bpm:g} bpm after {recording.first_beat_s:g} s "
        f"(it lasts {clip.seconds:.2f} s)",
    )


def _align_to_origin(clip: Clip, samples: npt.NDArray[np.int64], at: float) -> tuple[Float32, Float32]:
    """Root and rotations of `samples`, moved and turned about y so that the sample `at` is at the origin facing +z."""
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
    """Heading [rad] of the hips' forward axis, 0 towards +z, positive towards +x; from their left axis if upright."""
    x, _, z = quaternion.rotate(hips, _Z)
    if math.hypot(x, z) < 0.2:
        left_x, _, left_z = quaternion.rotate(hips, np.array((1.0, 0.0, 0.0)))
        return math.atan2(-left_z, left_x)
    return math.atan2(x, z)
