"""AgentModel, AgentState and Steering: refused parameters, and state arrays as views of one buffer."""

import numpy as np
import pytest

from live.agents.crowd.agent_state import AgentModel, AgentState, Steering


def test_state_arrays_are_contiguous_views_of_one_buffer():
    state = AgentState.at_rest(np.arange(6.0).reshape(3, 2))
    for array in (state.position, state.velocity, state.acceleration, state.rest, state.rest_separation):
        assert array.flags.c_contiguous
        assert np.shares_memory(array, state.flat)
    other = AgentState(3)
    other.copy_from(state)
    assert (other.position == state.position).all()
    assert not np.shares_memory(other.flat, state.flat)


def test_unbounded_stage_is_infinite_in_kernel_vector():
    vector = Steering(half_width=None, half_depth=3.0, avoidance="thesis").vector()
    assert np.isinf(vector[0])
    assert vector[1] == 3.0
    assert vector[2] == 1.0


@pytest.mark.parametrize("wrong", [{"acceleration": -1.0}, {"turn_rate": float("nan")}, {"avoidance": "none"}])
def test_invalid_steering_parameters_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Steering(**wrong)


@pytest.mark.parametrize(
    ("radius", "responsibility"), [([0.0], [1.0]), ([0.3], [1.5]), ([0.3], [-0.1]), ([0.3, 0.3], [1.0])]
)
def test_invalid_radius_or_responsibility_is_refused(radius, responsibility):
    with pytest.raises(ValueError, match=r"radius|responsib"):
        AgentModel(np.array(radius, np.float32), np.array(responsibility, np.float32), Steering(), 1)
