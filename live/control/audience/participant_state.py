"""State of each phone's voice.

Each phone has one voice. Its weight is its region's weight; after the finger is lifted it halves every second.
`voice_sketch` says which places many voices chose.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.control.audience.phone_protocol import FULL_SCALE, TOUCH_DTYPE
from live.control.audience.voice_sketch import VoiceSketch, grid_of, merge, whole_weights

FRESH_SECONDS: Final = 0.75
"""A voice keeps its full weight this long [s] after its last message; resting fingers send three messages a second."""
FADE_HALF_LIFE: Final = 1.0
"""Half-life [s] of a voice after that."""
MIN_FRESHNESS: Final = 0.05
"""A voice below this share of its weight is ignored."""
SHAKE_SECONDS: Final = 1.0
"""A shake counts this long [s]."""


class Hearing(IntEnum):
    """What becomes of a phone's touch; phones are told the number."""

    SILENT = 0
    """It says nothing."""
    HEARD = 1
    """It counts."""
    SEEN = 2
    """It counts, and its light is on the stage."""
    WAITS = 3
    """Another region has its turn."""
    NO_VOICE = 4
    """It does not count: its place is crowded, its region has no weight, or the show does not answer."""


class Voices:
    """Voices in rows, one per connected phone. Thread: one."""

    def __init__(self, most: int) -> None:
        """`most`: maximum number of simultaneous phones."""
        self.x: Float64 = np.zeros(most)
        self.z: Float64 = np.zeros(most)
        self.message_time: Float64 = np.full(most, -np.inf)
        """Time of each row's last message [s]."""
        self.shake_time: Float64 = np.full(most, -np.inf)
        self.mode = np.zeros(most, np.int8)
        self.touching = np.zeros(most, np.bool_)
        """Whether the finger is on the screen."""
        self.region = np.zeros(most, np.int64)
        self.number = np.zeros(most, np.int64)
        """The phone's number; 0: the row is free."""
        self.allowed = np.ones(most, np.bool_)
        """False for a banned phone."""
        self.share: Float64 = np.ones(most)
        """Fraction of a voice of each row."""
        self.told_hearing: npt.NDArray[np.int8] = np.zeros(most, np.int8)
        """The `Hearing` that each row's phone was last told."""
        self.pending_touches: dict[int, tuple[bytes, float]] = {}
        """Latest raw message and its time [s] of each row since the last `apply_touches`."""
        self._free = list(range(most - 1, -1, -1))
        self._weights: Float64 = np.ones(1)
        self._half = (6.0, 4.0)

    @property
    def count(self) -> int:
        """Number of connected phones."""
        return len(self.number) - len(self._free)

    def add(self, number: int, region: int, *, allowed: bool) -> int:
        """Add a phone; return its row, -1 if there is no room."""
        if not self._free:
            return -1
        row = self._free.pop()
        self.number[row], self.region[row], self.allowed[row] = number, region, allowed
        self.mode[row], self.touching[row], self.share[row] = 0, False, 1.0
        self.told_hearing[row] = Hearing.SILENT
        self.message_time[row] = self.shake_time[row] = -np.inf
        return row

    def remove(self, row: int) -> None:
        """Free a row."""
        self.number[row] = 0
        self.mode[row] = 0
        self.pending_touches.pop(row, None)
        self._free.append(row)

    def update_rules(self, weights: Sequence[float], banned: Sequence[int], half: tuple[float, float]) -> None:
        """Set the regions' weights, the banned phones, and the stage's half sizes [m]."""
        self._weights = np.array(weights or [1.0], np.float64)
        self.allowed = ~np.isin(self.number, np.array(banned, np.int64))
        self._half = half

    def apply_touches(self) -> None:
        """Apply the collected touch messages, which are well formed (see `phone_protocol`)."""
        if not self.pending_touches:
            return
        rows = np.fromiter(self.pending_touches, np.int64, len(self.pending_touches))
        said = np.frombuffer(b"".join(data for data, _ in self.pending_touches.values()), TOUCH_DTYPE)
        self.message_time[rows] = [when for _, when in self.pending_touches.values()]
        self.pending_touches.clear()
        self.touching[rows] = said["mode"] != 0
        there = said["mode"] != 0
        rows, said = rows[there], said[there]
        self.mode[rows] = said["mode"]
        self.x[rows] = (2.0 * said["x"] / FULL_SCALE - 1.0) * self._half[0]
        self.z[rows] = (2.0 * said["z"] / FULL_SCALE - 1.0) * self._half[1]

    def weights(self, now: float) -> Float64:
        """Return the present weight of each row, (N,)."""
        fresh = self._freshness(now)
        weight = self._region_weights() * self.share * fresh
        weight[(fresh < MIN_FRESHNESS) | (self.mode == 0) | ~self.allowed] = 0.0
        return weight

    def _freshness(self, now: float) -> Float64:
        """Return the share of its weight that each row's voice has left, (N,)."""
        age = np.maximum(now - self.message_time - FRESH_SECONDS * self.touching, 0.0)
        fresh: Float64 = 0.5 ** (age / FADE_HALF_LIFE)
        return fresh

    def _region_weights(self) -> Float64:
        """Return the weight of each row's region, (N,)."""
        weights: Float64 = self._weights[np.minimum(self.region, len(self._weights) - 1)]
        return weights

    def hearing(self, now: float, seen: Sequence[int], *, turn: int, answers: bool) -> npt.NDArray[np.int8]:
        """Return the `Hearing` of each row, (N,).

        `seen`: highlighted rows; `turn`: the region that has its turn, -1: none; `answers`: whether the show does.
        Banned phones are told the same as if they were not.
        """
        found = np.full(len(self.number), Hearing.HEARD, np.int8)
        found[list(seen)] = Hearing.SEEN
        found[self._region_weights() == 0.0] = Hearing.NO_VOICE
        if turn >= 0:
            found[(found == Hearing.NO_VOICE) & (self.region != turn)] = Hearing.WAITS
        found[self.share == 0.0] = Hearing.NO_VOICE
        if not answers:
            found[:] = Hearing.NO_VOICE
        found[(self._freshness(now) < MIN_FRESHNESS) | (self.mode == 0) | (self.number == 0)] = Hearing.SILENT
        return found

    def people(self) -> float:
        """Return the total number of voices, speaking or not; fractions of a voice are added."""
        return float(self.share[(self.number > 0) & self.allowed].sum())

    def sketch(self, now: float, weight: Float64 | None = None) -> VoiceSketch:
        """Return the sketch of all voices; `weight`: the result of `weights`, if known."""
        weight = self.weights(now) if weight is None else weight
        whole = whole_weights(weight)
        rows = np.flatnonzero(whole)
        there = self.allowed & (self.number > 0)
        shares = whole_weights(self.share)
        shaken = (now - self.shake_time < SHAKE_SECONDS) & there
        return VoiceSketch.of_voices(
            grid_of(self._half), self.x[rows], self.z[rows], whole[rows], self.mode[rows], int(shares[there].sum()),
            int(shares[shaken].sum()),
        )  # fmt: skip

    def silence(self) -> VoiceSketch:
        """Return the sketch of voices that nobody listens to."""
        return merge(grid_of(self._half), ())
