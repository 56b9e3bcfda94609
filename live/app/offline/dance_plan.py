"""Planning of `live dance`: library, motion graph, the path through it, and the motion."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.app.offline.dance_request import SKETCHES, check_attributes, read_clips, read_text, read_wanted
from live.app.offline.step_listing import RECORDING_THRESHOLD_M, SKETCH_THRESHOLD_M
from live.base.arrays import Float64, Int32
from live.base.errors import PersonError
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.render_dance import RenderedDance, render_dance
from live.graph.search.depth_first_reference import SearchTooLong
from live.graph.search.path_diagnostics import MissingMotion, find_missing, path_problems
from live.graph.search.path_following import FollowedPath, Targets, follow_line, follow_path, read_path, smoothed
from live.graph.search.sequence import NoPath, best_start, find_name, find_sequence, list_steps
from live.graph.search.sequence_spec import SequenceEntry, SequenceSpec, specify
from live.graph.select.candidates import find_candidates
from live.graph.select.selector import recorded_seconds, tempo_excess
from live.graph.step_library import StepLibrary
from live.motion.editing.tempo_forms import TEMPO_LIMITS

WINDOW_BEATS: Final = 0.75
MAX_PATH_MEASURES: Final = 3000
"""Longest dance along a path; each measure takes a twentieth of a second."""


@dataclass(frozen=True, slots=True)
class DanceOptions:
    """Options of the command line."""

    library: str
    sequence: str
    bpm: float | None = None
    path: str | None = None
    heading: str | None = None
    correction: float = 0.0
    start: str | None = None
    window: float | None = None
    threshold: float | None = None
    foot_rule: bool = False
    depth_first: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class DancePlan:
    """Planned dance of M measures."""

    graph: MotionGraph
    specification: SequenceSpec
    bpm: float
    node: Int32
    """Shape (M,)."""
    edge_cost: Float64
    """Distance of the poses at the start of each measure [m], 0 for the first, shape (M,)."""
    missing: tuple[MissingMotion, ...]
    heading: float
    """The dancer's initial heading [rad]."""
    targets: Targets | None = None
    """The path, if there is one."""
    followed: FollowedPath | None = None

    @property
    def deviations(self) -> npt.NDArray[np.bool_]:
        """Measures that differ from the request, shape (M,)."""
        return np.asarray(~self.specification.fits[self.specification.set_index, self.node])

    @property
    def off_tempo(self) -> tuple[str, ...]:
        """A line for each recorded clip that is danced outside the limits of its tempo."""
        library = self.graph.library
        seconds = library.beats_per_measure * 60.0 / self.bpm
        ratio = recorded_seconds(library)[self.node] / seconds
        off = np.abs(tempo_excess(ratio * seconds, seconds)) > 1e-9
        told = {
            f"{library.steps[library.node_step[node]]!r} is danced at {own:.2f} times its {self.bpm / own:.4g} bpm; "
            f"{TEMPO_LIMITS[0]} to {TEMPO_LIMITS[1]} looks natural: choose another --bpm"
            for node, own in zip(self.node[off].tolist(), ratio[off].tolist(), strict=True)
        }
        return tuple(sorted(told))


def make_plan(options: DanceOptions) -> DancePlan:
    """Read the library and find the dance; raise PersonError if that fails."""
    library, wanted = read_wanted(read_clips(options.library), read_text(options.sequence))
    check_attributes(library, wanted)
    specification = specify(library, wanted, foot_rule=options.foot_rule)
    graph = _graph(options, library)
    start = None if options.start is None else _start(graph, specification, options.start)
    missing = find_missing(graph, specification, start=start)
    _refuse_lone_steps(graph, wanted, missing)
    bpm = _tempo(options, library, wanted)
    headings = _headings(options)
    if options.path is not None:
        return _along_path(options, graph, specification, bpm, headings, missing)
    if isinstance(headings, str) or len(headings) > 1:
        raise PersonError(f"--heading {options.heading}: only a --path can be faced along or turned on", "--heading 0")
    try:
        found = find_sequence(
            graph, specification, start=start, method="depth first" if options.depth_first else "layered"
        )
    except (NoPath, SearchTooLong) as error:
        needs = "; ".join(one.needs for one in missing[:1])
        raise PersonError(f"--sequence: {error}", needs or "leave --depth-first out") from None
    return DancePlan(graph, specification, bpm, found.node, found.edge_cost, tuple(missing), headings[0])


def assemble_plan(plan: DancePlan) -> RenderedDance:
    """Return the motion of a plan; raise PersonError if it is too long for one file."""
    followed, targets = plan.followed, plan.targets
    try:
        if followed is None or targets is None:
            return render_dance(plan.graph, plan.node, bpm=plan.bpm, start=(0.0, 0.0, plan.heading))
        return render_dance(
            plan.graph,
            plan.node,
            bpm=plan.bpm,
            turns=followed.turn,
            corrections=followed.correction,
            takes=(followed.take, followed.share),
            start=(float(targets.place[0, 0]), float(targets.place[0, 1]), float(targets.heading[0])),
        )
    except ValueError as error:
        raise PersonError(f"--sequence: {error}", "--json alone finds the dance without its motion") from None


