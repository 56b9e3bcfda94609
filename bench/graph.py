"""The motion graph: all pairs of measures against a plain loop, building, inserting a take, deciding for a crowd."""

import gc
import math
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._recorded_measures import varied_measures
from bench._show import crowd
from live.base.event_queue import EventQueue
from live.base.jit import kernel
from live.cli.bench import Row
from live.clock.time_source import ManualClock
from live.control.events.events import ControlEvent
from live.graph.build.bridges import BASE_RATE, PosedRecording, find_bridges
from live.graph.build.components import strong_components
from live.graph.build.metric import FlatClouds, Metric
from live.graph.build.nearest_pairs import PairCodes, near_pairs
from live.graph.build.transitions import transition_windows
from live.graph.library_insert import insert_clips
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.step_library import StepLibrary, build_library
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.skeleton import JOINT_COUNT
from live.motion.step_clip import StepClip
from live.show.engine import Engine
from live.show.loader import RECORDING_THRESHOLDS_M, load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH, PATCHES
from live.show.view.status import Status

Float64 = npt.NDArray[np.float64]

FRAMES, POINTS = 20, 31
"""Windows of the plain loop: those of the literature."""
FASTER = 25.0
FPS = 60


def run(full: bool, shared: Path | None) -> list[Row]:
    """The project's own sketches, each danced by many bodies; the best of several runs, decisions by CPU time."""
    repeats = 7 if full else 4
    clips = _measures(1000)
    rows = _metric(repeats)
    gc.collect()
    build = _best(lambda: _library_and_graph(clips), repeats)
    _, graph = _library_and_graph(clips)
    rows.append(Row("graph of 1,000 measures, clips to edges", build, "s", 1.0))
    rows.append(Row("of it the library", _best(lambda: build_library(clips), repeats), "s"))
    rows.append(Row("its edges", float(graph.edge_count), ""))
    take = _measures(1, seed=7)
    joining = _best(lambda: insert_clips(graph, take), 3 * repeats)
    rows.append(Row("a take joins 1,000 measures", 1e3 * joining, "ms", 100.0))
    rows += _recorded(shared, full)
    rows.append(Row("10,000 measures, all pairs, components", _many(graph, 2 if full else 1), "s", 8.0))
    rows.append(Row("bridge over 30 min of motion, a pair of steps", _bridge(graph, repeats), "s", 1.0))
    for dancers, bar in ((200, 4.0), (1000, 15.0), (10_000, 150.0)):
        work = _decisions(dancers, measures=3 if dancers > 1000 else 24 if full else 10)
        rows.append(Row(f"{dancers} dancers: planning of a measure, median", float(np.median(work)), "ms", bar))
        rows.append(Row(f"{dancers} dancers: the longest", float(work.max()), "ms"))
    return rows


@kernel("void(f8[:,:,::1],f8[:,:,::1],f8[::1],f8[:,::1])")
def plain_loop(first: Float64, second: Float64, weight: Float64, out: Float64) -> None:
    """K002 for all pairs of (N, P, 3) and (M, P, 3) as it is written: K001's closed form, then the sum of squares."""
    total = 0.0
    for p in range(weight.shape[0]):
        total += weight[p]
    for i in range(first.shape[0]):
        for j in range(second.shape[0]):
            sx, sz, tx, tz, cross, dot = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for p in range(weight.shape[0]):
                w, x, z = weight[p], first[i, p, 0], first[i, p, 2]
                u, v = second[j, p, 0], second[j, p, 2]
                sx += w * x
                sz += w * z
                tx += w * u
                tz += w * v
                cross += w * (x * v - u * z)
                dot += w * (x * u + z * v)
            yaw = math.atan2(cross - (sx * tz - tx * sz) / total, dot - (sx * tx + sz * tz) / total)
            c, s = math.cos(yaw), math.sin(yaw)
            x0, z0 = (sx - tx * c - tz * s) / total, (sz + tx * s - tz * c) / total
            distance = 0.0
            for p in range(weight.shape[0]):
                u, v = second[j, p, 0], second[j, p, 2]
                dx = first[i, p, 0] - (u * c + v * s + x0)
                dy = first[i, p, 1] - second[j, p, 1]
                dz = first[i, p, 2] - (-u * s + v * c + z0)
                distance += weight[p] * (dx * dx + dy * dy + dz * dz)
            out[i, j] = distance


