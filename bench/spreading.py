"""Spreading and crossing over: how soon and how evenly a group fills the stage, and how it changes sides.

Stage 12 x 8 m, 48 dancers, no two spread alike: the definitions are those of the spreading survey. Peers are wandering
and separation alone in the same run (the thesis' first try, 4.4.2). VMR is variance / mean of the counts in cells; the
quantisation energy is that of the dancers as sites, divided by that of a hexagonal lattice.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.base.element_kinds import CROSSING, SPREADER, WANDER
from live.cli.bench import Row

Float64 = npt.NDArray[np.float64]

TICK = 1.0 / 64.0
WIDTH, DEPTH, DANCERS, RADIUS, SPEED = 12.0, 8.0, 48, 0.25, 1.3
SAMPLES = np.stack(np.meshgrid((np.arange(180) + 0.5) / 15 - 6, (np.arange(120) + 0.5) / 15 - 4), -1).reshape(-1, 2)


class Crowd:
    """A stage with dancers who do what elements say; positions are kept every quarter of a second."""

    def __init__(self, position: Float64, elements: list[Element], *, size: tuple[float, float], seed: int) -> None:
        count = len(position)
        half = (size[0] / 2, size[1] / 2)
        steering = Steering(half_width=half[0], half_depth=half[1])
        model = AgentModel(np.full(count, RADIUS, np.float32), np.ones(count, np.float32), steering, seed)
        self._advance, self._surroundings = CrowdStepper(model), Surroundings()
        self.state, self._spare = AgentState.at_rest(position), AgentState.at_rest(position)
        self.wants = AgentCommand(count)
        self.wants.speed[:] = SPEED
        self._groups = np.zeros(count, np.uint64)
        self.field = ElementField(count, half_width=half[0], half_depth=half[1], seed=seed)
        for element in elements:
            self.field.add(element)
        self.ticks = 0
        self.kept: list[Float64] = []

    def tick(self) -> None:
        """One tick; two beats a second."""
        time = self.ticks * TICK
        if self.ticks % 16 == 0:
            self.kept.append(self.state.position.astype(np.float64))
        self.wants.clear()
        self.field.refresh(time * 2.0, self.wants, self.state, self._groups)
        self.field.apply(self.wants, self.state, self._groups, time=time)
        self._advance(self.state, self._spare, commands=self.wants, surroundings=self._surroundings, time=time, dt=TICK)
        self.state, self._spare = self._spare, self.state
        self.ticks += 1


def vmr(position: Float64, columns: int, rows: int, cell: tuple[float, float] = (0.0, 0.0)) -> float:
    """Variance / mean of the counts in cells; `cell` shifts the grid by half of that size inwards, a cell fewer."""
    half_x, half_z = (WIDTH - cell[0]) / 2, (DEPTH - cell[1]) / 2
    edges = [np.linspace(-half_x, half_x, columns + 1), np.linspace(-half_z, half_z, rows + 1)]
    counts = np.histogram2d(position[:, 0], position[:, 1], edges)[0]
    return float(counts.var() / counts.mean())


def energy(position: Float64) -> float:
    """Quantisation energy / that of the hexagonal lattice (1: the best there is; at random 2.3)."""
    distance = cKDTree(position).query(SAMPLES)[0]
    area = WIDTH * DEPTH
    return float((distance**2).mean() * area / (5.0 * area**2 / (18.0 * np.sqrt(3.0) * len(position))))


def places(chance: np.random.Generator, count: int, low: Float64, high: Float64, apart: float) -> Float64:
    """`count` places at random in a rectangle, at least `apart` [m] from each other."""
    while True:
        found = np.zeros((0, 2))
        for _ in range(20_000):
            place = chance.uniform(low, high)
            if len(found) == 0 or np.hypot(*(found - place).T).min() >= apart:
                found = np.vstack([found, place])
            if len(found) == count:
                return found


def seconds_to_spread(kept: list[Float64]) -> float:
    """Seconds until VMR (3 x 2) stays under 0.5 for 2 s; the length of the run if it never does."""
    fine = [vmr(p, 3, 2) < 0.5 for p in kept]
    for k in range(len(fine) - 8):
        if all(fine[k : k + 9]):
            return k * 0.25
    return len(kept) * 0.25


def spreading(separation: float, *, alone: bool, seeds: int, seconds: float) -> tuple[float, float, float, float]:
    """Median seconds to spread from the left third; mean VMR, VMR on the shifted grid and energy from 20 s on."""
    kind = WANDER if alone else SPREADER
    times: list[float] = []
    means: list[tuple[float, float, float]] = []
    for seed in range(seeds):
        chance = np.random.default_rng(1000 + seed)
        clump = places(chance, DANCERS, np.array([-5.7, -3.7]), np.array([-2.0, 3.7]), 0.52)
        crowd = Crowd(clump, [Element(kind, start_beat=-9.0, separation=separation)], size=(WIDTH, DEPTH), seed=seed)
        for _ in range(int(seconds / TICK)):
            crowd.tick()
        times.append(seconds_to_spread(crowd.kept))
        late = crowd.kept[80::8]
        means.append(
            (
                float(np.mean([vmr(p, 3, 2) for p in late])),
                float(np.mean([vmr(p, 5, 3, (2.0, 2.0)) for p in late])),
                float(np.mean([energy(p) for p in late])),
            )
        )
    even, shifted, energies = np.mean(means, axis=0)
    return float(np.median(times)), float(even), float(shifted), float(energies)


def crossing(count: int, apart: float, seed: int) -> tuple[float, float, int]:
    """Seconds until everybody is within 0.3 m of her mirrored place; share who are over; overlaps over 5 mm."""
    chance = np.random.default_rng(1000 + seed)
    low, high = np.array([1.0, -4.5]), np.array([7.5, 4.5])
    right = places(chance, count // 2, low, high, apart)
    left = places(chance, count // 2, low, high, apart) * [-1.0, 1.0]
    start = np.concatenate([left, right])
    bar = Element(CROSSING, ((0.0, -1.0), (0.0, 1.0)), start_beat=-9.0)
    crowd = Crowd(start, [bar], size=(19.0, 13.0), seed=seed)
    goal = start * [-1.0, 1.0]
    arrived = np.full(count, np.inf)
    pairs, overlaps = np.triu_indices(count, 1), np.zeros(count * (count - 1) // 2, np.bool_)
    events = 0
    for tick in range(60 * 64):
        crowd.tick()
        position = crowd.state.position.astype(np.float64)
        away = np.hypot(*(position - goal).T)
        arrived[(away < 0.3) & np.isinf(arrived)] = (tick + 1) * TICK
        gap = np.hypot(*(position[pairs[0]] - position[pairs[1]]).T)
        now = gap < 2 * RADIUS - 0.005
        events += int((now & ~overlaps).sum())
        overlaps = now
        if away.max() < 0.2:
            break
    over = np.sign(crowd.state.position[:, 0]) == -np.sign(start[:, 0])
    return float(min(arrived.max(), 60.0)), float(over.mean()), events


def run(full: bool, shared: Path | None) -> list[Row]:
    """8 seeds of 90 s in full; 4 seeds of 40 s otherwise. Bars: the survey's aims."""
    del shared
    seeds, seconds = (8, 90.0) if full else (4, 40.0)
    rows: list[Row] = []
    for separation in (0.7, 1.0, 1.5):
        mine = spreading(separation, alone=False, seeds=seeds, seconds=seconds)
        other = spreading(separation, alone=True, seeds=seeds, seconds=seconds)
        figures = (("seconds to spread", "s", 7.0), ("VMR 3x2", "", 0.2), ("VMR shifted grid", "", 0.5))
        for place, (name, unit, bar) in enumerate((*figures, ("quantisation energy", "of hexagonal", 1.45))):
            peers = {"wander + separation": other[place]}
            rows.append(Row(f"separation {separation} m: {name}", mine[place], unit, bar, peers=peers))
    for count, apart in ((50, 0.9), (100, 0.72)):
        results = [crossing(count, apart, seed) for seed in range(3 if full else 1)]
        rows.append(Row(f"cross-{count}: last arrival", max(r[0] for r in results), "s"))
        rows.append(Row(f"cross-{count}: over", min(r[1] for r in results) * 100, "%", 100.0, "at least"))
        rows.append(Row(f"cross-{count}: overlaps", float(max(r[2] for r in results)), "", 0.0))
    return rows
