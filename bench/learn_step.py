"""A step learnt from a performer in a show of 100 clips: how long it takes until it can be danced."""

import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np

from bench._seen_bodies import danced_by_another
from live.cli.bench import Row
from live.graph.select.selector import StepSelector
from live.library.clip_text import clips_to_text
from live.library.step_folder import load_folder
from live.motion.skeleton import JOINT_COUNT
from live.motion.step_clip import StepClip
from live.show.capture.danced_poses import Take
from live.show.capture.learnt_step import learn_step
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH, PATCHES
from live.show.selection.graph_update import steps_hash

BPM: Final = 120.0
SEEN_LATE_S: Final = 0.125
"""Latest arrival of the last poses of a measure (a quarter of a beat) [s]."""
DECIDED_BEATS: Final = 1.25
"""Beats before the measure line until which a step can be chosen for the next measure: a beat and eight ticks."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` also a step of four measures."""
    loaded = load_show(DEFAULT_PATCH)
    clips = loaded.graph.library.clips
    rows = []
    for measures in (1, 4) if full else (1,):
        took, texts = [], []
        for seed, clip in enumerate(_foreign_steps()):
            take = _take(clip, measures, seed)
            take.hips += np.float32(time.time() % 1.0)  # never the cached step of a run before
            begin = time.perf_counter()
            with tempfile.TemporaryDirectory() as place:
                step = learn_step(take, loaded.graph, loaded.patch, (BPM, BPM), Path(place))
            texts.append(len(clips_to_text(step.clips)))
            steps_hash(step.graph)
            StepSelector.of(step.graph)
            took.append(time.perf_counter() - begin)
        room = 4 * 60.0 / BPM - DECIDED_BEATS * 60.0 / BPM - SEEN_LATE_S
        note = f"{len(clips)} clips, {BPM:g} bpm; of {len(took)} steps the longest, the first {took[0]:.2f} s"
        name = f"{measures} measure{'s' if measures > 1 else ''}"
        rows.append(Row(f"{name} danced to a step in the graph", max(took[1:]), "s", room, note=note))
        rows.append(Row(f"{name}: size in the journal", max(texts) / 1000.0, "kB"))
    return rows


def _foreign_steps() -> list[StepClip]:
    """Return steps that the show's library does not have, sketched ones of other styles."""
    found: dict[str, StepClip] = {}
    for style in ("house", "hiphop"):
        for clip in load_folder(PATCHES / style / "steps"):
            if not clip.mirrored:
                found.setdefault(clip.step, clip)
    return list(found.values())[:6]


def _take(clip: StepClip, measures: int, seed: int) -> Take:
    """Return what a camera saw of another body that danced a step again and again, smoothed as by its tracker."""
    parts = [
        danced_by_another(clip, n % clip.measures, BPM, np.random.default_rng(seed), jitter=0.0)
        for n in range(measures + 1)
    ]
    kept = [(part.beats >= 0.0) & (part.beats < 4.0) for part in parts]
    beats = np.concatenate(
        [part.beats[those] + 4.0 * n for n, (part, those) in enumerate(zip(parts, kept, strict=True))]
    )
    hips = np.concatenate([part.hips[those] for part, those in zip(parts, kept, strict=True)])
    rotation = np.concatenate([part.rotation[those] for part, those in zip(parts, kept, strict=True)])
    assert rotation.shape[1] == JOINT_COUNT
    return Take(
        "anna", f"learnt {seed} {measures}", "*", 4, measures, 4, 4.0, hips.astype(np.float32),
        rotation.astype(np.float32), np.stack([beats, beats * 60.0 / BPM], axis=1),
    )  # fmt: skip
