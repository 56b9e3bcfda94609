"""Which steps can follow a step, and how well: what a dancer may be told before anything is danced (T003, T043)."""

from dataclasses import dataclass

from live.graph.build.joins import Boundaries, JoinRule, find_joins
from live.graph.step_library import StepLibrary


@dataclass(frozen=True, slots=True)
class Follower:
    """A step that can come next."""

    step: str
    distance_m: float
    """Distance of the nearest pair of measures [m] (T034)."""
    pairs: int
    """Joins between a variation of the one and a variation of the other."""


def followers(library: StepLibrary, step: int, *, window: float = 0.1875, threshold: float = 0.16) -> list[Follower]:
    """The steps that can follow the step of that index within `threshold` [m], the nearest first."""
    rule = JoinRule(window, threshold)
    joins = find_joins(library, Boundaries.of(library, rule), rule)
    own = (library.node_step[joins.source] == step) & (library.node_measure[joins.target] == 0)
    follows, cost = library.node_step[joins.target[own]], joins.cost[own]
    found = []
    for index, name in enumerate(library.steps):
        distances = cost[follows == index]
        if len(distances):
            found.append(Follower(name, float(distances.min()), len(distances)))
    return sorted(found, key=lambda follower: (follower.distance_m, follower.step))
