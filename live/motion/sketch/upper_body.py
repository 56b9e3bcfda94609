"""Building blocks for the poses of a sketch: key channels as smooth functions of beats, the pose, and the arms.

Arms follow their keys or hang with a counter-swing. They have weight: elbows hang, and hands and elbows arrive a little
late and follow through.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.curve import (
    gaussian_filter,
    hermite,
    interpolate,
    monotone_slopes,
    repeat_keys,
    smoothstep,
    spring_response,
)
from live.motion.pose.body_capsules import FOREARM_RADIUS, TRUNK_HALF_DEPTH, TRUNK_HALF_WIDTH
from live.motion.pose.two_bone_ik import bone_rotation, hinge_axis, two_bone
from live.motion.skeleton import SKELETON
from live.motion.sketch.foot_trajectories import FootTrack
from live.motion.sketch.sketch_file import Key, Sketch

SAMPLES_PER_BEAT: Final = 32
_KEY_SMOOTHING: Final = 0.05 * SAMPLES_PER_BEAT
"""Standard deviation [samples] of the smoothing of keys; it does not shift them in time."""


class Channels:
    """The amounts of one part at `beats` (T,) by channel; channels without keys are zero."""

    def __init__(self, sketch: Sketch, part: str, beats: Float) -> None:
        self.keys = sketch.parts.get(part, ())
        self.sketch = sketch
        self.beats = beats
        self.named = {name for key in self.keys for name in key.amounts} - {"neutral"}

    def __getitem__(self, channel: str) -> Float:
        if channel not in self.named:
            return np.zeros(len(self.beats))
        keys = [(key.beat, key.amounts.get(channel, 0.0)) for key in self.keys if _has_channel(key, channel)]
        times, values = extend_keys(self.sketch, keys, self.beats)
        return gaussian_filter(interpolate(times, values, self.beats), _KEY_SMOOTHING)


def _has_channel(key: Key, channel: str) -> bool:
    return channel in key.amounts or "neutral" in key.amounts


def extend_keys(sketch: Sketch, keys: list[tuple[float, float]], beats: Float) -> tuple[Float, Float]:
    """Return times and values of keys (beat, amount) repeated over `beats`, or from and to zero if not cyclic."""
    if sketch.cyclic:
        table = np.array(keys)
        return repeat_keys(table[:, 0], table[:, 1], sketch.beats, 0.0, beats)
    table = np.array([(0.0, 0.0), *keys, (float(sketch.beats), 0.0)])
    return table[:, 0], table[:, 1]


def facing_keys(sketch: Sketch) -> tuple[Float, float]:
    """Return keys (K, 2) of the whole body's facing (beat, rad), and its total turn over the step."""
    keys = [(key.beat, key.amounts["turn"]) for key in sketch.parts.get("body", ()) if "turn" in key.amounts]
    if not keys or keys[0][0] > 0.0:
        keys.insert(0, (0.0, 0.0))
    return np.array(keys), keys[-1][1] - keys[0][1]


def facing(sketch: Sketch, at: Float) -> Float:
    """Return the facing of the whole body [rad] at the beats `at` (K,), accumulated over repetitions."""
    keys, turned = facing_keys(sketch)
    if len(keys) == 1:
        return np.full(len(at), keys[0, 1])
    if not sketch.cyclic:
        return interpolate(keys[:, 0], keys[:, 1], at)
    span = np.array((min(at.min(), 0.0), max(at.max(), 0.0)))
    times, values = repeat_keys(keys[:, 0], keys[:, 1], sketch.beats, turned, span)
    return hermite(times, values, monotone_slopes(times, values), at)


X_AXIS, Y_AXIS, Z_AXIS = np.eye(3)


def joint_index(name: str) -> int:
    """Return the index of a joint of the engine's skeleton."""
    return SKELETON.index(name)


