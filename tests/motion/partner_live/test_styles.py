"""Followers who go on in another style or with other examples, without a jump (H025)."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.partner.point_clouds import leader_cloud
from live.motion.partner.units import Example, cut_units, retime_to_beats
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.online_player import LivePartner
from live.motion.partner_live.stage_partner import PartnerExamples
from tests.motion.partner_live.led_pairs import RATE, led_pair

TEMPO = 120.0


def takes() -> list[Example]:
    """Takes of two couples."""
    return [replace(led_pair(seed)[1].examples[0], name=f"take {seed}") for seed in (41, 47)]


def examples_of(styles: tuple[str, ...]) -> PartnerExamples:
    timed = retime_to_beats(cut_units(takes()), unit_beats=2, samples=30, period=60.0 / TEMPO)
    return PartnerExamples(timed, unit_beats=2, per_beat=15, tempo=TEMPO, stretch=0.15, styles=styles)


def copy_of(partner: LivePartner) -> LivePartner:
    shared = (partner.filter.units, partner.filter.model)
    return copy.deepcopy(partner, {id(value): value for value in shared})


def turn_between(one: np.ndarray, other: np.ndarray) -> float:
    """The largest angle between rotations (J, 4) [rad]."""
    between = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(one), other))
    return float(np.linalg.norm(between, axis=-1).max())


@pytest.mark.long
def test_each_style_learns_from_its_own_examples_and_from_those_without_one() -> None:
    lore = examples_of(("Soft ", "hard"))
    assert sorted(lore.filters) == ["", "hard", "soft"]
    assert [one.name for one in lore.filters["soft"].units.examples] == ["take 41"]
    alone = PartnerExamples(
        lore.filters["soft"].units, unit_beats=2, per_beat=15, tempo=TEMPO, stretch=0.15
    ).filter.model
    assert np.array_equal(alone.weights, lore.filters["soft"].model.weights)
    everywhere = examples_of(("soft", ""))
    assert everywhere.filters["soft"] is everywhere.filters[""]
    with pytest.raises(KeyError):
        lore.new_partner("wild")


@pytest.mark.long
def test_place_and_speed_of_the_follower_go_on_when_another_model_takes_over() -> None:
    both = cut_units(takes())
    only = {n: cut_units([one]) for n, one in enumerate(both.examples)}
    models = {n: FollowerFilter(units, rate=RATE) for n, units in only.items()}
    cloud = leader_cloud(led_pair(41)[0]).resampled(RATE)
    partner, blended = LivePartner(FollowerFilter(both, rate=RATE)), 0
    for n in range(120):
        partner.process_frame(cloud.floor[n], cloud.height[n])
        if n < 20:
            continue
        other = copy_of(partner)
        into = 1 - partner._example
        shared = (models[into].units, models[into].model)
        other.continue_with(copy.deepcopy(models[into], {id(value): value for value in shared}))
        assert other.filter.units.examples[other._example].name == both.examples[into].name
        before, after = partner.pose(), other.pose()
        assert after.root == pytest.approx(before.root, abs=1e-6)
        assert turn_between(after.rotation, before.rotation) < 1e-5
        short = 0.2 / RATE
        before, after = partner.pose(short), other.pose(short)
        assert after.root == pytest.approx(before.root, abs=0.002)
        assert turn_between(after.rotation, before.rotation) < 0.02
        assert other.filter.frame_index == partner.filter.frame_index
        assert np.array_equal(other.filter._x, partner.filter._x, equal_nan=True)
        blended += 1
    assert blended == 100


def test_a_recording_that_the_other_model_has_too_goes_on_with_what_is_known_of_it() -> None:
    both = cut_units(takes())
    cloud = leader_cloud(led_pair(41)[0]).resampled(RATE)
    partner = LivePartner(FollowerFilter(both, rate=RATE))
    for n in range(90):
        partner.process_frame(cloud.floor[n], cloud.height[n])
    danced, source = partner._example, partner._source
    posterior = partner.filter.posterior[partner.filter.model.moments.example == danced]
    turned = cut_units([replace(both.examples[1 - danced], name="new"), both.examples[danced]])
    partner.continue_with(FollowerFilter(turned, rate=RATE))
    assert (partner._example, partner._source) == (1, source)
    known = partner.filter.posterior[partner.filter.model.moments.example == 1]
    assert known == pytest.approx(posterior, abs=0.02)
    assert posterior.max() > 0.1
    partner.process_frame(cloud.floor[90], cloud.height[90])
    assert partner.filter.expected[0] != 0.0


@pytest.mark.long
def test_a_filter_of_another_rate_is_refused() -> None:
    units = cut_units(takes())
    partner = LivePartner(FollowerFilter(units, rate=RATE))
    with pytest.raises(ValueError, match="same rate"):
        partner.continue_with(FollowerFilter(units, rate=15.0))
