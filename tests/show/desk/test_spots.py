"""Follow spots go after whom they are told, and where they are is part of the show's state."""

import math
from itertools import pairwise

from live.clock.ticks import TICK
from tests.show.desk.desk_show import DESK, Hands


def spot(hands, number):
    view = hands.show.view()
    hands.show.fill(view, hands.ticks * TICK)
    return view.spot[number - 1]


def test_a_spot_follows_a_dancer_damped_and_another_one_after_that():
    hands = Hands(DESK).run(beats=1)
    assert hands.say("/dance/spot/follow", "front & 1", 2, 0.8, 0)
    for _ in range(30):
        hands.run(ticks=6)
        assert math.dist(spot(hands, 2), hands.show.state.position[0]) < 0.9
    assert hands.value("/dance/spot/2") == 0.8
    hands.say("/dance/spot/follow", "front & 3", 2, 0.8, 1)
    ways = [spot(hands.run(ticks=1), 2).copy() for _ in range(128)]
    assert max(math.dist(a, b) for a, b in pairwise(ways)) < 0.1
    assert math.dist(ways[-1], hands.show.state.position[2]) < 0.9


def test_spots_belong_to_the_state_and_nobody_is_refused():
    def danced():
        hands = Hands(DESK).run(beats=1)
        hands.say("/dance/spot/follow", "back", 1, 1, 0)
        return hands.run(beats=2).show.state_hash()

    hands = Hands(DESK).run(beats=1)
    assert not hands.say("/dance/spot/follow", "nonesuch")
    assert not hands.say("/dance/spot/follow", "front", 1.5)
    assert danced() == danced() != hands.run(beats=2).show.state_hash()
