"""Simulated players: seeded Poisson calls that the controls accept."""

from itertools import islice, pairwise, takewhile

import numpy as np
import pytest

from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.rehearse.simulated_players import ArgumentGenerator, SimulatedPlayers
from live.show.patch.patch_reader import parse_patch
from tests.show.desk.desk_show import DESK
from tests.show.made_show import PATCH


@pytest.fixture(scope="module")
def arguments():
    return ArgumentGenerator(parse_patch(PATCH + DESK, "made.toml"), ("sway", "glide", "spin"))


def test_every_control_accepts_valid_arguments(arguments):
    chance = np.random.default_rng(0)
    for control in REGISTRY:
        for _ in range(20):
            made = REGISTRY.call(control.address, arguments.values(control, chance), 0.0, "phone")
            assert "Rejection" not in type(made).__name__, (control.address, made)


def test_invalid_calls_raise_nothing_and_are_mostly_refused(arguments):
    calls = list(islice(SimulatedPlayers(1, arguments, invalid_share=1.0).calls(), 3000))
    made = [REGISTRY.call(call.address, call.values, call.time, call.source) for call in calls]
    assert np.mean([isinstance(event, ControlEvent) for event in made]) < 0.1


def test_calls_arrive_in_order_at_the_given_rate(arguments):
    players = SimulatedPlayers(2, arguments, count=10, rate=6.0, role="musician")
    calls = list(takewhile(lambda call: call.time < 3600.0, players.calls()))
    assert all(a.time <= b.time for a, b in pairwise(calls))
    assert len({call.source for call in calls}) == 10
    assert len(calls) > 3600 * 0.8  # once a second, and fingers that move
    assert all(REGISTRY[call.address].role != "operator" for call in calls)


def test_same_seed_makes_the_same_calls(arguments):
    first, again = (list(islice(SimulatedPlayers(3, arguments, invalid_share=0.0).calls(), 500)) for _ in range(2))
    assert first == again


def test_zero_players_make_no_calls(arguments):
    assert list(SimulatedPlayers(1, arguments, count=0).calls()) == []