def offset_of(name: str) -> Float:
    """Return the joint's offset from its parent in the rest pose [m], (3,)."""
    return np.asarray(SKELETON.offsets[joint_index(name)], np.float64)


def axis_rotation(axis: Float, angle: Float) -> Float:
    """Return rotations (T, 4) by `angle` [rad] (T,) about a fixed axis (3,)."""
    return quaternion.from_axis_angle(axis, angle)


def body_rotation(turn: Float, lean: Float, tilt: Float) -> Float:
    """Return rotations (T, 4) of angles (T,): turn (left positive) about the vertical, lean forward, tilt left."""
    return quaternion.mul(
        axis_rotation(Y_AXIS, turn), quaternion.mul(axis_rotation(X_AXIS, lean), axis_rotation(Z_AXIS, -tilt))
    )


def rotation_share(rotation: Float, share: float) -> Float:
    """Return the given share of a rotation, (T, 4)."""
    return quaternion.slerp(
        np.broadcast_to(np.array(quaternion.IDENTITY), rotation.shape), rotation, np.full(len(rotation), share)
    )


@dataclass(slots=True, eq=False)
class Pose:
    """World positions and rotations of the joints while a pose is built, (T, J, 3) and (T, J, 4)."""

    position: Float
    rotation: Float

    def attach(self, name: str, rotation: Float) -> Float:
        """Attach the joint to its parent with the given world rotation; return its world position (T, 3)."""
        joint = joint_index(name)
        parent = int(SKELETON.parents[joint])
        offset = quaternion.rotate(self.rotation[:, parent], offset_of(name))
        self.position[:, joint] = self.position[:, parent] + offset
        self.rotation[:, joint] = rotation
        return self.position[:, joint]

    def transform_of(self, name: str) -> tuple[Float, Float]:
        """Return world position and rotation of a joint."""
        return self.position[:, joint_index(name)], self.rotation[:, joint_index(name)]


@dataclass(frozen=True, slots=True, eq=False)
class FootSupport:
    """Foot tracks, facing and weight distribution over T samples, the input for the body pose."""

    beats: Float
    facing: Float
    balance: Float
    left: FootTrack
    right: FootTrack
    flights: list[tuple[float, float]]


def stride_of(ground: FootSupport) -> Float:
    """Return how far the left foot is in front of the right one in body axes [m], (T,)."""
    apart = ground.left.support_point - ground.right.support_point
    return np.asarray(apart[:, 0] * np.sin(ground.facing) + apart[:, 1] * np.cos(ground.facing))


_REST_HAND: Final = np.array((0.115, -0.44, 0.075))
"""Position of a relaxed hand relative to its shoulder: out, up, forward [m]."""

_HANGING: Final = float(np.linalg.norm(_REST_HAND))
"""Distance of a relaxed hand from its shoulder [m]: where no height is written, a hand hangs that far away."""
_LOW_ELBOW: Final = np.array((0.45, -0.4, -0.9))
_LEVEL_ELBOW: Final = np.array((0.5, -0.8, -0.4))
_HIGH_ELBOW: Final = np.array((0.95, -0.35, 0.0))
_TRUNK_HALF: Final = np.array((TRUNK_HALF_WIDTH, TRUNK_HALF_DEPTH)) + FOREARM_RADIUS + 0.02
"""Half width and half depth [m] of what a wrist goes around: the trunk, the forearm's thickness and a gap."""
_TRUNK_LOW, _TRUNK_HIGH = -0.62, 0.02
"""Heights over the shoulder [m] between which the trunk is in the way ..."""
_TRUNK_SOFT: Final = 0.08
"""... from this far [m] outside of them on."""
_LATE_SHARE: Final = 0.2
"""A hand is later than its keys by this share of its spring's period ..."""
_HAND_DAMPING: Final = 0.75
"""... with this damping: it goes on by a thirtieth of its way before it comes back."""
_ELBOW_PERIOD, _ELBOW_DAMPING = 0.7, 0.45
"""The elbow swings about its place with this period [beats] and damping ..."""
_MAX_ELBOW_SWING: Final = 0.4
"""... by less than this share of the upper arm."""


