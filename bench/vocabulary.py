"""Whole recordings cut into steps: time for half an hour, repeats found again, and dancers in unison who agree."""

import json
import tempfile
import time
from collections.abc import Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from bench._long_recording import LongRecording, long_recording
from bench._motion_clips import SALSA, recordings
from bench._recorded_measures import FILES, single_measures
from live.base.arrays import Bool, Float64, Int32
from live.cli.bench import Row
from live.graph.vocabulary.measures import measure_distances, measures_of
from live.graph.vocabulary.repeats import find_steps
from live.library.add_step import with_beats
from live.library.motion_file import read_motion
from live.library.vocabulary import Vocabulary, add_vocabulary, find_vocabulary
from live.library.vocabulary_sheet import sheet_page
from live.motion.beats.music_reference import MusicReference
from live.motion.beats.tempo_estimation import estimate_tempo
from live.motion.clip import Clip
from live.motion.formats.bvh_writer import write_bvh
from live.motion.retarget.retarget import retarget

MEASURES, BPM = 1200, 160.0
"""Half an hour."""
ROUTINE = tuple(f"group/perfume_{name}.bvh" for name in ("aachan", "kashiyuka", "nocchi"))


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` also with beats that are guessed from the feet, and all couples."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    found = recordings(folder, tuple(name for name in FILES if name in SALSA))
    if not found:
        return [Row("half an hour to a library, CPU (no recordings here)", None, "s", 60.0)]
    rows = _half_an_hour(long_recording([single_measures(each) for each in found], MEASURES, BPM), full)
    return rows + _routine(folder) + _couples(folder, range(1, 8) if full else range(1, 5))


def _half_an_hour(long: LongRecording, full: bool) -> list[Row]:
    rows = []
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "long.bvh"
        file.write_text(write_bvh(long.clip), encoding="utf-8")
        for name, beats in (("", _known(long.bpm)), (", beats guessed", _guessed)):
            if name and not full:
                continue
            begin = time.process_time()
            vocabulary = find_vocabulary([file], {}, beats)
            sheet_page(vocabulary, "")
            add_vocabulary(Path(place) / f"library{name}", vocabulary, vocabulary.steps)
            rows.append(Row(f"half an hour to a library{name}, CPU", time.process_time() - begin, "s", 60.0))
            if not name:
                rows += _found_again(vocabulary, long)
    return rows


def _known(bpm: float) -> Any:
    def beats(file: Path, fields: dict[str, Any]) -> tuple[dict[str, Any], Mapping[str, str], MusicReference | None]:
        return fields | {"bpm": bpm, "first_beat_s": 0.0}, {}, None

    return beats


def _guessed(file: Path, fields: dict[str, Any]) -> tuple[dict[str, Any], Mapping[str, str], MusicReference | None]:
    told, comments, found = with_beats(file, fields)
    return told, comments, found.reference


def _found_again(vocabulary: Vocabulary, long: LongRecording) -> list[Row]:
    """Which measures of the recordings are found again, and what else is taken for them."""
    label = np.full(len(vocabulary.measures), -1)
    number = 0
    for step in vocabulary.steps:
        for n in range(step.found.measures):
            label[np.array(step.found.starts) + n] = number
            number += 1
    found, true = _same(label), _same(long.identity[: len(label)])
    return [
        Row("pairs of repeats that are found", float((found & true).sum() / true.sum()), "", 0.8, "at least"),
        Row("pairs that are variants of one measure, of those found", float((found & true).sum() / found.sum()), ""),
        Row("steps", float(len(vocabulary.steps)), ""),
    ]


def _same(label: Int32) -> Bool:
    """Whether each pair of measures has one label."""
    first, second = np.triu_indices(len(label), 1)
    return np.asarray(label[first] == label[second])


def _labels(clip: Clip, lines: Float64) -> Int32:
    """The step that each measure belongs to, and which measure of it."""
    measures = measures_of([clip], [lines], 4)
    label = np.full(len(measures), -1, np.int32)
    number = 0
    for step in find_steps(measures, measure_distances(measures)):
        for n in range(step.measures):
            label[np.array(step.starts) + n] = number
            number += 1
    return label


def _agreement(labels: Sequence[Int32]) -> tuple[float, float, float]:
    """Pairs found by one dancer, the share of them that another finds, too, and that share by chance."""
    count = min(map(len, labels))
    pairs = [_same(label[:count]) for label in labels]
    ways = list(permutations(pairs, 2))
    found = sum(int(one.sum()) for one, _ in ways)
    both = sum(int((one & other).sum()) for one, other in ways)
    return found / len(ways), both / max(found, 1), float(np.mean([other.mean() for _, other in ways]))


def _rows(name: str, labels: Sequence[Int32]) -> list[Row]:
    found, agreed, chance = _agreement(labels)
    return [
        Row(f"{name}: pairs of repeats that a dancer's cut has", found, ""),
        Row(f"{name}: share of them that another's has, too", agreed, "", peers={"by chance": chance}),
    ]


def _routine(folder: Path) -> list[Row]:
    """Three dancers of one routine, all on the beats guessed from the first."""
    files = [folder / "mocap" / name for name in ROUTINE]
    if not all(file.is_file() for file in files):
        return []
    clips = [retarget(read_motion(file), name=file.stem, drop_frames=1) for file in files]
    guess = estimate_tempo(clips[0])
    if guess is None:
        return []
    first, measure = guess.reference.first_beat_s, 240.0 / guess.reference.bpm
    lines = np.arange(first, min(clip.seconds for clip in clips), measure)
    return _rows("routine of three", [_labels(clip, lines) for clip in clips])


def _couples(folder: Path, takes: Sequence[int]) -> list[Row]:
    """Leader and follower, who dance different parts of one figure, on the same measure lines."""
    rows = json.loads((folder / "mocap" / "beats_estimated.json").read_text(encoding="utf-8"))
    beats = {file: row for row in rows for file in row["files"]}
    found = []
    for take in takes:
        pair = recordings(folder, (f"salsa/60_0{take}.bvh", f"salsa/61_0{take}.bvh"))
        if len(pair) < 2:
            continue
        row = beats[pair[0].name]
        size = min(each.clip.seconds for each in pair)
        lines = np.arange(row["phase_of_4beats_s"], size, row["four_beats_s"])
        found.append([_labels(each.clip, lines) for each in pair])
    return [row for take, labels in zip(takes, found, strict=False) for row in _rows(f"salsa {take}", labels)]