def _metric(repeats: int) -> list[Row]:
    """Nanoseconds per pair; both see each pair once, ours keeps those that are near with their alignment."""
    clouds = _clouds(2000)
    metric = Metric(np.full(POINTS, 1.0 / POINTS), np.full(FRAMES, 1.0 / FRAMES))
    few = np.ascontiguousarray(clouds[:300].reshape(300, -1, 3))
    table = np.empty((300, 300))
    loop = _best(lambda: plain_loop(few, few, metric.points, table), repeats) / table.size
    threshold = math.sqrt(float(np.quantile(table, 0.02)))

    def ours(count: int) -> int:
        flat = FlatClouds.of(clouds[:count], metric)
        return len(near_pairs(flat, flat, threshold, PairCodes.free(count, count)).row)

    if ours(300) != np.count_nonzero(table <= threshold**2):
        raise AssertionError("the two do not agree")
    own = _best(lambda: ours(len(clouds)), repeats) / len(clouds) ** 2
    peers = {"plain loop, numba, one thread": 1e9 * loop}
    return [
        Row(f"a pair of windows of {FRAMES} × {POINTS} points", 1e9 * own, "ns", peers=peers),
        Row("all pairs, times the plain loop", loop / own, "×", FASTER, "at least"),
    ]


def _clouds(count: int) -> Float64:
    """Windows of one body whose joints swing differently each time, anywhere on the stage, (count, K, J, 3)."""
    chance = np.random.default_rng(3)
    body = chance.normal((0.0, 1.0, 0.0), 0.35, (1, 1, POINTS, 3))
    swing = np.sin(np.linspace(0.0, 1.0, FRAMES)[:, None, None] * 3.0 + chance.uniform(0, 6, (count, 1, POINTS, 3)))
    cloud = body + 0.15 * swing * chance.uniform(0.2, 1.0, (count, 1, 1, 1))
    cloud[..., (0, 2)] += chance.uniform(-4, 4, (count, 1, 1, 2))
    return np.ascontiguousarray(cloud)


def _measures(count: int, seed: int = 1) -> list[StepClip]:
    """`count` measures: the sketches, with every joint of every dancer held a little differently."""
    chance = np.random.default_rng(seed)
    sketches = load_folder(PATCHES / "steps")
    beats = sketches[0].beats_per_measure
    sketches = [step for step in sketches if step.beats_per_measure == beats and step.measures == 1]
    found = []
    for n in range(count):
        step = sketches[n % len(sketches)]
        axis = chance.normal(size=(JOINT_COUNT, 3))
        axis /= np.linalg.norm(axis, axis=1)[:, None]
        habit = quaternion.from_axis_angle(axis, chance.normal(0.0, 0.08, JOINT_COUNT))
        rotation = quaternion.unit(quaternion.mul(step.clip.rotation.astype(np.float64), habit)).astype(np.float32)
        found.append(replace(step, clip=replace(step.clip, rotation=rotation)))
    return found


