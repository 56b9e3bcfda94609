"""Tests of follow spots: damped following, and positions as part of the show state."""

import math
from itertools import pairwise

from live.clock.ticks import TICK
from tests.show.desk.desk_show import DESK, DeskSession


def spot_row(session, number):
    view = session.show.view()
    session.show.fill(view, session.ticks * TICK)
    return view.spot[number - 1]


def test_spot_follows_dancer_with_damping_and_changes_target():
    session = DeskSession(DESK).run(beats=1)
    assert session.say("/dance/spot/follow", "front & 1", 2, 0.8, 0)
    for _ in range(30):
        session.run(ticks=6)
        assert math.dist(spot_row(session, 2), session.show.state.position[0]) < 0.9
    assert session.value("/dance/spot/2") == 0.8
    session.say("/dance/spot/follow", "front & 3", 2, 0.8, 1)
    ways = [spot_row(session.run(ticks=1), 2).copy() for _ in range(128)]
    assert max(math.dist(a, b) for a, b in pairwise(ways)) < 0.1
    assert math.dist(ways[-1], session.show.state.position[2]) < 0.9


def test_spots_are_in_state_hash_and_unknown_targets_are_refused():
    def danced():
        session = DeskSession(DESK).run(beats=1)
        session.say("/dance/spot/follow", "back", 1, 1, 0)
        return session.run(beats=2).show.state_hash()

    session = DeskSession(DESK).run(beats=1)
    assert not session.say("/dance/spot/follow", "nonesuch")
    assert not session.say("/dance/spot/follow", "front", 1.5)
    assert danced() == danced() != session.run(beats=2).show.state_hash()
