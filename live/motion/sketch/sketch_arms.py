"""The arms of a sketch: led by keys, or hanging with a counter-swing, always trailing the body a little."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.curve import followed, smoothed, through
from live.motion.sketch.motion_sketch_pose import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Ground,
    Pose,
    about,
    joint_index,
    offset_of,
    share_of,
    stride_of,
)
from live.motion.sketch.sketch_channels import SAMPLES_PER_BEAT, Channels
from live.motion.sketch.sketch_file import Sketch
from live.motion.two_bone_ik import bone_rotation, hinge_axis, two_bone

Float = npt.NDArray[np.floating]

_REST_HAND: Final = np.array((0.115, -0.44, 0.075))
"""Where a relaxed hand hangs from its shoulder: out, up, forward [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Hand:
    place: Float
    """Out, up, forward from the shoulder [m], (T, 3)."""
    elbow: Float
    wrist: Float
    keyed: Float
    """1 where the sketch leads the hand, 0 where it hangs, (T,)."""


def _hand(sketch: Sketch, part: str, beats: Float) -> _Hand:
    rows = []
    for key in sketch.parts.get(part, ()):
        a = key.amounts
        if "rest" in a:
            rows.append((key.beat, *_REST_HAND, 0.0, 0.0, 0.0, 0.0, 0.0))
            continue
        place = a.get("out", 0.0), a.get("up", 0.0), a.get("forward", 0.0)
        elbow = a.get("elbow out", 0.0), a.get("elbow up", 0.0), a.get("elbow forward", 0.0)
        rows.append((key.beat, *place, *elbow, a.get("wrist", 0.0), 1.0))
    rest = (*_REST_HAND, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not sketch.cyclic:
        rows = [(0.0, *rest), *rows, (float(sketch.beats), *rest)]
    if not rows:
        rows = [(0.0, *rest)]
    table = np.array(rows)
    times, values = table[:, 0], table[:, 1:]
    if sketch.cyclic:
        cycles = np.arange(math.floor(beats[0] / sketch.beats) - 2, math.ceil(beats[-1] / sketch.beats) + 3)
        times = (times[None] + cycles[:, None] * sketch.beats).ravel()
        values = np.tile(values, (len(cycles), 1))
    track = smoothed(through(times, values, beats), 0.06 * SAMPLES_PER_BEAT)
    return _Hand(track[:, :3], track[:, 3:6], track[:, 6], track[:, 7])


def pose_arm(sketch: Sketch, ground: Ground, pose: Pose, side: float, name: str) -> None:
    hand = _hand(sketch, f"{name}_hand", ground.beats)
    _, chest = pose.of("upperChest")
    swing = -side * 0.75 * np.tanh(followed(stride_of(ground), 0.55 * SAMPLES_PER_BEAT, 0.6) / 0.6) * (1.0 - hand.keyed)
    place = hand.place * (1.0 - 0.25 * np.maximum(swing, 0.0))[:, None]  # the elbow bends on the way forward
    place = quaternion.rotate(about(X_AXIS, -swing), place * (side, 1.0, 1.0))
    shoulder = Channels(sketch, f"{name}_shoulder", ground.beats)
    high = np.clip((place[:, 1] + 0.25) / 0.7, 0.0, 1.0)
    rise = np.arcsin(np.clip(shoulder["up"] / 0.135, -0.4, 0.7)) + math.radians(22.0) * high * high
    front = np.arcsin(np.clip(shoulder["forward"] / 0.135, -0.5, 0.6))
    clavicle = quaternion.mul(about(Y_AXIS, -side * front), about(Z_AXIS, side * rise))
    pose.attach(f"{name}Shoulder", quaternion.mul(chest, clavicle))
    root = pose.attach(f"{name}UpperArm", chest).copy()
    frame = quaternion.slerp(about(Y_AXIS, ground.facing), chest, np.full(len(chest), 0.6))
    hung = 0.5 * (followed(root, 0.4 * SAMPLES_PER_BEAT, 0.6) - root)
    target = root + hung + quaternion.rotate(frame, place)
    raised = np.clip((place[:, 1:2] + 0.15) / 0.5, 0.0, 1.0) ** 2
    pole = (1.0 - raised) * (0.6, -0.6, -0.5) + raised * (0.9, -0.35, -0.25) + hand.elbow / 0.3
    pole = quaternion.rotate(frame, pole * (side, 1.0, 1.0))
    upper, lower = float(abs(offset_of("leftLowerArm")[0])), float(abs(offset_of("leftHand")[0]))
    elbow, wrist = two_bone(root, target, pole, upper=upper, lower=lower)
    hinge = hinge_axis(root, target, pole)
    pose.rotation[:, joint_index(f"{name}UpperArm")] = bone_rotation(elbow - root, hinge, side * X_AXIS, side * Y_AXIS)
    forearm = bone_rotation(wrist - elbow, hinge, side * X_AXIS, side * Y_AXIS)
    pose.attach(f"{name}LowerArm", forearm)
    pose.attach(f"{name}Hand", _trailing(forearm, hand.wrist, side))


def _trailing(forearm: Float, wrist: Float, side: float) -> Float:
    """The hand's rotation (T, 4): the forearm's, bent by `wrist` [rad] and dragged behind quick movements."""
    along = quaternion.rotate(forearm, side * X_AXIS)
    late = quaternion.unit(followed(along, 0.35 * SAMPLES_PER_BEAT, 0.6))
    drag = share_of(quaternion.from_two_vectors(along, late), 0.6)
    return quaternion.mul(drag, quaternion.mul(forearm, about(Z_AXIS, side * wrist)))
