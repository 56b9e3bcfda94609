"""Made pairs for tests of live followers, and followers of them frame by frame."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud, leader_cloud
from live.motion.partner.units import Hold, Units
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.online_player import LivePartner
from tests.motion.partner.test_answer import pair_of

RATE = 30.0


def led_pair(seed: int, samples: int = 600, holds: tuple[Hold, ...] = ()) -> tuple[Clip, Units]:
    """A leader, and the units of one pair in which she is followed."""
    leader, units = pair_of(seed, samples, holds)
    known = tuple(replace(one, leader=leader_cloud(leader)) for one in units.examples)
    return leader, replace(units, examples=known)


def follow(
    leader: Clip | Cloud, units: Units, frames: int | None = None, phase: np.ndarray | None = None
) -> Iterator[LivePartner]:
    """The one partner, after each of the leader's frames."""
    cloud = leader if isinstance(leader, Cloud) else leader_cloud(leader).resampled(RATE)
    partner = LivePartner(FollowerFilter(units, rate=RATE))
    for n in range(cloud.count if frames is None else frames):
        partner.process_frame(cloud.floor[n], cloud.height[n], None if phase is None else float(phase[n]))
        yield partner
