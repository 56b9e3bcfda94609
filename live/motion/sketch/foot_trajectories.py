"""Foot trajectories of a sketch: world placement of stances, swings, and foot roll (beats and metres)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float
from live.motion.curve import interpolate
from live.motion.skeleton import SKELETON
from live.motion.sketch.foot_plan import FAR_BEAT, Stance, place_of
from live.motion.sketch.sketch_file import Key

HOME_OUT: Final = 0.11
"""Lateral distance of the ankle from the middle in the neutral stance [m]."""
HOME_FORWARD: Final = -0.03
HOME_TURN: Final = math.radians(10.0)
"""Turn-out of the toes in the neutral stance [rad]."""
BALL_FORWARD: Final = float(SKELETON.offsets[SKELETON.index("leftToes"), 2])
HEEL_TO_BALL: Final = BALL_FORWARD + 0.05
"""Distance from heel to ball of the foot, the two pivots of its roll [m]."""
_MAX_TWIST: Final = math.radians(25.0)
_MAX_LEAD: Final = math.radians(30.0)
_MIN_FOOT_GAP: Final = 0.15
_MIN_LIFT: Final = 0.025
_MAX_LIFT: Final = 0.12
"""Range of the lift of a swing without a given lift [m]."""
_LIFT_BEATS: Final = 0.2
_LIFT_SHARE: Final = 0.85
"""_SOON beats after take-off and before landing a foot is at the share _NEARLY of its lift."""
_LOW_HEIGHT: Final = 0.05
"""A foot lower than this [m] appears to slide when it moves horizontally."""
_MAX_LOW_DISTANCE: Final = 0.018
"""Maximum distance of a low foot from its previous or next place [m]."""
_MAX_VERTICAL_SHARE: Final = 0.35
"""Maximum share of half a swing, or of the time to a key in the air, for vertical motion."""


@dataclass(frozen=True, slots=True, eq=False)
class FootTrack:
    """One foot over T samples."""

    ball: Float
    """World position of the ball, projected on the floor [m], shape (T, 2) (x, z)."""
    height: Float
    """Height of the sole at the ball above the floor [m], (T,)."""
    yaw: Float
    """Heading of the toes [rad], (T,)."""
    heel: Float
    """Rotation of the heel about the ball [rad], (T,)."""
    toe: Float
    """Rotation of the toes about the heel [rad], (T,)."""
    support_point: Float
    """Current or next support point, under the ankle or, with the heel up, the ball [m], (T, 2)."""
    contact: Bool
    stance_weight: Float
    """1 in stance, 0 in the air, smooth between, (T,)."""
    air_weight: Float
    """1 in a swing through keys in the air, which the pelvis need not follow, else 0, smooth between, (T,)."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyPath:
    """Path of the whole body: its facing [rad] at given beats, and its displacement per beat [m] (x, z)."""

    facing: Callable[[Float], Float]
    per_beat: tuple[float, float]

    def world(self, beats: Float, facing: Float, places: Float, side: float) -> Float:
        """Ankle x, z and heading (K, 3) of a foot with `places` (K, 3) from a body with `facing` (K,) at `beats`."""
        x, z = side * (HOME_OUT + places[:, 0]), HOME_FORWARD + places[:, 1]
        sine, cosine = np.sin(facing), np.cos(facing)
        return np.stack(
            (
                x * cosine + z * sine + beats * self.per_beat[0],
                z * cosine - x * sine + beats * self.per_beat[1],
                facing + side * (HOME_TURN + places[:, 2]),
            ),
            axis=1,
        )

    def stance_facing(self, own: list[Stance]) -> tuple[Float, Float]:
        """Return the beat on which the body is over each stance (K,), and the body facing for which it is placed (K,).

        A foot is placed for the facing at the middle of its stance, at most 30° ahead of the body on arrival.
        """
        middles = np.array([stance.middle if abs(stance.middle) < FAR_BEAT / 4 else 0.0 for stance in own])
        arrivals = np.array([max(stance.arrive, -FAR_BEAT / 4) for stance in own])
        arriving = self.facing(arrivals)
        return middles, arriving + np.clip(self.facing(middles) - arriving, -_MAX_LEAD, _MAX_LEAD)


