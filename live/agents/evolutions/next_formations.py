"""Which formations could come next: known ones ranked by the ways into them, from where dancers stand now (T096, T110).

After a crossing or another element dancers stand where it left them. Each known formation is planned from there as a
segment would plan it, with straight ways, and the plans are compared.
"""

from collections.abc import Iterable, Set
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import Evolve, FormationLike, PathMode, Repertoire, Segment
from live.agents.evolutions.segment_start import MotionDraft, PlannedMotion, SegmentStart
from live.agents.evolutions.slot_assignment import assign, distances
from live.agents.evolutions.trajectory import Locomotion
from live.agents.evolutions.trajectory_builder import plan_segment
from live.base.arrays import Float64, Int32

MOST_MEASURES: Final = 8
"""Most measures of a way into a formation, unless the caller allows fewer."""
MEETING_COST: Final = 1.0
"""Cost if every dancer meets another one on the way [m of way for each dancer]."""
MIXING_COST: Final = 3.0
"""Cost if groups that were wholly apart are wholly mixed [m]."""
REPEAT_COST: Final = 4.0
"""Cost of the formation that was there before [m]."""
MEASURE_COST: Final = 0.3
"""Cost of each measure after the first one [m]."""
CONTRAST_M: Final = 1.0
"""From this mean distance to the former places on, a formation counts as a new one [m]."""
NEIGHBOUR_M: Final = 1.5
"""Distance over which dancers count as neighbours [m]."""
TOUCH_TOLERANCE_M: Final = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """Where D dancers stand, or are predicted to stand, and what they can do."""

    position: Float64
    """Places [m], (D, 2)."""
    group: Int32
    """Group of each dancer, (D,)."""
    attributes: tuple[Set[str], ...]
    """Attributes of each dancer, length D: formations may reserve places for them."""
    reach: Float64
    """How far each dancer gets in a measure [m], (D,)."""
    radius: Float64
    """Body radii [m], (D,)."""
    half_stage: tuple[float, float]
    """Half the width and depth of the stage [m]."""
    before: Float64 | None = None
    """Places where they stood before [m], (P, 2): formations that resemble them rank lower. None: no matter."""
    others: Float64 | None = None
    """Places of dancers who stay where they are [m], (O, 2); None: there are none."""
    measures: int = MOST_MEASURES
    """Measures within which a formation has to be reached, at least 1."""
    measure_beats: float = 4.0


@dataclass(frozen=True, slots=True)
class NextFormation:
    """A formation that could come next."""

    formation: str
    measures: int
    """The fewest measures in which all dancers get there."""
    total_m: float
    """Sum of all ways [m]."""
    longest_m: float
    """The longest way [m]."""
    meetings: int
    """Pairs of dancers who would touch: on straight ways, where the show sends them around each other, or a dancer in
    their place and one who stays."""
    mixing: float
    """How much more the groups are mixed there than they are now, 0 to 1."""
    repeat: float
    """How much it resembles what was there before, 0 to 1."""
    cost: float
    """What it is ranked by [m of way for each dancer]."""


def rank_formations(standing: Standing, formations: Iterable[FormationLike]) -> tuple[NextFormation, ...]:
    """Return the formations that could come next, the best one first.

    Left out are those that cannot be reached within `standing.measures`, that do not fit the stage, that have too few
    places, or whose places are too near to each other. The order of the dancers does not matter; of equal formations
    the first given comes first.
    """
    pieces = rank_in_pieces(standing, formations)
    while True:
        try:
            next(pieces)
        except StopIteration as stop:
            ranked: tuple[NextFormation, ...] = stop.value
            return ranked


def rank_in_pieces(standing: Standing, formations: Iterable[FormationLike]) -> Pieces[tuple[NextFormation, ...]]:
    """Rank as `rank_formations` does, in pieces of about a millisecond for fifty dancers."""
    own = _in_order(standing)
    if not len(own.position):
        return ()
    mixed = _mixing(own.position, own.group)
    found = []
    for formation in formations:
        yield
        slots = np.asarray(formation.slots, np.float64).reshape(-1, 2)
        if _is_possible(own, slots):
            motion = yield from _plan(own, formation)
            one = _rate(own, formation.name, slots, motion, mixed)
            if one is not None:
                found.append(one)
    return tuple(sorted(found, key=lambda one: one.cost))  # stable


