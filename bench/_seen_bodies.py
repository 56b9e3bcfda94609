"""Steps danced by other bodies and seen by a camera: other proportions, tempo, size and timing, jitter, lost frames."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.clip import read_clip
from live.motion.forward_kinematics import local_rotations
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

FPS: Final = 30.0
JITTER_M: Final = 0.04
"""Root mean square of the error of a joint in space [m]."""
LOST: Final = 0.1
"""Share of single frames that are lost."""
GAP_S: Final = 0.25
"""In a third of the measures so long a gap, too [s]."""
_Y: Final = np.array((0.0, 1.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class SeenMeasure:
    """What a camera saw of one measure and a little before and after, on the engine's skeleton."""

    hips: Float64
    """(T, 3) [m]"""
    rotation: Float64
    """(T, J, 4)"""
    beats: Float64
    """Beats from the measure line, (T,)."""


def danced_by_another(step: StepClip, measure: int, bpm: float, chance: np.random.Generator, *, mirror: bool = False,
    jitter: float = JITTER_M) -> SeenMeasure:  # fmt: skip
    """Return a measure of a step at `bpm`, danced by a body drawn by `chance`.

    Legs, arms and trunk are 12 % longer or shorter, motion about the mean pose 15 % larger or smaller, the timing up to
    0.12 beats early or late and uneven within the measure; the stage and the heading are turned at random.
    """
    beats = step.beats_per_measure
    seconds = beats * 60.0 / bpm
    times = np.arange(-0.25, seconds + 0.3, 1.0 / FPS) + chance.uniform(0.0, 1.0 / FPS)
    at = times * bpm / 60.0
    late = chance.uniform(-0.12, 0.12) + 0.06 * np.sin(2.0 * np.pi * (at / beats + chance.uniform()))
    samples = step.first + (measure + (at - late) / beats) * step.samples_per_measure
    root, rotation, _ = read_clip(step.clip, samples)
    mean = quaternion.mean_rotation(rotation[:, 1:])
    rotation[:, 1:] = quaternion.scale_about_mean(mean, rotation[:, 1:], chance.uniform(0.85, 1.15))
    turn = quaternion.from_axis_angle(_Y, np.asarray(chance.uniform(-np.pi, np.pi)))
    root = (
        quaternion.rotate(turn, root * chance.uniform(0.9, 1.1)) + np.array((*chance.uniform(-2, 2, 2), 0.0))[[0, 2, 1]]
    )
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    points = _other_body(root, rotation, chance)
    if mirror:
        points = points[:, _MIRROR] * (-1.0, 1.0, 1.0)
    points += jitter / np.sqrt(3.0) * chance.standard_normal(points.shape)
    kept = chance.random(len(times)) >= LOST
    if chance.random() < 1.0 / 3.0:
        begin = chance.uniform(0.0, max(seconds - GAP_S, 0.0))
        kept &= (times < begin) | (times > begin + GAP_S)
    hips, turned = engine_pose(points[kept])
    return SeenMeasure(hips, turned, at[kept])


def _other_body(root: Float, rotation: Float, chance: np.random.Generator) -> Float64:
    """Return joints (T, J, 3) of a body with other proportions in these poses."""
    legs, arms, trunk = chance.uniform(0.88, 1.12, 3)
    names = SKELETON.names
    scale = [
        legs if "Leg" in n or "Foot" in n or "Toes" in n else arms if "Arm" in n or "Hand" in n else trunk
        for n in names
    ]
    offsets = SKELETON.offsets.astype(np.float64) * np.array(scale)[:, None]
    position, _ = quaternion.chain(SKELETON.parents, [root * (1.0, legs, 1.0), *offsets[1:]], rotation)
    return np.asarray(position)


def _mirror_rows() -> list[int]:
    swapped = {"left": "right", "right": "left"}
    rows = []
    for name in SKELETON.names:
        side = next((one for one in swapped if name.startswith(one)), None)
        rows.append(SKELETON.index(name if side is None else swapped[side] + name.removeprefix(side)))
    return rows


_MIRROR: Final = _mirror_rows()


def engine_pose(points: Float64) -> tuple[Float64, Float64]:
    """Return hips (T, 3) and rotations (T, J, 4) of the engine's skeleton that point as the joints (T, J, 3) do.

    Bones have the engine's lengths; twists about bones that joints do not tell are the least.
    """

    def joint(name: str) -> Float64:
        return np.asarray(points[:, SKELETON.index(name)])

    def frame(across: Float64, up: Float64) -> Float64:
        x = quaternion.unit(across)
        z = quaternion.unit(np.cross(x, up))
        return np.asarray(quaternion.from_columns(x, np.cross(z, x), z))

    world = np.zeros((len(points), SKELETON.joint_count, 4))
    world[:, 0] = frame(joint("leftUpperLeg") - joint("rightUpperLeg"), joint("spine") - joint("hips"))
    chest = frame(joint("leftUpperArm") - joint("rightUpperArm"), joint("neck") - joint("spine"))
    for child_of, name in enumerate(SKELETON.names):
        if child_of == 0:
            continue
        parent = world[:, SKELETON.parents[child_of]]
        children = np.flatnonzero(SKELETON.parents == child_of)
        if name in ("spine", "chest", "upperChest"):
            world[:, child_of] = chest
        elif len(children) == 1:
            child = int(children[0])
            aim = quaternion.unit(points[:, child] - points[:, child_of])
            rest = quaternion.rotate(parent, np.broadcast_to(SKELETON.offsets[child], aim.shape).astype(np.float64))
            world[:, child_of] = quaternion.mul(quaternion.from_two_vectors(quaternion.unit(rest), aim), parent)
        else:
            world[:, child_of] = parent
    return points[:, 0], np.asarray(local_rotations(world))
