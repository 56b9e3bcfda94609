"""Tests of a live follower: no look-ahead, a recorded leader, no jumps, beats, odd leaders."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.partner.evaluation import joint_positions
from live.motion.partner.point_clouds import Cloud, leader_cloud
from live.motion.partner.units import Units, cut_units
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.online_player import LivePartner
from tests.fixtures.mostly_long import mostly_long
from tests.motion.partner.test_answer import transform_clip
from tests.motion.partner_live.led_pairs import RATE, follow, led_pair


def hips_of(partner: LivePartner) -> np.ndarray:
    return partner.pose().root


def test_recorded_leader_gets_recorded_follower_at_any_placement() -> None:
    """A leader who dances as recorded, elsewhere: after a second the follower is where the recorded one was."""
    leader, units = led_pair(51)
    moved = transform_clip(leader, 0.9, 2.0, -1.0)
    real = joint_positions(transform_clip(units.examples[0].follower, 0.9, 2.0, -1.0))[::2, 0]
    found = np.array([hips_of(partner) for partner in follow(moved, units)])
    away = np.hypot(*(found[:, ::2] - real[: len(found), ::2]).T)
    assert np.median(away[30:]) < 0.15
    assert np.abs(real - real.mean(axis=0)).mean() > 0.4  # the law says something: the follower walks about


@pytest.mark.long
def test_output_is_causal_and_reproducible() -> None:
    leader, units = led_pair(52)
    whole = np.array([hips_of(partner) for partner in follow(leader, units)])
    part = np.array([hips_of(partner) for partner in follow(leader, units, frames=120)])
    np.testing.assert_array_equal(part, whole[:120])


def test_follower_moves_continuously() -> None:
    """The follower's hips move no faster than recorded ones and the correction together."""
    leader, units = led_pair(53)
    roots = np.array([hips_of(partner) for partner in follow(leader, units)])
    step = np.linalg.norm(np.diff(roots, axis=0), axis=-1)[15:] * RATE
    recorded = np.linalg.norm(np.diff(joint_positions(units.examples[0].follower)[:, 0], axis=0), axis=-1) * 60.0
    assert step.max() < recorded.max() + 2.0
    assert step.min() > 0.0


def two_takes(seed: int) -> tuple[Cloud, Units]:
    """A leader, and pairs of whom the first is followed by the same follower a little later: beats tell nothing new."""
    leader, units = led_pair(seed)
    _, more = led_pair(seed + 7)
    return leader_cloud(leader).resampled(RATE), cut_units([*units.examples, *more.examples])


