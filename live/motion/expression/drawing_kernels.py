"""Faces and hands of a frame, from the state of the last tick and the drawn poses."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.body.expression import (
    BLINK_LEFT,
    BLINK_RIGHT,
    BROW,
    EFFORT,
    GAZE_PITCH,
    GAZE_YAW,
    SPREAD,
)
from live.base.body.hand_shapes import FLAT, HOLD, RELAXED
from live.base.jit import inline_kernel, kernel
from live.motion.expression.dance_kernels import HEAD_JOINT
from live.motion.expression.face_kernels import (
    BLINK_AGE,
    BLINK_S,
    KIND,
    LAST_KIND,
    LAST_OTHER,
    LAST_TARGET,
    LEAD,
    OTHER,
    SACCADE_AGE,
    SACCADE_S,
    TARGET,
    mixed,
)
from live.motion.expression.gaze_kernels import AHEAD, DANCER, LEFT_HAND
from live.motion.expression.hand_kernels import SOFT, SPEED, VALUE

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

YAW_LIMIT = math.radians(35.0)
"""Eyes turn so far to both sides [rad], ..."""
UP_LIMIT, DOWN_LIMIT = math.radians(20.0), math.radians(25.0)
"""... so far up and down [rad]."""
KNEE = 0.7
"""From this share of a limit on eyes turn less than their target moves."""
SEEN_COSINE, GONE_COSINE = 0.5, -0.42
"""Eyes let go of a target that is from 60 to 115 degrees aside of the face, by the cosines of these angles."""
EYES_UP, EYES_FORWARD = 0.07, 0.085
"""The eyes from the head's joint [m]."""
FAST_TURN, FASTER_TURN = 0.7, 2.4
"""From a turn of the head by so much in `dance_kernels.LEAD_S` on [rad], eyes go where the head goes, then wholly."""
DRIFT_S, DRIFT_JUMP_S = 0.55, 0.03
"""Within a fixation the eyes jump a little so often, in so much time [s], ..."""
DRIFT = math.radians(1.6)
"""... by so much at most [rad]."""
CLOSING, CLOSED = 0.32, 0.44
"""Shares of a blink after which the lids are closed, and begin to open."""
LEFT_SHOULDER, RIGHT_SHOULDER, LEFT_WRIST, RIGHT_WRIST = 7, 11, 9, 13
"""Joints of upper arms and hands."""
ARM_LENGTH = 0.51
"""Upper arm and forearm [m]."""
REACHING = 0.86
"""Share of the arm's length from which on soft fingers straighten ..."""
STRAIGHTENING = 0.55
"""... by so much of their curl, ..."""
HANGING, RAISED = -0.9 * ARM_LENGTH, -0.5 * ARM_LENGTH
"""... unless the arm hangs: by the height of the hand over the shoulder [m]."""
FLOOR_FROM, FLOOR_AT = 0.24, 0.11
"""Hands whose wrists come so near to the floor [m] begin to lie flat, and are flat."""
_SCALE: Any = DRIFT / 32768.0
_PER_COSINE: Any = 1.0 / (SEEN_COSINE - GONE_COSINE)
_NEAR: Any = (REACHING * ARM_LENGTH) ** 2
_PER_RAISED: Any = 1.0 / (RAISED - HANGING)
_PER_REACH: Any = 1.0 / (ARM_LENGTH**2 - (REACHING * ARM_LENGTH) ** 2)


