"""Notation of what a couple danced, in Laban-like words, count by count of the music (H026).

The paper proposes to transcribe motion into symbols or Laban notation (Hsu, Gentry, Popović, 2004, section 7). Words
are those of Labanotation's support column (A. Hutchinson Guest, *Labanotation*): which foot takes the weight, in which
direction the weight moves as the dancer faces, at which level (low: knees bent, high: on the toes), and how far the
dancer turns within the count, in eighths. Hands that are held and the couple's stance stand beside it. It is a record
for readers, and not complete enough to dance from.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.beats.dance_rhythm import gaussian_smooth
from live.motion.clip import Clip
from live.motion.editing.facing import heading_of
from live.motion.partner.couple_states import CoupleStates, Stance
from live.motion.partner.evaluation import joint_positions
from live.motion.skeleton import SKELETON

DIRECTIONS: Final = (
    "forward", "left forward", "left", "left back", "back", "right back", "right", "right forward",
)  # fmt: skip
"""Directions of the weight as the dancer faces, counterclockwise from above."""
PLACE: Final = "place"
PLACE_M: Final = 0.12
"""Weight that moves less than this within a count stays in place [m]."""
LOW_M: Final = 0.045
"""Hips so far below their usual height are at a low level [m];"""
HIGH_M: Final = 0.03
"""so far above, at a high one [m]."""
BEFORE_COUNT: Final = 0.35
"""A step so many counts before a count belongs to it: dancers step on the count, a little early or late."""
EIGHTH: Final = 0.25 * np.pi
SWING_SPEED: Final = 0.5
"""A foot that is faster swings [m/s];"""
REST_SPEED: Final = 0.3
"""one that gets slower than this has landed [m/s]. Recorded contacts are not used: bodies that were fitted to another
skeleton may float over the floor."""
SPEED_SMOOTHING_S: Final = 0.033
AIR_M: Final = 0.1
"""Both feet so far over their usual lowest height are in the air [m]."""
_FOOT_ENDS: Final = tuple(tuple(SKELETON.index(side + end) for end in ("Foot", "Toes")) for side in ("left", "right"))


@dataclass(frozen=True, slots=True)
class Movement:
    """What one dancer does in a count."""

    support: str
    """`left` or `right`: that foot takes the weight; `both`; `hold`: the weight stays; `air`: no foot on the floor."""
    direction: str
    """One of `DIRECTIONS`, or `place`."""
    level: str
    """`low`, `middle` or `high`."""
    turn: int
    """Eighths of a turn, positive to the left."""

    @property
    def words(self) -> str:
        """It for readers, as `left, back, low, 2/8 to the right`."""
        way = "" if self.turn == 0 else f", {abs(self.turn)}/8 to the {'left' if self.turn > 0 else 'right'}"
        return f"{self.support}, {self.direction}, {self.level}{way}"


@dataclass(frozen=True, slots=True)
class CountNotation:
    """One count of the music."""

    count: int
    """From 1 to the number of counts of a pattern."""
    begin: float
    """Time [s]."""
    leader: Movement
    follower: Movement
    hands: str
    """Held hands, the leader's first, as `left-right`; empty: none."""
    stance: Stance
    turn: str
    """The follower's turn that goes on, as `inside turn`; empty: none."""


def notate(
    leader: Clip, follower: Clip, states: CoupleStates, beats: Float64, *, counts: int, first: int = 0
) -> tuple[CountNotation, ...]:
    """Return the notation of all counts that lie within both clips; `beats`: their samples (n,), ascending.

    `counts`: counts of a pattern; the beat of index `first` is a one.
    """
    last = min(leader.sample_count, follower.sample_count) - 1.0
    inside = np.flatnonzero((beats >= 0.0) & (beats <= last))
    if len(inside) < 2:
        return ()
    movements = [_movements(clip, beats[inside]) for clip in (leader, follower)]
    found = []
    for n, index in enumerate(inside[:-1].tolist()):
        middle = 0.5 * (float(beats[index]) + float(beats[index + 1]))
        turn = states.turn_at(middle)
        found.append(
            CountNotation(
                (index - first) % counts + 1, float(beats[index]) / follower.sample_rate, movements[0][n],
                movements[1][n], _hands_words(states, middle), Stance(int(states.stance[round(middle)])),
                "" if turn is None else turn.words,
            )
        )  # fmt: skip
    return tuple(found)


