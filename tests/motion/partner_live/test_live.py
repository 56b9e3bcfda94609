"""Tests of the causal reading: no look-ahead, agreement with the offline search on clear units, no pops."""

import numpy as np

from live.motion.partner.decoder import Reading
from live.motion.partner.evaluation import joint_positions
from live.motion.partner.point_clouds import ends_cloud
from live.motion.partner_live.live_partner import agreement
from live.motion.partner_live.online_decoder import OnlineDecoder
from live.motion.partner_live.online_player import LivePartner
from tests.motion.partner.test_answer import pair_of

RATE = 30.0


def run_partner(
    seed: int, frames: int | None = None
) -> tuple[LivePartner, list[int], np.ndarray, list[tuple[int, int, float]]]:
    leader, units = pair_of(seed)
    x = ends_cloud(leader).resampled(RATE)
    partner = LivePartner(OnlineDecoder(units, rate=RATE, stretch=0.15, k=4.0))
    danced, roots, decided = [], [], []
    for n in range(x.count if frames is None else frames):
        partner.process_frame(x.floor[n], x.height[n], boundary=True, unit_frames=None)
        danced.append(partner.unit)
        if partner.has_pose:
            roots.append(partner.pose().root)
        decided += partner.decisions
    return partner, danced, np.array(roots), decided


def test_database_leader_is_recognized_by_middle_of_unit() -> None:
    _, units = pair_of(51)
    _, danced, _, decided = run_partner(51)
    correct = total = 0
    for unit in range(units.count):
        at = round((units.start[unit] + 0.6 * units.length[unit]) / 60.0 * RATE)
        if unit > 0 and at < len(danced):
            total += 1
            correct += danced[at] == unit
    assert total >= 10
    assert correct >= 0.85 * total
    assert np.median([seen for _, _, seen in decided]) <= 0.5


def test_output_is_causal_and_reproducible() -> None:
    _, whole, roots, _ = run_partner(52)
    _, part, some, _ = run_partner(52, frames=120)
    assert part == whole[:120]
    np.testing.assert_array_equal(some, roots[: len(some)])


def test_follower_moves_continuously() -> None:
    """The follower's hips move no faster than recorded ones, and move in every frame."""
    _, units = pair_of(53)
    _, _, roots, _ = run_partner(53)
    step = np.linalg.norm(np.diff(roots, axis=0), axis=-1)[15:] * RATE
    recorded = np.linalg.norm(np.diff(joint_positions(units.examples[0].follower)[:, 0], axis=0), axis=-1) * 60.0
    assert step.max() < recorded.max() + 2.0
    assert step.min() > 0.0


def test_units_begin_on_clock_beats() -> None:
    leader, units = pair_of(54)
    x = ends_cloud(leader).resampled(RATE)
    partner = LivePartner(OnlineDecoder(units, rate=RATE, stretch=0.15, k=4.0))
    begun = set()
    for n in range(x.count):
        partner.process_frame(x.floor[n], x.height[n], boundary=n % 7 == 0, unit_frames=21.0)
        begun |= {begin for _, begin, _ in partner.decisions}
    assert len(begun) > 5
    assert all(begin % 7 == 0 for begin in begun)


def test_agreement_compares_units_at_their_middle() -> None:
    """Of two units of 30 frames the first is danced; the second only in its beginning, or as a similar one."""
    offline = Reading(
        np.array([0, 1]), np.array([0, 30]), np.array([30, 30]), np.ones(2, complex), np.zeros(2, complex),
        np.zeros(2), np.zeros(1), 0.0, RATE,
    )  # fmt: skip
    danced = [(0, 0)] * 30 + [(1, 30)] * 10 + [(2, 30)] * 20
    near = np.eye(3, dtype=bool)
    assert agreement(danced, offline) == 0.5
    assert agreement(danced, offline, similar=near) == 0.5
    near[2, 1] = True
    assert agreement(danced, offline, similar=near) == 1.0
