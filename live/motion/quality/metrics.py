"""Motion quality metrics: beat alignment, foot sliding and skating, smoothness, bone lengths.

Beat alignment follows Bailando (music to motion) and AIST++ (motion to music). Smoothness compares velocity changes at
clip transitions with those inside the clips. Contact is never detected in the evaluated motion: it comes from the
source clips, carried through blends, so that a floating foot is not excused.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float, Float64, Int64
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE

BEAT_SMOOTHING: Final = 5.0 / 60.0
"""Width [s] of the Gaussian that smooths the mean speed: five frames at 60 per second."""
ALIGNMENT_DEVIATION: Final = 3.0 / 60.0
"""Width [s] of the kernel of the alignment: three frames at 60 per second, 50 ms."""


def mean_speed(position: Float, rate: float) -> Float64:
    """Return the mean speed of all joints [m/s] between neighbouring samples, (T - 1, ...) from (T, ..., J, 3)."""
    moved = np.diff(position.astype(np.float64), axis=0)
    return np.asarray(np.linalg.norm(moved, axis=-1).mean(axis=-1) * rate, np.float64)


def motion_beats(speed: Float64, rate: float, begin: float = 0.0) -> Float64:
    """Return the times [s] of the local minima of the smoothed mean speed (T - 1,), which starts half a sample after
    `begin`."""
    from scipy.ndimage import gaussian_filter1d

    if len(speed) < 3:
        return np.zeros(0)
    smooth = gaussian_filter1d(speed, BEAT_SMOOTHING * rate, mode="nearest")
    low = np.flatnonzero((smooth[1:-1] < smooth[:-2]) & (smooth[1:-1] <= smooth[2:])) + 1
    return np.asarray(begin + (low + 0.5) / rate, np.float64)


def beat_offsets(beats: Float64, others: Float64) -> Float64:
    """Signed offset from each of `beats` (n,) to the nearest of `others` (m,) [s], (n,); empty if either is."""
    if not len(beats) or not len(others):
        return np.zeros(0)
    others = np.sort(others)
    after = np.minimum(np.searchsorted(others, beats), len(others) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(np.abs(others[before] - beats) <= np.abs(others[after] - beats), before, after)
    return np.asarray(others[nearer] - beats, np.float64)


def beat_alignment(beats: Float64, others: Float64) -> float | None:
    """Mean of exp(-d² / 2σ²) over `beats`, d the distance to the nearest of `others`, σ 50 ms; None without beats.

    With the music's beats first it is Bailando's score (does every beat have a move?), with the motion's first that of
    AIST++ (is every move on a beat?). 0 if `others` is empty.
    """
    if not len(beats):
        return None
    if not len(others):
        return 0.0
    return float(np.exp(-(beat_offsets(beats, others) ** 2) / (2.0 * ALIGNMENT_DEVIATION**2)).mean())


SKATING_RATE: Final = 20.0
SKATING_HEIGHT: Final = 0.05
SKATING_SPEED: Final = 0.5
"""Frames per second, metres and m/s of the skating ratio (GMD)."""
SKATING_FRAMES: Final = 5
"""Frames over which the speed is also averaged."""


def slide_speeds(position: Float, rate: float) -> Float64:
    """Horizontal speed [m/s] of each foot, the slower of heel and ball, (T - 1, ..., 2) from (T, ..., J, 3)."""
    feet = np.stack((position[..., ANKLES, :], position[..., BALLS, :]), axis=-2).astype(np.float64)
    moved = np.diff(feet, axis=0)[..., (0, 2)]
    return np.asarray(np.hypot(moved[..., 0], moved[..., 1]).min(axis=-1) * rate, np.float64)


def contact_slide_speeds(position: Float, contact: Bool, rate: float) -> Float64:
    """Return `slide_speeds` between samples in which the foot is in contact, (n,); `contact` is (T, ..., 2)."""
    return np.asarray(slide_speeds(position, rate)[contact[1:] & contact[:-1]], np.float64)


def skating_frames(position: Float, rate: float) -> Bool:
    """At 20 frames per second whether a ball skates, (F, ...) from joints (T, ..., J, 3); see `skating_balls`."""
    count = int((len(position) - 1) * SKATING_RATE / rate + 1e-6) + 1
    at = np.minimum(np.arange(count) * rate / SKATING_RATE, len(position) - 1.0)
    low = at.astype(np.int64)
    part = (at - low).reshape(-1, *(1,) * (position.ndim - 1))
    balls = position[..., BALLS, :].astype(np.float64)
    return skating_balls((1.0 - part) * balls[low] + part * balls[np.minimum(low + 1, len(balls) - 1)])


def skating_balls(balls: Float, rest: Float | float = TOES_OVER_SOLE) -> Bool:
    """Return whether either foot skates, (F - 1, ...) from the balls at 20 frames per second, (F, ..., 2, 3) [m].

    A ball skates if it is lower than 5 cm above its `rest` height [m], (..., 2), in two adjacent frames and faster than
    0.5 m/s both now and in the mean of five frames.
    """
    if len(balls) < 2:
        return np.zeros((0, *balls.shape[1:-2]), np.bool_)
    moved = np.diff(balls, axis=0)
    speed = np.hypot(moved[..., 0], moved[..., 2]) * SKATING_RATE
    on_floor = balls[..., 1] - rest < SKATING_HEIGHT
    reach = SKATING_FRAMES // 2
    padded = np.pad(speed, ((reach, reach), *((0, 0),) * (speed.ndim - 1)))
    mean = np.lib.stride_tricks.sliding_window_view(padded, SKATING_FRAMES, axis=0).mean(axis=-1)
    found = on_floor[1:] & on_floor[:-1] & (speed > SKATING_SPEED) & (mean > SKATING_SPEED)
    return np.asarray(found.any(axis=-1), np.bool_)


STILL_SPEED: Final = 0.15
LOW_HEIGHT: Final = 0.04
"""A foot stands, judged by its positions alone, while its stillest point is slower than this [m/s] and no higher than
this [m] above its lowest height."""


@dataclass(frozen=True, slots=True)
class PositionFigures:
    """Figures of the feet from joint positions alone; contacts are not known. None where nothing was measured."""

    slide_mean: float | None
    """[m/s], of the stillest point of feet that stand."""
    slide_p99: float | None
    skating_ratio: float | None
    """Share of frames at 20 per second in which a ball within 5 cm of its lowest height is faster than 0.5 m/s."""

    def as_json(self) -> dict[str, float | None]:
        """Return the figures by name."""
        return {name: getattr(self, name) for name in PositionFigures.__slots__}


def foot_points(position: Float) -> Float:
    """Return ankle and ball of both feet, (..., 2, 2, 3) from joints (..., J, 3)."""
    return np.stack((position[..., ANKLES, :], position[..., BALLS, :]), axis=-2)


class StandingFeet:
    """Reader of standing feet that knows positions only: feed it every frame, then ask for `speeds`."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._before: Float | None = None
        self._lowest: Float64 = np.zeros(0)
        self._found: list[tuple[Int64, Float64, Float64]] = []

    def add(self, position: Float) -> None:
        """Add the next frame: joints of all dancers, (A, J, 3) [m]."""
        points = foot_points(position).astype(np.float64).reshape(-1, 2, 3)
        height = points[..., 1]
        self._lowest = height.copy() if self._before is None else np.minimum(self._lowest, height)
        if self._before is not None:
            moved = points - self._before
            speed = np.hypot(moved[..., 0], moved[..., 2]) * self._rate
            still, foot = speed.argmin(axis=-1), np.arange(len(speed))
            speed, high = speed[foot, still], height[foot, still]
            may = (speed < STILL_SPEED) & (high < self._lowest[foot, still] + LOW_HEIGHT)  # lowest only gets lower
            self._found.append((2 * foot[may] + still[may], speed[may], high[may]))
        self._before = points

    def speeds(self) -> Float64:
        """Speeds over the floor [m/s] of the stillest point of feet that stand, (n,)."""
        if not self._found:
            return np.zeros(0)
        point, speed, high = (np.concatenate(parts) for parts in zip(*self._found, strict=True))
        return np.asarray(speed[high < self._lowest.reshape(-1)[point] + LOW_HEIGHT])