def _hands_words(states: CoupleStates, sample: float) -> str:
    names = ("left", "right")
    return " ".join(f"{names[one]}-{names[other]}" for one, other in states.hands_at(sample))


def _movements(clip: Clip, beats: Float64) -> list[Movement]:
    """Return what a dancer does from each beat to the next, (n - 1)."""
    joints = joint_positions(clip)
    weight = joints[:, 0, 2] + 1j * joints[:, 0, 0]
    height = joints[:, 0, 1]
    usual = float(np.median(height))
    heading = np.unwrap(heading_of(clip.rotation[:, 0]))
    landed = foot_landings(joints, clip.sample_rate)
    lowest = np.stack([joints[:, ends, 1].min(axis=1) for ends in _FOOT_ENDS], axis=1)
    in_air = (lowest > np.percentile(lowest, 5, axis=0) + AIR_M).all(axis=1)
    found = []
    told = float(heading[round(beats[0])])  # the heading as the eighths so far tell it, so that they add up
    for begin, end in zip(beats[:-1].tolist(), beats[1:].tolist(), strict=True):
        early = BEFORE_COUNT * (end - begin)
        lands = [bool(((one >= begin - early) & (one < end - early)).any()) for one in landed]
        i, j = round(begin), min(round(end), clip.sample_count - 1)
        moved = complex(weight[j] - weight[i]) * np.exp(-1j * heading[i : j + 1].mean())
        level = float(height[i : j + 1].min()) - usual, float(height[i : j + 1].max()) - usual
        words = "low" if level[0] < -LOW_M else "high" if level[1] > HIGH_M else "middle"
        turn = round((float(heading[j]) - told) / EIGHTH)
        told += turn * EIGHTH
        found.append(Movement(_support(lands, bool(in_air[i : j + 1].mean() > 0.5)), _direction(moved), words, turn))
    return found


def foot_landings(joints: Float64, rate: float) -> tuple[Float64, Float64]:
    """Return the samples at which the left and the right foot land, from the speed of the slower end of each foot."""
    speed = np.linalg.norm(np.gradient(joints, axis=0), axis=-1) * rate
    found = []
    for ends in _FOOT_ENDS:
        own = gaussian_smooth(speed[:, ends].min(axis=1), SPEED_SMOOTHING_S * rate)
        change = np.where(own > SWING_SPEED, 1, np.where(own < REST_SPEED, -1, 0))
        latest = np.maximum.accumulate(np.where(change != 0, np.arange(len(change)), -1))
        swings = (latest >= 0) & (change[np.maximum(latest, 0)] > 0)
        found.append(np.asarray(np.flatnonzero(swings[:-1] & ~swings[1:]) + 1, np.float64))
    return found[0], found[1]


def _support(lands: Sequence[bool], in_air: bool) -> str:
    if all(lands):
        return "both"
    if any(lands):
        return "left" if lands[0] else "right"
    return "air" if in_air else "hold"


def _direction(moved: complex) -> str:
    """Return the word for a way on the floor, ahead + i left [m]."""
    if abs(moved) < PLACE_M:
        return PLACE
    return DIRECTIONS[round(float(np.angle(moved)) / EIGHTH) % len(DIRECTIONS)]


def notation_text(counts: Sequence[CountNotation], *, names: Sequence[str] = ()) -> str:
    """Return a table as text, one line for each count; `names`: what else is known of each, as the units danced."""
    heading = (" time", "count", "leader", "follower", "hands", "stance", "danced")
    rows = [
        (
            f"{one.begin:6.2f}", str(one.count), one.leader.words, one.follower.words, one.hands or "-",
            one.stance.words + (f", {one.turn}" if one.turn else ""), name,
        )
        for one, name in zip(counts, names or [""] * len(counts), strict=True)
    ]  # fmt: skip
    wide = [max(len(row[n]) for row in (heading, *rows)) for n in range(len(heading))]
    lines = ["  ".join(word.ljust(size) for word, size in zip(row, wide, strict=True)) for row in (heading, *rows)]
    return "\n".join(line.rstrip() for line in lines) + "\n"
