"""Beats: how the motion's own beats lie to those of the music (design: Bailando's and AIST++'s measures, both ways).

Feet: how they slide while they are in contact, and how often they skate.

Contact is never found in the motion that is judged: it is what the source clips say, carried through blends, so that a
foot that floats or flies is not excused.

Smoothness: how the joints' velocities change, where clips are joined and in the clips themselves.

The figures of one step: slide and skating, jumps of velocity and acceleration, bone lengths.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter1d

from live.motion.clip import Clip
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.motion.step_clip import StepClip

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

SMOOTH: Final = 5.0 / 60.0
"""Width [s] of the Gaussian that smooths the mean speed: five frames of 60 a second."""
KERNEL: Final = 3.0 / 60.0
"""Width [s] of the kernel of the alignment: three frames of 60 a second, 50 ms."""


def mean_speed(position: Float, rate: float) -> Float64:
    """Mean speed of all joints [m/s] between neighbouring samples, (T - 1, ...) from (T, ..., J, 3)."""
    moved = np.diff(position.astype(np.float64), axis=0)
    return np.asarray(np.linalg.norm(moved, axis=-1).mean(axis=-1) * rate, np.float64)


def motion_beats(speed: Float64, rate: float, begin: float = 0.0) -> Float64:
    """Times [s] of the local minima of the smoothed mean speed (T - 1,), whose first value lies at `begin` plus half
    a sample."""
    if len(speed) < 3:
        return np.zeros(0)
    smooth = gaussian_filter1d(speed, SMOOTH * rate, mode="nearest")
    low = np.flatnonzero((smooth[1:-1] < smooth[:-2]) & (smooth[1:-1] <= smooth[2:])) + 1
    return np.asarray(begin + (low + 0.5) / rate, np.float64)


def offsets(beats: Float64, others: Float64) -> Float64:
    """From each of `beats` (n,) to the nearest of `others` (m,) [s], signed, (n,); empty if either is."""
    if not len(beats) or not len(others):
        return np.zeros(0)
    others = np.sort(others)
    after = np.minimum(np.searchsorted(others, beats), len(others) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(np.abs(others[before] - beats) <= np.abs(others[after] - beats), before, after)
    return np.asarray(others[nearer] - beats, np.float64)


def alignment(beats: Float64, others: Float64) -> float | None:
    """Mean of exp(-d² / 2σ²) over `beats`, d the distance to the nearest of `others`, σ 50 ms; None without beats.

    With the music's beats first it is Bailando's score (does every beat have a move?), with the motion's first that of
    AIST++ (is every move on a beat?). 0 where there is nothing to be near to.
    """
    if not len(beats):
        return None
    if not len(others):
        return 0.0
    return float(np.exp(-(offsets(beats, others) ** 2) / (2.0 * KERNEL**2)).mean())


Bool = npt.NDArray[np.bool_]

SKATING_RATE: Final = 20.0
SKATING_HEIGHT: Final = 0.05
SKATING_SPEED: Final = 0.5
"""Frames per second, metres and m/s of the skating ratio (GMD)."""
SKATING_FRAMES: Final = 5
"""Frames over which the speed is averaged besides."""


def slide_speeds(position: Float, rate: float) -> Float64:
    """Speed over the floor [m/s] of each foot, of heel and ball the stiller, (T - 1, ..., 2) from (T, ..., J, 3)."""
    feet = np.stack((position[..., ANKLES, :], position[..., BALLS, :]), axis=-2).astype(np.float64)
    moved = np.diff(feet, axis=0)[..., (0, 2)]
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]).min(axis=-1) * rate, np.float64)


def slides(position: Float, contact: Bool, rate: float) -> Float64:
    """Those speeds between samples in which the foot is in contact, (n,); `contact` is (T, ..., 2)."""
    return np.asarray(slide_speeds(position, rate)[contact[1:] & contact[:-1]], np.float64)


def skates(position: Float, rate: float) -> Bool:
    """Frames at 20 a second in which a ball skates, (F, ...) from joints (T, ..., J, 3); see `skating_balls`."""
    count = int((len(position) - 1) * SKATING_RATE / rate + 1e-6) + 1
    at = np.minimum(np.arange(count) * rate / SKATING_RATE, len(position) - 1.0)
    low = at.astype(np.int64)
    part = (at - low).reshape(-1, *(1,) * (position.ndim - 1))
    balls = position[..., BALLS, :].astype(np.float64)
    return skating_balls((1.0 - part) * balls[low] + part * balls[np.minimum(low + 1, len(balls) - 1)])


def skating_balls(balls: Float) -> Bool:
    """Whether a ball skates, (F - 1, ...) from the balls of both feet at 20 frames a second, (F, ..., 2, 3) [m].

    Lower than 5 cm over its place on the floor in two adjacent frames, and faster than 0.5 m/s now and in the mean of
    five frames; either foot.
    """
    if len(balls) < 2:
        return np.zeros((0, *balls.shape[1:-2]), np.bool_)
    moved = np.diff(balls, axis=0)
    speed = np.hypot(moved[..., 0], moved[..., 2]) * SKATING_RATE
    on_floor = balls[..., 1] - TOES_OVER_SOLE < SKATING_HEIGHT
    reach = SKATING_FRAMES // 2
    padded = np.pad(speed, ((reach, reach), *((0, 0),) * (speed.ndim - 1)))
    mean = np.lib.stride_tricks.sliding_window_view(padded, SKATING_FRAMES, axis=0).mean(axis=-1)
    found = on_floor[1:] & on_floor[:-1] & (speed > SKATING_SPEED) & (mean > SKATING_SPEED)
    return np.asarray(found.any(axis=-1), np.bool_)


ACCELERATION_WINDOW: Final = 3
"""Samples over which velocities are averaged before accelerations: recorded markers tremble."""
AROUND: Final = 0.2
"""A join is looked at for so many seconds before and after its middle, at least..."""
BESIDE: Final = 0.05
"""... and always for so many before and after its blend."""
DRAWN: Final = 4000
"""Random places of the raw clips that joins are compared with."""


def velocity_changes(position: Float, rate: float) -> Float64:
    """Change of each joint's velocity at the samples between the first and last [m/s], (T - 2, ...) of (T, ..., 3)."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    return np.asarray(np.linalg.norm(np.diff(velocity, axis=0), axis=-1), np.float64)