ACCELERATION_WINDOW: Final = 3
"""Samples over which velocities are averaged before accelerations, because recorded markers jitter."""
MIN_HALF_WIDTH: Final = 0.2
"""Minimum seconds before and after the middle of a transition that are evaluated."""
BLEND_MARGIN: Final = 0.05
"""Seconds evaluated before and after the blend of a transition."""
RANDOM_POSITIONS: Final = 4000
"""Number of random positions in the raw clips with which transitions are compared."""


def velocity_changes(position: Float, rate: float) -> Float64:
    """Change of each joint's velocity at the samples between the first and last [m/s], (T - 2, ...) of (T, ..., 3)."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    return np.asarray(np.linalg.norm(np.diff(velocity, axis=0), axis=-1), np.float64)


def accelerations(position: Float, rate: float) -> Float64:
    """Accelerations [m/s²], velocities averaged over three samples, (T - 4, ...) from (T, ..., 3): none at the ends."""
    velocity = np.diff(position.astype(np.float64), axis=0) * rate
    if len(velocity) < ACCELERATION_WINDOW + 1:
        return np.zeros((0, *velocity.shape[1:-1]))
    windows = np.lib.stride_tricks.sliding_window_view(velocity, ACCELERATION_WINDOW, axis=0)
    return np.asarray(np.linalg.norm(np.diff(windows.mean(axis=-1), axis=0), axis=-1) * rate, np.float64)


def strict_ratios(joins: Float64, unjoined: Float64) -> Float64:
    """Return the strict ratio of each join, (K,), from the largest velocity changes of each joint around it, (K, J).

    It is the largest, over all joints, of the change relative to the 99th percentile of the same joint in `unjoined`
    (M, J), the same at random moments of the raw clips. Joints that hardly move in the clips are measured at 0.1 m/s.
    """
    usual = np.maximum(np.percentile(unjoined, 99, axis=0), MIN_USUAL_CHANGE)
    return np.asarray((joins / usual).max(axis=1), np.float64)


def largest_at_samples(position: Float, rate: float) -> tuple[Float64, Float64]:
    """Return the largest velocity change [m/s] and acceleration [m/s²] of any joint per sample, (T, ...).

    `position` is (T, ..., J, 3). 0 at the first and last samples, where there is none.
    """
    shape = position.shape[:-2]
    change, acceleration = np.zeros(shape), np.zeros(shape)
    if len(position) > 2:
        change[1:-1] = velocity_changes(position, rate).max(axis=-1)
    if len(position) > ACCELERATION_WINDOW + 1:
        acceleration[2:-2] = accelerations(position, rate).max(axis=-1)
    return change, acceleration


MIN_USUAL_CHANGE: Final = 0.1
"""Least 99th percentile of a joint's velocity changes [m/s]: less is measurement noise."""