def place_stances(path: BodyPath, own: list[Stance], side: float) -> Float:
    """Return world ankle x, z and heading (K, 3) of each stance: directly under the body at its middle."""
    middles, facing = path.stance_facing(own)
    return path.world(middles, facing, np.array([stance.place for stance in own]), side)


def separate_feet(left: list[Stance], left_world: Float, right: list[Stance], right_world: Float) -> None:
    """Shift stances along x, in place, so that the legs do not cross in a step that travels sideways.

    Feet planted at the same time keep 15 cm, or the sketch's own distance; both are shifted equally.
    """
    pairs = [
        (i, j, min(_MIN_FOOT_GAP, 2.0 * HOME_OUT + a.place[0] + b.place[0]))
        for i, a in enumerate(left)
        for j, b in enumerate(right)
        if a.arrive < b.leave + 0.25 and b.arrive < a.leave + 0.25
    ]
    if not pairs:
        return
    i, j = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    gap = np.array([pair[2] for pair in pairs])
    # the same stance moves equally in every repetition
    numbers = [np.unique([stance.number for stance in own], return_inverse=True)[1] for own in (left, right)]
    for _ in range(200):
        lack = np.maximum(gap - left_world[i, 0] + right_world[j, 0], 0.0)
        if lack.max() < 1e-4:
            break
        # all stances move at once, so that equal steps stay equal
        for world, own, pair, way in ((left_world, numbers[0], i, 0.5), (right_world, numbers[1], j, -0.5)):
            most = np.zeros(own.max() + 1)
            np.maximum.at(most, own[pair], lack)
            world[:, 0] += way * most[own]


def foot_track(
    path: BodyPath, own: list[Stance], world: Float, side: float, beats: Float, leaps: list[tuple[float, float]]
) -> FootTrack:
    """Return the foot's trajectory at `beats` (T,) through stances at `world` (K, 3); `leaps`: spans in the air."""
    ball = world.copy()
    ball[:, 0] += BALL_FORWARD * np.sin(world[:, 2])
    ball[:, 1] += BALL_FORWARD * np.cos(world[:, 2])
    up = _heights(own, world)
    times, ground_times, places, ground = [], [], [], []
    landed = 0.0
    for index, stance in enumerate(own):
        following = own[index + 1] if index + 1 < len(own) else None
        above = _air_points(path, stance, following, side) if following and stance.air else np.zeros((0, 4))
        lifted = landing = 0.0
        if following:
            ends = (stance.leave, *ball[index, :2]), *above[:, :3], (following.arrive, *ball[index + 1, :2])
            lifted, landing = _vertical_beats(up, np.array(ends), stance.leave, following.arrive)
        times += [stance.arrive - landed, min(stance.leave, FAR_BEAT) + lifted, *above[:, 0]]
        ground_times += [stance.arrive, min(stance.leave, FAR_BEAT)]
        places += [ball[index], ball[index], *above[:, 1:]]
        ground += [ball[index], ball[index]]
        landed = landing
    way = interpolate(np.array(times), np.array(places), beats)
    stand = interpolate(np.array(ground_times), np.array(ground), beats)
    pivot, heel, firm = _pivot(path, own, beats), _heel(own, world, beats, leaps), _stance_weight(own, beats, plain=0.0)
    behind = BALL_FORWARD - 0.09 * firm * np.minimum(heel / math.radians(20.0), 1.0)
    yaw = stand[:, 2] + pivot
    contact = np.zeros(len(beats), np.bool_)
    for stance in own:
        contact |= (beats >= stance.arrive - 1e-6) & (beats <= stance.leave + 1e-6)
    return FootTrack(
        ball=way[:, :2],
        height=interpolate(up[:, 0], up[:, 1], beats),
        yaw=way[:, 2] + pivot,
        heel=heel,
        toe=_toe(own, beats),
        support_point=stand[:, :2] - behind[:, None] * np.stack((np.sin(yaw), np.cos(yaw)), axis=1),
        contact=contact,
        stance_weight=firm,
        air_weight=1.0 - _stance_weight(own, beats, plain=1.0),
    )