def _recorded(shared: Path | None, full: bool) -> list[Row]:
    """Graphs of recorded measures, which are all alike: what they cost."""
    named = {2000: ("2,000 recorded measures", 2.0), 10_000: ("10,000 recorded measures", 15.0)}
    rows = []
    for count, (name, bar) in named.items():
        if count > 2000 and not full:
            continue
        clips = varied_measures(shared, count)
        if not clips:
            rows.append(Row(f"{name}, clips to edges, CPU (no recordings here)", None, "s", bar))
            continue
        times = []
        for _ in range(1 if count > 2000 else 3):
            gc.collect()
            begin = time.process_time()
            library = build_library(clips)
            graph = build_graph(library, window=0.25, threshold=max(RECORDING_THRESHOLDS_M))
            times.append(time.process_time() - begin)
        rows.append(Row(f"{name}, clips to edges, CPU", min(times), "s", bar))
        rows.append(Row("its edges", float(graph.edge_count), ""))
        if count > 2000:
            continue
        begin = time.process_time()
        insert_clips(graph, clips[:1])
        rows.append(Row(f"a take joins {name}, CPU", 1e3 * (time.process_time() - begin), "ms"))
        del graph
        tracemalloc.start()
        build_graph(library, window=0.25, threshold=max(RECORDING_THRESHOLDS_M))
        rows.append(
            Row(f"{name}, the graph's memory at its peak", tracemalloc.get_traced_memory()[1] / 1e6, "MB", 200.0)
        )
        tracemalloc.stop()
    return rows


def _library_and_graph(clips: list[StepClip]) -> tuple[StepLibrary, MotionGraph]:
    library = build_library(clips)
    return library, build_graph(library)


def _many(graph: MotionGraph, repeats: int) -> float:
    """Ten thousand measures: the thousand ten times, moved a little each time, at half the threshold."""
    chance = np.random.default_rng(5)

    def ten(windows: Float64) -> FlatClouds:
        cloud = np.tile(windows, (10, 1, 1, 1))
        cloud += 0.02 * chance.normal(size=(len(cloud), 1, JOINT_COUNT, 3))
        return FlatClouds.of(cloud, graph.rule.metric)

    ends, starts = (ten(windows) for windows in transition_windows(graph.library, graph.window))
    free = PairCodes.free(len(ends), len(starts))

    def whole() -> None:
        pairs = near_pairs(ends, starts, 0.5 * graph.rule.threshold, free, graph.rule.limits)
        strong_components(len(ends), pairs.row, pairs.column)

    return _best(whole, repeats)


def _bridge(graph: MotionGraph, repeats: int) -> float:
    """Searching half an hour, here all measures of the library one after another, for a way between two steps."""
    parts = [PosedRecording.of(clip.clip) for clip in graph.library.clips[:100]]
    times = math.ceil(30 * 60 * BASE_RATE / sum(len(part.floor) for part in parts))
    floor = np.concatenate([part.floor for part in parts] * times)
    height = np.concatenate([part.height for part in parts] * times)
    whole = PosedRecording(parts[0].clip, floor, height)
    return _best(lambda: find_bridges(graph, [whole], 0, 1, measure_s=2.0), repeats)


def _decisions(dancers: int, measures: int) -> Float64:
    """CPU time [ms] of the planning for each measure line: looking ahead, paths, steps, edges, parting."""
    show = crowd(dancers, load_show(DEFAULT_PATCH))
    clock = ManualClock()
    engine = Engine(
        show, clock=clock, inbox=EventQueue[ControlEvent](), status=Status(show, rejected=Counter, memory=float)
    )
    spent = np.zeros(measures + 2)
    inside = False

    def timed(work: Callable[..., object]) -> Callable[..., None]:
        def timed_work(*arguments: object, **named: object) -> None:
            nonlocal inside
            if inside:  # the decision finishes the look-ahead, and is timed with it
                work(*arguments, **named)
                return
            inside, begin = True, time.thread_time_ns()
            work(*arguments, **named)
            inside = False
            spent[min(show.span.number, measures + 1)] += (time.thread_time_ns() - begin) * 1e-6

        return timed_work

    for name in ("decide", "work"):
        setattr(show.scheduler, name, timed(getattr(show.scheduler, name)))
    frame = 0
    while show.span.number <= measures:
        clock.set(frame / FPS)
        engine.frame(lambda view: None)
        frame += 1
    return spent[1 : measures + 1]


def _best(work: Callable[[], object], repeats: int) -> float:
    """The shortest of `repeats` runs [s]."""
    best = math.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return best
