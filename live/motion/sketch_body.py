"""From the channels and foot tracks of a sketch to a pose for every sample: pelvis, spine, head, arms, legs."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.curve import followed, hermite, monotone_slopes, smoothed, soft_min, through
from live.motion.ik import SOFTNESS, bone_rotation, two_bone
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.sketch import Sketch
from live.motion.sketch_channels import SAMPLES_PER_BEAT, Channels, closed
from live.motion.sketch_feet import HOME_FORWARD, FootTrack

Float = npt.NDArray[np.floating]

STANDING: Final = float(SKELETON.offsets[0, 1]) - 0.03
"""Height of the hips in the neutral stance, knees soft [m]."""
GRAVITY: Final = 9.81
_SHIFT: Final = 0.55
"""Share of the way from the middle to the standing foot that the pelvis takes."""
_X, _Y, _Z = np.eye(3)
_LEFT_RIGHT: Final = ((1.0, "left"), (-1.0, "right"))
_REST_HAND: Final = np.array((0.115, -0.44, 0.075))
"""Where a relaxed hand hangs from its shoulder: out, up, forward [m]."""


def _joint(name: str) -> int:
    return SKELETON.index(name)


def _offset(name: str) -> Float:
    return np.asarray(SKELETON.offsets[_joint(name)], np.float64)


def _about(axis: Float, angle: Float) -> Float:
    return quaternion.from_axis_angle(axis, angle)


def _turned(turn: Float, lean: Float, tilt: Float) -> Float:
    """Turn (left positive) about the vertical, lean forward, tilt to the left: angles (T,) → rotations (T, 4)."""
    return quaternion.mul(_about(_Y, turn), quaternion.mul(_about(_X, lean), _about(_Z, -tilt)))


@dataclass(slots=True, eq=False)
class Pose:
    """World positions and rotations of the joints while a pose is put together, (T, J, 3) and (T, J, 4)."""

    position: Float
    rotation: Float

    def attach(self, name: str, rotation: Float) -> Float:
        """Hang the joint on its parent with the given world rotation; its world position (T, 3)."""
        joint = _joint(name)
        parent = int(SKELETON.parents[joint])
        offset = quaternion.rotate(self.rotation[:, parent], _offset(name))
        self.position[:, joint] = self.position[:, parent] + offset
        self.rotation[:, joint] = rotation
        return self.position[:, joint]

    def of(self, name: str) -> tuple[Float, Float]:
        """World position and rotation of a joint."""
        return self.position[:, _joint(name)], self.rotation[:, _joint(name)]


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What the feet give to the body over T samples."""

    beats: Float
    facing: Float
    balance: Float
    left: FootTrack
    right: FootTrack
    flights: list[tuple[float, float]]


def pose_body(sketch: Sketch, ground: Ground) -> tuple[Float, Float, Float]:
    """Root positions (T, 3) and local rotations (T, J, 4) of the whole dancer, at all samples of `ground`.

    The third is how far each ankle stays short of its place [m], (T, 2), left and right.
    """
    count = len(ground.beats)
    pose = Pose(np.zeros((count, JOINT_COUNT, 3)), np.zeros((count, JOINT_COUNT, 4)))
    pelvis = Channels(sketch, "pelvis", ground.beats)
    _pose_pelvis(sketch, ground, pelvis, pose)
    _pose_trunk(sketch, ground, pelvis, pose)
    for side, name in _LEFT_RIGHT:
        _pose_arm(sketch, ground, pose, side, name)
    short = [_pose_leg(track, pose, name) for track, name in ((ground.left, "left"), (ground.right, "right"))]
    parents = SKELETON.parents[1:]
    local = pose.rotation.copy()
    local[:, 1:] = quaternion.mul(quaternion.inverse(pose.rotation[:, parents]), pose.rotation[:, 1:])
    return pose.position[:, 0].copy(), quaternion.continuous(quaternion.unit(local)), np.stack(short, axis=1)


# --- pelvis ------------------------------------------------------------------------------------------------------


