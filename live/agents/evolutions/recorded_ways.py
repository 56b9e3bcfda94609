"""Planning of evolutions that are danced as they were drawn or recorded: a way for each dancer (T145, T146)."""

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import FollowWays, Segment
from live.agents.evolutions.segment_start import MotionDraft, SegmentStart
from live.agents.evolutions.slot_layout import assign_places
from live.agents.groups.roster import mirror_places
from live.base.arrays import Float32, Float64

APPROACH_MEASURES = 1.0
"""Dancers who are elsewhere come to their ways within so many measures, at most half of the time."""


def paths_to_ways(
    segment: Segment,
    follow: FollowWays,
    ways: npt.NDArray[np.floating],
    departure: SegmentStart,
    draft: MotionDraft,
) -> Pieces[tuple[Float32, npt.NDArray[np.int32]]]:
    """Return the paths of the dancers (D, K, 2) [m] at even times, and the way of each, (D,), -1 for none.

    Each begins where she is, and comes to her way early in the segment. Whoever has no way goes to the edge.
    """
    lines = np.asarray(ways, np.float64)
    if follow.backwards:
        lines = lines[:, ::-1]
    if segment.mirror is not None:
        lines = mirror_places(lines, segment.mirror)
    slot, places = yield from assign_places(follow.matching, lines[:, 0], (), departure, draft)
    waiting = np.repeat(places[len(lines) :, None], lines.shape[1], axis=1)
    paths = np.concatenate([lines, waiting])[slot]
    away: Float64 = departure.position - paths[:, 0]
    length = max(departure.end - departure.begin, 1e-9)
    approach = min(APPROACH_MEASURES * departure.measure_beats / length, 0.5)
    share = np.clip(np.linspace(0.0, 1.0, lines.shape[1]) / approach, 0.0, 1.0)
    left = 1.0 - share * share * (3.0 - 2.0 * share)
    paths = paths + left[None, :, None] * away[:, None]
    return np.ascontiguousarray(paths, np.float32), np.where(slot < len(lines), slot, -1).astype(np.int32)
