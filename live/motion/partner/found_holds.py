"""Found holds: who held whose hand in a pair of recordings that nobody annotated, by how near the palms were.

Ours; the paper has annotations made by hand (H014). Bodies that were brought onto one skeleton have their hands a
little elsewhere than the dancers had, so nobody but who gives the recordings knows how near is a hold.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.partner.enforce import palms
from live.motion.partner.units import Hold

LETS_GO: Final = 1.5
"""A hold goes on until palms are this many times as far apart as it may begin at."""


@dataclass(frozen=True, slots=True)
class Near:
    """What counts as a hold: palms within `distance` [m], and never much farther for `seconds` at least."""

    distance: float
    seconds: float


def found_holds(leader: Clip, follower: Clip, near: Near) -> tuple[Hold, ...]:
    """The holds of two recordings that belong together sample by sample, in their order, in samples.

    Each hand holds one at a time, the nearest that is free, until it lets go of it.
    """
    count = min(leader.sample_count, follower.sample_count)
    lead, own = palms(leader)[:count], palms(follower)[:count]
    apart = np.linalg.norm(lead[:, :, None] - own[:, None], axis=-1)  # (T, leader's hand, follower's hand)
    long = [
        one for one in _runs(apart, near.distance) if one.end - one.begin >= near.seconds * follower.sample_rate - 1e-6
    ]
    return tuple(sorted(long, key=lambda one: (one.begin, one.follower_hand)))


def _runs(apart: npt.NDArray[np.float64], distance: float) -> list[Hold]:
    """All holds, however short, of palms that are so far `apart` (T, 2, 2) [m]."""
    runs: list[Hold] = []
    begun: dict[tuple[int, int], int] = {}
    for sample, gaps in enumerate(apart.tolist()):
        for hands in [hands for hands in begun if gaps[hands[0]][hands[1]] > LETS_GO * distance]:
            runs.append(Hold(*hands, float(begun.pop(hands)), sample - 1.0))
        for gap, hands in sorted((gaps[one][other], (one, other)) for one in range(2) for other in range(2)):
            if gap <= distance and not any(hands[0] == one or hands[1] == other for one, other in begun):
                begun[hands] = sample
    return runs + [Hold(*hands, float(first), len(apart) - 1.0) for hands, first in begun.items()]
