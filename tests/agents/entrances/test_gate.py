"""Gates lie on the edge of the stage and have waiting places outside."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.entrances.gate import WAITING_DISTANCE, WAITING_SPACING, Gate, default_gates

metres = st.floats(-50, 50)


@given(x=metres, z=metres, width=st.floats(0.1, 40), half=st.tuples(st.floats(1, 20), st.floats(1, 20)))
def test_gate_lies_on_edge_with_waiting_places_outside(
    x: float, z: float, width: float, half: tuple[float, float]
) -> None:
    gate = Gate.at_edge("g", (x, z), width, half_width=half[0], half_depth=half[1])
    on_side = math.isclose(abs(gate.x), half[0]) and abs(gate.z) <= half[1] + 1e-9
    on_depth = math.isclose(abs(gate.z), half[1]) and abs(gate.x) <= half[0] + 1e-9
    assert on_side or on_depth
    assert math.hypot(gate.out_x, gate.out_z) == 1.0
    places = gate.waiting_places(7)
    out = (places - (gate.x, gate.z)) @ (gate.out_x, gate.out_z)
    assert out.min() >= WAITING_DISTANCE - 1e-9


def test_waiting_places_are_separated_within_gate_width() -> None:
    gate = default_gates(6.0, 4.0)[2]
    places = gate.waiting_places(20)
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))[np.triu_indices(20, 1)]
    assert apart.min() >= WAITING_SPACING - 1e-9
    assert np.abs(places[:, 0] - gate.x).max() <= gate.width / 2
    assert (places[:, 1] <= -4.0 - WAITING_DISTANCE + 1e-9).all()


def test_default_gates_are_left_right_and_back() -> None:
    assert [(gate.name, gate.x, gate.z) for gate in default_gates(6.0, 4.0)] == [
        ("left", -6.0, 0.0),
        ("right", 6.0, 0.0),
        ("back", 0.0, -4.0),
    ]


@pytest.mark.parametrize(("at", "width"), [((math.nan, 0.0), 1.0), ((0.0, math.inf), 1.0), ((0.0, 0.0), 0.0)])
def test_gate_without_position_or_width_is_refused(at: tuple[float, float], width: float) -> None:
    with pytest.raises(ValueError, match="gate 'g'"):
        Gate.at_edge("g", at, width, half_width=6.0, half_depth=4.0)