@inline_kernel
def _smooth(t: float) -> float:
    """Return the smooth step of t clamped to [0, 1]."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@inline_kernel
def _limited(angle: float, limit: float) -> float:
    """Return an angle that approaches `limit` softly from KNEE of it on."""
    size, knee = abs(angle), KNEE * limit
    if size <= knee:
        return angle
    over = (size - knee) / (limit - knee)
    return math.copysign(knee + (limit - knee) * over / (1.0 + over), angle)


@inline_kernel
def _arcsine(sine: float) -> float:
    """Return the arcsine by its series: beyond 50 degrees, where it is too short, eyes are at their limit."""
    return sine * (1.0 + sine * sine * (1.0 / 6.0 + 0.075 * sine * sine))


# No array is handed from these loops to an inlined function: counting its references takes longer than all else.


@kernel("void(f4[:,::1], f4[:,:,::1], b1[::1], f4[:,:,::1], b1[::1], f4[:,::1], f4[:,::1], f8[::1], f8, i8, i8)")
def _rest_far(
    face: Float32, hand: Float32, near: Bool, position: Float32, there: Bool, slow: Float32, shapes: Float32,
    eye: Float64, far: float, begin: int, end: int,
) -> None:  # fmt: skip
    """Write who is `near` (A,) and there, and the expressions of the others, who rest; near faces get what is slow."""
    square = far * far
    for i in range(begin, end):
        x, y, z = position[i, 0, 0] - eye[0], position[i, 0, 1] - eye[1], position[i, 0, 2] - eye[2]
        near[i] = there[i] and x * x + y * y + z * z < square
        if near[i]:
            for c in range(BROW, EFFORT + 1):
                face[i, c] = slow[i, c]
        else:
            for c in range(EFFORT + 1):
                face[i, c] = 0.0
            for c in range(SPREAD + 1):
                hand[i, 0, c] = hand[i, 1, c] = shapes[RELAXED, c]


@kernel("void(f4[:,::1], b1[::1], f4[:,:,::1], f4[:,:,::1], f4[:,::1], i4[:,::1], f8, i8, i8)")
def _turn_eyes(
    face: Float32, near: Bool, position: Float32, rotation: Float32, number: Float32, choice: Int32, age: float,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Write where the eyes of the near stand in their heads, `age` [s] after the tick, without drift."""
    for i in range(begin, end):
        if not near[i]:
            continue
        since, saccade, lead = number[i, SACCADE_AGE] + age, number[i, SACCADE_S], number[i, LEAD]
        qw, qx = rotation[i, HEAD_JOINT, 0], rotation[i, HEAD_JOINT, 1]
        qy, qz = rotation[i, HEAD_JOINT, 2], rotation[i, HEAD_JOINT, 3]
        yaw = pitch = goal_yaw = goal_pitch = 0.0
        for before in range(2 if since < saccade else 1):
            kind, other, target = choice[i, KIND], choice[i, OTHER], TARGET
            if before:
                kind, other, target = choice[i, LAST_KIND], choice[i, LAST_OTHER], LAST_TARGET
                goal_yaw, goal_pitch = yaw, pitch
            if kind == AHEAD:
                yaw, pitch = _limited(lead, YAW_LIMIT), 0.0
                continue
            row, joint = other if kind == DANCER else i, HEAD_JOINT
            if kind >= LEFT_HAND:
                joint = LEFT_WRIST if kind == LEFT_HAND else RIGHT_WRIST
            if kind >= DANCER:
                x, y, z = position[row, joint, 0], position[row, joint, 1], position[row, joint, 2]
            else:
                x, y, z = number[i, target], number[i, target + 1], number[i, target + 2]
            x, y, z = x - position[i, HEAD_JOINT, 0], y - position[i, HEAD_JOINT, 1], z - position[i, HEAD_JOINT, 2]
            # into the head's axes: left, up, forward
            a, b, c = 2.0 * (qz * y - qy * z), 2.0 * (qx * z - qz * x), 2.0 * (qy * x - qx * y)
            own = 0.0 if kind == DANCER else 1.0  # another's eyes are as far from the joint
            left = x + qw * a + qz * b - qy * c
            up = y + qw * b + qx * c - qz * a - own * EYES_UP
            forward = z + qw * c + qy * a - qx * b - own * EYES_FORWARD
            level = left * left + forward * forward + 1e-9
            per_level, per_way = 1.0 / math.sqrt(level), 1.0 / math.sqrt(level + up * up)
            gain = _smooth((forward * per_way - GONE_COSINE) * _PER_COSINE)
            yaw, pitch = _limited(gain * _arcsine(left * per_level), YAW_LIMIT), gain * _arcsine(up * per_way)
            pitch = _limited(pitch, UP_LIMIT if pitch > 0.0 else DOWN_LIMIT)
        if since < saccade:
            share = _smooth(since / saccade)
            yaw, pitch = yaw + share * (goal_yaw - yaw), pitch + share * (goal_pitch - pitch)
        turning = _smooth(
            (abs(lead) - FAST_TURN) * (1.0 / (FASTER_TURN - FAST_TURN))
        )  # nothing can be held in a fast turn
        face[i, GAZE_YAW] = yaw + turning * (_limited(lead, YAW_LIMIT) - yaw)
        face[i, GAZE_PITCH] = (1.0 - turning) * pitch