def _stride(ground: Ground) -> Float:
    """How far the left foot stands before the right one, as the dancer sees it [m], (T,)."""
    apart = ground.left.ground - ground.right.ground
    return np.asarray(apart[:, 0] * np.sin(ground.facing) + apart[:, 1] * np.cos(ground.facing))


def _pose_pelvis(sketch: Sketch, ground: Ground, pelvis: Channels, pose: Pose) -> None:
    stride = smoothed(_stride(ground), 0.1 * SAMPLES_PER_BEAT)
    weight = smoothed(ground.balance, 0.12 * SAMPLES_PER_BEAT)
    turn = pelvis["turn"] - 0.16 * np.tanh(stride / 0.45)
    tilt = pelvis["tilt"] - (0.0 if "tilt" in pelvis.named else math.radians(3.5) * weight)
    rotation = _turned(ground.facing + turn, pelvis["lean"], tilt)
    position = np.empty((len(ground.beats), 3))
    middle = 0.5 * (ground.left.ground + ground.right.ground)
    apart = 0.5 * (ground.left.ground - ground.right.ground)
    sideways = np.zeros(1) if "left" in pelvis.named else weight
    if np.ptp(ground.facing) < 1.0:
        # the weight goes over the standing foot sideways; forwards only the middle of both feet is followed
        side = np.stack((np.cos(ground.facing), -np.sin(ground.facing)), axis=1)
        apart = side * np.sum(apart * side, axis=1, keepdims=True)
    over = smoothed(_SHIFT * apart * np.reshape(sideways, (-1, 1)), 0.05 * SAMPLES_PER_BEAT)
    middle = smoothed(middle, 0.22 * SAMPLES_PER_BEAT) + over
    shift = np.stack((pelvis["left"], np.zeros(len(ground.beats)), pelvis["forward"] - HOME_FORWARD), axis=1)
    shift = quaternion.rotate(_about(_Y, ground.facing), shift)
    position[:, 0] = middle[:, 0] + shift[:, 0]
    position[:, 2] = middle[:, 1] + shift[:, 2]
    height = STANDING + _rise(sketch, ground, pelvis)
    ahead = -0.25 * np.clip(STANDING - height, 0.0, 0.25)  # who bends her knees takes the seat back
    position[:, 0] += ahead * np.sin(ground.facing)
    position[:, 2] += ahead * np.cos(ground.facing)
    for track, name in ((ground.left, "left"), (ground.right, "right")):
        height = soft_min(height, _reach(track, name, position, rotation), 0.008)
    position[:, 1] = height
    pose.position[:, 0] = position
    pose.rotation[:, 0] = rotation


def _rise(sketch: Sketch, ground: Ground, pelvis: Channels) -> Float:
    """Height of the pelvis over the neutral stance [m], with free flight where both feet are in the air."""
    beats = ground.beats
    keys = [(key.beat, key.amounts.get("up", 0.0)) for key in pelvis.keys if {"up", "neutral"} & set(key.amounts)]
    if not ground.flights:
        if "up" in pelvis.named:
            return pelvis["up"]
        if not sketch.cyclic:
            return np.zeros(len(beats))
        return np.asarray(-sketch.bounce * (0.5 + 0.5 * np.cos(2.0 * np.pi * beats)))
    if keys:
        times, values = closed(sketch, keys, beats)
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
    knots = sorted(knots + [(at, 0.02) for at in ends])
    table = np.array(knots)
    slopes = monotone_slopes(table[:, 0], table[:, 1])
    for index, (at, _) in enumerate(knots):
        slopes[index] = ends.get(at, slopes[index])
    return smoothed(hermite(table[:, 0], table[:, 1], slopes, beats), 0.02 * SAMPLES_PER_BEAT)


def _ankle(track: FootTrack) -> tuple[Float, Float]:
    """World position of the ankle (T, 3) and rotation of the foot (T, 4), rolled over ball and heel."""
    yaw = _about(_Y, track.yaw)
    heel_to_ball, ball_to_ankle = np.array((0.0, 0.02, 0.18)), -_offset("leftToes")
    toe = _about(_X, -track.toe)
    rotation = quaternion.mul(yaw, quaternion.mul(_about(_X, track.heel), toe))
    ball = np.stack((track.ball[:, 0], track.height + 0.02, track.ball[:, 1]), axis=1)
    ball = ball + quaternion.rotate(yaw, quaternion.rotate(toe, heel_to_ball) - heel_to_ball)
    ball[:, 1] += 0.06 * np.sin(track.heel) * (1.0 - track.firm)
    return ball + quaternion.rotate(rotation, ball_to_ankle), rotation


