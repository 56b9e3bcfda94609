"""Locomotion: where each dancer is and whither she faces at every beat; the lowest of the three levels (T085, T088)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import places_at

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]


class Setting:
    """Where dancers are, how they move and whither they face at one beat: arrays that are filled again and again."""

    def __init__(self, dancer_count: int) -> None:
        self.position: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Place (x, z) [m], shape (D, 2)."""
        self.velocity: Float32 = np.zeros((dancer_count, 2), np.float32)
        """Velocity [m per beat], shape (D, 2)."""
        self.heading: Float32 = np.zeros(dancer_count, np.float32)
        """Heading [rad], shape (D,); unwrapped, so that the way of turning shows."""
        self.under: npt.NDArray[np.uint8] = np.zeros(dancer_count, np.uint8)
        """1 for whom the rest means anything, shape (D,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Locomotion:
    """What D dancers do from a beat to a beat, as knots; before they stand at its start, afterwards at its end."""

    ways: Float32
    """Knots at even shares of each way [m], shape (D, K, 2), K at least 2; two knots are a straight line."""
    times: Float64
    """Beats at which each dancer starts and arrives, shape (D, 2)."""
    turns: Float64
    """Knots (beat, unwrapped heading [rad]) in the order of beats, shape (D, H, 2), H at least 1."""
    soft: float = 0.25
    """Share of her time in which a dancer gathers speed, and loses it again; 0: constant speed. The same for all."""

    def __post_init__(self) -> None:
        count = len(self.ways)
        if self.ways.ndim != 3 or self.ways.shape[1] < 2 or self.ways.shape[2] != 2:
            raise ValueError(f"ways have the shape (D, K, 2) with at least two knots, not {self.ways.shape}")
        if self.times.shape != (count, 2) or self.turns.ndim != 3 or self.turns.shape[::2] != (count, 2):
            raise ValueError(f"times {self.times.shape} and turns {self.turns.shape} do not fit {count} dancers")
        if not 0.0 <= self.soft <= 0.5:
            raise ValueError(f"soft is a share from 0 to 0.5, not {self.soft}")
        if (self.times[:, 1] < self.times[:, 0]).any():
            raise ValueError("a dancer would arrive before she starts")

    @property
    def count(self) -> int:
        """Number of dancers D."""
        return len(self.ways)

    @property
    def begin(self) -> float:
        """The beat at which the first starts."""
        return float(self.times[:, 0].min()) if self.count else 0.0

    @property
    def end(self) -> float:
        """The beat at which the last has arrived."""
        return float(self.times[:, 1].max()) if self.count else 0.0

    def at(self, beat: float, out: Setting) -> None:
        """Fill `out` (of D dancers) with where they are at `beat`."""
        everyone = np.arange(self.count, dtype=np.int32)
        keep = np.ones(self.count, np.uint8)
        self.write(beat, everyone, keep, out)

    def write(self, beat: float, who: npt.NDArray[np.int32], keep: npt.NDArray[np.uint8], out: Setting) -> None:
        """Fill the rows `who` (D,) of `out` (A dancers) where `keep` (D,) is 1; nothing is allocated."""
        places_at(
            beat,
            self.ways,
            self.times,
            self.soft,
            self.turns,
            who,
            keep,
            out.position,
            out.velocity,
            out.heading,
            out.under,
        )

    def sampled(self, beats: npt.ArrayLike) -> tuple[Float32, Float32]:
        """Places (T, D, 2) [m] and headings (T, D) [rad] at T beats: for drawing, checks and plans."""
        when = np.atleast_1d(np.asarray(beats, np.float64))
        out = Setting(self.count)
        places = np.empty((len(when), self.count, 2), np.float32)
        headings = np.empty((len(when), self.count), np.float32)
        for row, beat in enumerate(when):
            self.at(float(beat), out)
            places[row], headings[row] = out.position, out.heading
        return places, headings
