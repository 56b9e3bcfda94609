"""Answer holds: which hands of their leaders those who answer are to hold now."""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from live.motion.partner_live.held import Held, hands_of
from live.show.partner.leader_input import AnswerLeaders
from live.show.partner.partner_pairs import Asked, Pair


def holds_of(
    pairs: Iterable[Pair],
    asked: Sequence[Asked],
    leaders: AnswerLeaders,
    share: npt.NDArray[np.float64],
) -> list[Held]:
    """What is to be held in the `pairs` that are shown, of whose answers so much is in, `share` (A,).

    Who dances at her own place, or along a way, stands elsewhere than the examples' follower: she holds nobody.
    """
    return [
        Held(pair.leader, pair.follower, hands_of(leaders.of(pair).partner), asked[pair.partner].hands)
        for pair in pairs
        if share[pair.follower] > 0.0 and not pair.own_place
    ]