def _headings(asked: DanceOptions) -> "str | tuple[float, ...]":
    """Parse the dancer's heading: "path", or one or two angles [rad]."""
    text = (asked.heading or "0").strip().lower()
    if text in ("path", "public"):
        return text if text == "path" else (0.0,)
    try:
        degrees = [float(word) for word in text.split(",")]
    except ValueError:
        degrees = []
    if not 1 <= len(degrees) <= 2 or not all(abs(value) <= 36_000 for value in degrees):
        raise PersonError(f"--heading {asked.heading!r}: degrees, two with a comma between, or 'path' expected")
    return tuple(math.radians(value) for value in degrees)


# -- search ------------------------------------------------------------------------------------------------------------


def _graph(asked: DanceOptions, library: StepLibrary) -> MotionGraph:
    window = (asked.window or WINDOW_BEATS) / library.beats_per_measure
    if window > 1.0:
        raise PersonError(f"--window {asked.window:g}: at most a measure, {library.beats_per_measure} beats, expected")
    usual = SKETCH_THRESHOLD_M if asked.library == SKETCHES else RECORDING_THRESHOLD_M
    try:
        return build_graph(library, window=window, threshold=asked.threshold or usual, prune=False)
    except ValueError as error:
        raise PersonError(f"{asked.library}: {error}", "a lower --threshold") from None


def _start(graph: MotionGraph, specification: SequenceSpec, name: str) -> int:
    """Return the last measure of the step's variation from which the dance continues best."""
    library = graph.library
    step = find_name(library, name)
    if step is None:
        raise PersonError(f"--start: there is no step {name[:60]!r}", list_steps(library))
    return best_start(graph, specification, np.flatnonzero((library.node_step == step) & specification.leaves))


def _refuse_lone_steps(graph: MotionGraph, wanted: Sequence[SequenceEntry], missing: Sequence[MissingMotion]) -> None:
    """Raise PersonError for a step without joins to or from other steps, unless it is the only one."""
    library = graph.library
    joined = np.zeros(len(library.steps), np.bool_)
    source = np.repeat(np.arange(library.node_count), np.diff(graph.edge_start))
    between = library.node_measure[graph.edge_target] == 0
    for node in (source[between], graph.edge_target[between]):
        joined[library.node_step[node]] = True
    for step in {entry.step for entry in wanted if entry.step is not None and not joined[entry.step]}:
        name = library.steps[step]
        why = [one.needs for one in missing if name in (one.source, one.target)]
        if why:
            raise PersonError(f"nothing leads to {name!r} or away from it within {graph.rule.threshold:g} m", why[0])


def _tempo(asked: DanceOptions, library: StepLibrary, wanted: Sequence[SequenceEntry]) -> float:
    named = [library.steps[entry.step] for entry in wanted if entry.step is not None]
    first = next(clip for clip in library.clips if not named or clip.step == named[0])
    return first.bpm if asked.bpm is None else asked.bpm


def _along_path(
    asked: DanceOptions, graph: MotionGraph, specification: SequenceSpec, bpm: float,
    headings: "str | tuple[float, ...]", missing: Sequence[MissingMotion],
) -> DancePlan:  # fmt: skip
    assert asked.path is not None
    points = read_path(asked.path)
    if specification.measures > MAX_PATH_MEASURES:
        raise PersonError(
            f"--path: {specification.measures} measures, at most {MAX_PATH_MEASURES} are led along a path",
            "a shorter --sequence",
        )
    if isinstance(headings, str):
        targets = smoothed(follow_line(points, specification.measures, facing="path"))
    else:
        targets = follow_line(points, specification.measures, facing=(headings[0], headings[-1]))
    seconds = graph.library.beats_per_measure * 60.0 / bpm
    candidates = find_candidates(graph)
    try:
        followed = follow_path(
            graph,
            targets,
            seconds=seconds,
            fits=specification.fits[specification.set_index],
            correction_m=asked.correction,
            candidates=candidates,
        )
    except ValueError as error:
        raise PersonError(f"--path: {error}") from None
    lacks = path_problems(graph, candidates, targets, followed, seconds=seconds)
    missing = [*missing, *(MissingMotion(lack.measures[0], None, lack.step, lack.text) for lack in lacks)]
    missing.sort(key=lambda one: one.measure)
    cost = np.zeros(len(followed.node))
    for n in range(1, len(cost)):
        row = slice(graph.edge_start[followed.node[n - 1]], graph.edge_start[followed.node[n - 1] + 1])
        cost[n] = graph.edge_cost[row][graph.edge_target[row] == followed.node[n]].min()
    return DancePlan(
        graph, specification, bpm, followed.node, cost, tuple(missing), float(targets.heading[0]), targets, followed
    )
