"""Foot planting: feet of a recording that stand are kept in place, and feet that swing clear the floor.

Footskate cleanup after Kovar, Schreiner and Gleicher (2002): each stance gets one place on the floor, the swings
between two stances are bent to lead from one place to the next, and the legs are solved for the feet. Hips sink where
a leg would be too short; trunk and arms stay as recorded.
"""

import itertools
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.editing.foot_correction import (
    ANKLES,
    BALLS,
    LEG_LENGTH,
    MAX_LEG_SHARE,
    UPPER_LEGS,
    bend_swings,
    lower_hips,
    smooth_upper_bound,
    solve_legs,
)
from live.motion.foot_contact import MIN_DURATION, TOES_OVER_SOLE, remove_flicker
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SOLE_BELOW_ANKLE

GLIDE_SPEED: Final = 0.25
"""A foot on the floor that goes farther than this [m/s], over GLIDE_WINDOW, glides on purpose and is not planted."""
GLIDE_WINDOW: Final = 0.2
"""Seconds."""
MIN_STANCES: Final = 0.5
"""If fewer of a clip's contacts than this share are stances, the dancer glides as a whole, and nothing is planted."""
MAX_PLANT_SHIFT: Final = 0.16
"""Most that a stance's slide is undone by [m]; the rest of a longer one stays."""
MAX_PLANT_HEIGHT: Final = 0.06
"""Most that a standing foot is raised or lowered to the floor [m]."""
TOE_LIFT: Final = 0.01
"""The foot stands on its heel if the ball is higher than it by this [m], else on its ball (as in the foot lock)."""
SWING_CLEARANCE: Final = 0.055
"""Least height of the ball over the floor [m] while it is fast: a foot that is dragged lower looks as if it slid."""
SWING_SPEEDS: Final = (0.3, 0.5)
"""Between these speeds [m/s] the clearance is demanded in part, above in full."""
CLEARANCE_FADE: Final = 0.08
"""Seconds next to a stance over which the clearance grows."""


@dataclass(frozen=True, slots=True)
class FootFaults:
    """Faults of the feet of one clip."""

    slide: float
    """Mean speed over the floor of standing feet [m/s]: of heel and ball the one that bears."""
    low_swing: float
    """Share of samples in which a foot that does not stand moves fast and low."""


@dataclass(frozen=True, slots=True, eq=False)
class PlantedClip:
    """A clip with planted feet, and its faults before and after."""

    clip: Clip
    before: FootFaults
    after: FootFaults
    largest_shift: float
    """Farthest that a standing foot was moved [m]."""