def _in_order(standing: Standing) -> Standing:
    """Return the dancers in an order that depends on their places only: equal assignments are then chosen alike."""
    position = np.asarray(standing.position, np.float64).reshape(-1, 2)
    order = np.lexsort((standing.group, position[:, 1], position[:, 0]))
    return Standing(
        position[order], standing.group[order], tuple(standing.attributes[index] for index in order.tolist()),
        np.asarray(standing.reach, np.float64)[order], np.asarray(standing.radius, np.float64)[order],
        standing.half_stage, standing.before, standing.others, standing.measures, standing.measure_beats,
    )  # fmt: skip


def _is_possible(standing: Standing, slots: Float64) -> bool:
    """Whether all dancers have a place on the stage there, and none touches another."""
    count = len(standing.position)
    if len(slots) < count or (np.abs(slots) > np.array(standing.half_stage) + TOUCH_TOLERANCE_M).any():
        return False
    apart = distances(slots, slots)
    apart[np.diag_indices(len(slots))] = np.inf
    return bool(apart.min(initial=np.inf) >= 2.0 * float(standing.radius.max()) - TOUCH_TOLERANCE_M)


def _plan(standing: Standing, formation: FormationLike) -> Pieces[PlannedMotion]:
    """Plan straight ways into a formation, in a measure; longer ways are the same, but slower."""
    count, beats = len(standing.position), standing.measure_beats
    evolve = Evolve(formation.name, path_mode=PathMode.STRAIGHT)
    start = SegmentStart(
        np.arange(count, dtype=np.int32), standing.position, np.zeros(count), standing.attributes, 0.0, beats, beats,
        standing.radius, standing.half_stage, 0,
    )  # fmt: skip
    only = Repertoire({formation.name: formation})
    return (yield from plan_segment(Segment(evolve), evolve, only, start, MotionDraft()))


def _rate(standing: Standing, name: str, slots: Float64, motion: PlannedMotion, mixed: float) -> NextFormation | None:
    """Return how a formation does; None if somebody has no place, or is too far away."""
    if (motion.slot < 0).any():
        return None
    goal = slots[motion.slot]
    way = np.hypot(*(goal - standing.position).T)
    measures = next(
        (one for one in range(1, standing.measures + 1) if (way * busiest_share(one) <= standing.reach).all()), None
    )
    if measures is None:
        return None
    mixing = max(0.0, _mixing(goal, standing.group) - mixed)
    repeat = _resemblance(standing.before, slots)
    meetings = len(motion.remaining)
    if standing.others is not None and len(standing.others):
        meetings += int((distances(goal, standing.others) < 2.0 * standing.radius[:, None] - TOUCH_TOLERANCE_M).sum())
    cost = (
        float(way.mean())
        + MEETING_COST * min(2.0 * meetings / len(way), 1.0)
        + MIXING_COST * mixing
        + REPEAT_COST * repeat
        + MEASURE_COST * (measures - 1)
    )
    return NextFormation(
        name, measures, round(float(way.sum()), 2), round(float(way.max()), 2), meetings, round(mixing, 3),
        round(repeat, 3), round(cost, 3),
    )  # fmt: skip


@lru_cache(maxsize=64)
def busiest_share(measures: int) -> float:
    """Return the share of a way that is danced in the busiest of its measures, as dancers accelerate and brake."""
    line: npt.NDArray[np.float32] = np.array([[[0.0, 0.0], [1.0, 0.0]]], np.float32)
    way = Locomotion(line, np.array([[0.0, float(measures)]]), np.zeros((1, 1, 2)), Evolve("").soft)
    places, _ = way.sample(np.arange(measures + 1))
    return float(np.diff(places[:, 0, 0]).max())


def _mixing(places: Float64, group: Int32) -> float:
    """Return the share of neighbours who are of another group, 0 to 1; nearer ones count more."""
    if len(places) < 2:
        return 0.0
    weight = np.exp(-np.square(distances(places, places) / NEIGHBOUR_M))
    weight[np.diag_indices(len(places))] = 0.0
    return float(weight[group[:, None] != group[None, :]].sum() / max(float(weight.sum()), 1e-12))


def _resemblance(before: Float64 | None, slots: Float64) -> float:
    """Return how much the places resemble those of before, 1: they are the same."""
    if before is None or not len(before):
        return 0.0
    slot = assign(before, slots)
    seated = slot >= 0
    there = slots[slot[seated]] - np.asarray(before, np.float64).reshape(-1, 2)[seated]
    return float(max(0.0, 1.0 - np.hypot(*there.T).mean() / CONTRAST_M))
