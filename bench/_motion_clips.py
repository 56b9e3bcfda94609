"""Steps for the benches of motion: measures of the recordings in the shared folder, or the project's own sketches."""

import json
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from live.library.motion_file import read_motion
from live.motion import quaternion
from live.motion.cleanup.foot_planting import plant_feet
from live.motion.cleanup.glitch_detection import find_glitches
from live.motion.cleanup.glitch_repair import repair
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.clip import Clip
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import StepClip

SKETCHES = Path(__file__).resolve().parent.parent / "patches" / "steps"
"""Beats come from beats_estimated.json; where it knows no phase, the first measure begins with the recording."""
SALSA = tuple(f"salsa/{who}_0{take}.bvh" for take in range(1, 8) for who in (60, 61))
WALKS = ("walk/cmu_02_01_walk.bvh", "walk/cmu_12_01_walk.bvh", "walk/131_01_styled.bvh", "walk/figure8_MS2_8Walk_M.bvh")
WALK_BPM = {WALKS[0]: 109.0, WALKS[1]: 94.0, WALKS[2]: 105.0, WALKS[3]: 140.0}
"""One foot on every beat, from the recordings' index."""
SOLO = (
    *(f"solo/modern05/05_{n}.bvh" for n in ("02", "06", "09", "10", "13", "14", "15", "18", "19")),
    "solo/rokoko_jesse_dance.bvh",
)


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """One recording or sketch: its whole clip and its measures as steps."""

    name: str
    clip: Clip
    steps: tuple[StepClip, ...]


def recordings(shared: Path, names: tuple[str, ...]) -> list[Material]:
    """The recordings among `names` that are in the folder `shared`/mocap, read and retargeted."""
    return [_recording(shared / "mocap", name) for name in names if (shared / "mocap" / name).is_file()]


def sketches(names: tuple[str, ...], direction: str = "long forward") -> list[Material]:
    """Sketches of the project."""
    found = []
    for name in names:
        path = SKETCHES / f"{name}.toml"
        step = step_clip(parse_sketch(path.read_text(encoding="utf-8"), path.name), direction)
        found.append(Material(name, step.clip, (step,)))
    return found


@cache
def _index(mocap: Path) -> dict[str, dict[str, Any]]:
    return {row["file"]: row for row in json.loads((mocap / "index.json").read_text(encoding="utf-8"))}


@cache
def _beats(mocap: Path) -> dict[str, dict[str, Any]]:
    rows = json.loads((mocap / "beats_estimated.json").read_text(encoding="utf-8"))
    return {file: row for row in rows for file in row["files"]}


@cache
def _recording(mocap: Path, name: str) -> Material:
    row = _index(mocap).get(name, {})
    clip = _mended(read_motion(mocap / name), name, row.get("true_fps"))
    if name in WALK_BPM:
        return Material(name, clip, tuple(measures_of(clip, "walk", 0.0, WALK_BPM[name], 1)))
    beats = _beats(mocap)[name]
    if name in SALSA:
        bpm = 240.0 / beats["four_beats_s"]
        return Material(name, clip, tuple(measures_of(clip, "salsa", beats["phase_of_4beats_s"], bpm, 2)))
    return Material(name, clip, tuple(measures_of(clip, "solo", 0.0, beats["bpm"], 1)))


def _mended(motion: SourceMotion, name: str, fps: float | None) -> Clip:
    """As `live steps add --repair` takes it: without T-pose and run-in, faults bridged where safe, feet planted."""
    tracks = body_tracks(motion, fps=fps)
    drop = find_recording_start(tracks).drop_frames
    mended, _ = repair(motion, find_glitches(tracks, motion.parents, start=drop), fps=fps)
    return plant_feet(retarget(mended, name=name, fps=fps, drop_frames=drop)).clip


def measures_of(clip: Clip, step: str, anchor: float, bpm: float, measures: int) -> list[StepClip]:
    """Every `measures` whole measures of 4 beats after the time `anchor` [s], each with up to a measure of lead-in.

    As in a library, the hips stand at x = z = 0 and face +z where the first measure begins.
    """
    size = 240.0 / bpm * clip.sample_rate
    start = anchor * clip.sample_rate
    found = []
    while start + measures * size <= clip.sample_count - 1:
        begin = max(0, math.floor(start - size))
        end = min(clip.sample_count, math.ceil(start + measures * size) + 9)
        found.append(
            StepClip(
                step=step,
                clip=_placed(clip, begin, end, round(start)),
                first=start - begin,
                samples_per_measure=size,
                measures=measures,
                bpm=bpm,
            )
        )
        start += measures * size
    return found


def _placed(clip: Clip, begin: int, end: int, at: int) -> Clip:
    """Samples `begin` to `end` (exclusive), moved and turned so that at sample `at` the hips stand at 0 and face +z."""
    x, _, z = quaternion.rotate(clip.rotation[at, 0].astype(np.float64), np.array((0.0, 0.0, 1.0)))
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(-math.atan2(x, z)))
    rotation = clip.rotation[begin:end].astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    root = quaternion.rotate(turn, clip.root_position[begin:end] - clip.root_position[at] * (1.0, 0.0, 1.0))
    return replace(
        clip,
        root_position=np.ascontiguousarray(root, np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        contact=clip.contact[begin:end],
    )
