"""Explanations of paths that cannot be followed (T075) and sequences that cannot be danced (T003, T043, T065).

Each names the reason and the remedy, such as the clip to record.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.build.nearest_pair_report import NearestPair
from live.graph.motion_graph import MotionGraph
from live.graph.search.path_following import FollowedPath, Targets
from live.graph.search.sequence import edges_of
from live.graph.search.sequence_diagnostics import Gap, find_gaps
from live.graph.search.sequence_spec import LEADING_FOOT, SequenceEntry, SequenceSpec
from live.graph.select.candidates import Candidates, turn_vectors
from live.graph.select.reachability import DIRECTION_NAMES, direction_of, reach_of
from live.graph.structure_rules import initial_side
from live.motion.step_clip import StepClip

THRESHOLD: Final = 0.15
"""A dancer farther than this [m] from their place at a measure line is off the path."""
CATCH_UP: Final = 1.25
"""Steps longer than the path's own by this factor let a dancer return to the path."""
_NO_TRAVEL: Final = 0.02


@dataclass(frozen=True, slots=True)
class PathProblem:
    """One thing that the recordings do not allow."""

    step: str
    direction: str
    """As seen by the dancer at the beginning of the measure; "" if the direction does not matter."""
    measures: tuple[int, ...]
    """Measures concerned, from 1."""
    text: str
    """Text for the choreographer, with the remedy."""


def path_problems(
    graph: MotionGraph,
    candidates: Candidates,
    targets: Targets,
    followed: FollowedPath,
    *,
    seconds: float,
    threshold: float = THRESHOLD,
) -> list[PathProblem]:
    """Return the reasons why a dancer is farther than `threshold` [m] from their places; [] if they never are.

    First come the steps for which the whole path is too fast, each with the speed that is possible; then, where the
    error has grown, the directions in which a longer step is missing.
    """
    if not (followed.error > threshold).any():
        return []
    library = graph.library
    steps = library.node_step[followed.node]
    lacks: list[PathProblem] = []
    slow: set[int] = set()
    for step in sorted(set(steps.tolist())):
        most = reach_of(graph, candidates, step, seconds).max_travel  # without turns: a spin does not travel
        mean = float(targets.distances[steps == step].mean())
        if mean > most:
            slow.add(step)
            lacks.append(_too_fast(library.steps[step], mean, most, np.flatnonzero(steps == step), targets))
    return lacks + _directions(graph, candidates, targets, followed, seconds, threshold, slow)


def _too_fast(
    step: str, mean: float, most: float, measures: npt.NDArray[np.int64], targets: Targets
) -> PathProblem:  # fmt: skip
    told = f"the path goes {mean:.2f} m a measure, but {step!r} travels {most:.2f} m at most"
    if most < _NO_TRAVEL:
        remedy = f"record {step!r} with travel, or choose a step that travels"
    else:
        needed = int(np.ceil(targets.distances[measures].sum() / most))
        remedy = f"give this path {needed} measures instead of {len(measures)}, or choose a step that travels farther"
    return PathProblem(step, "", tuple((measures + 1).tolist()), f"{told}: {remedy}")


def _directions(
    graph: MotionGraph, candidates: Candidates, targets: Targets, followed: FollowedPath, seconds: float,
    threshold: float, slow: set[int],
) -> list[PathProblem]:  # fmt: skip
    """Return, per step and direction in which the error grew beyond the threshold, the longest distance wanted."""
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
        # the missing step goes a little farther than the path; it need not make up for the whole error at once
        longest = min(float(np.hypot(*wanted)), CATCH_UP * max(float(targets.distances[n]), threshold))
        found.setdefault((int(steps[n]), direction_of(wanted)), []).append((int(n) + 1, longest))
    lacks = []
    for (step, direction), rows in found.items():
        reach = reach_of(graph, candidates, step, seconds)
        reached = float(reach.straight[DIRECTION_NAMES.index(direction)])
        longest = max(way for _, way in rows)
        measures = tuple(measure for measure, _ in rows)
        name = library.steps[step]
        error = max(float(followed.error[measure - 1]) for measure in measures)
        where = "measure" if len(measures) == 1 else "measures"
        text = f"{where} {_listed(measures)}: {error:.2f} m off the path with {name!r}, "
        if longest > reached:
            text += (
                f"{longest:.2f} m {direction} wanted, {reached:.2f} m available: record {name!r} {direction}, "
                f"{longest:.1f} m a measure"
            )
        else:
            text += f"which travels {direction} far enough, but not after the step before: give the turn more measures"
        lacks.append(PathProblem(name, direction, measures, text))
    return lacks


def _listed(measures: tuple[int, ...]) -> str:
    shown = ", ".join(str(measure) for measure in measures[:6])
    return shown if len(measures) <= 6 else f"{shown} and {len(measures) - 6} more"


