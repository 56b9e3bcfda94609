"""What a path asks too much of, in words: too fast, off the line, and what to record for it (T075)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.followed_path import FollowedPath
from live.graph.search.path import Targets
from live.graph.select.candidates import Candidates
from live.graph.select.placing import turn_vectors
from live.graph.select.reach import DIRECTIONS, direction_of, reach_of

Float64 = npt.NDArray[np.float64]

THRESHOLD: Final = 0.15
"""A dancer farther than this [m] from her place at a measure line is off the path."""
CATCH_UP: Final = 1.25
"""Whoever is off the path can come back to it with steps this much longer than the path's own."""
_NO_TRAVEL: Final = 0.02


@dataclass(frozen=True, slots=True)
class Lack:
    """One thing that the recordings do not allow."""

    step: str
    direction: str
    """As the dancer sees it who begins the measure; "" where it is no matter of direction."""
    measures: tuple[int, ...]
    """Measures concerned, from 1."""
    text: str
    """For the choreographer, with what to do about it."""


def path_lacks(
    graph: MotionGraph,
    candidates: Candidates,
    targets: Targets,
    followed: FollowedPath,
    *,
    seconds: float,
    threshold: float = THRESHOLD,
) -> list[Lack]:
    """Why a dancer is farther than `threshold` [m] from her places: [] if she never is.

    First the steps for which the whole path is too fast, each with how fast it can be followed; then, where the error
    has grown, the directions in which a longer step is missing.
    """
    if not (followed.error > threshold).any():
        return []
    library = graph.library
    steps = library.node_step[followed.node]
    lacks: list[Lack] = []
    slow: set[int] = set()
    for step in sorted(set(steps.tolist())):
        most = reach_of(graph, candidates, step, seconds).most  # without turns: a spin is no way to travel
        mean = float(targets.ways[steps == step].mean())
        if mean > most:
            slow.add(step)
            lacks.append(_too_fast(library.steps[step], mean, most, np.flatnonzero(steps == step), targets))
    return lacks + _directions(graph, candidates, targets, followed, seconds, threshold, slow)


def _too_fast(
    step: str, mean: float, most: float, measures: npt.NDArray[np.int64], targets: Targets
) -> Lack:  # fmt: skip
    told = f"the path goes {mean:.2f} m a measure, but {step!r} travels {most:.2f} m at most"
    if most < _NO_TRAVEL:
        remedy = f"record {step!r} going somewhere, or choose a step that travels"
    else:
        needed = int(np.ceil(targets.ways[measures].sum() / most))
        remedy = f"give this way {needed} measures instead of {len(measures)}, or choose a step that travels farther"
    return Lack(step, "", tuple((measures + 1).tolist()), f"{told}: {remedy}")


def _directions(
    graph: MotionGraph, candidates: Candidates, targets: Targets, followed: FollowedPath, seconds: float,
    threshold: float, slow: set[int],
) -> list[Lack]:  # fmt: skip
    """For every step and direction in which the error grew beyond the threshold, the longest way that was wanted."""
    library, steps = graph.library, graph.library.node_step[followed.node]
    before = np.concatenate(([0.0], followed.error[:-1]))
    grew = (followed.error > threshold) & (followed.error > before)
    place = np.vstack([targets.place[:1], followed.place])
    found: dict[tuple[int, str], list[tuple[int, float]]] = {}
    for n in np.flatnonzero(grew):
        if int(steps[n]) in slow:
            continue
        heading = targets.heading[n : n + 1]
        wanted = turn_vectors(targets.place[n + 1 : n + 2] - place[n : n + 1], -heading)[0]
        # what is missing is a step that goes a little farther than the path, not one that makes up for all at once
        longest = min(float(np.hypot(*wanted)), CATCH_UP * max(float(targets.ways[n]), threshold))
        found.setdefault((int(steps[n]), direction_of(wanted)), []).append((int(n) + 1, longest))
    lacks = []
    for (step, direction), rows in found.items():
        reach = reach_of(graph, candidates, step, seconds)
        reached = float(reach.straight[DIRECTIONS.index(direction)])
        longest = max(way for _, way in rows)
        measures = tuple(measure for measure, _ in rows)
        name = library.steps[step]
        error = max(float(followed.error[measure - 1]) for measure in measures)
        where = "measure" if len(measures) == 1 else "measures"
        text = f"{where} {_listed(measures)}: {error:.2f} m off the path with {name!r}, "
        if longest > reached:
            text += (
                f"{longest:.2f} m {direction} wanted, {reached:.2f} m there are: record {name!r} {direction}, "
                f"{longest:.1f} m a measure"
            )
        else:
            text += f"which goes {direction} far enough, but not after the step before: give the turn more measures"
        lacks.append(Lack(name, direction, measures, text))
    return lacks


def _listed(measures: tuple[int, ...]) -> str:
    shown = ", ".join(str(measure) for measure in measures[:6])
    return shown if len(measures) <= 6 else f"{shown} and {len(measures) - 6} more"
