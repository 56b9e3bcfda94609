"""Seed: what the hand says that a tracker of sound should know, too."""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["tempo", "one", "scale", "metre", "forget"]


@dataclass(frozen=True, slots=True)
class Seed:
    """One hint, for whoever tracks the sound.

    tempo: `value` bpm, with a beat at `time` (NaN: nobody says where); one: a downbeat at `time`; scale: from now on
    `value` times as many beats; metre: measures have `value` beats; forget: the hand's hints are void (the operator
    restarted the sound).
    """

    kind: Kind
    time: float
    """Seconds of the show."""
    value: float = 0.0