@mostly_long("off", [0.5, None], quick=[])
def test_wrong_beats_are_not_obeyed(off: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beats half a unit off, or of another tempo (None), where beats are believed as strictly as ever: the leader
    contradicts them, and the follower is no farther from the recorded one, within 5 % and 1.5 cm."""
    monkeypatch.setattr("live.motion.partner_live.follower_model._beat_sharpness", lambda moments: 5.0)
    cloud, units = two_takes(54)
    time = np.arange(cloud.count) / RATE
    right = (time * 60.0 - units.start[0]) / units.length[0] % 1.0
    wrong = (right + off) % 1.0 if off is not None else time / 0.53 % 1.0
    real = joint_positions(units.examples[0].follower)[::2, 0][: cloud.count]
    errors, trust = [], []
    for phase in (right, wrong):
        made = []
        for partner in follow(cloud, units, phase=phase):
            made.append(hips_of(partner))
            believed = partner.filter.beat_trust
        errors.append(float(np.hypot(*(np.array(made) - real)[30:, ::2].T).mean()))
        trust.append(believed)
    assert trust[0] > 0.9
    assert trust[1] < 0.1
    assert errors[1] < 1.05 * errors[0] + 0.015


def odd_leader(kind: str, cloud: Cloud) -> Cloud:
    """The leader after three seconds as usual: stops, leaves, turns her back, loses hands, is at double tempo."""
    floor, height, start = cloud.floor.copy(), cloud.height.copy(), 90
    if kind == "stops":
        floor[start:], height[start:] = floor[start], height[start]
    if kind == "walks off":
        floor[start:] += 0.05 * np.arange(len(floor) - start)[:, None]
    if kind == "turns about":
        middle = floor[start:, :2].mean(axis=1, keepdims=True)
        floor[start:] = middle - (floor[start:] - middle)
    if kind == "loses hands":
        floor[start:, 2:4] = height[start:, 2:4] = np.nan
    if kind == "double tempo":
        rows = np.minimum(np.arange(len(floor)) * 2, len(floor) - 1)
        floor, height = floor[rows], height[rows]
    return Cloud(floor, height, cloud.rate)


@mostly_long("kind", ["stops", "walks off", "turns about", "loses hands", "double tempo"], quick=[3])
@mostly_long("takes", [1, 2], quick=[0])
def test_odd_leaders_are_followed_without_jumps_at_a_distance(kind: str, takes: int) -> None:
    """Whatever the leader does, and with one example or two dances mixed: finite poses, hips that do not jump, and
    never long nearer to the leader than nearly all recorded followers."""
    leader, units = led_pair(55, 900)
    known = units if takes == 1 else cut_units([*units.examples, *led_pair(63, 900)[1].examples])
    cloud = odd_leader(kind, leader_cloud(leader).resampled(RATE))
    roots, near, turned = [], [], []
    for partner in follow(cloud, known):
        pose = partner.pose()
        assert np.isfinite(pose.root).all()
        assert np.isfinite(pose.rotation).all()
        roots.append(pose.root)
        apart = abs(complex(pose.root[2], pose.root[0]) - partner.filter.place)
        near.append(apart < partner.filter.min_distance - 0.15)
        turned.append(partner.filter.posterior.sum())
    step = np.linalg.norm(np.diff(np.array(roots), axis=0), axis=-1)[15:] * RATE
    recorded = max(
        float(np.linalg.norm(np.diff(joint_positions(one.follower)[:, 0], axis=0), axis=-1).max() * 60.0)
        for one in known.examples
    )
    assert step.max() < recorded + 3.5  # the correction, twice as fast away from a leader who is too near
    assert np.mean(near) < 0.1
    np.testing.assert_allclose(turned, 1.0)


@pytest.mark.long
def test_lost_hands_change_little() -> None:
    """Without the hands the other points still tell where the couple is."""
    leader, units = led_pair(56)
    cloud = leader_cloud(leader).resampled(RATE)
    blind = odd_leader("loses hands", cloud)
    whole, part = (np.array([hips_of(partner) for partner in follow(one, units)]) for one in (cloud, blind))
    assert np.hypot(*(whole - part)[:, ::2].T).mean() < 0.1


@pytest.mark.long
def test_roles_can_be_exchanged() -> None:
    """Learnt with the follower as the leader, the recorded leader comes out."""
    leader, units = led_pair(57)
    follower = units.examples[0].follower
    swapped = replace(units.examples[0], leader=leader_cloud(follower), follower=leader)
    real = joint_positions(leader)[::2, 0]
    found = np.array([hips_of(partner) for partner in follow(follower, cut_units([swapped]))])
    assert np.median(np.hypot(*(found - real[: len(found)])[30:, ::2].T)) < 0.15


def test_mirrored_leader_is_followed_by_mirror_image() -> None:
    """If mirror images are learnt, too, a mirrored leader's follower is expected where the mirrored one was."""
    from live.motion.mirror import mirror_clip

    leader, units = led_pair(58)
    reader = FollowerFilter(units, rate=RATE)
    assert reader.model.moments.mirrored.any()  # they help with these examples
    cloud = leader_cloud(mirror_clip(leader)).resampled(RATE)
    real = joint_positions(mirror_clip(units.examples[0].follower))[::2, 0]
    away = []
    for n in range(cloud.count):
        reader.process_frame(cloud.floor[n], cloud.height[n])
        away.append(abs(reader.expected_root()[0] - complex(real[n, 2], real[n, 0])))
    assert np.median(away[30:]) < 0.2


def test_unsure_follower_faces_the_leader_at_arms_length() -> None:
    """A leader who suddenly whirls as no example does: the follower is lost within three seconds, faces him at the
    place of the basic step as far as it can be reached, and is sure again when he dances as recorded."""
    leader, units = led_pair(59, 1200)
    cloud = leader_cloud(leader).resampled(RATE)
    strange = Cloud(cloud.floor.copy(), cloud.height.copy(), RATE)
    rows = np.arange(120, 300)
    middle = strange.floor[120, :2].mean()
    arms = 2.0 * np.exp(0.5j * np.array((0, np.pi, 1.0, 4.0, 2.0, 5.0)))
    strange.floor[rows] = middle + arms * (0.1, 0.1, 1.0, 1.0, 1.0, 1.0)
    strange.height[rows, 2:] = 2.5
    unsure, faces, apart = [], [], []
    for partner in follow(strange, units):
        reader = partner.filter
        unsure.append(reader.unsure)
        place, facing = reader.expected_root()
        away = reader.place - place
        faces.append((facing * away.conjugate()).real / abs(away))
        apart.append(abs(away))
    assert max(unsure[60:118]) < 0.1
    assert unsure[215] > 0.9
    assert min(faces[215:295]) > 0.9
    assert min(apart[215:295]) > 0.6
    assert unsure[-1] < 0.1
    assert np.abs(np.diff(unsure)).max() < 0.1  # eased