@kernel("void(f4[:,::1], b1[::1], f4[:,::1], i8, f8, f8, i8, i8)")
def _add_drift_and_blinks(
    face: Float32, near: Bool, number: Float32, seed: int, age: float, time: float, begin: int, end: int
) -> None:
    """Add the small saccades within a fixation at `time` [s] to the eyes of the near, and write their lids."""
    for i in range(begin, end):
        if not near[i]:
            continue
        cell = time * (1.0 / DRIFT_S) + 0.381966 * i  # each dancer at other times
        k = int(cell)
        jump, key = (cell - k) * (DRIFT_S / DRIFT_JUMP_S), seed + 0x9E3779B * i
        bits = mixed(key + 0x61C8865 * k)
        aside, above = float((bits & 0xFFFF) - 32768), float((bits >> 16) - 32768)
        if jump < 1.0:
            bits, share = mixed(key + 0x61C8865 * (k - 1)), 1.0 - _smooth(jump)
            aside += share * (float((bits & 0xFFFF) - 32768) - aside)
            above += share * (float((bits >> 16) - 32768) - above)
        face[i, GAZE_YAW] = min(max(face[i, GAZE_YAW] + _SCALE * aside, -YAW_LIMIT), YAW_LIMIT)
        face[i, GAZE_PITCH] = min(max(face[i, GAZE_PITCH] + 0.5 * _SCALE * above, -DOWN_LIMIT), UP_LIMIT)
        at, closed = (number[i, BLINK_AGE] + age) * (1.0 / BLINK_S), 0.0
        if at < 1.0:
            closed = _smooth(at / CLOSING if at < CLOSING else (1.0 - at) / (1.0 - CLOSED))
        face[i, BLINK_LEFT] = face[i, BLINK_RIGHT] = closed


@kernel("void(f4[:,:,::1], b1[::1], f4[:,:,::1], f4[:,:,:,::1], f4[:,::1], f4[:,::1], f8, i8, i8)")
def _curl_fingers(
    hand: Float32, near: Bool, position: Float32, hands: Float32, shapes: Float32, held: Float32, age: float,
    begin: int, end: int,
) -> None:  # fmt: skip
    """Write the hands of the near: as eased, straighter with the arm, flat on the floor, closed in a hold."""
    later, held_hands = np.float32(age), held.shape[0] > 0
    for i in range(begin, end):
        if not near[i]:
            continue
        for side in range(2):
            shoulder, wrist = LEFT_SHOULDER, LEFT_WRIST
            if side:
                shoulder, wrist = RIGHT_SHOULDER, RIGHT_WRIST
            x = position[i, wrist, 0] - position[i, shoulder, 0]
            y = position[i, wrist, 1] - position[i, shoulder, 1]
            z = position[i, wrist, 2] - position[i, shoulder, 2]
            straight = STRAIGHTENING * _smooth((x * x + y * y + z * z - _NEAR) * _PER_REACH)
            straight *= _smooth((y - HANGING) * _PER_RAISED)
            # a tick later at most: the speeds of the columns are enough
            soft = hands[VALUE, i, side, SOFT] + hands[SPEED, i, side, SOFT] * age
            curled = np.float32(1.0 - straight * soft)
            for c in range(SPREAD):
                hand[i, side, c] = curled * (hands[VALUE, i, side, c] + later * hands[SPEED, i, side, c])
            hand[i, side, SPREAD] = hands[VALUE, i, side, SPREAD] + later * hands[SPEED, i, side, SPREAD]
            share = float(held[i, side]) if held_hands else 0.0
            if position[i, wrist, 1] < FLOOR_FROM or share > 0.0:
                flat = (1.0 - share) * _smooth((FLOOR_FROM - position[i, wrist, 1]) / (FLOOR_FROM - FLOOR_AT))
                kept = 1.0 - share - flat
                for c in range(SPREAD + 1):
                    hand[i, side, c] = kept * hand[i, side, c] + share * shapes[HOLD, c] + flat * shapes[FLAT, c]


@kernel(
    "void(f4[:,::1], f4[:,:,::1], f4[:,:,::1], f4[:,:,::1], b1[::1], f4[:,::1], i4[:,::1], f4[:,::1], f4[:,:,:,::1],"
    " f4[:,::1], f4[:,::1], f8[::1], f8, i8, f8, f8, i8, i8)"
)
def draw_expressions(
    face: Float32, hand: Float32, position: Float32, rotation: Float32, there: Bool, number: Float32, choice: Int32,
    slow: Float32, hands: Float32, shapes: Float32, held: Float32, eye: Float64, far: float, seed: int, age: float,
    time: float, begin: int, end: int,
) -> None:  # fmt: skip
    """Write `face` (A, FACE_SIZE) and `hand` (A, 2, HAND_SIZE) of the dancers begin..end-1, `age` [s] after the tick.

    In: drawn poses `position` (A, J, 3) [m] and `rotation` (A, J, 4), who is `there` (A,), states `number`, `choice`,
    `slow` and `hands`, `shapes` (K, 6), how far hands are in a hold `held` (A, 2) or (0, 2), and the show's `time` [s].
    Dancers farther from `eye` (3,) than `far` [m] have faces at rest and relaxed hands.
    """
    near = np.empty(there.shape[0], np.bool_)
    _rest_far(face, hand, near, position, there, slow, shapes, eye, far, begin, end)
    _turn_eyes(face, near, position, rotation, number, choice, age, begin, end)
    _add_drift_and_blinks(face, near, number, seed, age, time, begin, end)
    _curl_fingers(hand, near, position, hands, shapes, held, age, begin, end)
