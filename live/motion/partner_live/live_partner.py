"""Evaluation of the live partner: a recorded leader answered causally, frame by frame (H024)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.partner.answer import Answer
from live.motion.partner.decoder import Reading
from live.motion.partner.partner_synthesis import PartnerResult, SearchSettings, StageTimer, no_clock
from live.motion.partner.point_clouds import Cloud, leader_cloud
from live.motion.partner.units import BEATS_OF_UNIT, Units
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.hand_holds import HoldRequest, LiveHandHolds
from live.motion.partner_live.online_player import LivePartner
from live.motion.partner_live.stage_partner import FollowerFootLock

LIVE_RATE: Final = 30.0
"""Frame rate of the causal decoder [Hz]."""


def evaluate_live(
    leader: Clip,
    x: Cloud,
    units: Units,
    search: SearchSettings,
    clock: Callable[[], float] = no_clock,
    *,
    weighs: bool = True,
) -> tuple[PartnerResult, dict[str, Any]]:
    """Return the follower as generated live, feet locked and hands held as on the stage, and times.

    `x` (T, P) is the leader's cloud at the rate of the clip, of which a path's is read. `clock` [s] measures the time
    per frame. Unless it `weighs` them, all examples count alike.
    """
    stages = StageTimer(clock)
    with stages("learning"):
        partner = LivePartner(FollowerFilter(units, rate=LIVE_RATE, weighs=weighs))
    body = x if partner.filter.point_count == x.floor.shape[1] else leader_cloud(leader)
    thin = body.resampled(LIVE_RATE)
    phase = None if search.beats is None or len(search.beats) < 3 else _unit_phase(search.beats, thin.count)
    poses, danced, spent, hands = [], [], [], []
    with stages("live"):
        for n in range(thin.count):
            began = clock()
            partner.process_frame(thin.floor[n], thin.height[n], None if phase is None else float(phase[n]))
            poses.append(partner.pose())
            spent.append(clock() - began)
            poses.append(partner.pose(0.5 / LIVE_RATE))
            danced.append((partner.unit, partner.begin))
            hands.append(partner.hands)
    root = np.array([pose.root for pose in poses])
    rotation = np.asarray(
        quaternion.align_signs(quaternion.unit(np.array([pose.rotation for pose in poses]))), np.float64
    )
    contact = np.array([pose.contact for pose in poses])
    clip = _at_rate(root, rotation, contact, leader.sample_count, leader.sample_rate)
    reading = _reading(danced, units)
    count, begins = leader.sample_count, np.round(reading.start[1:] * leader.sample_rate / LIVE_RATE).astype(np.int64)
    made = Answer(clip, np.zeros(count), np.zeros(count, np.int64), (), begins)
    with stages("feet and hands"):
        held = lock_live_feet(clip) if search.hold_feet else clip
        if search.hold_hands and leader.sample_count == clip.sample_count:
            held = hold_hands(held, leader, hands, LIVE_RATE)
    figures = {
        "live": {
            "frame_ms": {
                "p50": float(np.percentile(spent, 50) * 1000.0), "p99": float(np.percentile(spent, 99) * 1000.0),
            },
            "changes_per_s": reading.count / (thin.count / LIVE_RATE),
            "example_weights": {
                one.name: round(float(weight), 3)
                for one, weight in zip(units.examples, partner.filter.model.example_weight, strict=True)
            },
        }
    }  # fmt: skip
    return PartnerResult(held, made, reading, reading, stages.seconds), figures


def _unit_phase(beats: Float64, count: int) -> Float64:
    """Return the share of a unit that has passed at each of `count` frames, if units begin on every second beat."""
    edges = beats[::BEATS_OF_UNIT]
    slow = np.diff(edges).mean() if len(edges) > 1 else 2.0 * np.diff(beats).mean()
    time = np.arange(count) / LIVE_RATE
    inside = np.interp(time, edges, np.arange(len(edges)))
    outside = np.minimum(time - edges[0], 0.0) / slow + np.maximum(time - edges[-1], 0.0) / slow
    return np.asarray((inside + outside) % 1.0)


def lock_live_feet(clip: Clip) -> Clip:
    """Return the clip with feet locked tick by tick as on the stage; its contacts are those that are left."""
    lock, row = FollowerFootLock(1), np.zeros(1, np.int32)
    world_position, world_rotation = forward_kinematics(clip.root_position, clip.rotation)
    root, rotation, contact = clip.root_position.copy(), clip.rotation.copy(), clip.contact.copy()
    for sample in range(clip.sample_count):
        position = np.array(world_position[sample : sample + 1], np.float32)
        turned = np.array(world_rotation[sample : sample + 1], np.float32)
        lock.tick(row, position, contact[sample : sample + 1], 1.0 / clip.sample_rate)
        lock.apply(row, position, turned, 0.0)
        root[sample], rotation[sample] = position[0, 0], local_rotations(turned)[0]
        contact[sample] &= ~lock.stepping[0]
    return replace(
        clip, root_position=root, rotation=np.ascontiguousarray(quaternion.align_signs(rotation), np.float32),
        contact=contact,
    )  # fmt: skip


def hold_hands(follower: Clip, leader: Clip, hands: list[tuple[int, int]], rate: float) -> Clip:
    """Return the follower with the `hands` held that are wanted at `rate` [Hz], tick by tick as on the stage."""
    holds, share = LiveHandHolds(2), np.ones(2)
    world = [
        [np.asarray(part, np.float32) for part in forward_kinematics(one.root_position, one.rotation)]
        for one in (leader, follower)
    ]
    rotation = follower.rotation.copy()
    position, turned = (np.zeros((2, *one.shape[1:]), np.float32) for one in world[0])
    for sample in range(follower.sample_count):
        position[:], turned[:] = (np.stack([one[n][sample] for one in world]) for n in range(2))
        wanted = hands[min(int(sample / follower.sample_rate * rate + 1e-6), len(hands) - 1)]
        request = [HoldRequest(0, 1, wanted, 1.0)]
        holds.tick(request, lambda rows: (position[rows], turned[rows]), 1.0 / follower.sample_rate)
        holds.apply(position, turned, share, 0.0)
        rotation[sample] = local_rotations(turned[1:2])[0]
    return replace(follower, rotation=np.ascontiguousarray(quaternion.align_signs(rotation), np.float32))


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


def _reading(danced: list[tuple[int, int]], units: Units) -> Reading:
    """Return the units danced live as a reading at LIVE_RATE."""
    rows = [danced[n] for n in range(len(danced)) if n == 0 or danced[n] != danced[n - 1]]
    start = np.array([max(begin, 0) for _, begin in rows], np.int64)
    start = np.maximum.accumulate(start)
    stop = np.concatenate((start[1:], [len(danced)]))
    unit = np.array([one for one, _ in rows], np.int64)
    count, zeros = len(rows), np.zeros(len(rows))
    turn = np.ones(count, np.complex128)
    return Reading(
        unit, start, np.maximum(stop - start, 1), turn, np.zeros(count, np.complex128), zeros, zeros[1:], 0.0, LIVE_RATE
    )
