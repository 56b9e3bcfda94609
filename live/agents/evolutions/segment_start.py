"""Departure and journey: what a segment begins with, and what is worked out of it."""

from collections.abc import Set
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.collision_check import Approach
from live.agents.evolutions.trajectory import Float64, Locomotion


@dataclass(frozen=True, slots=True, eq=False)
class Departure:
    """The boundary condition at the start: D dancers, where they stand and face, and the time there is."""

    numbers: npt.NDArray[np.int32]
    """Their indices among all dancers, shape (D,)."""
    position: Float64
    """Places [m], shape (D, 2)."""
    heading: Float64
    """Headings [rad], shape (D,)."""
    words: tuple[Set[str], ...]
    """The attributes of each, length D."""
    begin: float
    """Beat of the start."""
    end: float
    """Beat by which all have arrived."""
    measure_beats: float
    """Beats of a measure."""
    radius: Float64
    """Body radii [m], shape (D,)."""
    half: tuple[float, float]
    """Half the width and depth of the stage [m]."""
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Journey:
    """The locomotion of a segment, and what there is to say of it."""

    locomotion: Locomotion
    slot: npt.NDArray[np.int32]
    """Slot of the formation that each dancer goes to, shape (D,); -1: none."""
    retimed: int = 0
    """How many dancers start at another time than asked, so that nobody meets."""
    bent: bool = False
    """Whether ways were bent, so that nobody meets."""
    remaining: tuple[Approach, ...] = ()
    """Pairs (rows of the locomotion) that come nearer than their bodies on these ways: left to steering."""
    checked: bool = True
    """Whether clearance was looked at; not of the largest groups."""


@dataclass(slots=True, eq=False)
class Draft:
    """What is known of a journey as soon as everybody has her place: the ways before they are mended."""

    journey: Journey | None = None