def _leg_length() -> tuple[float, float]:
    return float(-_offset("leftLowerLeg")[1]), float(-_offset("leftFoot")[1])


def _reach(track: FootTrack, name: str, pelvis: Float, rotation: Float) -> Float:
    """The greatest height of the pelvis at which this leg still reaches its place [m], (T,)."""
    hip = quaternion.rotate(rotation, _offset(f"{name}UpperLeg"))
    ankle, _ = _ankle(track)
    away = ankle - pelvis - hip
    reach = (1.0 - 1.05 * SOFTNESS) * sum(_leg_length())
    room = np.maximum(reach**2 - away[:, 0] ** 2 - away[:, 2] ** 2, 0.09)
    return np.asarray(ankle[:, 1] + np.sqrt(room) - hip[:, 1] + 0.4 * track.free)


def _pose_leg(track: FootTrack, pose: Pose, name: str) -> Float:
    ankle, foot = _ankle(track)
    _, pelvis = pose.of("hips")
    ahead = quaternion.unit(quaternion.rotate(foot, _Z) * (1.0, 0.0, 1.0))
    front = quaternion.unit(quaternion.rotate(pelvis, _Z) * (1.0, 0.0, 1.0))
    pole = quaternion.unit(0.65 * ahead + 0.35 * front) + 0.5 * _Y
    upper, lower = _leg_length()
    hip = pose.attach(f"{name}UpperLeg", foot)
    knee, end = two_bone(hip, ankle, pole, upper=upper, lower=lower)
    pose.rotation[:, _joint(f"{name}UpperLeg")] = bone_rotation(knee - hip, pole, -_Y, _Z)
    pose.attach(f"{name}LowerLeg", bone_rotation(end - knee, pole, -_Y, _Z))
    pose.attach(f"{name}Foot", foot)
    bend = track.heel * (0.3 + 0.7 * track.firm)
    pose.attach(f"{name}Toes", quaternion.mul(foot, _about(_X, -bend)))
    return np.asarray(np.linalg.norm(end - ankle, axis=1))


# --- spine and head ----------------------------------------------------------------------------------------------


def _share(rotation: Float, share: float) -> Float:
    """The given share of a rotation, (T, 4)."""
    return quaternion.slerp(
        np.broadcast_to(np.array(quaternion.IDENTITY), rotation.shape), rotation, np.full(len(rotation), share)
    )


def _pose_trunk(sketch: Sketch, ground: Ground, pelvis: Channels, pose: Pose) -> None:
    beats = ground.beats
    chest, head = Channels(sketch, "chest", beats), Channels(sketch, "head", beats)
    stride = smoothed(_stride(ground), 0.1 * SAMPLES_PER_BEAT)
    weight = followed(ground.balance, 0.5 * SAMPLES_PER_BEAT, 0.7)
    height = pose.position[:, 0, 1]
    drop = followed(STANDING - np.clip(height, STANDING - 0.15, STANDING + 0.05), 0.45 * SAMPLES_PER_BEAT, 0.55)
    turn = chest["turn"] + 0.20 * np.tanh(stride / 0.45) + 0.15 * pelvis["turn"]
    lean = chest["lean"] + math.radians(1.0) + 0.6 * drop + 0.3 * pelvis["lean"]
    tilt = chest["tilt"] + math.radians(2.0) * weight + 0.2 * pelvis["tilt"]
    upright = _turned(ground.facing + turn, lean, tilt)
    _, hips = pose.of("hips")
    bend = quaternion.mul(quaternion.inverse(hips), upright)
    # a shift of the rib cage is an S of the spine: bent at its foot, bent back at its top
    side, front = (
        np.arcsin(np.clip(chest["left"] / 0.245, -0.8, 0.8)),
        np.arcsin(np.clip(chest["forward"] / 0.25, -0.8, 0.8)),
    )
    shift = quaternion.mul(_about(_X, front), _about(_Z, -side))
    low = quaternion.mul(quaternion.mul(hips, _share(bend, 0.3)), shift)
    pose.attach("spine", low)
    pose.attach("chest", quaternion.mul(low, _share(bend, 0.35)))
    pose.attach("upperChest", upright)
    nod = 0.9 * followed(drop, 0.3 * SAMPLES_PER_BEAT, 0.5) - 0.5 * drop
    gaze = _turned(
        ground.facing + head["turn"] + 0.2 * chest["turn"],
        head["lean"] + 0.45 * chest["lean"] + nod,
        head["tilt"] + 0.35 * chest["tilt"],
    )
    look = quaternion.mul(quaternion.inverse(upright), gaze)
    pose.attach("neck", quaternion.mul(upright, _share(look, 0.45)))
    pose.attach("head", gaze)