@dataclass(frozen=True, slots=True)
class MissingMotion:
    """A join or a variation that a dance lacks."""

    measure: int
    """The first measure of the dance, from 1, for which it is needed."""
    source: str | None
    """The step that it must follow; None if that does not matter."""
    target: str | None
    """The step that cannot be reached; None: any."""
    needs: str
    """What to record, change or allow."""
    pair: tuple[int, int] | None = None
    """The nearest nodes that would have to be joined."""
    distance: float | None = None
    """Distance of their poses [m] (K002)."""

    def row(self) -> dict[str, str | None]:
        """Return the row for reports."""
        return {"from": self.source, "to": self.target, "needs": self.needs}


def find_missing(graph: MotionGraph, specification: SequenceSpec, *, start: int | None = None) -> list[MissingMotion]:
    """Return the fewest joins and clips that would make a sequence possible; empty if it is possible.

    Each is named once, where it is first needed.
    """
    words = _GapExplainer(graph, specification)
    found: dict[tuple[str | None, str | None, str], MissingMotion] = {}
    for gap in find_gaps(edges_of(graph), specification, words.pairs.find, start=start):
        one = words.explain(gap)
        found.setdefault((one.source, one.target, one.needs), one)
    return list(found.values())


class _GapExplainer:
    """Formatter of the remedies for gaps."""

    def __init__(self, graph: MotionGraph, specification: SequenceSpec) -> None:
        self._library = graph.library
        self._spec = specification
        self._threshold = graph.rule.threshold
        self.pairs = NearestPair(graph)

    def explain(self, gap: Gap) -> MissingMotion:
        """Return a gap with its explanation."""
        number = int(self._spec.entry_index[gap.measure])
        entry = self._spec.entries[number]
        target = None if entry.step is None else self._library.steps[entry.step]
        if gap.pair is None:
            before = self._spec.entries[number - 1].step if number else None
            source = None if before is None else self._library.steps[before]
            return MissingMotion(gap.measure + 1, source, target, self._no_clip(entry, gap))
        u, v = gap.pair
        source, distance = self._step(u), self.pairs.distance[gap.pair]
        needs = self._no_join(u, v, entry, distance)
        return MissingMotion(gap.measure + 1, source, target, needs, gap.pair, distance)

    def _no_clip(self, entry: SequenceEntry, gap: Gap) -> str:
        if entry.step is None or gap.has_clip:
            name = "the dance ends" if entry.step is None else f"{self._library.steps[entry.step]} begins"
            return f"no step is short enough to end where {name}: record one of 1 measure"
        words = self._travel_clauses(entry)
        if not words:  # the step exists, but all its clips were left out because of the leading foot (T134)
            words = ["leads with the right foot where it travels left, or with the left where it travels right"]
        return f"no {self._library.steps[entry.step]}{_clauses(words)}: record one"

    def _no_join(self, u: int, v: int, entry: SequenceEntry, distance: float) -> str:
        a, b = self._step(u), "step" if entry.step is None else self._step(v)
        clauses, or_else = [], ""
        if self.pairs.poses_clash(u, v):
            end, begin = self._clip(u).end_pose, self._clip(v).begin_pose
            clauses.append(f"starts in {end}")
            or_else = f" (or {a} that ends in {begin})"
        if self.pairs.repeats(u, v):
            other = LEADING_FOOT.get(initial_side(self._clip(u)))
            clauses.append("is begun on the other side" if other is None else f"is begun with the {other} foot")
            or_else = or_else or " (its mirror image will do)"
        if clauses:
            return f"no {b}{_clauses([*clauses, *self._travel_clauses(entry)])}: record one{or_else}"
        join = f"{self._library.describe(u)!r} and {self._library.describe(v)!r}"
        if distance <= self._threshold:
            return f"{join} would fit, but the graph leaves that join out: look at `live steps check`"
        allow = math.ceil(distance * 100.0) / 100.0
        return (
            f"no {b}{_clauses([f'begins as {a} ends', *self._travel_clauses(entry)])}: record one, or "
            f"allow {allow:.2f} m; the nearest, {join}, are {100.0 * distance:.0f} cm apart "
            f"where {100.0 * self._threshold:.0f} cm may be"
        )

    def _travel_clauses(self, entry: SequenceEntry) -> list[str]:
        """Return clauses for its direction and leading foot."""
        if not entry.direction:
            return []
        words = ["is danced in place" if entry.direction == "in place" else f"travels {entry.direction}"]
        foot = LEADING_FOOT.get(entry.direction.split()[-1])
        if self._spec.foot_rule and foot is not None:
            words.append(f"leads with the {foot} foot")
        return words

    def _step(self, node: int) -> str:
        return self._library.steps[int(self._library.node_step[node])]

    def _clip(self, node: int) -> StepClip:
        clip: StepClip = self._library.clips[self._library.node_clip[node]]
        return clip


def _clauses(words: list[str]) -> str:
    """Return clauses as in " that starts in Sous-sus, leads with the right foot and travels left"."""
    if not words:
        return ""
    return " that " + (", ".join(words[:-1]) + " and " if len(words) > 1 else "") + words[-1]
