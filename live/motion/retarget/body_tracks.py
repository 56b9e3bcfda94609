"""A recorded body as joint positions and rotations per frame, Y up, in metres or file units, with hand and foot
tips."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import (
    BODY_HEIGHT_RANGE,
    ENGINE_LEG,
    body_height,
    find_unit,
    leg_length,
    standing_pose,
)
from live.motion.formats.source_motion import SourceMotion, UpAxis, WorldPose, end_positions, rest_pose
from live.motion.retarget.joint_mapping import find_body
from live.motion.retarget.rest_pose_alignment import SIDES, SourcePoints
from live.motion.retarget.source_body import SourceBody

Int = npt.NDArray[np.int64]

BODY_SIDES: Final = ("left", "right")
PALM_SHARE: Final = 0.5
"""Position of the palm as a share of the distance from the wrist to the hand's tip."""
_Z_UP_TO_Y_UP: Final = np.array((np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class BodyTracks:
    """B joints of the body (without fingers, eyes and helpers) and the ends of its limbs over T frames."""

    body: SourceBody
    names: tuple[str, ...]
    """Names of the B joints in the file."""
    joints: Int
    """Their indices in the file, ascending, shape (B,)."""
    positions: Float64
    """World positions [m], Y up, shape (T, B, 3)."""
    rotation: Float64
    """Rotations relative to the parent, as in the file, shape (T, B, 4)."""
    palms: Float64
    """Palm centres, left and right [m], shape (T, 2, 3)."""
    ankles: Float64
    """Ankles, left and right [m], shape (T, 2, 3)."""
    toes: Float64
    """Toes, left and right [m], the ankle if the file has none, shape (T, 2, 3)."""
    rate: float
    """Frames per second in use."""
    unit_m: float
    """Metres per file unit in use."""

    @property
    def frame_count(self) -> int:
        """Number of frames T."""
        return int(self.positions.shape[0])

    def column(self, name: str) -> int | None:
        """Return the column (0 to B - 1) of one of the engine's joints, or None."""
        joint = self.body.joints[name]
        return None if joint is None else int(np.searchsorted(self.joints, joint))


def body_tracks(
    motion: SourceMotion, *, fps: float | None = None, up: UpAxis | None = None, unit_m: float | None = None
) -> BodyTracks:
    """Return the body's tracks; rate, axis and unit default to the file's values or are detected.

    If no unit gives a plausible person, the body is scaled to the engine's leg length. Raises MotionFileError if the
    skeleton is not a body.
    """
    body = find_body(motion)
    if body.missing:
        raise MotionFileError(
            motion.file, None, f"no joints found for {', '.join(body.missing)}", "a full body expected"
        )
    world, axis = standing_pose(motion, body, up)
    leg = leg_length(body, world.positions)
    if not leg > 1e-6 or not np.isfinite(leg):
        raise MotionFileError(motion.file, None, "the legs have no length", "a full body expected")
    unit = unit_m or _plausible_unit(motion.unit_m, leg) or find_unit(leg) or ENGINE_LEG / leg
    ends = end_positions(motion, world)

    def metres(points: Float) -> Float64:
        turned = quaternion.rotate(_Z_UP_TO_Y_UP, points) if axis == "Z" else points
        return np.asarray(turned * unit, np.float64)

    parts = {j for j in body.joints.values() if j is not None} | set(body.spine) | set(body.neck)
    joints = np.array(sorted(parts), np.int64)
    tips = [_hand_tip(motion, body, side, world.positions, ends) for side in BODY_SIDES]
    wrists = [
        tips[n] if (j := body.joints[side + "Hand"]) is None else world.positions[:, j]
        for n, side in enumerate(BODY_SIDES)
    ]
    ankles = np.stack([world.positions[:, body.joint(side + "Foot")] for side in BODY_SIDES], axis=1)
    toes = np.stack([_toes(motion, body, side, world.positions, ends) for side in BODY_SIDES], axis=1)
    hands = np.stack(
        [(1.0 - PALM_SHARE) * wrist + PALM_SHARE * tip for wrist, tip in zip(wrists, tips, strict=True)], axis=1
    )
    return BodyTracks(
        body=body,
        names=tuple(motion.names[j] for j in joints),
        joints=joints,
        positions=metres(world.positions[:, joints]),
        rotation=np.ascontiguousarray(motion.rotation[:, joints], np.float64),
        palms=metres(hands),
        ankles=metres(ankles),
        toes=metres(toes),
        rate=fps or motion.header_fps,
        unit_m=float(unit),
    )


def _plausible_unit(unit: float | None, leg: float) -> float | None:
    """Return the unit that the format fixes if the body height is plausible: some files in centimetres claim metres."""
    low, high = BODY_HEIGHT_RANGE
    return unit if unit is not None and low <= body_height(leg) * unit <= high else None


def _hand_tip(motion: SourceMotion, body: SourceBody, side: str, positions: Float, ends: Float) -> Float64:
    """Return the mean of the hand's children without the thumb, (T, 3); without any, the hand (or lower arm) itself."""
    hand = body.joints[side + "Hand"]
    return _mean_of_children(motion, body.joint(side + "LowerArm") if hand is None else hand, positions, ends)


def _toes(motion: SourceMotion, body: SourceBody, side: str, positions: Float, ends: Float) -> Float64:
    toes = body.joints[side + "Toes"]
    return (
        np.asarray(positions[:, toes], np.float64)
        if toes is not None
        else _mean_of_children(motion, body.joint(side + "Foot"), positions, ends)
    )


def _mean_of_children(motion: SourceMotion, joint: int, positions: Float, ends: Float) -> Float64:
    children = [c for c in np.flatnonzero(motion.parents == joint) if "thumb" not in motion.names[c].lower()]
    places = [positions[:, c] for c in children] + [ends[:, e] for e in np.flatnonzero(motion.end_parents == joint)]
    distant = [place for place in places if np.median(np.linalg.norm(place - positions[:, joint], axis=-1)) > 1e-9]
    return np.asarray(np.mean(distant, axis=0), np.float64) if distant else np.asarray(positions[:, joint], np.float64)


def source_points(motion: SourceMotion, body: SourceBody, world: WorldPose, axis: UpAxis) -> SourcePoints:
    """Return a body's poses from `world` in Y-up axes, in file units, with the tips of hands and feet.

    Raises MotionFileError if a lower arm has no end.
    """
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
                tip = _joint_tip(motion, source, positions, ends)
                if tip is not None:
                    tips[side + child] = tip
        if not (body.joints[side + "Hand"] is not None or side + "Hand" in tips):
            raise MotionFileError(
                motion.file, None, f"the {side} lower arm has no end", "a hand or an End Site expected"
            )
    return SourcePoints(body, positions, rotations, tips)


def _joint_tip(motion: SourceMotion, joint: int, positions: Float, ends: Float) -> Float | None:
    """Return the mean of a joint's children (without thumbs), (T, 3); None if there are none or they coincide with
    it."""
    children = [c for c in np.flatnonzero(motion.parents == joint) if "thumb" not in motion.names[c].lower()]
    places = [positions[:, c] for c in children] + [ends[:, e] for e in np.flatnonzero(motion.end_parents == joint)]
    distant = [place for place in places if np.median(np.linalg.norm(place - positions[:, joint], axis=-1)) > 1e-6]
    return np.mean(distant, axis=0) if distant else None


def rest_points(motion: SourceMotion, body: SourceBody, axis: UpAxis) -> SourcePoints:
    """Return `source_points` of the rest pose, a single sample."""
    return source_points(motion, body, rest_pose(motion), axis)
