"""Formations into formations: who meets, who is late, how long the matching takes (T096-T101)."""

import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings
from live.agents.evolutions import facing, paths
from live.agents.evolutions.collision_check import Clearance, repair_in_pieces
from live.agents.evolutions.incremental_assignment import IncrementalAssignment, run_to_end
from live.agents.evolutions.intention import Evolve, Places, Repertoire, Segment
from live.agents.evolutions.paths import bend_paths_in_pieces
from live.agents.evolutions.running_plan import Plan
from live.agents.evolutions.slot_assignment import Cost, assign, distances
from live.agents.evolutions.start_delays import Ripple, StartOrder, delays, start_and_arrival
from live.agents.evolutions.trajectory import Locomotion
from live.agents.groups.roster import Roster
from live.cli.bench import Row

Float64 = npt.NDArray[np.float64]

DANCERS, WIDTH, DEPTH, SPACING, RADIUS = 50, 14.0, 10.0, 1.0, 0.25
TRANSITIONS = 40
BEATS = 8.0
"""Two measures for every transition."""
BEATS_PER_SECOND = 2.0
TICK = 1.0 / 64.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """40 random transitions of 50 dancers on 14 x 10 m, 1 m apart, half of them to a grid of 1 m."""
    pairs = list(transitions())
    rows = [row for cost in Cost for row in _cost_rows(cost, pairs)]
    rows += _ripple_rows(pairs)
    rows += _arrival_rows(pairs if full else pairs[::4])
    return rows + _time_rows((50, 200, 1000, 2000) if full else (50, 200, 1000))


def poisson(chance: np.random.Generator, count: int = DANCERS) -> Float64:
    """`count` random places at least `SPACING` apart, by throwing darts."""
    places: list[Float64] = []
    while len(places) < count:
        dart = chance.uniform(-0.5, 0.5, 2) * (WIDTH - 2 * RADIUS, DEPTH - 2 * RADIUS)
        if all(math.dist(dart, place) >= SPACING for place in places):
            places.append(dart)
    return np.array(places)


def transitions() -> Iterator[tuple[Float64, Float64]]:
    """Starts and goals, both (50, 2) [m]."""
    x, z = np.meshgrid(np.arange(10) - 4.5, np.arange(5) - 2.0)
    grid = np.stack([x.ravel(), z.ravel()], axis=1) * SPACING
    for number in range(TRANSITIONS):
        chance = np.random.default_rng([17, number])
        yield poisson(chance), poisson(chance) if number % 2 == 0 else grid


def journey(start: Float64, goal: Float64, waits: Float64 | None = None) -> Locomotion:
    """Straight ways."""
    own = start_and_arrival(0.0, BEATS, np.zeros(len(start)) if waits is None else waits)
    return Locomotion(
        paths.straight_paths(start, goal), own, facing.linear_turns(own, np.zeros(len(start)), np.zeros(1))
    )


def nearest(locomotion: Locomotion) -> tuple[int, float]:
    """How many pairs overlap, and how near two centres come [m]."""
    clearance = Clearance(locomotion, RADIUS, 129)
    clearance.compute_rows(0, locomotion.count)
    return len(clearance.approaches()), float(clearance.distance.min())


def _cost_rows(cost: Cost, pairs: list[tuple[Float64, Float64]]) -> list[Row]:
    total, longest, least = [], [], []
    meeting = {"straight": 0, "thesis": 0, "divided": 0}
    for number, (start, goal) in enumerate(pairs):
        slot = assign(start, goal, cost=cost)
        way = distances(start, goal)[np.arange(len(start)), slot]
        total.append(float(way.sum()))
        longest.append(float(way.max()))
        straight = journey(start, goal[slot])
        overlaps, distance = nearest(straight)
        least.append(distance)
        meeting["straight"] += overlaps > 0
        if overlaps:
            once = run_to_end(bend_paths_in_pieces(straight, 2 * RADIUS, seed=number, rounds=1, randomness=1.0))
            half = WIDTH / 2, DEPTH / 2
            often = run_to_end(bend_paths_in_pieces(straight, 2 * RADIUS + 0.04, seed=number, half=half))
            meeting["thesis"] += nearest(once)[0] > 0
            meeting["divided"] += nearest(often)[0] > 0
    share = {name: 100.0 * count / len(pairs) for name, count in meeting.items()}
    default = cost is Cost.SQUARED
    return [
        Row(f"{cost}: transitions with overlap, straight ways", share["straight"], "%", 0.0 if default else None,
            "at most"),
        Row(f"{cost}: after the thesis' divide and conquer", share["thesis"], "%", 0.0 if default else None, "at most"),
        Row(f"{cost}: after divide and conquer in rounds", share["divided"], "%", 0.0, "at most"),
        Row(f"{cost}: nearest two centres", min(least), "m", SPACING / math.sqrt(2) if default else None, "at least"),
        Row(f"{cost}: all ways together", float(np.mean(total)), "m", None, "at most"),
        Row(f"{cost}: longest way", float(np.mean(longest)), "m", None, "at most"),
    ]  # fmt: skip


