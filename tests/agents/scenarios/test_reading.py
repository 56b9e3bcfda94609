"""Scenarios in JSON: accepted fields, and refusal of invalid fields by name."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.scenarios.reading import MAX_AGENTS, read_scenario, unknown_fields
from live.base.errors import PersonError

GOOD = {
    "duration": 10,
    "radius": 0.25,
    "preferred_speed": 1.3,
    "max_speed": 1.8,
    "goal_radius": 0.3,
    "stage": [-6, -4, 6, 4],
    "agents": [{"position": [-4, 0], "goal": [4, 0]}, {"position": [4, 0], "goal": [[0, 1], [-4, 0]]}],
    "walls": [[0, -4, 0, -1]],
}


def edit_scenario(path, value):
    """GOOD with the value at `path`, a list of keys, replaced; the marker ... deletes it."""
    data = json.loads(json.dumps(GOOD))
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    if value is ...:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return json.dumps(data)


def test_complete_scenario_is_read():
    scenario = read_scenario(json.dumps(GOOD))
    assert (scenario.duration, scenario.radius, scenario.preferred_speed) == (10.0, 0.25, 1.3)
    assert (scenario.max_speed, scenario.goal_radius) == (1.8, 0.3)
    assert scenario.stage == (-6, -4, 6, 4)
    np.testing.assert_array_equal(scenario.start, [[-4, 0], [4, 0]])
    assert [way.tolist() for way in scenario.goals] == [[[4, 0]], [[0, 1], [-4, 0]]]
    np.testing.assert_array_equal(scenario.last_goal, [[4, 0], [-4, 0]])
    np.testing.assert_array_equal(scenario.walls, [[0, -4, 0, -1]])
    np.testing.assert_allclose(scenario.straight_distance, [8, 2 * np.hypot(4, 1)])


def test_stage_and_walls_and_agents_are_optional():
    data = {key: value for key, value in GOOD.items() if key not in ("stage", "walls")}
    scenario = read_scenario(json.dumps({**data, "agents": [], "author": "Ana"}).encode())
    assert scenario.stage is None
    assert scenario.walls.shape == (0, 4)
    assert scenario.agent_count == 0
    assert scenario.last_goal.shape == (0, 2)
    assert read_scenario(edit_scenario(["stage"], None)).stage is None
    assert unknown_fields(json.dumps({**GOOD, "author": "Ana"})) == ["author"]


BIG = 10**400
WRONG = [
    (["duration"], ..., "duration: missing"),
    (["agents"], ..., "agents: missing"),
    (["duration"], 0, "duration"),
    (["duration"], 1e9, "duration"),
    (["duration"], "10", "duration"),
    (["duration"], True, "duration"),
    (["radius"], 0, "radius"),
    (["radius"], -1, "radius"),
    (["radius"], float("nan"), "radius"),
    (["radius"], float("inf"), "radius"),
    (["radius"], BIG, "radius"),
    (["radius"], None, "radius"),
    (["preferred_speed"], [1.3], "preferred_speed"),
    (["max_speed"], 1.0, "max_speed"),
    (["goal_radius"], {}, "goal_radius"),
    (["stage"], [1, 2, 3], "stage"),
    (["stage"], [6, -4, -6, 4], "stage"),
    (["stage"], [-6, -4, 6, float("nan")], "stage[3]"),
    (["stage"], "big", "stage"),
    (["walls"], {"a": 1}, "walls"),
    (["walls", 0], [0, 1], "walls[0]"),
    (["walls", 0, 2], 1e300, "walls[0][2]"),
    (["walls"], [[0, 0, 1, 1]] * 65, "walls"),
    (["agents"], "many", "agents"),
    (["agents"], [[0, 0]], "agents[0]"),
    (["agents"], [{}] * (MAX_AGENTS + 1), "agents"),
    (["agents", 1, "goal"], ..., "agents[1].goal: missing"),
    (["agents", 0, "position"], ..., "agents[0].position: missing"),
    (["agents", 0, "position"], [7, 0], "agents[0].position"),
    (["agents", 0, "position"], [0, 0, 0], "agents[0].position"),
    (["agents", 0, "position", 1], "0", "agents[0].position[1]"),
    (["agents", 0, "goal"], [], "agents[0].goal"),
    (["agents", 0, "goal"], [[]], "agents[0].goal[0]"),
    (["agents", 0, "goal"], [[1, 2], 3], "agents[0].goal[1]"),
    (["agents", 0, "goal", 0], float("-inf"), "agents[0].goal[0]"),
    (["agents", 0, "goal"], [[0, 0]] * 1001, "agents[0].goal"),
]


@pytest.mark.parametrize(("path", "value", "field"), WRONG, ids=lambda value: None)
def test_invalid_field_is_refused_with_remedy(path, value, field):
    with pytest.raises(PersonError) as caught:
        read_scenario(edit_scenario(path, value), "a.json")
    assert caught.value.message.startswith(f"a.json: {field}")
    assert caught.value.remedy
    assert len(caught.value.message) < 200


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"duration": }', "[" * 100_000, b"\xff\xfe\x00", b"\x80{}"])
def test_invalid_document_is_refused(text):
    with pytest.raises(PersonError, match="the scenario"):
        read_scenario(text)


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=8,
)
PLACES = [["agents", 0, "goal"], ["agents", 1], ["walls", 0], ["stage"], ["radius"], ["agents"], ["walls"]]


@pytest.mark.long
@given(st.sampled_from(PLACES), ANYTHING)
@settings(max_examples=200, deadline=None)
def test_any_value_is_read_or_refused(path, value):
    try:
        scenario = read_scenario(edit_scenario(path, value))
    except PersonError as error:
        assert error.remedy  # noqa: PT017 - both outcomes are fine
        return
    numbers = [scenario.radius, *scenario.walls.flat, *scenario.start.flat, *(scenario.stage or ())]
    assert np.isfinite(np.array(numbers, float)).all()
    assert all(np.isfinite(way).all() and way.shape[0] > 0 for way in scenario.goals)
