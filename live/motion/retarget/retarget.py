"""Retargeting of a recording to the engine's skeleton: bones keep their directions, feet their places on the floor.

Trunk and neck chains of any length are distributed over the engine's three spine joints and one neck joint.
"""

from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE, find_contacts
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import BODY_HEIGHT_RANGE, ENGINE_LEG, body_height, leg_length, standing_pose
from live.motion.formats.source_motion import LocalPose, SourceMotion, UpAxis, world_pose
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.retarget.body_tracks import rest_points, source_points
from live.motion.retarget.floor_contact import find_floor, place_hips
from live.motion.retarget.joint_mapping import find_body
from live.motion.retarget.rest_pose_alignment import (
    LIMB_BONES,
    SIDES,
    SourcePoints,
    engine_direction,
    hinge_twist,
    reference_rotations,
    standing_cost,
    standing_frame,
)
from live.motion.retarget.source_body import SourceBody
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

SPINE: Final = ("spine", "chest", "upperChest")


def _engine_spine_fractions() -> list[float]:
    """Return the midpoints of the segments above spine, chest and upperChest, from 0 (hips) to 1 (neck)."""
    chain = [SKELETON.index(name) for name in (*SPINE, "neck")]
    heights = np.cumsum([np.linalg.norm(SKELETON.offsets[joint]) for joint in chain])
    return [float(0.5 * (heights[n] + heights[n + 1]) / heights[-1]) for n in range(len(SPINE))]


SPINE_FRACTIONS: Final = _engine_spine_fractions()


def source_spine_fractions(rest: SourcePoints) -> Float:
    """Return the midpoints of the source's segments above the hips and each spine joint, from 0 (hips) to 1 (arms).

    Lengths are measured along the chain in the rest pose. The last segment ends at the neck, or at the line between the
    shoulder joints if the neck has the same position.
    """
    body = rest.body
    chain = [rest.at("hips")[0], *(rest.positions[0, joint] for joint in body.spine)]
    top = rest.positions[0, body.neck[0]] if body.neck else rest.middle("UpperArm")[0]
    lengths = [float(np.linalg.norm(b - a)) for a, b in zip(chain, [*chain[1:], top], strict=True)]
    ends = np.cumsum(lengths)
    middles = ends - 0.5 * np.array(lengths)
    return np.asarray(middles / max(float(ends[-1]), 1e-9))


def spine_rotations(rest: SourcePoints, hips: Float, chain: list[Float]) -> dict[str, Float]:
    """Return world rotations of spine, chest and upperChest, (T, 4) each, from the aligned rotations of hips and chain.

    Each engine joint gets the source trunk's rotation at the same relative height: SLERP between the two nearest.
    """
    known = [hips, *chain]
    places = source_spine_fractions(rest)
    rotations = {}
    for name, place in zip(SPINE, SPINE_FRACTIONS, strict=True):
        above = int(np.searchsorted(places, place))
        if above == 0 or above == len(known):
            rotations[name] = known[min(above, len(known) - 1)]
        else:
            gap = places[above] - places[above - 1]
            part = (place - places[above - 1]) / gap if gap > 1e-9 else 1.0
            rotations[name] = quaternion.slerp(known[above - 1], known[above], np.asarray(part))
    return rotations


