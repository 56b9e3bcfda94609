"""Recorder for motion metrics of many dancers during playback, frame by frame, in little memory."""

from collections import deque
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.motion.editing.foot_correction import BALLS
from live.motion.quality.metrics import (
    SKATING_RATE,
    PositionFigures,
    StandingFeet,
    largest_at_samples,
    mean_speed,
    skating_balls,
    velocity_changes,
)

BLOCK = 64
"""Frames processed together."""
OVERLAP = 4
"""Frames of the previous block needed by the next: accelerations need two on both sides."""
RECENT: Final = 5.0
"""Seconds for which the velocity changes of single joints are kept."""


class MotionRecorder:
    """Records frames evenly spaced at `rate` per second; results are read after the last frame.

    It keeps three numbers per dancer and frame, and the balls of the feet at 20 frames per second.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._pending: list[Float32] = []
        self._change: list[Float64] = []
        self._acceleration: list[Float64] = []
        self._speed: list[Float64] = []
        self._balls: list[Float32] = []
        self._feet = StandingFeet(rate)
        self._recent: deque[tuple[int, Float32]] = deque()  # first frame and changes (n, A, J) of the latest blocks
        self._known = 1  # frames whose changes are known, but for the first, which has none
        self.count = 0

    def add(self, position: Float32) -> None:
        """Add the next frame: joints of all dancers, (A, J, 3) [m]; copied."""
        picture = np.array(position, np.float32)
        self.count += 1
        self._pending.append(picture)
        self._record_balls(picture)
        self._feet.add(picture)
        if len(self._pending) >= BLOCK + OVERLAP:
            self._process()

    def largest(self) -> tuple[Float64, Float64]:
        """Return the largest velocity change [m/s] and acceleration [m/s²] of any joint per frame, (T, A) each."""
        self._process()
        return self._concatenate(self._change, 1), self._concatenate(self._acceleration, 2)

    def speeds(self) -> Float64:
        """Return the mean speed of the joints between neighbouring frames [m/s], (T - 1, A)."""
        self._process()
        return np.concatenate(self._speed) if self._speed else np.zeros((0, 0))

    def skating_ratio(self) -> float | None:
        """Share of dancer frames, at 20 per second, in which a foot skates; None for fewer than two frames."""
        found = skating_balls(np.stack(self._balls)) if self._balls else np.zeros((0, 0), np.bool_)
        return float(found.mean()) if found.size else None

    def largest_by_joint(self, first: int, last: int) -> Float32:
        """Return the largest velocity change [m/s] of each joint in the frames `first` to `last` (inclusive), (A, J).

        They must lie within the last RECENT seconds, and two frames must have followed.
        """
        self._process()
        parts = [block[max(first - begin, 0) : last + 1 - begin] for begin, block in self._recent if begin <= last]
        return np.asarray(np.concatenate([part for part in parts if len(part)]).max(axis=0))

    def position_figures(self) -> PositionFigures:
        """Return the figures of the feet from positions alone."""
        speeds = self._feet.speeds()
        balls = np.stack(self._balls) if self._balls else np.zeros((0, 0, 2, 3), np.float32)
        skates = skating_balls(balls, balls[..., 1].min(axis=0)) if len(balls) else np.zeros((0, 0), np.bool_)
        return PositionFigures(
            float(speeds.mean()) if len(speeds) else None,
            float(np.percentile(speeds, 99)) if len(speeds) else None,
            float(skates.mean()) if skates.size else None,
        )

    def _record_balls(self, picture: Float32) -> None:
        """Record the balls at the times k / 20 s between the previous frame and this one, interpolated."""
        if len(self._pending) < 2:
            self._balls.append(picture[:, BALLS])
            return
        before, now = self._pending[-2][:, BALLS], picture[:, BALLS]
        while (at := len(self._balls) * self._rate / SKATING_RATE) <= self.count - 1 + 1e-6:
            part = np.float32(at - (self.count - 2))
            self._balls.append((1 - part) * before + part * now)

    def _concatenate(self, blocks: list[Float64], edge: int) -> Float64:
        """Return the concatenated blocks, with zeros for the frames at both ends without a value."""
        if not blocks:
            return np.zeros((self.count, 0))
        zeros = np.zeros((edge, blocks[0].shape[1]))
        return np.concatenate([zeros, *blocks, zeros])[: self.count]

    def _process(self) -> None:
        """Process the pending frames; keep the last OVERLAP of them."""
        if len(self._pending) <= OVERLAP:
            return
        block = np.stack(self._pending)
        change, acceleration = largest_at_samples(block, self._rate)
        fresh = slice(1, -1) if not self._change else slice(OVERLAP - 1, -1)
        joints = velocity_changes(block, self._rate)[fresh.start - 1 :].astype(np.float32)
        self._recent.append((self._known, joints))
        self._known += len(joints)
        while self._recent[0][0] + len(self._recent[0][1]) < self.count - RECENT * self._rate:
            self._recent.popleft()
        self._change.append(change[fresh])
        self._acceleration.append(acceleration[2:-2])
        self._speed.append(mean_speed(block, self._rate)[0 if len(self._speed) == 0 else OVERLAP - 1 :])
        self._pending = self._pending[-OVERLAP:]