def accelerations(position: Float, rate: float) -> Float64:
    """Acceleration [m/s²], velocities averaged over three samples, (T - 4, ...) from (T, ..., 3): none at the ends."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    if len(velocity) < ACCELERATION_WINDOW + 1:
        return np.zeros((0, *velocity.shape[1:-1]))
    windows = np.lib.stride_tricks.sliding_window_view(velocity, ACCELERATION_WINDOW, axis=0)
    return np.asarray(np.linalg.norm(np.diff(windows.mean(axis=-1), axis=0), axis=-1) * rate, np.float64)


def at_samples(position: Float, rate: float) -> tuple[Float64, Float64]:
    """Largest velocity change [m/s] and acceleration [m/s²] of any joint at every sample, (T, ...) of (T, ..., J, 3).

    0 at the first and last samples, where there is none.
    """
    shape = position.shape[:-2]
    change, acceleration = np.zeros(shape), np.zeros(shape)
    if len(position) > 2:
        change[1:-1] = velocity_changes(position, rate).max(axis=-1)
    if len(position) > ACCELERATION_WINDOW + 1:
        acceleration[2:-2] = accelerations(position, rate).max(axis=-1)
    return change, acceleration


def half_width(blend: float) -> float:
    """Seconds before and after the middle of a join that takes `blend` seconds over which it is looked at."""
    return max(AROUND, 0.5 * blend + BESIDE)


def largest_around(values: Float64, middle: Float64, half: float, rate: float) -> Float64:
    """The largest of `values` (T,) within `half` seconds of each of the times `middle` (n,) [s], (n,)."""
    first = np.clip(np.ceil((middle - half) * rate - 1e-6).astype(np.int64), 0, len(values) - 1)
    last = np.clip(np.floor((middle + half) * rate + 1e-6).astype(np.int64), 0, len(values) - 1)
    width = int((last - first).max(initial=0)) + 1
    rows = np.minimum(first[:, None] + np.arange(width), last[:, None])
    return np.asarray(values[rows].max(axis=1), np.float64)


def p99_of_raw(traces: Sequence[Float64], half: float, rate: float, *, seed: int = 0) -> float:
    """p99 of the largest value within `half` seconds of random samples of the raw clips' `traces`, each (T,).

    Places are drawn evenly from all samples of all clips that have `half` seconds on both sides; of a clip shorter
    than that its middle counts. 0 if there is no clip.
    """
    chance = np.random.default_rng(seed)
    margin = half * rate
    room = np.array([max(len(trace) - 1 - 2.0 * margin, 0.0) + 1.0 for trace in traces])
    if not len(room):
        return 0.0
    clip = chance.choice(len(traces), DRAWN, p=room / room.sum())
    found = []
    for n, trace in enumerate(traces):
        places = chance.uniform(0.0, room[n] - 1.0, int((clip == n).sum())) + min(margin, 0.5 * (len(trace) - 1))
        if len(places):
            found.append(largest_around(trace, places / rate, half, rate))
    return float(np.percentile(np.concatenate(found), 99))


class StepFigures:
    """The figures of one step, over its measures (lead-in and tail left out)."""

    def __init__(self, step: StepClip) -> None:
        first = int(step.first)
        last = math.ceil(step.first + step.measures * step.samples_per_measure)
        part = slice(first, last + 1)
        self._rate = step.clip.sample_rate
        self._contact = step.clip.contact[part]
        self._rotation = step.clip.rotation[part].astype(np.float64)
        self._position, _ = forward_kinematics(step.clip.root_position[part].astype(np.float64), self._rotation)

    @property
    def slides(self) -> Float64:
        """Speeds over the floor [m/s] of feet in contact, of heel and ball the stiller; contact is the clip's own."""
        return slides(self._position, self._contact, self._rate)

    @property
    def slide(self) -> float | None:
        """Their mean; None if no foot is ever in contact."""
        found = self.slides
        return float(found.mean()) if len(found) else None

    @property
    def skating(self) -> float:
        """Share of frames, of 20 a second, in which a foot skates."""
        found = skates(self._position, self._rate)
        return float(found.mean()) if len(found) else 0.0

    @property
    def velocity_jump(self) -> float:
        """Largest change of any joint's velocity from one sample to the next [m/s]."""
        return float(velocity_changes(self._position, self._rate).max(initial=0.0))

    @property
    def accelerations(self) -> Float64:
        """Acceleration of each joint [m/s²], velocities averaged over three samples, shape (n, J)."""
        return accelerations(self._position, self._rate)

    @property
    def bone_error(self) -> float:
        """Largest deviation of a bone's length from the skeleton's [m], as a renderer of matrices would see it."""
        error = 0.0
        for joint, parent in enumerate(SKELETON.parents):
            if parent >= 0:
                length = np.linalg.norm(self._position[:, joint] - self._position[:, parent], axis=-1)
                error = max(error, float(np.abs(length - np.linalg.norm(SKELETON.offsets[joint])).max()))
        return error

    @property
    def below_floor(self) -> float:
        """How far the lowest sole goes below the floor [m]."""
        heel = self._position[:, ANKLES, 1] - SOLE_BELOW_ANKLE
        ball = self._position[:, BALLS, 1] - TOES_OVER_SOLE
        return float(max(0.0, -np.minimum(heel, ball).min()))


def pelvis_way(before: Clip, after: Clip) -> float:
    """How far the pelvis was moved by an edit at most [m]."""
    return float(np.linalg.norm(after.root_position - before.root_position, axis=-1).max())