def _ripple_rows(pairs: list[tuple[Float64, Float64]]) -> list[Row]:
    before = after = changed = 0
    for number, (start, goal) in enumerate(pairs):
        slot = assign(start, goal)
        waits = delays(Ripple(3.0, StartOrder.RANDOM), start, np.arange(len(start)))
        rippled = journey(start, goal[slot], waits)
        before += nearest(rippled)[0] > 0
        half = WIDTH / 2, DEPTH / 2
        pieces = repair_in_pieces(rippled, RADIUS, waits, begin=0.0, end=BEATS, seed=number, half=half)
        result = run_to_end(pieces)
        after += nearest(result.locomotion)[0] > 0
        changed += result.retimed
    count = len(pairs)
    return [
        Row("random ripple of 3 beats: transitions with overlap", 100.0 * before / count, "%", None, "at most"),
        Row("random ripple of 3 beats, mended: transitions with overlap", 100.0 * after / count, "%", 0.0, "at most"),
        Row("random ripple of 3 beats, mended: dancers who start otherwise", changed / count, "", None, "at most"),
    ]


def _arrival_rows(pairs: list[tuple[Float64, Float64]]) -> list[Row]:
    late, pushed, turned, overlaps = 0.0, 0.0, 0.0, 0
    for number, (start, goal) in enumerate(pairs):
        heading = np.random.default_rng([18, number]).uniform(-np.pi, np.pi, len(goal))
        missing, angle, met = _danced(start, goal, heading, push=0.0)
        late, turned, overlaps = max(late, missing), max(turned, angle), overlaps + met
        pushed = max(pushed, _danced(start, goal, heading, push=0.4)[0])
    return [
        Row("arrival on the measure, steered: farthest from the place", 100.0 * late, "cm", 5.0, "at most"),
        Row("arrival on the measure: heading off by", math.degrees(turned), "deg", 5.0, "at most"),
        Row("steered transitions: overlaps over 5 mm", float(overlaps), "", 0.0, "at most"),
        Row("every fifth dancer pushed 0.4 m aside halfway: farthest from the place", 100.0 * pushed, "cm", 5.0,
            "at most"),
    ]  # fmt: skip


def _danced(start: Float64, goal: Float64, heading: Float64, *, push: float) -> tuple[float, float, int]:
    """One transition through the plan and the real steering: metres off, radians off, ticks with new overlaps."""
    count = len(start)
    repertoire = Repertoire().with_formation(Places("goal", goal, heading))
    plan = Plan(Roster.create(count), repertoire, [Segment(Evolve("goal"), measures=2)], half=(WIDTH / 2, DEPTH / 2))
    model = AgentModel(
        np.full(count, RADIUS, np.float32), np.ones(count, np.float32), Steering(WIDTH / 2, DEPTH / 2), 0
    )
    advance, surroundings, wants = CrowdStepper(model), Surroundings(), AgentCommand(count)
    wants.speed[:] = 1.8
    state, spare = AgentState.at_rest(start), AgentState.at_rest(start)
    plan.begin_measure(0, state.position, np.zeros(count))
    touching, overlaps = np.zeros((count, count), np.bool_), 0
    ticks = round(BEATS / BEATS_PER_SECOND / TICK)
    for tick in range(ticks):
        if push and tick == ticks // 2:
            state.position[::5, 0] += push
        wants.clear()
        plan.write_commands(wants, state, tick * TICK * BEATS_PER_SECOND, BEATS_PER_SECOND)
        advance(state, spare, commands=wants, surroundings=surroundings, time=tick * TICK, dt=TICK)
        state, spare = spare, state
        apart = np.hypot(*np.moveaxis(state.position[:, None] - state.position[None], -1, 0))
        now = np.triu(apart < 2 * RADIUS - 0.005, 1)
        overlaps += int((now & ~touching).sum())
        touching = now
    target = plan.predicted_state(BEATS)
    motion = plan.motions[0].motion
    assert motion is not None  # an Evolve always has one
    off = float(np.hypot(*(state.position - goal[motion.slot]).T).max())
    angle = facing.shortest_turn(target.heading, heading[motion.slot])
    return off, float(np.abs(angle).max()), overlaps


def _time_rows(sizes: tuple[int, ...]) -> list[Row]:
    rows: list[Row] = []
    for count in sizes:
        side = math.sqrt(count / 0.5)
        chance = np.random.default_rng([19, count])
        start, goal = chance.uniform(-side / 2, side / 2, (2, count, 2))
        pieces: list[list[float]] = []
        cost = 0.0
        for _ in range(5):
            matching, own = IncrementalAssignment(), []
            began = time.perf_counter()
            matching.begin(start, goal)
            own.append(time.perf_counter() - began)
            while not matching.done:
                began = time.perf_counter()
                matching.work()
                own.append(time.perf_counter() - began)
            pieces.append(own)
            cost = float(((start - goal[matching.slot]) ** 2).sum())
        quickest = np.min(np.array(pieces), axis=0) * 1000.0  # the work is the same every time
        began = time.perf_counter()
        exact = assign(start, goal)
        whole = (time.perf_counter() - began) * 1000.0
        best = float(((start - goal[exact]) ** 2).sum())
        rows.append(
            Row(
                f"matching {count}: largest piece",
                float(quickest.max()),
                "ms",
                2.0 if count <= 1000 else None,
                "at most",
                {"exact, at once": whole},
            )
        )
        rows.append(Row(f"matching {count}: in all", float(quickest.sum()), "ms", None, "at most"))
        rows.append(Row(f"matching {count}: sum of squares over the least", cost / best, "", None, "at most"))
    return rows  # fmt: skip
