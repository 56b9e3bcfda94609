"""Full-body poses from the channels and foot tracks of a sketch: pelvis, spine, head, arms, legs."""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.curve import gaussian_filter, hermite, monotone_slopes, soft_min, spring_response
from live.motion.pose.two_bone_ik import SOFTNESS, bone_rotation, hinge_axis, two_bone
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.sketch.foot_trajectories import HOME_FORWARD, FootTrack
from live.motion.sketch.sketch_file import Sketch
from live.motion.sketch.upper_body import (
    SAMPLES_PER_BEAT,
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Channels,
    FootSupport,
    Pose,
    axis_rotation,
    body_rotation,
    extend_keys,
    facing,
    joint_index,
    offset_of,
    pose_arm,
    rotation_share,
    stride_of,
)

STANDING_HEIGHT: Final = float(SKELETON.offsets[0, 1]) - 0.03
"""Height of the hips in the neutral stance, knees soft [m]."""
GRAVITY: Final = 9.81
_WEIGHT_SHIFT: Final = 0.55
"""Share of the distance from the middle to the supporting foot by which the pelvis shifts."""
_MAX_FOOT_DISTANCE: Final = 0.62
"""Maximum lateral distance of a foot from the pelvis [m]."""
_HEAD_LEAD: Final = 0.35
"""The head looks where the body will face so many beats later ..."""
_MAX_HEAD_LEAD: Final = math.radians(55.0)
"""... as far as the neck goes [rad]."""
_LEFT_RIGHT: Final = ((1.0, "left"), (-1.0, "right"))


def pose_body(sketch: Sketch, ground: FootSupport) -> tuple[Float, Float, Float]:
    """Return root positions (T, 3) and local rotations (T, J, 4) of the dancer at all samples of `ground`.

    The third value is the distance by which each ankle misses its place [m], (T, 2), left and right.
    """
    count = len(ground.beats)
    pose = Pose(np.zeros((count, JOINT_COUNT, 3)), np.zeros((count, JOINT_COUNT, 4)))
    pelvis = Channels(sketch, "pelvis", ground.beats)
    _pose_pelvis(sketch, ground, pelvis, pose)
    _pose_trunk(sketch, ground, pelvis, pose)
    for side, name in _LEFT_RIGHT:
        pose_arm(sketch, ground, pose, side, name)
    short = [_pose_leg(track, pose, name) for track, name in ((ground.left, "left"), (ground.right, "right"))]
    parents = SKELETON.parents[1:]
    local = pose.rotation.copy()
    local[:, 1:] = quaternion.mul(quaternion.inverse(pose.rotation[:, parents]), pose.rotation[:, 1:])
    return pose.position[:, 0].copy(), quaternion.align_signs(quaternion.unit(local)), np.stack(short, axis=1)


# --- pelvis ------------------------------------------------------------------------------------------------------


def _pose_pelvis(sketch: Sketch, ground: FootSupport, pelvis: Channels, pose: Pose) -> None:
    stride = gaussian_filter(stride_of(ground), 0.1 * SAMPLES_PER_BEAT)
    weight = gaussian_filter(ground.balance, 0.12 * SAMPLES_PER_BEAT)
    turn = pelvis["turn"] - 0.16 * np.tanh(stride / 0.45)
    tilt = pelvis["tilt"] - (0.0 if "tilt" in pelvis.named else math.radians(5.0) * weight)
    rotation = body_rotation(ground.facing + turn, pelvis["lean"], tilt)
    position = np.empty((len(ground.beats), 3))
    middle = 0.5 * (ground.left.support_point + ground.right.support_point)
    apart = 0.5 * (ground.left.support_point - ground.right.support_point)
    sideways = np.zeros(1) if "left" in pelvis.named else weight
    if np.ptp(ground.facing) < 1.0:
        # laterally the pelvis shifts over the supporting foot; forwards it follows only the middle of both feet
        side = np.stack((np.cos(ground.facing), -np.sin(ground.facing)), axis=1)
        apart = side * np.sum(apart * side, axis=1, keepdims=True)
    over = gaussian_filter(_WEIGHT_SHIFT * apart * np.reshape(sideways, (-1, 1)), 0.05 * SAMPLES_PER_BEAT)
    # in a wide stance the pelvis stays near enough to the middle for both legs to reach the floor
    room = np.maximum(_MAX_FOOT_DISTANCE - np.linalg.norm(apart, axis=1, keepdims=True), 0.02)
    over = over * room / (room**4 + np.sum(over * over, axis=1, keepdims=True) ** 2) ** 0.25
    middle = gaussian_filter(middle, 0.22 * SAMPLES_PER_BEAT) + over
    shift = np.stack((pelvis["left"], np.zeros(len(ground.beats)), pelvis["forward"] - HOME_FORWARD), axis=1)
    shift = quaternion.rotate(axis_rotation(Y_AXIS, ground.facing), shift)
    position[:, 0] = middle[:, 0] + shift[:, 0]
    position[:, 2] = middle[:, 1] + shift[:, 2]
    height = STANDING_HEIGHT + _pelvis_height(sketch, ground, pelvis)
    ahead = -0.25 * np.clip(STANDING_HEIGHT - height, 0.0, 0.25)  # bent knees move the pelvis back
    position[:, 0] += ahead * np.sin(ground.facing)
    position[:, 2] += ahead * np.cos(ground.facing)
    for track, name in ((ground.left, "left"), (ground.right, "right")):
        height = soft_min(height, _max_pelvis_height(track, name, position, rotation), 0.008)
    position[:, 1] = height
    pose.position[:, 0] = position
    pose.rotation[:, 0] = rotation


