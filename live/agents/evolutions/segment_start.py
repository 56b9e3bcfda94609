"""The starting state of a segment (departure) and the planned result (journey)."""

from collections.abc import Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.trajectory import Locomotion
from live.base.arrays import Float64

if TYPE_CHECKING:
    from live.agents.evolutions.collision_check import Approach


@dataclass(frozen=True, slots=True, eq=False)
class SegmentStart:
    """The boundary condition at the start: places and headings of D dancers, and the time available."""

    dancer_indices: npt.NDArray[np.int32]
    """Indices among all dancers, shape (D,)."""
    position: Float64
    """Places [m], shape (D, 2)."""
    heading: Float64
    """Headings [rad], shape (D,)."""
    attributes: tuple[Set[str], ...]
    """The attributes of each dancer, length D."""
    begin: float
    """Beat of the start."""
    end: float
    """Beat by which all dancers have arrived."""
    measure_beats: float
    """Beats of a measure."""
    radius: Float64
    """Body radii [m], shape (D,)."""
    half_stage: tuple[float, float]
    """Half the width and depth of the stage [m]."""
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMotion:
    """The locomotion of a segment, with the results of the collision check."""

    locomotion: Locomotion
    slot: npt.NDArray[np.int32]
    """Slot of the formation that each dancer goes to, shape (D,); -1: none."""
    retimed: int = 0
    """Number of dancers whose start time was changed to avoid collisions."""
    bent: bool = False
    """Whether paths were bent to avoid collisions."""
    remaining: "tuple[Approach, ...]" = ()
    """Pairs (rows of the locomotion) whose bodies would touch on these paths: left to steering."""
    checked: bool = True
    """Whether clearance was checked; the largest groups are not checked."""


@dataclass(slots=True, eq=False)
class MotionDraft:
    """The journey as soon as slots are assigned, before collision repair."""

    motion: PlannedMotion | None = None
    urgent: bool = False
    """Whether the segment begins now: places are given at once, if need be not the best ones."""
