"""Dancers enter and leave at measure lines, through gates, to free positions."""

import numpy as np

from live.agents.agent_command import ABSENT, ON_STAGE, PASSING, AgentCommand
from live.agents.entrances.entrances import CALLED, ENTERING, LEAVING, ON, WAITING, Entrances
from live.agents.entrances.gate import default_gates

SIZE = (6.0, 4.0)


def walk(entrances: Entrances, position: np.ndarray, seconds: float) -> AgentCommand:
    """Moves every dancer exactly at its commanded velocity."""
    wants = AgentCommand(len(position))
    for _ in range(round(seconds * 64)):
        wants.clear()
        wants.speed[:] = 1.2
        entrances.update_arrivals(position)
        entrances.write(wants, position)
        position += wants.velocity / 64 * (wants.presence != ABSENT)[:, None]
    return wants


def test_called_dancer_enters_at_next_measure_line() -> None:
    entrances = Entrances(6, 4, default_gates(*SIZE), SIZE)
    position = np.zeros((6, 2), np.float32)
    position[:4] = [(-2, 0), (2, 0), (0, 2), (0, -2)]
    assert entrances.present.tolist() == [True] * 4 + [False] * 2
    rows = entrances.call_in(1, entrances.gate_index("RIGHT"))
    assert rows.tolist() == [4]
    assert entrances.state[4] == CALLED
    assert not entrances.present[4]
    assert entrances.cross_measure_line(position).tolist() == [4]
    assert position[4, 0] > 6.0
    wants = walk(entrances, position, 0.1)
    assert wants.presence.tolist() == [ON_STAGE] * 4 + [PASSING, ABSENT]
    wants = walk(entrances, position, 12.0)
    assert entrances.state[4] == ON
    assert np.abs(position[4]).tolist() < [6.0, 4.0]
    apart = np.hypot(*(position[:4] - position[4]).T)
    assert apart.min() > 1.0


def test_leaving_dancer_is_absent_from_first_line_after_exit() -> None:
    entrances = Entrances(3, 3, default_gates(*SIZE), SIZE)
    position = np.array([(-4, 0), (4, 0), (0, -3)], np.float32)
    assert entrances.send_off(np.array([True, False, True]), None, position) == 2
    assert entrances.state.tolist() == [LEAVING, ON, LEAVING]
    walk(entrances, position, 8.0)
    assert position[0, 0] < -6.0
    assert position[2, 1] < -4.0
    assert entrances.present.all()
    entrances.cross_measure_line(position)
    assert entrances.present.tolist() == [False, True, False]
    assert entrances.state[0] == WAITING


def test_calls_are_limited_to_waiting_dancers_with_separate_goals() -> None:
    entrances = Entrances(8, 2, default_gates(*SIZE), SIZE)
    position = np.zeros((8, 2), np.float32)
    assert len(entrances.call_in(100, None)) == 6
    assert len(entrances.call_in(1, None)) == 0
    entrances.cross_measure_line(position)
    assert (entrances.state[2:] == ENTERING).all()
    goals = entrances.goal[2:]
    apart = np.hypot(*(goals[:, None] - goals[None]).transpose(2, 0, 1))[np.triu_indices(6, 1)]
    assert apart.min() > 0.7


def test_call_is_canceled_before_entrance() -> None:
    entrances = Entrances(2, 1, default_gates(*SIZE), SIZE)
    position = np.zeros((2, 2), np.float32)
    entrances.call_in(1, None)
    assert entrances.send_off(np.array([False, True]), None, position) == 0
    assert len(entrances.cross_measure_line(position)) == 0
    assert entrances.state[1] == WAITING
