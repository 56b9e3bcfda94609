"""Which steps can follow a step, and how well: what a dancer may be told before anything is danced (T003, T043)."""

from dataclasses import dataclass

import numpy as np

from live.graph.library import StepLibrary
from live.graph.motion_graph import allowed_edges
from live.graph.transition import all_pairs, transition_windows


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
    transitions = all_pairs(*transition_windows(library, window))
    allowed = allowed_edges(library, transitions, threshold)
    allowed[:, library.node_measure > 0] = False
    own = library.node_step == step
    found = []
    for index, name in enumerate(library.steps):
        joins = allowed[np.ix_(own, library.node_step == index)]
        if joins.any():
            distances = transitions.distance[np.ix_(own, library.node_step == index)]
            found.append(Follower(name, float(distances[joins].min()), int(joins.sum())))
    return sorted(found, key=lambda follower: (follower.distance_m, follower.step))
