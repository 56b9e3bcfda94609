"""Evaluation of the live partner: a recorded leader answered causally, frame by frame (H024)."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.base.errors import PersonError
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.partner.answer import Answer, enforce_feet
from live.motion.partner.decoder import Reading
from live.motion.partner.partner_synthesis import (
    PartnerResult,
    SearchSettings,
    StageTimer,
    boundary_costs,
    decode_input,
    no_clock,
)
from live.motion.partner.point_clouds import Cloud
from live.motion.partner.units import Units, unit_distances
from live.motion.partner_live.online_decoder import OnlineDecoder
from live.motion.partner_live.online_player import LivePartner

LIVE_RATE: Final = 30.0
"""Frame rate of the causal decoder [Hz]."""
SIMILAR_DISTANCE: Final = 0.2
"""Units at most this far from each other [m] (rms, `unit_distances`) are alike: `--cluster 0.2` may merge them."""


def evaluate_live(
    leader: Clip, x: Cloud, units: Units, search: SearchSettings, clock: Callable[[], float] = no_clock
) -> tuple[PartnerResult, dict[str, Any]]:
    """Return the follower as generated live, and a comparison with the offline search.

    `x` (T, P) is the leader's cloud at the rate of the clip. `clock` [s] measures the time per frame.
    """
    stages = StageTimer(clock)
    with stages("offline search, to compare"):
        coarse, fine = decode_input(x, units, search, stages)
    thin = x.resampled(LIVE_RATE)
    toll = boundary_costs(search, thin)
    allowed = np.ones(thin.count, np.bool_) if toll is None else toll == 0.0
    beat = None if search.beats is None or len(search.beats) < 2 else float(np.diff(search.beats).mean())
    unit_beats = None if beat is None else max(1, round(float(np.median(units.seconds)) / beat))
    length = None if beat is None or unit_beats is None else unit_beats * beat * LIVE_RATE
    reader = OnlineDecoder(units, rate=LIVE_RATE, stretch=search.stretch, k=search.k * LIVE_RATE / search.rate)
    partner = LivePartner(reader)
    poses, danced, spent = [], [], []
    decided: list[tuple[int, int, float]] = []
    with stages("live"):
        for n in range(thin.count):
            began = clock()
            partner.process_frame(thin.floor[n], thin.height[n], boundary=bool(allowed[n]), unit_frames=length)
            pose = partner.pose() if partner.has_pose else None
            spent.append(clock() - began)
            poses += [pose, partner.pose(0.5 / LIVE_RATE) if partner.has_pose else None]
            danced.append((partner.unit, partner.begin))
            decided = _final_decisions(decided, partner.decisions, reader)
    if partner.unit < 0:
        raise PersonError("the leader's motion is too short to decode a unit", "a longer motion")
    first = next(pose for pose in poses if pose is not None)
    whole = [pose or first for pose in poses]
    root = np.array([pose.root for pose in whole])
    rotation = np.asarray(
        quaternion.align_signs(quaternion.unit(np.array([pose.rotation for pose in whole]))), np.float64
    )
    contact = np.array([pose.contact for pose in whole])
    clip = _at_rate(root, rotation, contact, leader.sample_count, leader.sample_rate)
    made = Answer(clip, np.zeros(leader.sample_count), np.zeros(leader.sample_count, np.int64), (), fine.start[1:])
    with stages("feet and hands"):
        held = enforce_feet(clip) if search.hold_feet else clip
    reading = _reading(danced, fine)
    figures = {
        "live": {
            "frame_ms": {
                "p50": float(np.percentile(spent, 50) * 1000.0), "p99": float(np.percentile(spent, 99) * 1000.0),
            },
            "committed_at": {
                "median": float(np.median([seen for _, _, seen in decided])),
                "latest": float(np.max([seen for _, _, seen in decided])),
            },
            "agreement": agreement(danced, fine),
            "agreement_alike": agreement(danced, fine, similar=similar_units(units)),
        }
    }  # fmt: skip
    return PartnerResult(held, made, coarse, reading, stages.seconds), figures


def _at_rate(root: Float64, rotation: Float64, contact: Bool, count: int, rate: float) -> Clip:
    place = np.clip(np.arange(count) * 2.0 * LIVE_RATE / rate, 0.0, len(root) - 1.0)
    low = np.minimum(place.astype(np.int64), max(len(root) - 2, 0))
    high = np.minimum(low + 1, len(root) - 1)
    w = place - low
    return Clip(
        "answer",
        np.ascontiguousarray((1.0 - w[:, None]) * root[low] + w[:, None] * root[high], np.float32),
        np.ascontiguousarray(quaternion.slerp(rotation[low], rotation[high], w[:, None]), np.float32),
        rate,
        np.ascontiguousarray(contact[np.round(place).astype(np.int64)]),
    )


def _final_decisions(
    decided: list[tuple[int, int, float]], changes: list[tuple[int, int, float]], reader: OnlineDecoder
) -> list[tuple[int, int, float]]:
    """Keep the final decision for each danced unit; a corrected decision replaces the previous one."""
    for unit, begin, seen in changes:
        if decided and begin < decided[-1][1] + 0.5 * float(reader.units.seconds[decided[-1][0]]) * reader.rate:
            decided = decided[:-1]
        decided = [*decided, (unit, begin, seen)]
    return decided


def similar_units(units: Units, max_distance: float = SIMILAR_DISTANCE) -> Bool:
    """Return which units are at most `max_distance` [m] from each other in both dancers' motion (N, N), as clustering
    merges them."""
    return np.asarray(unit_distances(units) <= max_distance)


def agreement(danced: list[tuple[int, int]], offline: Reading, part: float = 0.5, similar: Bool | None = None) -> float:
    """Return the share of the offline search's units that are danced live when `part` of them has passed.

    The same moment of the same recording counts or, with `similar` (N, N), a unit like it.
    """
    same = 0
    for unit, start, frames in zip(offline.unit, offline.start, offline.duration, strict=True):
        at = int((start + part * frames) / offline.rate * LIVE_RATE)
        own = danced[min(at, len(danced) - 1)][0]
        same += bool(own == unit if similar is None or own < 0 else similar[own, unit])
    return same / max(offline.count, 1)


def _reading(danced: list[tuple[int, int]], offline: Reading) -> Reading:
    """Return the units danced live as a reading at the offline rate."""
    rows = [danced[n] for n in range(len(danced)) if danced[n][0] >= 0 and (n == 0 or danced[n] != danced[n - 1])]
    ratio = offline.rate / LIVE_RATE
    start = np.array([round(begin * ratio) for _, begin in rows], np.int64)
    stop = np.concatenate((start[1:], [round(len(danced) * ratio)]))
    unit = np.array([one for one, _ in rows], np.int64)
    count, zeros = len(rows), np.zeros(len(rows))
    turn = np.ones(count, np.complex128)
    return Reading(
        unit, start, np.maximum(stop - start, 1), turn, np.zeros(count, np.complex128), zeros, zeros[1:],
        offline.score, offline.rate,
    )  # fmt: skip
