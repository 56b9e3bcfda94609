"""LookAhead: the same motion as the advance it copies, however it is cut into pieces."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.advance import Advance, LookAhead, Parting
from live.agents.elements import ATTRACTOR, Element, ElementField
from live.agents.model import AgentModel, AgentState, Steering


def _scene():
    chance = np.random.default_rng(2)
    model = AgentModel(np.full(15, 0.25, np.float32), Steering(), 1)
    field = ElementField()
    field.add(Element(ATTRACTOR, 2.0, 1.0, 1.0, 0.0, 1e9))
    field.refresh(10.0)
    return model, AgentState.at(chance.uniform(-3, 3, (15, 2))), field, np.full(15, 0.8, np.float32)


def test_pieces_of_any_size_give_the_same_prediction():
    model, state, field, speed = _scene()
    results = []
    for piece in (1, 3, 1000):
        look = LookAhead(model, Advance(model))
        look.begin(state, time=0.0, seconds=2.6)
        while not look.done:
            look.work(piece, speed=speed, field=field)
        results.append(look.position.copy())
    assert (results[0] == results[1]).all()
    assert (results[0] == results[2]).all()


def test_the_prediction_is_near_what_happens_and_leaves_the_agents_alone():
    model, state, field, speed = _scene()
    before = state.position.copy()
    look = LookAhead(model, Advance(model))
    look.begin(state, time=0.0, seconds=2.5)
    look.work(10**6, speed=speed, field=field)
    assert (state.position == before).all()
    spare, advance = AgentState.at(np.zeros((15, 2))), Advance(model)
    for tick in range(160):
        advance(state, spare, speed=speed, dancer=state.position, field=field, time=tick / 64, dt=1 / 64)
        state, spare = spare, state
    assert np.hypot(*(look.position - state.position).T).mean() < 0.12


def test_nobody_is_no_problem():
    model = AgentModel(np.zeros(0, np.float32), Steering(), 1)
    look = LookAhead(model, Advance(model))
    look.begin(AgentState.at(np.zeros((0, 2))), time=0.0, seconds=1.0)
    look.work(100, speed=np.zeros(0, np.float32), field=ElementField())
    assert look.done


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 40), st.integers(0, 2**32 - 1), st.floats(0.0, 1.0))
def test_nobody_is_moved_farther_than_allowed_or_without_need(count, seed, most):
    chance = np.random.default_rng(seed)
    model = AgentModel(np.full(count, 0.25, np.float32), Steering(), 1)
    anchor = chance.uniform(-3, 3, (count, 2)).astype(np.float32)
    place = anchor.copy()
    Parting(model, 0.7)(place, anchor, most)
    assert np.isfinite(place).all()
    assert (np.hypot(*(place - anchor).T) <= most + 1e-5).all()
    apart = anchor * 10.0  # the same crowd with room for everybody, where there is any
    if _nearest(apart) > 0.7:
        place = apart.copy()
        Parting(model, 0.7)(place, apart, most)
        assert (place == apart).all()


def test_crowds_have_more_room_afterwards():
    """A single pair may come nearer while others part; what all pairs together lack of the gap shrinks each time."""
    model = AgentModel(np.full(24, 0.25, np.float32), Steering(), 1)
    for seed in range(100):
        anchor = np.random.default_rng(seed).uniform(-3, 3, (24, 2)).astype(np.float32)
        place = anchor.copy()
        Parting(model, 0.7)(place, anchor, 0.35)
        assert _lack(place) < 0.5 * _lack(anchor)


def test_a_crowd_in_one_place_parts_when_it_may():
    model = AgentModel(np.full(9, 0.25, np.float32), Steering(), 1)
    anchor = np.full((9, 2), 1.0, np.float32)
    place = anchor.copy()
    part = Parting(model, 0.7)
    for _ in range(5):
        part(place, anchor, 3.0)
    assert _nearest(place) > 0.65


def _nearest(place):
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1)) + 9 * np.eye(len(place))
    return apart.min() if len(place) > 1 else 9.0


def _lack(place):
    """By how much all pairs together are nearer than 0.7 m [m]."""
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))[np.triu_indices(len(place), 1)]
    return np.maximum(0.7 - apart, 0.0).sum()