def half_width(blend: float) -> float:
    """Return the seconds evaluated before and after the middle of a transition with a blend of `blend` seconds."""
    return max(MIN_HALF_WIDTH, 0.5 * blend + BLEND_MARGIN)


def largest_around(values: Float64, middle: Float64, half: float, rate: float) -> Float64:
    """Return the largest of `values` (T,) within `half` seconds of each of the times `middle` (n,) [s], (n,)."""
    first = np.clip(np.ceil((middle - half) * rate - 1e-6).astype(np.int64), 0, len(values) - 1)
    last = np.clip(np.floor((middle + half) * rate + 1e-6).astype(np.int64), 0, len(values) - 1)
    width = int((last - first).max(initial=0)) + 1
    rows = np.minimum(first[:, None] + np.arange(width), last[:, None])
    return np.asarray(values[rows].max(axis=1), np.float64)


def raw_p99(traces: Sequence[Float64], half: float, rate: float, *, seed: int = 0) -> float:
    """Return p99 of the largest value within `half` seconds of random samples of the raw clips' `traces`, each (T,).

    Positions are drawn uniformly from all samples of all clips with `half` seconds on both sides; of a shorter clip
    the middle is used. 0 if there is no clip.
    """
    if not traces:
        return 0.0
    found = [
        largest_around(traces[clip], places / rate, half, rate)
        for clip, places in _random_places([len(trace) for trace in traces], half * rate, seed)
    ]
    return float(np.percentile(np.concatenate(found), 99))


def random_changes(changes: Sequence[Float64], half: float, rate: float, *, seed: int = 0) -> Float64:
    """Return the largest velocity change of each joint within `half` seconds of random samples, (M, J).

    `changes` (T, J) of each clip, as of `velocity_changes`; the positions are drawn as in `raw_p99`.
    """
    return np.concatenate(
        [
            np.stack([largest_around(joint, places / rate, half, rate) for joint in changes[clip].T], axis=1)
            for clip, places in _random_places([len(change) for change in changes], half * rate, seed)
        ]
    )


def _random_places(lengths: Sequence[int], margin: float, seed: int) -> Iterator[tuple[int, Float64]]:
    """Yield clips of so many samples, and random positions in them with `margin` samples on both sides."""
    chance = np.random.default_rng(seed)
    room = np.array([max(length - 1 - 2.0 * margin, 0.0) + 1.0 for length in lengths])
    clip = chance.choice(len(lengths), RANDOM_POSITIONS, p=room / room.sum())
    for n, length in enumerate(lengths):
        places = chance.uniform(0.0, room[n] - 1.0, int((clip == n).sum())) + min(margin, 0.5 * (length - 1))
        if len(places):
            yield n, places
