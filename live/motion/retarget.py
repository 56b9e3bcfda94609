"""A recording onto the engine's skeleton: the bones keep their directions, the feet their places on the floor."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.alignment import (
    LIMB_BONES,
    SIDES,
    SourcePoints,
    engine_direction,
    hinge_twist,
    plainness,
    reference_rotations,
    standing_frame,
)
from live.motion.clip import Clip
from live.motion.contact import TOES_OVER_SOLE, find_contacts
from live.motion.file_error import MotionFileError
from live.motion.forward import forward_kinematics
from live.motion.joint_map import SourceBody, find_body
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.motion.source_axes import (
    BODY_HEIGHT_RANGE,
    ENGINE_LEG,
    body_height,
    leg_length,
    standing_pose,
)
from live.motion.source_motion import SourceMotion, UpAxis
from live.motion.source_pose import LocalPose, WorldPose, end_positions, rest_pose, world_pose
from live.motion.trunk import neck_rotation, spine_rotations

Float = npt.NDArray[np.floating]

SAMPLE_RATE: Final = 60.0
"""Samples per second of clips made from recordings [Hz]."""
SUPPORT_HEIGHT: Final = 0.05
"""A foot this high [m] over its floor counts e times less than one on it when the hips are placed."""
FLOOR_PERCENTILE: Final = 5.0
FLOATING: Final = 0.08
"""Where the lowest sole is this high [m] over the floor for half of the time, the recording drifts."""
DRIFT_WINDOW: Final = 2.0
"""Seconds within which a foot is sure to come down (a jump lasts less than one)."""
TWISTED: Final = np.radians(60.0)
"""A limb that bends this far beside our hinge axis has a rest pose whose twist means nothing."""
_NEARLY: Final = 1e-3
"""Part of a frame that is none: headers round the frame time."""
_Z_UP_TO_Y_UP: Final = np.array((np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0))
_HIP_MIDDLE: Final = SKELETON.offsets[SKELETON.index("leftUpperLeg")].astype(np.float64) * (0.0, 1.0, 1.0)


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
    """The motion as a clip of the engine's skeleton, `sample_rate` samples per second.

    `fps` is the true frame rate where the header lies, `drop_frames` leading frames are left out before anything
    else, `unit_m` (metres per unit) is only checked for plausibility, for the scale is the ratio of leg lengths:
    steps become as long as the engine's legs make them. `up` is found if it is not given.

    Limb bones point exactly where the source's do (its own skeleton, at the same moment); trunk and neck chains of
    any length are spread over ours; the hips are placed so that the feet that carry stand where the source's stood.
    The floor comes to y = 0 (5th percentile of the lowest sole; a recording that drifts up and down, as those from
    video do, is followed slowly), the first sample's hips come to x = z = 0, unless it is not to be `centred`
    (two who were recorded together); the heading stays as recorded. Between
    frames rotations are interpolated by SLERP, never as Euler angles.

    Raises MotionFileError if the skeleton is no body or has no size, ValueError for arguments out of range.
    """
    body = find_body(motion)
    _check(motion, body, fps, drop_frames, sample_rate)
    _, axis = standing_pose(motion, body, up)
    recorded = LocalPose(motion.translation, motion.rotation)
    local = _resampled(recorded, drop_frames, (fps or motion.header_fps) / sample_rate)
    points = _points(motion, body, world_pose(motion.parents, local), axis)
    leg = leg_length(body, points.positions)
    if not leg > 1e-6 or not np.isfinite(leg):
        raise MotionFileError(motion.file, None, "the legs have no length", "OFFSETs of a body expected")
    _check_unit(motion, body_height(leg), unit_m)
    world = _world_rotations(points, _rest_points(motion, body, axis))
    rotation = quaternion.continuous(_local_rotations(world))
    root = _place_hips(points, world, rotation, ENGINE_LEG / leg)
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
            "names of a body expected",
        )


def _check_unit(motion: SourceMotion, height: float, unit_m: float | None) -> None:
    low, high = BODY_HEIGHT_RANGE
    if unit_m is not None and not low <= height * unit_m <= high:
        raise ValueError(
            f"unit_m {unit_m}: the dancer of {motion.file} would be {height * unit_m:.3g} m tall; "
            f"{low} to {high} m is believed, that is unit_m {low / height:.3g} to {high / height:.3g}"
        )


def _resampled(local: LocalPose, drop: int, frames_per_sample: float) -> LocalPose:
    """Samples at the new rate from frame `drop` on: SLERP and linear between frames."""
    frames = local.rotation.shape[0] - drop
    count = int((frames - 1) / frames_per_sample + _NEARLY) + 1
    place = np.minimum(np.arange(count) * frames_per_sample, frames - 1)
    before = np.minimum(place.astype(np.int64), max(frames - 2, 0))
    part = place - before
    before += drop
    if np.abs(part - np.round(part)).max(initial=0.0) < _NEARLY:
        exact = before + np.round(part).astype(np.int64)
        return LocalPose(local.translation[exact], local.rotation[exact])
    after, weight = before + 1, part[:, None, None]
    return LocalPose(
        local.translation[before] * (1.0 - weight) + local.translation[after] * weight,
        quaternion.slerp(local.rotation[before], local.rotation[after], part[:, None]),
    )


def _points(motion: SourceMotion, body: SourceBody, world: WorldPose, axis: UpAxis) -> SourcePoints:
    """The body in Y-up axes, with the tips of hands and feet."""
    ends = end_positions(motion, world)
    positions, rotations = world.positions, world.rotations
    if axis == "Z":
        ends, positions = (quaternion.rotate(_Z_UP_TO_Y_UP, points) for points in (ends, positions))
        rotations = quaternion.mul(_Z_UP_TO_Y_UP, rotations)
    tips: dict[str, Float] = {}
    for side, _ in SIDES:
        for joint, child in (("LowerArm", "Hand"), ("Foot", "Toes"), ("Hand", "HandEnd")):
            source = body.joints[side + joint]
            if source is not None and body.joints.get(side + child) is None:
                tip = _tip(motion, source, positions, ends)
                if tip is not None:
                    tips[side + child] = tip
        if not (body.joints[side + "Hand"] is not None or side + "Hand" in tips):
            raise MotionFileError(
                motion.file, None, f"nothing ends the {side} lower arm", "a hand or an End Site expected"
            )
    return SourcePoints(body, positions, rotations, tips)


def _tip(motion: SourceMotion, joint: int, positions: Float, ends: Float) -> Float | None:
    """Mean of what hangs on a joint (thumbs left out), (T, 3); None if nothing does or if it is the joint itself."""
    children = [c for c in np.flatnonzero(motion.parents == joint) if "thumb" not in motion.names[c].lower()]
    places = [positions[:, c] for c in children] + [ends[:, e] for e in np.flatnonzero(motion.end_parents == joint)]
    distant = [place for place in places if np.median(np.linalg.norm(place - positions[:, joint], axis=-1)) > 1e-6]
    return np.mean(distant, axis=0) if distant else None


def _rest_points(motion: SourceMotion, body: SourceBody, axis: UpAxis) -> SourcePoints:
    return _points(motion, body, rest_pose(motion), axis)


def _world_rotations(points: SourcePoints, rest: SourcePoints) -> Float:
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


def _local_rotations(world: Float) -> Float:
    local = world.copy()
    for joint, parent in enumerate(SKELETON.parents):
        if parent >= 0:
            local[:, joint] = quaternion.mul(quaternion.inverse(world[:, parent]), world[:, joint])
    return quaternion.unit(local)


def find_floor(lowest: Float, sample_rate: float) -> Float:
    """Height of the floor [m] at each sample, (T,), from the height `lowest` (T,) of the lowest sole."""
    floor = np.full(lowest.shape, np.percentile(lowest, FLOOR_PERCENTILE))
    if np.median(lowest - floor) < FLOATING:
        return floor
    half = max(1, round(0.5 * DRIFT_WINDOW * sample_rate))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(lowest, half, mode="edge"), 2 * half + 1)
    least = np.pad(windows.min(axis=-1), half, mode="edge")
    return np.asarray(np.convolve(least, np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid"))


def _place_hips(points: SourcePoints, world: Float, rotation: Float, scale: float) -> Float:
    """Where the hips go [m], (T, 3): between the source's hip joints, then moved so that carrying feet stay put.

    Legs of other proportions put the feet a few centimetres beside the source's; the hips take up that difference,
    weighted by how near each foot is to the floor, and the directions of the bones remain as they are.
    """
    root = scale * points.middle("UpperLeg") - quaternion.rotate(world[:, 0], _HIP_MIDDLE)
    positions, _ = forward_kinematics(root, rotation)
    total, weights = np.zeros_like(root), np.full((len(root), 1), 1e-9)
    for side, _ in SIDES:
        target = scale * points.at(side + "Foot")
        height = target[:, 1] - np.percentile(target[:, 1], FLOOR_PERCENTILE)
        weight = np.exp(-np.clip(height / SUPPORT_HEIGHT, 0.0, 15.0))[:, None]
        total += weight * (target - positions[:, SKELETON.index(side + "Foot")])
        weights += weight
    return np.asarray(root + total / weights)
