"""Quality of dances through the motion graph: joins, feet and beats on recordings, and paths with sketched steps."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._motion_clips import SALSA, SKETCHES, SOLO, WALKS, recordings
from live.cli.bench import Row
from live.graph.dance_metrics import DanceMetrics, RawClips
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.render_dance import RenderedDance, render_dance
from live.graph.search.path_following import follow_line, follow_path, smoothed
from live.graph.select.candidates import find_candidates
from live.graph.step_library import build_library
from live.library.step_folder import load_folder
from live.motion.quality.beat_chance import compare_with_chance
from live.motion.quality.metrics import beat_offsets, mean_speed, motion_beats
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

USUAL = (0.75 / 4.0, 0.35)
"""Length of a blend [measures] and largest distance of a join [m]: what `live dance` takes for recordings."""
CLOSE = (1.0 / 4.0, 0.2)
"""`live dance --window 1 --threshold 0.2`: fast music leaves little time for a blend, and near poses need less."""
MEASURES = 32
SQUARE = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]
CIRCLE = [(2.0 * np.sin(phi), 2.0 * np.cos(phi)) for phi in np.linspace(0.0, 2.0 * np.pi, 361)]
MOST_SLIDE = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Danced:
    """Random walks through the graph of one kind of recordings."""

    name: str
    figures: list[DanceMetrics]
    raw: RawClips


def run(full: bool, shared: Path | None) -> list[Row]:
    """Random walks over the recordings in `shared`/mocap, and paths with the project's own nine-direction steps."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    rows: list[Row] = []
    for name, files in _groups(full).items():
        walks = 24 if full else 8
        close = _dance(name, folder, files, CLOSE, walks)
        rows += _join_rows(f"{name}, blends of a beat within 20 cm", close)
        rows += _join_rows(f"{name}, as usual", _dance(name, folder, files, USUAL, walks))
        rows += _foot_rows(name, close) + _beat_rows(name, close)
    return rows + _path_rows(full)


def _groups(full: bool) -> dict[str, tuple[str, ...]]:
    return {
        "salsa, leaders": tuple(name for name in SALSA if "/60_" in name)[: 7 if full else 3],
        "salsa, followers": tuple(name for name in SALSA if "/61_" in name)[: 7 if full else 3],
        "modern dance": SOLO[:-1],
        "walks": WALKS,
    }


def _dance(name: str, shared: Path, files: tuple[str, ...], setting: tuple[float, float], walks: int) -> Danced | None:
    """`walks` random walks at the recordings' own tempo; None without recordings, or where nothing joins."""
    material = recordings(shared, files)
    if not material:
        return None
    tempo = float(np.median([step.bpm for each in material for step in each.steps]))
    clips = [measure for each in material for step in each.steps for measure in _measures(step)]
    try:
        graph = build_graph(build_library(clips), window=setting[0], threshold=setting[1])
    except ValueError:
        return None
    chance = np.random.default_rng(1)
    figures = [
        DanceMetrics(graph, render_dance(graph, _random_walk(graph, chance), bpm=tempo)) for _ in range(walks)
    ]  # fmt: skip
    raw = RawClips(tuple(clips), float(figures[0].dance.line_time[1]), figures[0].dance.clip.sample_rate)
    return Danced(name, figures, raw)


def _measures(step: StepClip) -> Iterator[StepClip]:
    """Each measure of a step as a step of its own, so that a walk may leave it at every line."""
    for measure in range(step.measures):
        yield replace(step, measures=1, first=step.first + measure * step.samples_per_measure)


def _random_walk(graph: MotionGraph, chance: np.random.Generator) -> list[int]:
    """MEASURES nodes; of the ways on, one that is not simply the recording's own continuation, where there is one."""
    library = graph.library
    node = int(chance.choice(np.flatnonzero(graph.alive)))
    path = [node]
    while len(path) < MEASURES:
        targets = graph.edge_target[graph.edge_start[node] : graph.edge_start[node + 1]]
        others = targets[np.abs(library.node_clip[targets] - library.node_clip[node]) > 1]
        node = int(chance.choice(others if len(others) else targets))
        path.append(node)
    return path


