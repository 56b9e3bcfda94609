"""Rotations of the engine's joints that let its bones point where those of a recorded body do."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.retarget.rest_pose_alignment import (
    LIMB_BONES,
    SIDES,
    SourcePoints,
    engine_direction,
    hinge_twist,
    plainness,
    reference_rotations,
    standing_frame,
)
from live.motion.retarget.trunk import neck_rotation, spine_rotations
from live.motion.skeleton import SKELETON

Float = npt.NDArray[np.floating]

TWISTED: Final = np.radians(60.0)
"""A limb that bends this far beside our hinge axis has a rest pose whose twist means nothing."""


def world_rotations(points: SourcePoints, rest: SourcePoints) -> Float:
    """World rotations of the engine's joints, shape (T, 22, 4)."""
    frame = standing_frame(rest, rest=True)
    from_rest = bool(plainness(rest, frame)[1][0])
    reference, at = rest, 0
    if not from_rest:
        reference, frame = points, standing_frame(points, rest=False)
        cost, usable = plainness(points, frame)
        at = int(np.argmin(np.where(usable, cost, cost + 100.0)))
    wanted = reference_rotations(reference, frame, at)

    def aligned(joint: str, source: int) -> Float:
        alignment = quaternion.mul(quaternion.inverse(reference.rotations[at, source]), wanted[joint])
        return quaternion.mul(points.rotations[:, source], alignment)

    body = points.body
    world = {name: aligned(name, source) for name, source in body.joints.items() if source is not None}
    hips = world["hips"]
    chain = [aligned("chest", source) for source in body.spine]
    world |= spine_rotations(rest, hips, chain)
    head = world.get("head", world["upperChest"])
    world["neck"] = neck_rotation([aligned("neck", source) for source in body.neck], world["upperChest"], head)
    world["head"] = head
    for joint, child in LIMB_BONES:
        world[joint] = _bent_like_ours(points, world[joint], joint, TWISTED if from_rest else 0.0)
        world[joint] = _exact(world[joint], points, joint, child)
    for side, _ in SIDES:
        world.setdefault(side + "Shoulder", world["upperChest"])
        world.setdefault(side + "Hand", world[side + "LowerArm"])
        world.setdefault(side + "Toes", world[side + "Foot"])
    return np.stack([world[name] for name in SKELETON.names], axis=1)


def _exact(rotation: Float, points: SourcePoints, joint: str, child: str) -> Float:
    """Turned by the little that is left, so that the bone points where the source's does (twist bones, drift)."""
    pointing = quaternion.rotate(rotation, engine_direction(child))
    target = points.at(child) - points.at(joint)
    target = np.where(np.linalg.norm(target, axis=-1, keepdims=True) > 1e-9, target, pointing)
    return quaternion.mul(quaternion.from_two_vectors(pointing, target), rotation)


def _bent_like_ours(points: SourcePoints, rotation: Float, joint: str, tolerance: float) -> Float:
    """Turned about the bone so that knee or elbow bend about our hinge axis, if they are off by over `tolerance`."""
    side = "left" if joint.startswith("left") else "right"
    limb = ("UpperArm", "LowerArm", "Hand") if joint.endswith("Arm") else ("UpperLeg", "LowerLeg", "Foot")
    upper, lower = (points.bone(side + limb[n], side + limb[n + 1]) for n in (0, 1))
    bone = engine_direction(side + limb[1])
    bends_to = np.array((0.0, 0.0, 1.0 if joint.endswith("Arm") else -1.0))
    angle = hinge_twist(upper, lower, rotation, bone, np.cross(bone, bends_to))
    if abs(angle) <= tolerance:
        return rotation
    return quaternion.mul(rotation, quaternion.from_axis_angle(bone, np.asarray(angle)))


def local_rotations(world: Float) -> Float:
    """Each joint's rotation from its parent's, of `world` ones, both (T, 22, 4)."""
    local = world.copy()
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            local[:, joint] = quaternion.mul(quaternion.inverse(world[:, parent]), world[:, joint])
    return quaternion.unit(local)