# --- arms --------------------------------------------------------------------------------------------------------


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
        rows = [(0.0, *rest), *[row for row in rows if row[0] > 0.0], (float(sketch.beats), *rest)]
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


def _pose_arm(sketch: Sketch, ground: Ground, pose: Pose, side: float, name: str) -> None:
    hand = _hand(sketch, f"{name}_hand", ground.beats)
    _, chest = pose.of("upperChest")
    swing = -side * 0.75 * np.tanh(followed(_stride(ground), 0.55 * SAMPLES_PER_BEAT, 0.6) / 0.6) * (1.0 - hand.keyed)
    place = hand.place * (1.0 - 0.25 * np.maximum(swing, 0.0))[:, None]  # the elbow bends on the way forward
    place = quaternion.rotate(_about(_X, -swing), place * (side, 1.0, 1.0))
    shoulder = Channels(sketch, f"{name}_shoulder", ground.beats)
    high = np.clip((place[:, 1] + 0.25) / 0.7, 0.0, 1.0)
    rise = np.arcsin(np.clip(shoulder["up"] / 0.135, -0.4, 0.7)) + math.radians(22.0) * high * high
    front = np.arcsin(np.clip(shoulder["forward"] / 0.135, -0.5, 0.6))
    clavicle = quaternion.mul(_about(_Y, -side * front), _about(_Z, side * rise))
    pose.attach(f"{name}Shoulder", quaternion.mul(chest, clavicle))
    root = pose.attach(f"{name}UpperArm", chest).copy()
    frame = quaternion.slerp(_about(_Y, ground.facing), chest, np.full(len(chest), 0.6))
    hung = 0.5 * (followed(root, 0.4 * SAMPLES_PER_BEAT, 0.6) - root)
    target = root + hung + quaternion.rotate(frame, place)
    raised = np.clip((place[:, 1:2] + 0.15) / 0.5, 0.0, 1.0) ** 2
    pole = (1.0 - raised) * (0.6, -0.6, -0.5) + raised * (0.9, -0.35, -0.25) + hand.elbow / 0.3
    pole = quaternion.rotate(frame, pole * (side, 1.0, 1.0))
    upper, lower = float(abs(_offset("leftLowerArm")[0])), float(abs(_offset("leftHand")[0]))
    elbow, wrist = two_bone(root, target, pole, upper=upper, lower=lower)
    pose.rotation[:, _joint(f"{name}UpperArm")] = bone_rotation(elbow - root, pole, side * _X, -_Z)
    forearm = bone_rotation(wrist - elbow, pole, side * _X, -_Z)
    pose.attach(f"{name}LowerArm", forearm)
    pose.attach(f"{name}Hand", _trailing(forearm, hand.wrist, side))


def _trailing(forearm: Float, wrist: Float, side: float) -> Float:
    """The hand's rotation (T, 4): the forearm's, bent by `wrist` [rad] and dragged behind quick movements."""
    along = quaternion.rotate(forearm, side * _X)
    late = quaternion.unit(followed(along, 0.35 * SAMPLES_PER_BEAT, 0.6))
    drag = _share(quaternion.from_two_vectors(along, late), 0.6)
    return quaternion.mul(drag, quaternion.mul(forearm, _about(_Z, side * wrist)))