@dataclass(frozen=True, slots=True, eq=False)
class _Hand:
    place: Float
    """Out, up, forward from the shoulder [m], (T, 3)."""
    elbow: Float
    wrist: Float
    turn: Float
    """Turn about the forearm [rad], positive palm up, (T,)."""
    key_weight: Float
    """1 where keys set the hand, 0 where it hangs, (T,)."""


def _hand(sketch: Sketch, part: str, beats: Float) -> _Hand:
    rows, rest = [], (*_REST_HAND, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for key in sketch.parts.get(part, ()):
        a = key.amounts
        if "rest" in a:
            rows.append((key.beat, *rest))
            continue
        aside, ahead = a.get("out", 0.0), a.get("forward", 0.0)
        place = aside, a.get("up", -math.sqrt(max(_HANGING**2 - aside**2 - ahead**2, 0.0))), ahead
        elbow = a.get("elbow out", 0.0), a.get("elbow up", 0.0), a.get("elbow forward", 0.0)
        rows.append((key.beat, *place, *elbow, a.get("wrist", 0.0), a.get("turn", 0.0), 1.0))
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
    track = interpolate(times, values, beats)
    track[:, :3] = _around_trunk(track[:, :3])
    track = gaussian_filter(track, 0.055 * SAMPLES_PER_BEAT)
    if sketch.late > 0.0:
        late = spring_response(track, sketch.late / _LATE_SHARE * SAMPLES_PER_BEAT, _HAND_DAMPING) - track
        if not sketch.cyclic:  # it begins and ends at rest
            late *= smoothstep(np.minimum(beats, sketch.beats - beats) / 0.5)[:, None]
        track = track + late
    return _Hand(track[:, :3], track[:, 3:6], track[:, 6], track[:, 7], track[:, 8])


def _around_trunk(place: Float) -> Float:
    """Return places (T, 3) of a hand, out, up, forward from its shoulder [m], none of which is in the trunk.

    A hand that would go through goes around: from where it enters to where it leaves, past its own side.
    """
    middle = np.array((-(offset_of("leftShoulder") + offset_of("leftUpperArm"))[0], 0.0))
    x, z = ((place[:, (0, 2)] - middle) / _TRUNK_HALF).T
    inside = np.concatenate(([False], np.hypot(x, z) < 1.0, [False]))
    if not inside.any():
        return place
    angle = np.arctan2(z, x)
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    for begin, end in edges.reshape(-1, 2):
        ends = [angle[at] for at in (begin - 1, end) if 0 <= at < len(angle)] or [0.5 * math.pi]
        angle[begin:end] = np.linspace(ends[0], ends[-1], end - begin + 2)[1:-1]
    outside = place.copy()
    rim = np.stack((np.cos(angle), np.sin(angle)), axis=1) * _TRUNK_HALF + middle
    outside[:, ::2] = np.where(inside[1:-1, None], rim, place[:, ::2])
    height = np.maximum(_TRUNK_LOW - place[:, 1], place[:, 1] - _TRUNK_HIGH)
    share = 1.0 - smoothstep(height / _TRUNK_SOFT)
    return np.asarray(place + share[:, None] * (outside - place))


def _elbow_pole(height: Float) -> Float:
    """Return where elbows point, (T, 3) out, up, forward, for hands at `height` (T, 1) [m] over the shoulder.

    The elbow of a low arm points back, that of a level one hangs, that of a high one points out.
    """
    level, high = smoothstep((height + 0.4) / 0.3), smoothstep((height - 0.02) / 0.4)
    return np.asarray((1.0 - level) * _LOW_ELBOW + level * ((1.0 - high) * _LEVEL_ELBOW + high * _HIGH_ELBOW))


def pose_arm(sketch: Sketch, ground: FootSupport, pose: Pose, side: float, name: str) -> None:
    hand = _hand(sketch, f"{name}_hand", ground.beats)
    _, chest = pose.transform_of("upperChest")
    swing = (
        -side
        * 0.75
        * np.tanh(spring_response(stride_of(ground), 0.55 * SAMPLES_PER_BEAT, 0.6) / 0.6)
        * (1.0 - hand.key_weight)
    )
    place = hand.place * (1.0 - 0.25 * np.maximum(swing, 0.0))[:, None]  # the elbow bends in the forward swing
    place = quaternion.rotate(axis_rotation(X_AXIS, -swing), place * (side, 1.0, 1.0))
    shoulder = Channels(sketch, f"{name}_shoulder", ground.beats)
    high = np.clip((place[:, 1] + 0.25) / 0.7, 0.0, 1.0)
    rise = np.arcsin(np.clip(shoulder["up"] / 0.135, -0.4, 0.7)) + math.radians(22.0) * high * high
    front = np.arcsin(np.clip(shoulder["forward"] / 0.135, -0.5, 0.6))
    clavicle = quaternion.mul(axis_rotation(Y_AXIS, -side * front), axis_rotation(Z_AXIS, side * rise))
    pose.attach(f"{name}Shoulder", quaternion.mul(chest, clavicle))
    root = pose.attach(f"{name}UpperArm", chest).copy()
    frame = quaternion.slerp(axis_rotation(Y_AXIS, ground.facing), chest, np.full(len(chest), 0.6))
    hung = 0.5 * (spring_response(root, 0.4 * SAMPLES_PER_BEAT, 0.6) - root)
    target = root + hung + quaternion.rotate(frame, place)
    pole = gaussian_filter(_elbow_pole(place[:, 1:2]) + hand.elbow / 0.3, 0.12 * SAMPLES_PER_BEAT)
    pole = quaternion.rotate(frame, pole * (side, 1.0, 1.0))
    upper, lower = float(abs(offset_of("leftLowerArm")[0])), float(abs(offset_of("leftHand")[0]))
    elbow, _ = two_bone(root, target, pole, upper=upper, lower=lower)
    late = spring_response(elbow - root, _ELBOW_PERIOD * SAMPLES_PER_BEAT, _ELBOW_DAMPING)
    swung = (late - (elbow - root)) / upper
    swung /= np.sqrt(1.0 + np.sum(swung * swung, axis=1, keepdims=True) / _MAX_ELBOW_SWING**2)
    pole = quaternion.unit(pole) + swung
    elbow, wrist = two_bone(root, target, pole, upper=upper, lower=lower)
    hinge = hinge_axis(root, target, pole)
    pose.rotation[:, joint_index(f"{name}UpperArm")] = bone_rotation(elbow - root, hinge, side * X_AXIS, side * Y_AXIS)
    forearm = bone_rotation(wrist - elbow, hinge, side * X_AXIS, side * Y_AXIS)
    turn = axis_rotation(X_AXIS, -0.5 * hand.turn)  # half in the forearm, half in the wrist
    forearm = quaternion.mul(forearm, turn)
    pose.attach(f"{name}LowerArm", forearm)
    pose.attach(f"{name}Hand", _lagging_hand(quaternion.mul(forearm, turn), hand.wrist, side))


def _lagging_hand(forearm: Float, wrist: Float, side: float) -> Float:
    """Return the hand's rotation (T, 4): the forearm's, bent by `wrist` [rad], lagging behind fast motion."""
    along = quaternion.rotate(forearm, side * X_AXIS)
    late = quaternion.unit(spring_response(along, 0.35 * SAMPLES_PER_BEAT, 0.6))
    drag = rotation_share(quaternion.from_two_vectors(along, late), 0.6)
    return quaternion.mul(drag, quaternion.mul(forearm, axis_rotation(Z_AXIS, side * wrist)))