def _pelvis_height(sketch: Sketch, ground: FootSupport, pelvis: Channels) -> Float:
    """Return the height of the pelvis above the neutral stance [m], ballistic while both feet are in the air."""
    beats = ground.beats
    keys = [(key.beat, key.amounts.get("up", 0.0)) for key in pelvis.keys if {"up", "neutral"} & set(key.amounts)]
    if not ground.flights:
        if "up" in pelvis.named:
            return pelvis["up"]
        if not sketch.cyclic:
            return np.zeros(len(beats))
        return np.asarray(-sketch.bounce * (0.5 + 0.5 * np.cos(2.0 * np.pi * beats)))
    if keys:
        times, values = extend_keys(sketch, keys, beats)
        knots = list(zip(times, values, strict=True))
    else:
        knots = [
            (at, v)
            for a, b in ground.flights
            for at, v in ((a - 1.1, 0.0), (a - 0.4, -0.1), (b + 0.4, -0.1), (b + 1.1, 0.0))
        ]
    knots = [(at, v) for at, v in knots if not any(a - 0.12 < at < b + 0.12 for a, b in ground.flights)]
    per_beat = 60.0 / sketch.bpm
    ends = {
        at: sign * 0.5 * GRAVITY * (b - a) * per_beat * per_beat
        for a, b in ground.flights
        for at, sign in ((a, 1.0), (b, -1.0))
    }
    knots = [
        (at, v)
        for at, v in {round(at, 6): v for at, v in knots}.items()
        if not any(abs(at - end) < 1e-6 for end in ends)
    ]
    knots = sorted(knots + [(at, 0.02) for at in ends])
    table = np.array(knots)
    slopes = monotone_slopes(table[:, 0], table[:, 1])
    for index, (at, _) in enumerate(knots):
        slopes[index] = ends.get(at, slopes[index])
    return gaussian_filter(hermite(table[:, 0], table[:, 1], slopes, beats), 0.02 * SAMPLES_PER_BEAT)


def _ankle(track: FootTrack) -> tuple[Float, Float]:
    """Return the ankle's world position (T, 3) and the foot's rotation (T, 4), rolled over ball and heel."""
    yaw = axis_rotation(Y_AXIS, track.yaw)
    heel_to_ball, ball_to_ankle = np.array((0.0, 0.02, 0.18)), -offset_of("leftToes")
    toe = axis_rotation(X_AXIS, -track.toe)
    rotation = quaternion.mul(yaw, quaternion.mul(axis_rotation(X_AXIS, track.heel), toe))
    ball = np.stack((track.ball[:, 0], track.height + 0.02, track.ball[:, 1]), axis=1)
    ball = ball + quaternion.rotate(yaw, quaternion.rotate(toe, heel_to_ball) - heel_to_ball)
    ball[:, 1] += 0.06 * np.sin(track.heel) * (1.0 - track.stance_weight)
    return ball + quaternion.rotate(rotation, ball_to_ankle), rotation


def _leg_length() -> tuple[float, float]:
    return float(-offset_of("leftLowerLeg")[1]), float(-offset_of("leftFoot")[1])


def _max_pelvis_height(track: FootTrack, name: str, pelvis: Float, rotation: Float) -> Float:
    """Return the maximum height of the pelvis at which this leg reaches its place [m], (T,)."""
    hip = quaternion.rotate(rotation, offset_of(f"{name}UpperLeg"))
    ankle, _ = _ankle(track)
    away = ankle - pelvis - hip
    reach = (1.0 - 1.05 * SOFTNESS) * sum(_leg_length())
    room = np.maximum(reach**2 - away[:, 0] ** 2 - away[:, 2] ** 2, 0.09)
    return np.asarray(ankle[:, 1] + np.sqrt(room) - hip[:, 1] + 0.4 * track.air_weight)


