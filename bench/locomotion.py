"""Locomotion: do steered dancers land where the group goes, feet on the floor? Three scenes, beside two naive ways."""

from collections.abc import Iterable
from functools import reduce
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from bench._locomotion_figures import Figures
from bench._locomotion_response import Response, responses
from bench._locomotion_run import ENGINE, SLIDING, UNCORRECTED, dance, drifting_beats
from bench._locomotion_scenes import BPM, SCENES, Take, changed, stage
from bench._motion_clips import WALKS, recordings
from live.cli.bench import Row
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion.mirror import mirror_step
from live.show.loader import RECORDING_THRESHOLDS_M, adapt_to_recordings, with_connected_steps

Float64 = npt.NDArray[np.float64]

NAIVE: Final = (SLIDING, UNCORRECTED)
EXACT: Final = {"warp_beats": 0.0, "amplitude": 0.0}
"""Where beats are judged nobody is early or late on purpose."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` three seeds of 90 s; otherwise one of 31 s, which holds every part of each scene once."""
    seeds, seconds = ((1, 2, 3), 90.0) if full else ((1,), 31.0)
    rows: list[Row] = []
    for scene in SCENES:
        takes = [Take(scene, seed, seconds) for seed in seeds]
        rows += scene_rows(scene, takes)
    rows += walk_rows(shared, 30.0 if full else 15.0)
    rows += beat_rows([Take("thrown", seed, seconds) for seed in seeds])
    rows += response_rows(seeds, 8 if full else 4)
    return rows


def together(found: Iterable[Figures]) -> Figures:
    """All runs as one."""
    return reduce(Figures.join_with, found)


def scene_rows(scene: str, takes: list[Take], ways: tuple[str, ...] = NAIVE) -> list[Row]:
    """The figures of one scene, beside each what the naive ways give."""
    found = {way: together(dance(take, way) for take in takes) for way in (ENGINE, *ways)}

    def row(name: str, unit: str, bar: float | None, of: str) -> Row:
        values = {way: figure(each, of) for way, each in found.items()}
        own = values.pop(ENGINE)
        return Row(f"{scene}: {name}", own, unit, bar, peers={w: v for w, v in values.items() if v is not None})

    return [
        row("foot slide in contact, mean", "m/s", 0.03, "slide"),
        row("foot slide in contact, p99", "m/s", 0.10, "slide p99"),
        row("skating ratio", "%", 1.0, "skating"),
        row("dancer to predicted agent at measure ends, mean", "m", 0.10, "predicted"),
        row("dancer to predicted agent at measure ends, p95", "m", 0.25, "predicted p95"),
        row("... as predicted last, mean", "m", 0.10, "predicted last"),
        row("... as predicted last, p95", "m", 0.25, "predicted last p95"),
        row("... prediction cut by the bench to the step's reach, mean", "m", None, "within reach"),
        row("... and p95", "m", None, "within reach p95"),
        row("... steering's own prediction, never cut, mean", "m", None, "free"),
        row("dancer to agent at measure ends, mean", "m", None, "agents"),
        row("join velocity ratio", "", 1.0, "join"),
        row("annotated beats (span), p95", "ms", None, "beats p95"),
        row("body overlaps", "", 0.0, "overlaps"),
        row("share of pictures with an overlap", "%", 0.0, "overlapping"),
        row("nearest hips", "m", None, "nearest"),
        row("hips beyond the stage's edge", "m", None, "outside"),
    ]


def walk_rows(shared: Path | None, seconds: float) -> list[Row]:
    """The first scene danced with recorded walks, which go forward only: without bars."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    clips = [step for material in recordings(folder, WALKS) for step in material.steps]
    named = {"slide": "m/s", "slide p99": "m/s", "skating": "%", "predicted": "m", "predicted p95": "m", "join": ""}
    if not clips:
        return [Row(f"recorded walks: {name} (no recordings here)", None, unit) for name, unit in named.items()]
    clips += [mirror_step(step) for step in clips]
    patch = adapt_to_recordings(stage().patch, clips)
    graph = build_graph(build_library(clips), window=0.25, threshold=max(RECORDING_THRESHOLDS_M))
    found = dance(Take("thrown", 1, seconds), patch=with_connected_steps(patch, graph), graph=graph)
    return [Row(f"recorded walks: {name}", figure(found, name), unit) for name, unit in named.items()]


def figure(found: Figures, of: str) -> float | None:
    """One number of what was found; None where nothing was."""
    name, _, kind = of.partition(" p9")
    if kind:
        values = _all(found, name)
        return float(np.percentile(values, 90 + int(kind))) if len(values) else None
    match name:
        case "slide" | "predicted" | "predicted last" | "within reach" | "free" | "agents":
            values = _all(found, name)
            return float(values.mean()) if len(values) else None
        case "skating" | "overlapping":
            return 100.0 * float(np.mean(getattr(found, name)))
        case "join":
            return max(found.join, default=None)
        case _:
            return float(getattr(found, name))


def _all(found: Figures, name: str) -> Float64:
    arrays = getattr(found, name.replace(" ", "_"))
    values = np.concatenate(arrays) if arrays else np.zeros(0)
    return values * 1e3 if name in ("beats", "drawn beats") else values


def beat_rows(takes: list[Take]) -> list[Row]:
    """Annotated beats against the Timeline, while the music's tempo drifts by eight per cent."""
    patch = changed(stage().patch, motion=dict(EXACT))
    found = together(dance(take, patch=patch, heard=drifting_beats(take.seconds, BPM)) for take in takes)
    values, drawn = _all(found, "beats"), _all(found, "drawn beats")
    return [
        Row("drifting tempo: annotated beats to the Timeline, median", float(np.median(values)), "ms", 5.0),
        Row("drifting tempo: annotated beats to the Timeline, p95", float(np.percentile(values, 95)), "ms", 20.0),
        Row("... found in the drawn poses, median", float(np.median(drawn)) if len(drawn) else None, "ms", 5.0),
        Row("... found in the drawn poses, p95", float(np.percentile(drawn, 95)) if len(drawn) else None, "ms", 20.0),
    ]


def response_rows(seeds: Iterable[int], moments: int) -> list[Row]:
    """From an attractor's packet to the first change that is seen."""
    found = [each for seed in seeds for each in responses(seed, moments)]
    return [
        Row("packet to the agents' first change of course (1 mm/s)", _worst(found, "first_frames"), "frames", 2.0),
        Row("packet to the agents' plain change of course (2 cm/s)", _worst(found, "agent_frames"), "frames"),
        Row("... of the last agent", _worst(found, "last_agent_frames"), "frames"),
        Row("packet to the dancers' change of course, median", _worst(found, "step_beats"), "beats", 5.0),
        Row("... of the last dancer", _worst(found, "last_step_beats"), "beats"),
    ]


def _worst(found: list[Response], name: str) -> float:
    return max(float(getattr(each, name)) for each in found)
