"""Steps of the whole library danced by other bodies at other tempos and seen by a camera: how many are recognised."""

import time
from collections import defaultdict
from pathlib import Path
from typing import Final

import numpy as np

from bench._motion_clips import SALSA, SOLO, WALKS, Material, recordings
from bench._recorded_measures import single_measures
from bench._seen_bodies import SeenMeasure, danced_by_another
from live.cli.bench import Row
from live.library.step_folder import load_folder
from live.motion.recognition.step_recognition import RecognisedStep, StepTemplates
from live.motion.step_clip import StepClip

PATCHES: Final = Path(__file__).resolve().parent.parent / "patches"
TEMPOS: Final = (84.0, 104.0, 120.0, 138.0)
EARLY_BEATS: Final = 2
"""Beats after which a step is answered in the next measure."""
TUNED_SEED, HELD_BACK_SEED = 1, 2
TUNED_UNKNOWN: Final = (*SALSA[:6], *SOLO[:4], WALKS[0])
"""Recordings and, of the library, every other step were looked at while the limits were chosen; the rest is held
back."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` every measure of every clip, otherwise two clips of each step."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    rows: list[Row] = []
    known = libraries()
    for tuned in (False, True):
        rows += _known(known, tuned, full)
        rows += _unknown(known, folder, tuned)
    return rows + _speed(known)


Library = tuple[list[str], list[StepClip], StepTemplates]


def libraries() -> dict[int, Library]:
    """Return names, clips and templates of all steps of the project, by beats per measure."""
    clips: dict[int, list[StepClip]] = defaultdict(list)
    for place in sorted({file.parent for file in PATCHES.rglob("steps/*.toml")}):
        for clip in load_folder(place):
            if not clip.unjoined:
                clips[clip.beats_per_measure].append(clip)
    found = {}
    for beats, some in sorted(clips.items()):
        names = sorted({clip.step for clip in some})
        templates = StepTemplates.of([(names.index(clip.step), clip) for clip in some], beats)
        found[beats] = names, some, templates
    return found


def seen_measures(
    known: dict[int, Library], tuned: bool, full: bool = False
) -> list[tuple[int, StepClip, int, SeenMeasure]]:
    """Return measures danced by others: beats per measure, clip, measure of the step, what was seen."""
    chance = np.random.default_rng(TUNED_SEED if tuned else HELD_BACK_SEED)
    found = []
    for beats, (names, clips, _) in known.items():
        chosen = {name for number, name in enumerate(names) if (number % 2 == 0) == tuned}
        count: dict[str, int] = defaultdict(int)
        for number in chance.permutation(len(clips)).tolist():
            clip = clips[number]
            count[clip.step] += 1
            if clip.step in chosen and (full or count[clip.step] <= 4):
                for measure in range(clip.measures):
                    bpm = float(chance.choice(TEMPOS))
                    found.append((beats, clip, measure, danced_by_another(clip, measure, bpm, chance)))
    return found


def recognised(known: dict[int, Library], beats: int, seen: SeenMeasure, count: int | None = None) -> RecognisedStep:
    """Return what is recognised in a measure."""
    return known[beats][2].recognise(seen.hips, seen.rotation, seen.beats, 0.0, count)


def _known(known: dict[int, Library], tuned: bool, full: bool) -> list[Row]:
    words = "tuned" if tuned else "held back"
    rows = []
    seen = seen_measures(known, tuned, full)
    for count in (None, EARLY_BEATS):
        right = missed = wrong = sides = 0
        for beats, clip, _, measure in seen:
            found = recognised(known, beats, measure, count)
            name = known[beats][0][found.step] if found.step >= 0 else None
            right += name == clip.step
            sides += name == clip.step and found.mirrored == clip.mirrored
            missed += name is None
            wrong += name not in (None, clip.step)
        note = f"{len(seen)} measures"
        part = "" if count is None else f", of their first {count} beats"
        total = max(len(seen), 1)
        bar = 0.85 if count is None else None
        rows.append(Row(f"measures recognised{part}, {words}", right / total, "of all", bar, "at least", note=note))
        rows.append(Row(f"taken for another step{part}, {words}", wrong / total, "of all"))
        rows.append(Row(f"answered by unknown{part}, {words}", missed / total, "of all"))
        rows.append(Row(f"side told right where recognised{part}, {words}", sides / max(right, 1), "of these"))
    return rows


def unknown_measures(folder: Path, tuned: bool) -> list[tuple[str, StepClip]]:
    """Return measures of recordings that are no steps of the library."""
    every = (*SALSA, *SOLO, *WALKS)
    wanted = tuple(name for name in every if (name in TUNED_UNKNOWN) == tuned)
    found: list[Material] = recordings(folder, wanted)
    return [(each.name, step) for each in found for step in single_measures(each)]


def _unknown(known: dict[int, Library], folder: Path, tuned: bool) -> list[Row]:
    words = "tuned" if tuned else "held back"
    measures = unknown_measures(folder, tuned)
    if not measures:
        return [Row(f"unknown motion taken for a step, {words}", None, "of all", note="no recordings here")]
    chance = np.random.default_rng(TUNED_SEED if tuned else HELD_BACK_SEED)
    rows = []
    seen = [(name, danced_by_another(step, 0, step.bpm, chance)) for name, step in measures]
    for count in (None, EARLY_BEATS):
        took = [name for name, each in seen if recognised(known, 4, each, count).step >= 0]
        part = "" if count is None else f", of its first {count} beats"
        note = f"{len(seen)} measures of salsa, modern dance and walks"
        rows.append(Row(f"unknown motion taken for a step{part}, {words}", len(took) / len(seen), "of all", note=note))
    return rows


def _speed(known: dict[int, Library]) -> list[Row]:
    beats, _, _, seen = seen_measures(known, False)[0]
    begin, count = time.process_time(), 0
    while time.process_time() - begin < 0.5:
        recognised(known, beats, seen)
        count += 1
    each = 1000.0 * (time.process_time() - begin) / count
    begin = time.process_time()
    names, clips, _ = known[4]
    StepTemplates.of([(names.index(clip.step), clip) for clip in clips], 4)
    made = time.process_time() - begin
    note = f"{len(known[beats][2].step)} rows of templates"
    return [
        Row("a measure recognised, CPU", each, "ms", note=note),
        Row("templates of the whole library, CPU", made, "s"),
    ]