def _heights(own: list[Stance], world: Float) -> Float:
    """Return beats and heights of the sole [m] through all stances and swings, (K, 2)."""
    heights = []
    for index, stance in enumerate(own):
        heights += [(stance.arrive, 0.0), (min(stance.leave, FAR_BEAT), 0.0)]
        if stance.air:
            heights += [(key.beat, key.amounts["up"]) for key in stance.air]
        elif index + 1 < len(own):
            heights += _swing_heights(stance, own[index + 1], world[index], world[index + 1])
    return np.array(heights)


def _vertical_beats(up: Float, ways: Float, leave: float, arrive: float) -> tuple[float, float]:
    """Return for how many beats a foot moves vertically after take-off and before landing.

    The foot stays within _NEAR of its place while it is low; otherwise it would skate (GMD). `up` (K, 2) as from
    `_heights`; `ways` (M, 3) beat, x and z [m] from departure to arrival. A foot with low keys in the air moves
    horizontally at once.
    """
    middle = 0.5 * (leave + arrive)
    straight = []
    for here, there in ((ways[0], ways[1]), (ways[-1], ways[-2])):
        span = abs((there[0] if len(ways) > 2 else middle) - here[0])
        at = np.linspace(0.0, span, 65)
        high = interpolate(up[:, 0], up[:, 1], here[0] + np.copysign(at, middle - here[0])) >= _LOW_HEIGHT
        low = at[int(np.argmax(high))]
        # a curve with zero slope at its key has covered at most 3 u² of its distance after the share u of its time
        near = math.sqrt(_MAX_LOW_DISTANCE / 3.0 / max(math.hypot(*(there - here)[1:]), _MAX_LOW_DISTANCE))
        near *= span if len(ways) > 2 else 2.0 * span
        straight.append(min(max(low - near, 0.0), _MAX_VERTICAL_SHARE * span))
    return straight[0], straight[1]


def _air_points(path: BodyPath, stance: Stance, following: Stance, side: float) -> Float:
    """Return beat, ball x, z and heading (K, 4) of keys in the air, with extra points if the body turns."""
    keys = [(stance.leave, *stance.place), *[(key.beat, *place_of(key)) for key in stance.air]]
    table = np.array([*keys, (following.arrive, *following.place)])
    turned = float(np.ptp(path.facing(table[:, 0])))
    moments = table[1:-1, 0]
    if turned > 0.5:
        inner = np.linspace(stance.leave, following.arrive, 2 + int(turned / 0.4))[1:-1]
        moments = np.unique(np.concatenate((moments, inner[np.abs(inner[:, None] - moments).min(axis=1) > 0.05])))
    places = np.stack([np.interp(moments, table[:, 0], column) for column in table.T[1:]], axis=1)
    world = path.world(moments, path.facing(moments), places, side)
    world[:, 0] += BALL_FORWARD * np.sin(world[:, 2])
    world[:, 1] += BALL_FORWARD * np.cos(world[:, 2])
    return np.concatenate((moments[:, None], world), axis=1)


def _swing_heights(stance: Stance, following: Stance, start: Float, end: Float) -> list[tuple[float, float]]:
    """Return beats and heights [m] of a swing from `start` to `end`: early rise, late descent, so it does not skim."""
    span = following.arrive - stance.leave
    lift = _lift(stance, math.hypot(end[0] - start[0], end[1] - start[1]))
    soon = min(_LIFT_BEATS, 0.4 * span)
    return [
        (stance.leave + soon, _LIFT_SHARE * lift),
        (stance.leave + 0.5 * span, lift),
        (following.arrive - soon, _LIFT_SHARE * lift),
    ]


def _lift(stance: Stance, way: float) -> float:
    """Return the lift of a swing over `way` [m]: as given, but over 5 cm for fast swings (GMD's skating)."""
    return max(_MIN_LIFT if stance.lift is None else stance.lift, min(0.5 * way, 0.055 + 0.08 * way, _MAX_LIFT))


def _pivot(path: BodyPath, own: list[Stance], beats: Float) -> Float:
    """Return the pivot of the foot on its ball where the body turns further than the hips allow."""
    times = np.array([at for stance in own for at in (stance.arrive, min(stance.leave, FAR_BEAT))])
    twist = path.facing(beats) - interpolate(times, np.repeat(path.stance_facing(own)[1], 2), beats)
    on_ball = [0.0 if any(_toe_angle(key) for key in stance.contacts) else 1.0 for stance in own]
    return np.asarray(
        (twist - _MAX_TWIST * np.tanh(twist / _MAX_TWIST)) * interpolate(times, np.repeat(on_ball, 2), beats)
    )