def _pose_leg(track: FootTrack, pose: Pose, name: str) -> Float:
    ankle, foot = _ankle(track)
    _, pelvis = pose.transform_of("hips")
    ahead = quaternion.unit(quaternion.rotate(foot, Z_AXIS) * (1.0, 0.0, 1.0))
    front = quaternion.unit(quaternion.rotate(pelvis, Z_AXIS) * (1.0, 0.0, 1.0))
    pole = quaternion.unit(0.65 * ahead + 0.35 * front) + 0.5 * Y_AXIS
    upper, lower = _leg_length()
    hip = pose.attach(f"{name}UpperLeg", foot)
    knee, end = two_bone(hip, ankle, pole, upper=upper, lower=lower)
    hinge = hinge_axis(hip, ankle, pole)
    pose.rotation[:, joint_index(f"{name}UpperLeg")] = bone_rotation(knee - hip, hinge, -Y_AXIS, -X_AXIS)
    pose.attach(f"{name}LowerLeg", bone_rotation(end - knee, hinge, -Y_AXIS, -X_AXIS))
    pose.attach(f"{name}Foot", foot)
    bend = track.heel * (0.3 + 0.7 * track.stance_weight)
    pose.attach(f"{name}Toes", quaternion.mul(foot, axis_rotation(X_AXIS, -bend)))
    return np.asarray(np.linalg.norm(end - ankle, axis=1))


# --- spine and head ----------------------------------------------------------------------------------------------


def _breath(sketch: Sketch, beats: Float) -> Float:
    """Return the breath, 0 out and 1 in, (T,): in once a measure, out at its lines."""
    beats = beats if sketch.cyclic else np.clip(beats, 0.0, sketch.beats)
    return np.asarray(sketch.breath * (0.5 - 0.5 * np.cos(2.0 * np.pi * beats / sketch.beats_per_measure)))


def _head_lead(sketch: Sketch, ground: FootSupport, head: Channels) -> Float:
    """Return by how much the head is ahead of the body's turn [rad], (T,): eyes go first. Keys of the head decide
    alone."""
    if "turn" in head.named:
        return np.zeros(len(ground.beats))
    ahead = facing(sketch, ground.beats + _HEAD_LEAD) - ground.facing
    return np.asarray(_MAX_HEAD_LEAD * np.tanh(ahead / _MAX_HEAD_LEAD))


def _pose_trunk(sketch: Sketch, ground: FootSupport, pelvis: Channels, pose: Pose) -> None:
    beats = ground.beats
    chest, head = Channels(sketch, "chest", beats), Channels(sketch, "head", beats)
    stride = gaussian_filter(stride_of(ground), 0.1 * SAMPLES_PER_BEAT)
    weight = spring_response(ground.balance, 0.5 * SAMPLES_PER_BEAT, 0.7)
    height = pose.position[:, 0, 1]
    drop = spring_response(
        STANDING_HEIGHT - np.clip(height, STANDING_HEIGHT - 0.15, STANDING_HEIGHT + 0.05), 0.45 * SAMPLES_PER_BEAT, 0.55
    )
    # the shoulders answer the hips: they turn and tilt against them while the weight goes from foot to foot
    turn = chest["turn"] + 0.25 * np.tanh(stride / 0.45) + 0.1 * pelvis["turn"]
    tilt = chest["tilt"] + 0.2 * pelvis["tilt"]
    turn += math.radians(2.0 if "turn" in chest.named else 5.0) * weight
    tilt += math.radians(2.5 if "tilt" in chest.named else 4.5) * weight
    breath = _breath(sketch, beats)
    lean = chest["lean"] + math.radians(1.0) + 0.6 * drop + 0.3 * pelvis["lean"] - math.radians(1.5) * breath
    upright = body_rotation(ground.facing + turn, lean, tilt)
    _, hips = pose.transform_of("hips")
    bend = quaternion.mul(quaternion.inverse(hips), upright)
    # a shift of the rib cage bends the spine into an S: bent at the bottom, bent back at the top
    side, front = (
        np.arcsin(np.clip(chest["left"] / 0.245, -0.8, 0.8)),
        np.arcsin(np.clip(chest["forward"] / 0.25, -0.8, 0.8)),
    )
    shift = quaternion.mul(axis_rotation(X_AXIS, front), axis_rotation(Z_AXIS, -side))
    low = quaternion.mul(quaternion.mul(hips, rotation_share(bend, 0.3)), shift)
    pose.attach("spine", low)
    pose.attach("chest", quaternion.mul(low, rotation_share(bend, 0.35)))
    pose.attach("upperChest", upright)
    nod = 0.9 * spring_response(drop, 0.3 * SAMPLES_PER_BEAT, 0.5) - 0.5 * drop
    gaze = body_rotation(
        ground.facing + head["turn"] + 0.2 * chest["turn"] + _head_lead(sketch, ground, head),
        head["lean"] + 0.45 * chest["lean"] + nod,
        head["tilt"] + 0.35 * chest["tilt"],
    )
    look = quaternion.mul(quaternion.inverse(upright), gaze)
    pose.attach("neck", quaternion.mul(upright, rotation_share(look, 0.45)))
    pose.attach("head", gaze)
