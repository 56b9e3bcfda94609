"""A bridge as a step clip, ready to be inserted into the graph (T141)."""

import math
from dataclasses import replace

import numpy as np

from live.graph.build.bridge import Bridge
from live.graph.step_library import StepLibrary
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.step_clip import StepClip
from live.motion.step_figures import measured_direction, measured_distance


def bridge_clip(library: StepLibrary, recording: Clip, bridge: Bridge, *, measures: int = 1) -> StepClip:
    """The stretch of `recording` that `bridge` names, as a step called "A to B", with up to a measure of lead-in.

    It begins in the pose in which the first step ends and ends in that in which the second begins, where those have
    names (T136). At its beginning the hips stand at x = z = 0 and face +z.
    """
    before, after = (library.clips[library.node_clip[node]] for node in (bridge.source, bridge.target))
    rate = recording.sample_rate
    size = (bridge.stop - bridge.start) * rate / measures
    start = bridge.start * rate
    begin = max(0, math.floor(start - size))
    end = min(recording.sample_count, math.ceil(bridge.stop * rate) + 9)
    name = f"{before.step} to {after.step}"
    step = StepClip(
        step=name,
        clip=_placed(recording, begin, end, round(start), f"{name}, {recording.name} from {bridge.start:.2f} s"),
        first=start - begin,
        samples_per_measure=size,
        measures=measures,
        beats_per_measure=library.beats_per_measure,
        bpm=60.0 * library.beats_per_measure * rate / size,
        begin_pose=before.end_pose,
        end_pose=after.begin_pose,
        tags=("bridge",),
    )
    return replace(step, direction=measured_direction(step), distance_m=measured_distance(step))


def _placed(clip: Clip, begin: int, end: int, at: int, name: str) -> Clip:
    """Samples `begin` to `end` (exclusive), moved and turned so that at sample `at` the hips stand at 0 and face +z."""
    x, _, z = quaternion.rotate(clip.rotation[at, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(-math.atan2(x, z)))
    rotation = clip.rotation[begin:end].astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    root = quaternion.rotate(turn, clip.root_position[begin:end] - clip.root_position[at] * (1.0, 0.0, 1.0))
    return Clip(
        name,
        np.ascontiguousarray(root, np.float32),
        np.ascontiguousarray(rotation, np.float32),
        clip.sample_rate,
        clip.contact[begin:end],
    )
