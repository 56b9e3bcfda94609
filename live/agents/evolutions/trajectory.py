"""Locomotion: place and heading of each dancer at every beat, the lowest of the three planning levels (T085, T088)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import evaluate_paths
from live.base.arrays import Float32, Float64


class GroupState:
    """Places, velocities and headings of dancers at one beat; the arrays are reused."""

    def __init__(self, dancer_count: int) -> None:
        self.position: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Place (x, z) [m], shape (D, 2)."""
        self.velocity: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Velocity [m per beat], shape (D, 2)."""
        self.heading: Float32 = np.zeros(dancer_count, np.float32)
        """Heading [rad], shape (D,); unwrapped, so that the direction of turning is kept."""
        self.controlled: npt.NDArray[np.uint8] = np.zeros(dancer_count, np.uint8)
        """1 for dancers whose row is valid, shape (D,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Locomotion:
    """Motion of D dancers between two beats, as knots; before it they stand at the start, after it at the end."""

    path_knots: Float32
    """Knots at even shares of each path [m], shape (D, K, 2), K at least 2; two knots are a straight line."""
    times: Float64
    """Beats at which each dancer starts and arrives, shape (D, 2)."""
    turns: Float64
    """Knots (beat, unwrapped heading [rad]) in order of beats, shape (D, H, 2), H at least 1."""
    ramp: float = 0.25
    """Share of a dancer's time used to accelerate, and to decelerate; 0: constant speed. The same for all."""

    def __post_init__(self) -> None:
        count = len(self.path_knots)
        if self.path_knots.ndim != 3 or self.path_knots.shape[1] < 2 or self.path_knots.shape[2] != 2:
            raise ValueError(f"ways have the shape (D, K, 2) with at least two knots, not {self.path_knots.shape}")
        if self.times.shape != (count, 2) or self.turns.ndim != 3 or self.turns.shape[::2] != (count, 2):
            raise ValueError(f"times {self.times.shape} and turns {self.turns.shape} do not fit {count} dancers")
        if not 0.0 <= self.ramp <= 0.5:
            raise ValueError(f"soft is a share from 0 to 0.5, not {self.ramp}")
        if (self.times[:, 1] < self.times[:, 0]).any():
            raise ValueError("a dancer would arrive before they start")

    @property
    def count(self) -> int:
        """Number of dancers D."""
        return len(self.path_knots)

    @property
    def begin(self) -> float:
        """The beat at which the first dancer starts."""
        return float(self.times[:, 0].min()) if self.count else 0.0

    @property
    def end(self) -> float:
        """The beat at which the last dancer has arrived."""
        return float(self.times[:, 1].max()) if self.count else 0.0

    def evaluate(self, beat: float, out: GroupState) -> None:
        """Fill `out` (of D dancers) with their state at `beat`."""
        everyone = np.arange(self.count, dtype=np.int32)
        keep = np.ones(self.count, np.uint8)
        self.write(beat, everyone, keep, out)

    def write(self, beat: float, who: npt.NDArray[np.int32], keep: npt.NDArray[np.uint8], out: GroupState) -> None:
        """Fill the rows `who` (D,) of `out` (A dancers) where `keep` (D,) is 1; allocates nothing."""
        evaluate_paths(
            beat,
            self.path_knots,
            self.times,
            self.ramp,
            self.turns,
            who,
            keep,
            out.position,
            out.velocity,
            out.heading,
            out.controlled,
        )

    def sample(self, beats: npt.ArrayLike) -> tuple[Float32, Float32]:
        """Return places (T, D, 2) [m] and headings (T, D) [rad] at T beats, for drawing, checks and plans."""
        when = np.atleast_1d(np.asarray(beats, np.float64))
        out = GroupState(self.count)
        places = np.empty((len(when), self.count, 2), np.float32)
        headings = np.empty((len(when), self.count), np.float32)
        for row, beat in enumerate(when):
            self.evaluate(float(beat), out)
            places[row], headings[row] = out.position, out.heading
        return places, headings
