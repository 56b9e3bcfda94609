"""Where the feet of a sketch stand and how they get there: places, swings, roll (beats and metres)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.curve import through
from live.motion.skeleton import SKELETON
from live.motion.sketch.foot_plan import ALWAYS, Stance, place_of
from live.motion.sketch.sketch_file import Key

Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]

HOME_OUT: Final = 0.11
"""Ankle of a foot in the neutral stance, from the middle [m]."""
HOME_FORWARD: Final = -0.03
HOME_TURN: Final = math.radians(10.0)
"""How far the toes point outwards in the neutral stance."""
BALL_FORWARD: Final = float(SKELETON.offsets[SKELETON.index("leftToes"), 2])
HEEL_TO_BALL: Final = BALL_FORWARD + 0.05
"""From the heel to the ball of the foot, the two points on which it rolls [m]."""
_PIVOT: Final = math.radians(25.0)
_AHEAD: Final = math.radians(30.0)
_GAP: Final = 0.15
_LEAST: Final = 0.025
_MOST: Final = 0.12
"""How high a foot is lifted that nobody has told, at least, and at most [m]."""
_SOON: Final = 0.2
_NEARLY: Final = 0.85
"""So many beats after it leaves the floor, and before it comes down, a foot is at this share of its height."""
_LOW: Final = 0.05
"""A foot lower than this [m] seems to slide where it moves over the floor."""
_NEAR: Final = 0.018
"""It is no farther than this [m] from where it stood or will stand."""
_STRAIGHT: Final = 0.35
"""Straight up, and straight down, take so much of the half of a swing at most, or of the way to a key in the air."""


@dataclass(frozen=True, slots=True, eq=False)
class FootTrack:
    """One foot over T samples."""

    ball: Float
    """World position of the ball, projected on the floor [m], shape (T, 2) (x, z)."""
    height: Float
    """Of the sole under the ball over the floor [m], (T,)."""
    yaw: Float
    """Heading of the toes [rad], (T,)."""
    heel: Float
    """Heel lifted about the ball [rad], (T,)."""
    toe: Float
    """Toes lifted about the heel [rad], (T,)."""
    ground: Float
    """Where it carries or is about to carry the body, under the ankle or, with the heel up, the ball [m], (T, 2)."""
    contact: Bool
    firm: Float
    """1 while it stands, 0 in the air, smooth between, (T,)."""
    free: Float
    """1 where a key leads it through the air and the pelvis need not follow, else 0, smooth between, (T,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """How the body as a whole goes: its facing [rad] at given beats, and its displacement per beat [m] (x, z)."""

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

    def standing(self, own: list[Stance]) -> tuple[Float, Float]:
        """Beat on which the body is over each stance (K,), and the facing that its foot is set down for (K,).

        A foot is set down for the facing in the middle of its time, but turns ahead of the body by 30° at most.
        """
        middles = np.array([stance.middle if abs(stance.middle) < ALWAYS / 4 else 0.0 for stance in own])
        arrivals = np.array([max(stance.arrive, -ALWAYS / 4) for stance in own])
        arriving = self.facing(arrivals)
        return middles, arriving + np.clip(self.facing(middles) - arriving, -_AHEAD, _AHEAD)


def placed(path: Path, own: list[Stance], side: float) -> Float:
    """World ankle x, z and heading (K, 3) of each stance: right under the body in the middle of its time."""
    middles, facing = path.standing(own)
    return path.world(middles, facing, np.array([stance.place for stance in own]), side)


def keep_apart(left: list[Stance], left_world: Float, right: list[Stance], right_world: Float) -> None:
    """Shift stances along x, in place, so that a step that travels sideways does not run through the other leg.

    Feet that stand at the same time keep 15 cm, or what the sketch itself asks for; both give way alike.
    """
    pairs = [
        (i, j, min(_GAP, 2.0 * HOME_OUT + a.place[0] + b.place[0]))
        for i, a in enumerate(left)
        for j, b in enumerate(right)
        if a.arrive < b.leave + 0.25 and b.arrive < a.leave + 0.25
    ]
    if not pairs:
        return
    i, j = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    gap = np.array([pair[2] for pair in pairs])
    # the same stance of every repetition moves alike
    numbers = [np.unique([stance.number for stance in own], return_inverse=True)[1] for own in (left, right)]
    for _ in range(200):
        lack = np.maximum(gap - left_world[i, 0] + right_world[j, 0], 0.0)
        if lack.max() < 1e-4:
            break
        # all give way at once, so that steps that are alike stay alike
        for world, own, pair, way in ((left_world, numbers[0], i, 0.5), (right_world, numbers[1], j, -0.5)):
            most = np.zeros(own.max() + 1)
            np.maximum.at(most, own[pair], lack)
            world[:, 0] += way * most[own]


def track(
    path: Path, own: list[Stance], world: Float, side: float, beats: Float, leaps: list[tuple[float, float]]
) -> FootTrack:
    """The foot's way at `beats` (T,) through its stances, which stand at `world` (K, 3); `leaps` as `flights` says."""
    ball = world.copy()
    ball[:, 0] += BALL_FORWARD * np.sin(world[:, 2])
    ball[:, 1] += BALL_FORWARD * np.cos(world[:, 2])
    up = _heights(own, world)
    times, ground_times, places, ground = [], [], [], []
    landed = 0.0
    for index, stance in enumerate(own):
        following = own[index + 1] if index + 1 < len(own) else None
        above = _in_the_air(path, stance, following, side) if following and stance.air else np.zeros((0, 4))
        lifted = landing = 0.0
        if following:
            ends = (stance.leave, *ball[index, :2]), *above[:, :3], (following.arrive, *ball[index + 1, :2])
            lifted, landing = _over_its_place(up, np.array(ends), stance.leave, following.arrive)
        times += [stance.arrive - landed, min(stance.leave, ALWAYS) + lifted, *above[:, 0]]
        ground_times += [stance.arrive, min(stance.leave, ALWAYS)]
        places += [ball[index], ball[index], *above[:, 1:]]
        ground += [ball[index], ball[index]]
        landed = landing
    way = through(np.array(times), np.array(places), beats)
    stand = through(np.array(ground_times), np.array(ground), beats)
    pivot, heel, firm = _pivot(path, own, beats), _heel(own, world, beats, leaps), _firm(own, beats, plain=0.0)
    behind = BALL_FORWARD - 0.09 * firm * np.minimum(heel / math.radians(20.0), 1.0)
    yaw = stand[:, 2] + pivot
    contact = np.zeros(len(beats), np.bool_)
    for stance in own:
        contact |= (beats >= stance.arrive - 1e-6) & (beats <= stance.leave + 1e-6)
    return FootTrack(
        ball=way[:, :2],
        height=through(up[:, 0], up[:, 1], beats),
        yaw=way[:, 2] + pivot,
        heel=heel,
        toe=_toe(own, beats),
        ground=stand[:, :2] - behind[:, None] * np.stack((np.sin(yaw), np.cos(yaw)), axis=1),
        contact=contact,
        firm=firm,
        free=1.0 - _firm(own, beats, plain=1.0),
    )


def _heights(own: list[Stance], world: Float) -> Float:
    """Beats and heights of the sole [m] through all stances and swings, (K, 2)."""
    heights = []
    for index, stance in enumerate(own):
        heights += [(stance.arrive, 0.0), (min(stance.leave, ALWAYS), 0.0)]
        if stance.air:
            heights += [(key.beat, key.amounts["up"]) for key in stance.air]
        elif index + 1 < len(own):
            heights += _over_the_floor(stance, own[index + 1], world[index], world[index + 1])
    return np.array(heights)


def _over_its_place(up: Float, ways: Float, leave: float, arrive: float) -> tuple[float, float]:
    """For how many beats a foot goes straight up before it sets out, and straight down when it has got there.

    So long that it is within _NEAR of its place as long as it is low: a foot that goes ahead over the floor skates
    (GMD). `up` (K, 2) as `_heights` says; `ways` (M, 3) beat, x and z [m] on its way from where it leaves to where it
    arrives. One that is led through the air low sets out at once.
    """
    middle = 0.5 * (leave + arrive)
    straight = []
    for here, there in ((ways[0], ways[1]), (ways[-1], ways[-2])):
        span = abs((there[0] if len(ways) > 2 else middle) - here[0])
        at = np.linspace(0.0, span, 65)
        high = through(up[:, 0], up[:, 1], here[0] + np.copysign(at, middle - here[0])) >= _LOW
        low = at[int(np.argmax(high))]
        # a curve that leaves its key flat is at 3 u² of its way when u of its time has passed, or less
        near = math.sqrt(_NEAR / 3.0 / max(math.hypot(*(there - here)[1:]), _NEAR))
        near *= span if len(ways) > 2 else 2.0 * span
        straight.append(min(max(low - near, 0.0), _STRAIGHT * span))
    return straight[0], straight[1]


def _in_the_air(path: Path, stance: Stance, following: Stance, side: float) -> Float:
    """Beat, ball x, z and heading (K, 4) on the way through keys in the air, led around with a body that turns."""
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


def _over_the_floor(stance: Stance, following: Stance, start: Float, end: Float) -> list[tuple[float, float]]:
    """Beats and heights [m] of a swing from `start` to `end`: up soon, down late: no foot skims the floor."""
    span = following.arrive - stance.leave
    lift = _lift(stance, math.hypot(end[0] - start[0], end[1] - start[1]))
    soon = min(_SOON, 0.4 * span)
    return [
        (stance.leave + soon, _NEARLY * lift),
        (stance.leave + 0.5 * span, lift),
        (following.arrive - soon, _NEARLY * lift),
    ]


def _lift(stance: Stance, way: float) -> float:
    """How high a foot is lifted that goes `way` [m]: as told, but over 5 cm where it goes fast (GMD's skating)."""
    return max(_LEAST if stance.lift is None else stance.lift, min(0.5 * way, 0.055 + 0.08 * way, _MOST))


def _pivot(path: Path, own: list[Stance], beats: Float) -> Float:
    """Turn of the foot on its ball where the body turns on by more than the hips allow."""
    times = np.array([at for stance in own for at in (stance.arrive, min(stance.leave, ALWAYS))])
    twist = path.facing(beats) - through(times, np.repeat(path.standing(own)[1], 2), beats)
    on_ball = [0.0 if any(_said_toe(key) for key in stance.contacts) else 1.0 for stance in own]
    return np.asarray((twist - _PIVOT * np.tanh(twist / _PIVOT)) * through(times, np.repeat(on_ball, 2), beats))


def _angle(centimetres_up: float) -> float:
    return math.asin(min(max(centimetres_up, 0.0) / HEEL_TO_BALL, 0.95))


def _heel(own: list[Stance], world: Float, beats: Float, leaps: list[tuple[float, float]]) -> Float:
    keys: list[tuple[float, float]] = []
    for index, stance in enumerate(own):
        leaping = any(abs(stance.leave - start) < 0.3 for start, _ in leaps)
        landing = any(abs(stance.arrive - end) < 0.3 for _, end in leaps)
        said = _rolls(stance, _said_heel)
        on_toes = landing and _said_toe(stance.contacts[0]) == 0.0
        keys.append((stance.arrive, math.radians(25.0) if on_toes else said[0][1]))
        if on_toes:
            keys.append((stance.arrive + 0.2, said[0][1]))
        keys.extend(said[1:])
        if index + 1 == len(own):
            break
        away = math.hypot(*(world[index + 1] - world[index])[:2])
        if _said_toe(stance.contacts[-1]) > 0.0:  # it leaves from the heel
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
    """Beats and angles that a stance is told, flat on the floor on the way from the heel to the toes and back."""
    rolls = [(stance.contacts[0].beat, said(stance.contacts[0]))]
    for before, after in pairwise(stance.contacts):
        if (_said_heel(before) and _said_toe(after)) or (_said_toe(before) and _said_heel(after)):
            rolls.append((0.5 * (before.beat + after.beat), 0.0))
        rolls.append((after.beat, said(after)))
    return rolls


def _said_toe(key: Key) -> float:
    return _angle(key.amounts.get("toe", 0.0))


def _said_heel(key: Key) -> float:
    if "heel" in key.amounts:
        return _angle(key.amounts["heel"])
    return math.radians(14.0) if "touch" in key.amounts and "toe" not in key.amounts else 0.0


def _toe(own: list[Stance], beats: Float) -> Float:
    keys: list[tuple[float, float]] = []
    for stance in own:
        keys.extend(_rolls(stance, _said_toe))
        keys.append((min(stance.leave, ALWAYS), keys[-1][1]))
        keys.extend((key.beat, _said_toe(key)) for key in stance.air)
    return _angles(keys, beats)


def _angles(keys: list[tuple[float, float]], beats: Float) -> Float:
    increasing = [keys[0]]
    for at, value in keys[1:]:
        if at > increasing[-1][0] + 0.01:
            increasing.append((at, value))
    table = np.array(increasing)
    return np.maximum(through(table[:, 0], table[:, 1], beats), 0.0)


def _firm(own: list[Stance], beats: Float, *, plain: float) -> Float:
    """1 in stances, 0 in the middle of swings through keys in the air, `plain` in the middle of all others, (T,)."""
    keys: list[tuple[float, float]] = []
    for index, stance in enumerate(own):
        if index:
            before = own[index - 1]
            level = 0.0 if before.air else plain
            keys.append((before.leave + 0.35 * (stance.arrive - before.leave), level))
            keys.append((before.leave + 0.55 * (stance.arrive - before.leave), level))
        keys.append((stance.arrive, 1.0))
        keys.append((min(stance.leave, ALWAYS), 1.0))
    table = np.array(keys)
    return through(table[:, 0], table[:, 1], beats)