def neck_rotation(chain: list[Float], chest: Float, head: Float) -> Float:
    """Return the neck's world rotation, (T, 4): the middle of the chain, or half way from chest to head."""
    if not chain:
        return quaternion.slerp(chest, head, np.asarray(0.5))
    low, high = chain[(len(chain) - 1) // 2], chain[len(chain) // 2]
    return low if low is high else quaternion.slerp(low, high, np.asarray(0.5))


TWIST_TOLERANCE: Final = np.radians(60.0)
"""If a limb's bend axis is this far off the engine's hinge axis, the twist of its rest pose is ignored."""


def world_rotations(points: SourcePoints, rest: SourcePoints) -> Float:
    """Return world rotations of the engine's joints, shape (T, 22, 4)."""
    frame = standing_frame(rest, rest=True)
    from_rest = bool(standing_cost(rest, frame)[1][0])
    reference, at = rest, 0
    if not from_rest:
        reference, frame = points, standing_frame(points, rest=False)
        cost, usable = standing_cost(points, frame)
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
        world[joint] = _align_hinge(points, world[joint], joint, TWIST_TOLERANCE if from_rest else 0.0)
        world[joint] = _align_exactly(world[joint], points, joint, child)
    for side, _ in SIDES:
        world.setdefault(side + "Shoulder", world["upperChest"])
        world.setdefault(side + "Hand", world[side + "LowerArm"])
        world.setdefault(side + "Toes", world[side + "Foot"])
    return np.stack([world[name] for name in SKELETON.names], axis=1)


def _align_exactly(rotation: Float, points: SourcePoints, joint: str, child: str) -> Float:
    """Apply the remaining rotation that makes the bone point exactly where the source's does (twist bones, drift)."""
    pointing = quaternion.rotate(rotation, engine_direction(child))
    target = points.at(child) - points.at(joint)
    target = np.where(np.linalg.norm(target, axis=-1, keepdims=True) > 1e-9, target, pointing)
    return quaternion.mul(quaternion.from_two_vectors(pointing, target), rotation)


def _align_hinge(points: SourcePoints, rotation: Float, joint: str, tolerance: float) -> Float:
    """Rotate about the bone so that knee or elbow bend about the engine's hinge axis, if off by over `tolerance`."""
    side = "left" if joint.startswith("left") else "right"
    limb = ("UpperArm", "LowerArm", "Hand") if joint.endswith("Arm") else ("UpperLeg", "LowerLeg", "Foot")
    upper, lower = (points.bone(side + limb[n], side + limb[n + 1]) for n in (0, 1))
    bone = engine_direction(side + limb[1])
    bends_to = np.array((0.0, 0.0, 1.0 if joint.endswith("Arm") else -1.0))
    angle = hinge_twist(upper, lower, rotation, bone, np.cross(bone, bends_to))
    if abs(angle) <= tolerance:
        return rotation
    return quaternion.mul(rotation, quaternion.from_axis_angle(bone, np.asarray(angle)))


SAMPLE_RATE: Final = 60.0
"""Sample rate of clips made from recordings [Hz]."""
_FRAME_TOLERANCE: Final = 1e-3
"""Fraction of a frame that counts as zero, because headers round the frame time."""


def retarget(
    motion: SourceMotion,
    *,
    name: str,
    fps: float | None = None,
    unit_m: float | None = None,
    up: UpAxis | None = None,
    drop_frames: int = 0,
    sample_rate: float = SAMPLE_RATE,
    centred: bool = True,
) -> Clip:
    """Return the motion as a clip of the engine's skeleton at `sample_rate`.

    `fps` is the true frame rate if the header is wrong. `drop_frames` leading frames are dropped first. `unit_m`
    (metres per unit) is only checked for plausibility: the scale is the ratio of leg lengths, so step length follows
    the engine's legs. `up` is detected if not given.

    Limb bones point exactly where the source's do (with its own skeleton, at the same moment). Trunk and neck chains of
    any length are distributed over the engine's. The hips are placed so that supporting feet stay where the source's
    stood. The floor is moved to y = 0 (5th percentile of the lowest sole; vertical drift, as in motion from video, is
    followed slowly). The first sample's hips are moved to x = z = 0 unless `centred` is false (two dancers recorded
    together). The heading stays as recorded. Between frames rotations are interpolated by SLERP, never as Euler angles.

    Raises MotionFileError if the skeleton is not a body or has no size, ValueError for arguments out of range.
    """
    body = find_body(motion)
    _check(motion, body, fps, drop_frames, sample_rate)
    _, axis = standing_pose(motion, body, up)
    recorded = LocalPose(motion.translation, motion.rotation)
    local = _resample_pose(recorded, drop_frames, (fps or motion.header_fps) / sample_rate)
    points = source_points(motion, body, world_pose(motion.parents, local), axis)
    leg = leg_length(body, points.positions)
    if not leg > 1e-6 or not np.isfinite(leg):
        raise MotionFileError(motion.file, None, "the legs have no length", "a body with OFFSETs of its limbs expected")
    _check_unit(motion, body_height(leg), unit_m)
    world = world_rotations(points, rest_points(motion, body, axis))
    rotation = quaternion.align_signs(local_rotations(world))
    root = place_hips(points, world, rotation, ENGINE_LEG / leg)
    positions, _ = forward_kinematics(root, rotation)
    ankles, toes = (positions[:, [SKELETON.index(s + j) for s, _ in SIDES]] for j in ("Foot", "Toes"))
    lowest = np.minimum(ankles[..., 1] - SOLE_BELOW_ANKLE, toes[..., 1] - TOES_OVER_SOLE).min(axis=1)
    shift = np.empty_like(root)
    shift[:] = -root[0] if centred else 0.0
    shift[:, 1] = -find_floor(lowest, sample_rate)
    places = shift[:, None]
    return Clip(
        name=name,
        root_position=np.ascontiguousarray(root + shift, np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        sample_rate=sample_rate,
        contact=find_contacts(ankles + places, toes + places, sample_rate),
    )


def _check(motion: SourceMotion, body: SourceBody, fps: float | None, drop_frames: int, sample_rate: float) -> None:
    if fps is not None and not 1.0 <= fps <= 10_000.0:
        raise ValueError(f"fps {fps}: 1 to 10000 expected")
    if not 1.0 <= sample_rate <= 1000.0:
        raise ValueError(f"sample rate {sample_rate} Hz: 1 to 1000 expected")
    if not 0 <= drop_frames < motion.frame_count:
        raise ValueError(f"drop_frames {drop_frames}: 0 to {motion.frame_count - 1} expected in {motion.file}")
    if body.missing:
        found = ", ".join(motion.names[:8]) + (", ..." if motion.joint_count > 8 else "")
        raise MotionFileError(
            motion.file,
            None,
            f"no joints found for {', '.join(body.missing)} among {found}",
            "a full body expected: hips, both legs and both arms",
        )


def _check_unit(motion: SourceMotion, height: float, unit_m: float | None) -> None:
    low, high = BODY_HEIGHT_RANGE
    if unit_m is not None and not low <= height * unit_m <= high:
        raise ValueError(
            f"unit_m {unit_m}: the dancer of {motion.file} would be {height * unit_m:.3g} m tall; "
            f"{low} to {high} m is plausible, that is unit_m {low / height:.3g} to {high / height:.3g}"
        )


def _resample_pose(local: LocalPose, drop: int, frames_per_sample: float) -> LocalPose:
    """Resample from frame `drop` on: SLERP for rotations, linear for translations."""
    frames = local.rotation.shape[0] - drop
    count = int((frames - 1) / frames_per_sample + _FRAME_TOLERANCE) + 1
    place = np.minimum(np.arange(count) * frames_per_sample, frames - 1)
    before = np.minimum(place.astype(np.int64), max(frames - 2, 0))
    part = place - before
    before += drop
    if np.abs(part - np.round(part)).max(initial=0.0) < _FRAME_TOLERANCE:
        exact = before + np.round(part).astype(np.int64)
        return LocalPose(local.translation[exact], local.rotation[exact])
    after, weight = before + 1, part[:, None, None]
    return LocalPose(
        local.translation[before] * (1.0 - weight) + local.translation[after] * weight,
        quaternion.slerp(local.rotation[before], local.rotation[after], part[:, None]),
    )