def _join_rows(name: str, danced: Danced | None) -> list[Row]:
    bars = (("velocity", "m/s", 1.0), ("acceleration", "m/s²", 1.2))
    if danced is None:
        return [Row(f"{name}: join {what} ratio", None, "", bar) for what, _, bar in bars]
    raw = danced.raw.p99(danced.figures[0].half)
    rows = []
    for index, (what, unit, bar) in enumerate(bars):
        joins = np.concatenate([each.joins[index] for each in danced.figures])
        peers = {
            f"raw p99 {unit}": raw[index],
            f"joins p99 {unit}": float(np.percentile(joins, 99)),
            f"joins median {unit}": float(np.median(joins)),
            "joins": float(len(joins)),
        }
        rows.append(
            Row(f"{name}: join {what} ratio", float(np.percentile(joins, 99)) / raw[index], "", bar, peers=peers)
        )
    return rows


def _foot_rows(name: str, danced: Danced | None) -> list[Row]:
    if danced is None:
        return [Row(f"{name}: foot slide", None, "m/s")]
    slide = np.concatenate([each.slide for each in danced.figures])
    raw = float(danced.raw.slide.mean())
    free = [_free_slide(each) for each in danced.figures]
    peers = {"raw": raw, "feet not held": float(np.concatenate(free).mean()), "p99": float(np.percentile(slide, 99))}
    return [Row(f"{name}: foot slide", float(slide.mean()), "m/s", raw + MOST_SLIDE, peers=peers)]


def _free_slide(figures: DanceMetrics) -> Float64:
    """Slides [m/s] of the same dance without the foot lock."""
    dance = figures.dance
    free = render_dance(figures.graph, dance.node, bpm=dance.bpm, hold_feet=False)
    return DanceMetrics(figures.graph, free).slide


def _beat_rows(name: str, danced: Danced | None) -> list[Row]:
    """Annotated: found in the motion itself, by the pose that the clip has on its beat; kinematic beside the raw and
    beside chance."""
    names = [f"{name}: annotated beat offset, {what}" for what in ("median", "p95")]
    if danced is None:
        return [Row(names[0], None, "ms", 5.0), Row(names[1], None, "ms", 15.0)]
    found = 1e3 * np.abs(np.concatenate([_shown_beats(each.graph, each.dance) for each in danced.figures]))
    raw = []
    rate, seconds = danced.raw.rate, danced.raw.seconds
    compared = [
        compare_with_chance(each.dance.beat_time, [motion_beats(mean_speed(each.position, rate), rate)])
        for each in danced.figures
    ]
    for step, (position, _) in zip(danced.raw.steps, danced.raw.sampled_clips, strict=True):
        begin = step.first / step.samples_per_measure * seconds
        beats = begin + np.arange(step.beats) * seconds / step.beats_per_measure
        raw.append(beat_offsets(beats, motion_beats(mean_speed(position, rate), rate)))
    kinds = ([each.offset for each in compared], raw, [each.chance_offset for each in compared])
    motion, recorded, chance = (1e3 * float(np.median(np.abs(np.concatenate(each)))) for each in kinds)
    music, usual = (
        float(np.mean([each.alignment[name] or 0.0 for each in compared])) for name in ("music", "music_chance")
    )
    return [
        Row(names[0], float(np.median(found)), "ms", 5.0, peers={"beats": float(len(found))}),
        Row(names[1], float(np.percentile(found, 95)), "ms", 15.0),
        Row(f"{name}: kinematic beat offset, median", motion, "ms", peers={"raw": recorded, "chance": chance}),
        Row(f"{name}: beat alignment of the music's beats", music, "", peers={"chance": usual}),
    ]