def _angle(centimetres_up: float) -> float:
    return math.asin(min(max(centimetres_up, 0.0) / HEEL_TO_BALL, 0.95))


def _heel(own: list[Stance], world: Float, beats: Float, leaps: list[tuple[float, float]]) -> Float:
    keys: list[tuple[float, float]] = []
    for index, stance in enumerate(own):
        leaping = any(abs(stance.leave - start) < 0.3 for start, _ in leaps)
        landing = any(abs(stance.arrive - end) < 0.3 for _, end in leaps)
        said = _rolls(stance, _heel_angle)
        on_toes = landing and _toe_angle(stance.contacts[0]) == 0.0
        keys.append((stance.arrive, math.radians(25.0) if on_toes else said[0][1]))
        if on_toes:
            keys.append((stance.arrive + 0.2, said[0][1]))
        keys.extend(said[1:])
        if index + 1 == len(own):
            break
        away = math.hypot(*(world[index + 1] - world[index])[:2])
        if _toe_angle(stance.contacts[-1]) > 0.0:  # the foot leaves from the heel
            keys.append((stance.leave, 0.0))
            continue
        roll = math.radians(35.0) if leaping else math.radians(min(10.0 + 55.0 * away, 32.0))
        keys.append((stance.leave - min(0.35, 0.7 * (stance.leave - keys[-1][0])), keys[-1][1]))
        keys.append((stance.leave, max(roll, keys[-1][1])))
        for key in stance.air:
            point = math.radians(40.0 if leaping else 15.0)
            keys.append((key.beat, _angle(key.amounts["heel"]) if "heel" in key.amounts else point))
    return _angles(keys, beats)


def _rolls(stance: Stance, said: Callable[[Key], float]) -> list[tuple[float, float]]:
    """Return beats and angles of a stance's keys, with a flat foot between heel and toe keys."""
    rolls = [(stance.contacts[0].beat, said(stance.contacts[0]))]
    for before, after in pairwise(stance.contacts):
        if (_heel_angle(before) and _toe_angle(after)) or (_toe_angle(before) and _heel_angle(after)):
            rolls.append((0.5 * (before.beat + after.beat), 0.0))
        rolls.append((after.beat, said(after)))
    return rolls


def _toe_angle(key: Key) -> float:
    return _angle(key.amounts.get("toe", 0.0))


def _heel_angle(key: Key) -> float:
    if "heel" in key.amounts:
        return _angle(key.amounts["heel"])
    return math.radians(14.0) if "touch" in key.amounts and "toe" not in key.amounts else 0.0


def _toe(own: list[Stance], beats: Float) -> Float:
    keys: list[tuple[float, float]] = []
    for stance in own:
        keys.extend(_rolls(stance, _toe_angle))
        keys.append((min(stance.leave, FAR_BEAT), keys[-1][1]))
        keys.extend((key.beat, _toe_angle(key)) for key in stance.air)
    return _angles(keys, beats)


def _angles(keys: list[tuple[float, float]], beats: Float) -> Float:
    increasing = [keys[0]]
    for at, value in keys[1:]:
        if at > increasing[-1][0] + 0.01:
            increasing.append((at, value))
    table = np.array(increasing)
    return np.maximum(interpolate(table[:, 0], table[:, 1], beats), 0.0)


def _stance_weight(own: list[Stance], beats: Float, *, plain: float) -> Float:
    """Return 1 in stances, 0 in the middle of swings through keys in the air, `plain` in that of others, (T,)."""
    keys: list[tuple[float, float]] = []
    for index, stance in enumerate(own):
        if index:
            before = own[index - 1]
            level = 0.0 if before.air else plain
            keys.append((before.leave + 0.35 * (stance.arrive - before.leave), level))
            keys.append((before.leave + 0.55 * (stance.arrive - before.leave), level))
        keys.append((stance.arrive, 1.0))
        keys.append((min(stance.leave, FAR_BEAT), 1.0))
    table = np.array(keys)
    return interpolate(table[:, 0], table[:, 1], beats)