def plant_feet(clip: Clip) -> PlantedClip:
    """Return the clip with its standing feet in place and its swinging feet off the floor.

    Contacts are those of the clip, without the stretches in which a foot glides; so a glide stays a glide, and a clip
    that glides most of the time is returned as it is. A clip without contact is only lifted where its feet drag.
    """
    rate = clip.sample_rate
    root: Float = clip.root_position.astype(np.float64)
    rotation: Float = clip.rotation.astype(np.float64)
    position, world = forward_kinematics(root, rotation)
    ankle, ball = position[:, ANKLES], position[:, BALLS]
    bearing = _bearing(ankle, ball)
    step = _bearing_steps(ankle, ball)
    contact = without_glides(clip.contact, bearing, rate)
    if contact.sum() < MIN_STANCES * clip.contact.sum():
        faults = foot_faults(clip)
        return PlantedClip(clip, faults, faults, 0.0)
    shift: Float = np.stack([_foot_shift(ankle[:, f], ball[:, f], step[:, f], contact[:, f]) for f in range(2)], axis=1)
    shift[..., 1] += _clearance(ankle + shift, ball + shift, contact, rate)
    moved: Float = ankle + shift
    own_leg = np.linalg.norm(position[:, UPPER_LEGS] - ankle, axis=-1)
    longest = np.where(contact, np.maximum(own_leg, MAX_LEG_SHARE * LEG_LENGTH), np.inf)  # a kick may fall short
    root = lower_hips(root, rotation, moved, longest, rate)
    moved = bend_swings(root, rotation, moved, contact, rate)
    rotation = quaternion.align_signs(solve_legs(root, rotation, moved, world[:, ANKLES]))
    planted = replace(
        clip,
        root_position=np.ascontiguousarray(root, np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        contact=contact,
    )
    largest = float(np.hypot(shift[..., 0], shift[..., 2])[contact].max(initial=0.0))
    return PlantedClip(planted, foot_faults(clip), foot_faults(planted), largest)


def foot_faults(clip: Clip) -> FootFaults:
    """Measure the faults of a clip's feet by its own contacts."""
    position, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    ankle, ball = position[:, ANKLES], position[:, BALLS]
    speed = np.hypot(*np.moveaxis(_bearing_steps(ankle, ball), -1, 0)) * clip.sample_rate
    stands = clip.contact[1:] & clip.contact[:-1]
    fast = np.hypot(*np.moveaxis(np.diff(ball[..., (0, 2)], axis=0), -1, 0)) * clip.sample_rate > SWING_SPEEDS[1]
    drags = fast & ~stands & (ball[1:, :, 1] - TOES_OVER_SOLE < SWING_CLEARANCE - 0.005)
    return FootFaults(
        slide=float(speed[1:][stands].mean()) if stands.any() else 0.0,
        low_swing=float(drags.any(axis=1).mean()) if len(drags) else 0.0,
    )


def without_glides(contact: Bool, bearing: Float, rate: float) -> Bool:
    """Return the `contact` (T, 2) without the stretches in which the `bearing` point (T, 2, 3) [m] glides."""
    half = max(1, round(0.5 * GLIDE_WINDOW * rate))
    at = np.arange(len(bearing))
    before, after = np.maximum(at - half, 0), np.minimum(at + half, len(bearing) - 1)
    for foot in range(2):  # a window must not look beyond the stance: the foot swings there
        begin, end = _stance_bounds(contact[:, foot])
        before_f, after_f = np.maximum(before, begin), np.minimum(after, end)
        way = bearing[after_f, foot][:, (0, 2)] - bearing[before_f, foot][:, (0, 2)]
        seconds = np.maximum(after_f - before_f, 1) / rate
        still = np.hypot(*way.T) / np.maximum(seconds, 0.5 * GLIDE_WINDOW) < GLIDE_SPEED
        kept = contact[:, foot] & still
        contact = contact.copy()
        contact[:, foot] = remove_flicker(kept, max(1, round(MIN_DURATION * rate))) & contact[:, foot]
    return contact


def _stance_bounds(stands: Bool) -> tuple[Float, Float]:
    """Return first and last sample of the stance that each sample of `stands` (T,) is in, (T,) each."""
    at = np.arange(len(stands))
    begin = np.maximum.accumulate(np.where(~stands, at + 1, 0))
    end = np.minimum.accumulate(np.where(~stands, at - 1, len(stands) - 1)[::-1])[::-1]
    return np.minimum(begin, at), np.maximum(end, at)


def _ball_share(ankle: Float, ball: Float) -> Float:
    """Return 1 where a foot stands on its ball, 0 where on its heel, from joints (..., 3)."""
    return ((ankle[..., 1] - SOLE_BELOW_ANKLE) - (ball[..., 1] - TOES_OVER_SOLE) + TOE_LIFT > 0.0).astype(np.float64)


def _bearing(ankle: Float, ball: Float) -> Float:
    """Return the joint on which each foot stands, (T, 2, 3)."""
    share = _ball_share(ankle, ball)[..., None]
    return ankle + share * (ball - ankle)


def _bearing_steps(ankle: Float, ball: Float) -> Float:
    """Return by how much the bearing joint of each foot moved since the sample before (x, z) [m], (T, 2, 2).

    It is always the motion of one joint: that which bore at the sample before.
    """
    share = _ball_share(ankle, ball)[:-1, :, None]
    heel, toes = np.diff(ankle[..., (0, 2)], axis=0), np.diff(ball[..., (0, 2)], axis=0)
    return np.concatenate([np.zeros((1, *heel.shape[1:])), heel + share * (toes - heel)])


def _foot_shift(ankle: Float, ball: Float, step: Float, stands: Bool) -> Float:
    """Return the shift of one foot (T, 3) [m]: its stances stand still on the floor, its swings lead from one to the
    next with the speeds that both have."""
    count = len(stands)
    shift = np.zeros((count, 3))
    edges = np.flatnonzero(np.diff(stands.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    height = np.minimum(ankle[:, 1] - SOLE_BELOW_ANKLE, ball[:, 1] - TOES_OVER_SOLE)
    for begin, end in edges:
        slid = np.cumsum(step[begin:end], axis=0) - step[begin]
        middle = 0.5 * (slid.max(axis=0) + slid.min(axis=0))
        size = float(np.hypot(*np.ptp(slid, axis=0)))
        share = min(1.0, MAX_PLANT_SHIFT / max(size, 1e-9))
        shift[begin:end, (0, 2)] = -share * (slid - middle)
        shift[begin:end, 1] = np.clip(-height[begin:end], -MAX_PLANT_HEIGHT, MAX_PLANT_HEIGHT)
    if not len(edges):
        return shift
    shift[: edges[0, 0]] = shift[edges[0, 0]]
    shift[edges[-1, 1] :] = shift[edges[-1, 1] - 1]
    for (_, off), (on, _) in itertools.pairwise(edges):
        _bridge(shift, off - 1, on)
    return shift


def _bridge(shift: Float, off: int, on: int) -> None:
    """Fill `shift` between the samples `off` and `on` with a cubic that keeps the speeds at both."""
    span = on - off
    at_off = shift[off] - shift[off - 1] if off > 0 else np.zeros(3)
    at_on = shift[min(on + 1, len(shift) - 1)] - shift[on]
    t = np.arange(1, span)[:, None] / span
    h = 1.0 - t
    shift[off + 1 : on] = (
        (1.0 + 2.0 * t) * h * h * shift[off]
        + t * h * h * span * at_off
        + t * t * (3.0 - 2.0 * t) * shift[on]
        - t * t * h * span * at_on
    )


def _clearance(ankle: Float, ball: Float, contact: Bool, rate: float) -> Float:
    """Return how far each foot must be lifted (T, 2) [m]: no sole below the floor, no fast ball near to it."""
    sole = np.minimum(ankle[..., 1] - SOLE_BELOW_ANKLE, ball[..., 1] - TOES_OVER_SOLE)
    speed = np.zeros(contact.shape)
    if len(ball) > 2:
        speed = np.hypot(*np.moveaxis(np.gradient(ball[..., (0, 2)], axis=0), -1, 0)) * rate
    fast = smoothstep((speed - SWING_SPEEDS[0]) / (SWING_SPEEDS[1] - SWING_SPEEDS[0]))
    wanted = fast * np.maximum(SWING_CLEARANCE - (ball[..., 1] - TOES_OVER_SOLE), 0.0)
    half = max(1, round(0.5 * CLEARANCE_FADE * rate))
    free = 1.0 - smooth_upper_bound(contact.astype(np.float64), half)
    lift = smooth_upper_bound(np.where(contact, 0.0, wanted), half) * free
    below = np.where(contact, 0.0, np.maximum(-sole - lift, 0.0))
    return np.asarray(lift + smooth_upper_bound(below, half) * np.where(contact, 0.0, 1.0))