def _shown_beats(graph: MotionGraph, dance: RenderedDance) -> Float64:
    """When each clip's own beat is seen in the motion, minus the beat [s]: beats within blends are left out.

    Local rotations of all joints but the hips (whose heading is turned) and the legs (which hold the floor) are
    compared with those that the source clip has on its beat; the nearest time within 100 ms, found between samples by
    a parabola, is when it is seen. Beats in whose surroundings the pose hardly changes say nothing and are left out.
    """
    library, clip = graph.library, dance.clip
    rate, beats = clip.sample_rate, dance.beats_per_measure
    arms = slice(1, 14)
    found = []
    reach = round(0.1 * rate)
    for n, node in enumerate(dance.node):
        step = library.clips[library.node_clip[node]]
        for beat in range(beats):
            if n > 0 and beat == 0:
                continue  # at the line itself the blend has just ended: before it the pose is a mixture
            time = dance.beat_time[n * beats + beat]
            if time > dance.line_time[n + 1] - graph.window * dance.line_time[1] - 0.1:
                continue
            source = library.node_first[node] + beat * step.samples_per_measure / beats
            low = int(source)
            part = source - low
            a, b = (
                library.clip_rotation[low, arms],
                library.clip_rotation[min(low + 1, len(library.clip_rotation) - 1), arms],
            )
            pose = (1.0 - part) * a + part * b * np.sign(np.sum(a * b, axis=-1, keepdims=True))
            middle = round(time * rate)
            samples = np.arange(max(middle - reach, 0), min(middle + reach + 1, clip.sample_count))
            cosine = np.abs(np.sum(clip.rotation[samples][:, arms] * pose, axis=-1)) / np.linalg.norm(pose, axis=-1)
            far = np.arccos(np.clip(cosine, 0.0, 1.0)) ** 2
            distance = far.sum(axis=1)
            best = int(np.argmin(distance))
            if not 0 < best < len(samples) - 1 or distance.max() < 0.01:
                continue
            before, at, after = distance[best - 1 : best + 2]
            found.append((samples[best] + 0.5 * (before - after) / (before - 2.0 * at + after)) / rate - time)
    return np.array(found)


def _path_rows(full: bool) -> list[Row]:
    """With the project's own steps in nine directions, at every measure line of the motion itself."""
    clips = [clip for clip in load_folder(SKETCHES) if clip.beats_per_measure == 4]
    graph = build_graph(build_library(clips))
    candidates = find_candidates(graph)
    rows = []
    for step in ("walk", "samba", "side step") if full else ("walk",):
        for line, points in (("square of 4 m", SQUARE), ("circle of 2 m radius", CIRCLE)):
            for facing in ("public", "path"):
                targets = smoothed(follow_line(points, MEASURES, facing=facing))
                followed = follow_path(
                    graph,
                    targets,
                    seconds=2.0,
                    wanted=np.full(MEASURES, graph.library.steps.index(step)),
                    candidates=candidates,
                )
                dance = render_dance(
                    graph,
                    followed.node,
                    bpm=120.0,
                    turns=followed.turn,
                    takes=(followed.take, followed.share),
                    start=(*targets.place[0], targets.heading[0]),
                )
                figures = DanceMetrics(graph, dance, targets)
                values = figures.result()
                errors = values["path_error_m"]["list"]
                peers = {
                    "mean": float(np.mean(errors)),
                    "mean of the last 8": float(np.mean(errors[-8:])),
                    "heading p95 °": values["heading_error_deg"]["p95"],
                    "slide": values["foot_slide_mean"],
                    "raw slide": float(figures.raw.slide.mean()),
                    "join velocity ratio": values["join_velocity_ratio"],
                    "join acceleration ratio": values["join_acceleration_ratio"],
                }
                label = f"{step}, {line}, facing the {facing}: largest path error in {MEASURES} measures"
                rows.append(Row(label, max(errors), "m", 0.15, peers=peers))
    return rows
