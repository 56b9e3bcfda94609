"""Assignment of dancers to formation slots, and places along the stage edges for dancers without one (T096-T100)."""

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.incremental_assignment import IncrementalAssignment, Pieces
from live.agents.evolutions.intention import AssignmentMethod, Matching
from live.agents.evolutions.segment_start import MotionDraft, SegmentStart
from live.agents.evolutions.slot_assignment import by_id, sections
from live.base.arrays import Float64


def edge_places(
    count: int, start: npt.ArrayLike, slots: npt.ArrayLike, *, half: tuple[float, float], gap: float = 1.0
) -> Float64:
    """Return `count` places (count, 2) [m], at least `gap` from each other and from all `slots` (S, 2).

    The sides and the back of the stage come first, in order of distance from the dancers at `start` (D, 2). If the
    edges are full, the next row inwards is used; if the whole stage is full, rows beyond its sides.
    """
    if count <= 0:
        return np.zeros((0, 2))
    taken = np.asarray(slots, np.float64).reshape(-1, 2)
    dancers = np.asarray(start, np.float64).reshape(-1, 2)
    found: list[Float64] = []
    for ring in range(1000):
        candidates = _ring(ring, half, gap)
        for fixed in (taken, *found):
            if len(fixed) and len(candidates):
                candidates = candidates[_nearest(candidates, fixed) >= gap - 1e-6]
        if len(candidates):
            near = np.zeros(len(candidates))
            if len(dancers):
                near = _nearest(candidates, dancers)
            wanted = count - sum(map(len, found))
            found.append(candidates[np.argsort(near, kind="stable")[:wanted]])
        if sum(map(len, found)) >= count:
            break
    return np.concatenate([*found, np.zeros((0, 2))])[:count]


def _nearest(places: Float64, others: Float64) -> Float64:
    """Return the distance of each of `places` (n, 2) to the nearest of `others` (m, 2) [m], (n,)."""
    from scipy.spatial import KDTree

    return np.asarray(KDTree(others).query(places)[0])


def _ring(ring: int, half: tuple[float, float], gap: float) -> Float64:
    """Return sides and back of the rectangle `ring` rows in from the edges, or beyond the sides if too far in."""
    inset = 0.5 + ring * gap
    width, depth = half[0] - inset, half[1] - inset
    if width < 0.0 or depth < 0.0:
        beyond = half[0] + gap * (1 + ring - int(min(half) // gap))
        z = np.arange(-half[1], half[1] + 1e-9, gap)
        return np.concatenate([np.stack([np.full(len(z), side * beyond), z], axis=1) for side in (-1.0, 1.0)])
    z = np.linspace(-depth, depth, max(1, int(2 * depth / gap) + 1))
    inner = max(0, int(2 * width / gap) - 1)
    x = np.linspace(-width, width, inner + 2)[1:-1]
    sides = [np.stack([np.full(len(z), side * width), z], axis=1) for side in (-1.0, 1.0)]
    return np.concatenate([*sides, np.stack([x, np.full(len(x), -depth)], axis=1)])


CLEAR_GAP = 1.0
"""Metres between dancers who stand clear of a formation."""


def assign_places(
    matching: Matching, slots: Float64, marks: object, departure: SegmentStart, draft: MotionDraft
) -> Pieces[tuple[npt.NDArray[np.int32], Float64]]:
    """Return each dancer's row of the places, and the places: the slots, then places for dancers without a slot."""
    count = len(departure.dancer_indices)
    words = tuple(marks) if isinstance(marks, list | tuple) and len(marks) == len(slots) else ("",) * len(slots)
    dancer_section, slot_section = sections(departure.attributes, words)
    left_over = count - _count_seated(dancer_section, slot_section)
    clear = edge_places(left_over, departure.position, slots, half=departure.half_stage, gap=CLEAR_GAP)
    places = np.concatenate([slots, clear])
    slot_section = np.concatenate([slot_section, np.zeros(len(clear), np.int32)])
    if matching.by is AssignmentMethod.ID:
        slot = by_id(count, len(slots))
        slot[slot < 0] = len(slots) + np.arange((slot < 0).sum())
        return slot, (places if len(clear) else slots)
    solver = IncrementalAssignment()
    solver.begin(
        departure.position,
        places,
        cost=matching.cost,
        equal_weight=matching.equal_weight,
        fill=matching.fill,
        dancer_section=dancer_section,
        slot_section=slot_section,
    )
    while not solver.done:
        if draft.urgent:
            solver.hurry()
        solver.work()
        yield
    return solver.slot, places


def _count_seated(dancer_section: npt.NDArray[np.int32], slot_section: npt.NDArray[np.int32]) -> int:
    """Count the dancers who get a slot: slots of their section first, then slots without a mark."""
    placed, rest = 0, 0
    for section in np.unique(dancer_section):
        members, own = int((dancer_section == section).sum()), int((slot_section == section).sum())
        if section == 0:
            rest += members
        else:
            placed += min(members, own)
            rest += max(members - own, 0)
    return placed + min(rest, int((slot_section == 0).sum()))
