"""Entrances and exits: the presence state of every dancer; changes begin at measure lines."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import ABSENT, ON_STAGE, PASSING, AgentCommand
from live.agents.agent_command_kernels import write_presence
from live.agents.entrances.gate import Gate
from live.base.arrays import Bool, Float32, Float64, Int8

Rows = npt.NDArray[np.intp]

WAITING, CALLED, ENTERING, ON, LEAVING = range(5)
"""In the wings; enters at the next measure line; on the way in; on the stage; on the way out."""
ARRIVAL_DISTANCE: Final = 0.35
"""An entering dancer has arrived within this distance of the goal [m]."""
_PRESENCE: Final = np.array([ABSENT, ABSENT, PASSING, ON_STAGE, PASSING], np.float32)
ARRIVAL_S: Final = 0.8
"""Remaining travel time [s] at which a dancer begins to slow down."""
CANDIDATES: Final = 48
"""Candidate places per entering dancer."""


class Entrances:
    """Presence of A dancers. Deterministic: free places are chosen among fixed candidates."""

    def __init__(self, agent_count: int, on_stage: int, gates: tuple[Gate, ...], size: tuple[float, float]) -> None:
        """The first `on_stage` dancers start on the stage; `size`: half width and half depth [m]."""
        self.gates = gates
        self.state: Int8 = np.full(agent_count, WAITING, np.int8)
        self.state[:on_stage] = ON
        self.goal: Float32 = np.zeros((agent_count, 2), np.float32)
        """Goals of entering and leaving dancers [m], shape (A, 2)."""
        self._gate = np.zeros(agent_count, np.int32)
        self._size = size
        self._exit_bounds = np.tile(np.array(size, np.float32), (agent_count, 1))  # of leaving dancers

    def resize(self, gates: tuple[Gate, ...], size: tuple[float, float]) -> None:
        """Set the stage's half sizes [m] and its gates, at least one.

        Who is to enter through a gate that is gone comes through the nearest one. Leaving dancers keep their goals; the
        goals of entering dancers are clamped to the new edges.
        """
        if gates != self.gates:
            self._gate = np.array([_successor(gate, gates) for gate in self.gates], np.int32)[self._gate]
        self.gates, self._size = gates, size
        rows = self.state == ENTERING
        edge = np.maximum(np.array(size, np.float32) - np.float32(0.8), np.float32(0.5) * np.array(size, np.float32))
        self.goal[rows] = np.clip(self.goal[rows], -edge, edge)

    @property
    def present(self) -> Bool:
        """Whether each dancer is visible, shape (A,)."""
        return np.asarray(self.state >= ENTERING)

    @property
    def staying(self) -> Bool:
        """Whether each dancer is on the stage or on the way in, shape (A,)."""
        return np.asarray((self.state == ENTERING) | (self.state == ON))

    @property
    def passing(self) -> Bool:
        """Whether each dancer is on the way in or out, shape (A,)."""
        return np.asarray((self.state == ENTERING) | (self.state == LEAVING))

    def gate_index(self, name: str) -> int | None:
        """Return the index of a gate, or None if there is none of that name."""
        return next((i for i, gate in enumerate(self.gates) if gate.name.casefold() == name.casefold()), None)

    def call_in(self, count: int, gate: int | None) -> Rows:
        """Let at most `count` waiting dancers enter at the next measure line; `gate` None: spread over all gates.

        Return their indices; fewer than `count` if fewer wait.
        """
        rows = np.flatnonzero(self.state == WAITING)[:count]
        self.state[rows] = CALLED
        self._gate[rows] = np.arange(len(rows)) % len(self.gates) if gate is None else gate
        return rows

    def send_off(self, mask: Bool, gate: int | None, position: Float32) -> int:
        """Let the dancers `mask` (A,) leave through `gate`, or each through the nearest (None); return how many."""
        self.state[mask & (self.state == CALLED)] = WAITING
        rows = np.flatnonzero(mask & ((self.state == ON) | (self.state == ENTERING)))
        for row in rows:
            away = [math.hypot(g.x - position[row, 0], g.z - position[row, 1]) for g in self.gates]
            self._gate[row] = int(np.argmin(away)) if gate is None else gate
        self.state[rows] = LEAVING
        self._exit_bounds[rows] = self._size
        for index, gate_ in enumerate(self.gates):
            through = rows[self._gate[rows] == index]
            self.goal[through] = gate_.waiting_places(len(through))
        return len(rows)

    def cross_measure_line(self, position: Float32) -> Rows:
        """Start the called entrances and finish completed exits; return the indices of the entering dancers.

        `position` (A, 2) [m] of the agents: entering ones are moved to their waiting places, the others are only read.
        """
        if (self.state == LEAVING).any():
            self.state[(self.state == LEAVING) & self._outside(position)] = WAITING
        if not (self.state == CALLED).any():
            return np.zeros(0, np.intp)
        rows = np.flatnonzero(self.state == CALLED)
        for index, gate in enumerate(self.gates):
            through = rows[self._gate[rows] == index]
            position[through] = gate.waiting_places(len(through))
        for row in rows.tolist():
            self.goal[row] = self._free_place(row, position)
            self.state[row] = ENTERING  # from now on this goal counts as taken, too
        return rows

    def update_arrivals(self, position: Float32) -> None:
        """Mark entering dancers that have reached their goals as on the stage; agents at `position` (A, 2) [m]."""
        if not (self.state == ENTERING).any():
            return
        rows = np.flatnonzero(self.state == ENTERING)
        way, half = self.goal[rows] - position[rows], self._size
        inside = (np.abs(position[rows]) <= half).all(axis=1)
        self.state[rows[inside & (np.hypot(*way.T) < ARRIVAL_DISTANCE)]] = ON

    def write(self, commands: AgentCommand, position: Float32) -> None:
        """Write the presence of all dancers and the motion while entering and leaving (arrive, T082) to `commands`."""
        if not write_presence(commands.rows, self.state, _PRESENCE, PASSING):
            return
        rows = np.flatnonzero(commands.presence == PASSING)
        way = self.goal[rows] - position[rows]
        far = np.maximum(np.hypot(*way.T), 1e-6)
        speed = np.minimum(commands.speed[rows], far / ARRIVAL_S)
        commands.velocity[rows] = way * (speed / far)[:, None]
        commands.firmness[rows] = 0.5

    def _outside(self, position: Float32) -> Bool:
        return np.asarray((np.abs(position) > self._exit_bounds).any(axis=1))

    def _free_place(self, row: int, position: Float32) -> tuple[float, float]:
        """Return the candidate with the most free space, preferring nearer ones; positions and goals count as taken."""
        taken = np.concatenate([position[self.state == ON], self.goal[self.state == ENTERING]])
        index = np.arange(1, CANDIDATES + 1)
        halton = np.stack([_radical_inverse(index, 2), _radical_inverse(index, 3)], 1)
        places = (2.0 * halton - 1.0) * (np.array(self._size) - np.minimum(0.8, 0.3 * np.array(self._size)))
        room = np.full(CANDIDATES, 4.0)
        if len(taken):
            away = np.hypot(*(places[:, None] - taken[None]).transpose(2, 0, 1)).min(axis=1)
            room = np.minimum(away, 1.5)  # beyond this the nearer place is better
        best = places[np.argmax(room - 0.05 * np.hypot(*(places - position[row]).T))]
        return float(best[0]), float(best[1])


def _successor(gate: Gate, gates: tuple[Gate, ...]) -> int:
    """Return the index of the gate of the same name, else of the nearest one."""
    far = [math.hypot(gate.x - other.x, gate.z - other.z) for other in gates]
    return min(range(len(gates)), key=lambda index: (gates[index].name.casefold() != gate.name.casefold(), far[index]))


def _radical_inverse(index: npt.NDArray[np.int64], base: int) -> Float64:
    """Return the Halton sequence in one dimension: the digits of `index` mirrored at the radix point."""
    left, share, value = index.copy(), 1.0 / base, np.zeros(len(index))
    while left.any():
        value += (left % base) * share
        left //= base
        share /= base
    return value
