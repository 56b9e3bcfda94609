"""Vocabulary of long recordings, for `live steps cut`: steps are found, named, chosen by a person and added at once.

Everything is cut before anything is written; no file is overwritten, and no name of the library is used again.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.graph.step_library import plain_name
from live.graph.vocabulary.measures import Measures, measure_distances, measures_of
from live.graph.vocabulary.repeats import ALIKE, LONGEST, FoundStep, find_steps
from live.graph.vocabulary.step_names import StepFacts, name_steps, standing_heights, step_facts
from live.library.add_step import (
    RequestedEntry,
    candidate_paths,
    import_file,
    refuse_external_files,
    remove_files,
    request_entry,
    same_file,
)
from live.library.cut_step import cut_step
from live.library.recording_file import Recording, RecordingEntry, StepFiles, parse_step_file, read_step_files
from live.library.recordings import RecordingReader
from live.motion.beats.music_reference import MusicReference
from live.motion.beats.tempo_estimation import track_lines
from live.motion.clip import Clip

EVEN: Final = 1e-3
"""Measure lines that differ by less [s] from an even grid are on it."""
MAX_TAKES: Final = 8
"""Occurrences of one step that are added, the most typical first: more of them make no difference on stage."""
_HEADER: Final = (
    "file", "skeleton", "fps", "unit_m", "up", "drop_frames", "repair", "bpm", "first_beat_s", "beats_per_measure",
    "author", "style", "tags", "mirror",
)  # fmt: skip
"""Fields that are written once, above the steps."""


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One recording with its beats."""

    entry: RequestedEntry
    """The recording as requested, under no name."""
    comments: Mapping[str, str]
    """Comments on tempo and first beat for the TOML file."""
    clip: Clip
    lines: Float64
    """Its measure lines [s], (measures + 1,)."""

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.entry.path.name

    def cut(self, number: int, measures: int) -> dict[str, Any]:
        """Return the fields of a step that begins with measure `number`, from 1.

        Where the tempo changes, each step has its own beats instead of a number on the recording's.
        """
        recording = self.entry.recording
        measure = recording.beats_per_measure * 60.0 / recording.bpm
        even = recording.first_beat_s + measure * np.arange(len(self.lines))
        fields: dict[str, Any] = {"start_measure": number}
        if np.abs(self.lines - even).max() > EVEN:
            begin, end = float(self.lines[number - 1]), float(self.lines[number - 1 + measures])
            bpm = 60.0 * recording.beats_per_measure * measures / (end - begin)
            # rounded down, so that the last measure ends within the recording
            fields = {"bpm": math.ceil(bpm * 1e3) / 1e3, "first_beat_s": math.floor(begin * 1e4) / 1e4}
        return fields | ({"measures": measures} if measures > 1 else {})


@dataclass(frozen=True, slots=True, eq=False)
class ProposedStep:
    """A step with the name under which it would be added."""

    name: str
    found: FoundStep
    facts: StepFacts


@dataclass(frozen=True, slots=True, eq=False)
class Vocabulary:
    """The steps of some recordings, in order of their first occurrence."""

    takes: tuple[Take, ...]
    measures: Measures
    steps: tuple[ProposedStep, ...]

    def place(self, start: int) -> tuple[Take, int]:
        """Return the recording of the measure with this index, and its number there, from 1."""
        return self.takes[self.measures.recording[start]], int(self.measures.number[start]) + 1


Beats = Callable[[Path, dict[str, Any]], tuple[dict[str, Any], Mapping[str, str], MusicReference | None]]
"""Returns the fields of a recording with its beats, the comments on them, and a reference if it was guessed."""


def find_vocabulary(
    files: Sequence[Path],
    fields: Mapping[str, Any],
    beats: Beats,
    *,
    alike: float = ALIKE,
    longest: int = LONGEST,
    library: Path | None = None,
) -> Vocabulary:
    """Cut recordings into steps: measures that are alike, and those that are always danced together, are one step.

    `fields` are those of every recording; `beats` finds what they do not say. Names of steps in the `library` are not
    used. PersonError names the file that cannot be read or has no whole measure.
    """
    takes = []
    for file in {file.resolve(): file for file in files}.values():
        told, comments, guess = beats(file, {"name": "found", **fields})
        entry = request_entry(file, told)
        clip = RecordingReader().clip(entry)
        takes.append(Take(entry, comments, clip, _measure_lines(entry, clip, guess)))
    try:
        measures = measures_of([take.clip for take in takes], [take.lines for take in takes], _beats_of(takes))
    except ValueError as error:
        raise PersonError(str(error), "cut the recordings in several parts") from None
    found = find_steps(measures, measure_distances(measures), alike=alike, longest=longest)
    facts = [step_facts(measures, step.starts[0], step.measures) for step in found]
    names = name_steps(facts, standing_heights(measures), () if library is None else names_in(library))
    return Vocabulary(tuple(takes), measures, tuple(map(ProposedStep, names, found, facts)))


def _beats_of(takes: Sequence[Take]) -> int:
    return takes[0].entry.recording.beats_per_measure


def _measure_lines(entry: RequestedEntry, clip: Clip, guess: MusicReference | None) -> Float64:
    recording = entry.recording
    measure = recording.beats_per_measure * 60.0 / recording.bpm
    whole = math.floor((clip.seconds - recording.first_beat_s) / measure + 1e-9)
    if whole < 1:
        raise PersonError(
            f"{entry.path}: not one whole measure: it lasts {clip.seconds:.2f} s, its first beat is at "
            f"{recording.first_beat_s:.2f} s, and a measure of {recording.beats_per_measure} beats at "
            f"{recording.bpm:g} bpm lasts {measure:.2f} s",
            "correct --anchor or --bpm, or record more",
        )
    if guess is not None:
        return track_lines(
            clip, replace(guess, first_beat_s=recording.first_beat_s, bpm=recording.bpm), recording.beats_per_measure
        )
    return np.asarray(recording.first_beat_s + measure * np.arange(whole + 1))


def names_in(library: Path) -> list[str]:
    """Return the names of all steps in a folder; none if it cannot be read."""
    from live.motion.sketch.sketch_file import SketchError, parse_sketch

    try:
        files = read_step_files(library)
    except PersonError:
        return []
    names = [entry.recording.name for entries in files.recordings.values() for entry in entries]
    for file, text in files.sketches.items():
        try:
            names.append(parse_sketch(text, file).name)
        except SketchError:
            names.append(Path(file).stem)
    return names


def renamed(vocabulary: Vocabulary, names: Mapping[int, str], library: Path | None = None) -> Vocabulary:
    """Return the vocabulary with other names for some steps, by their numbers from 1.

    PersonError for a number that is not there, or a name of another step, in the vocabulary or in the library.
    """
    steps = list(vocabulary.steps)
    for number, name in names.items():
        if not 1 <= number <= len(steps):
            raise PersonError(f"--rename {number}={name}: there are steps 1 to {len(steps)}")
        steps[number - 1] = replace(steps[number - 1], name=name)
    taken = {plain_name(name) for name in ([] if library is None else names_in(library))}
    for number, name in names.items():
        same = [n for n, step in enumerate(steps, 1) if plain_name(step.name) == plain_name(name) and n != number]
        if same or plain_name(name) in taken:
            where = f"step {same[0]} is called so" if same else "the library has a step called so"
            raise PersonError(f"--rename {number}={name}: {where}", "choose another name")
    return replace(vocabulary, steps=tuple(steps))


@dataclass(frozen=True, slots=True, eq=False)
class AddedSteps:
    """What was written."""

    steps: tuple[ProposedStep, ...]
    cuts: int
    """Occurrences that were added, in all."""
    known: int
    """Occurrences that the library had already."""
    tomls: tuple[Path, ...]


def add_vocabulary(
    library: Path, vocabulary: Vocabulary, steps: Sequence[ProposedStep], takes: int = MAX_TAKES
) -> AddedSteps:
    """Add `steps`, each with up to `takes` of its occurrences, to the folder `library`, which may be new.

    Cuts that the library has already are left out. On a PersonError nothing has changed.
    """
    known = _known_cuts(library, vocabulary.takes)
    cuts: dict[int, list[tuple[int, ProposedStep]]] = {}
    there = 0
    for step in steps:
        for start in step.found.starts[:takes]:
            own, number = int(vocabulary.measures.recording[start]), vocabulary.place(start)[1]
            take = vocabulary.takes[own]
            begin = _begin_ms(take.entry.recording.model_copy(update=take.cut(number, step.found.measures)))
            if (own, begin, step.found.measures) in known:
                there += 1
                continue
            _check_cut(vocabulary.takes[own], step, number)
            cuts.setdefault(own, []).append((number, step))
    if not cuts:
        raise PersonError(
            f"all {there} cuts are in {library} already" if there else "no step was chosen", "--accept all"
        )
    for own in cuts:
        refuse_external_files(vocabulary.takes[own].entry)
    made: list[Path] = []
    try:
        library.mkdir(parents=True, exist_ok=True)
        tomls = [_write_take(library, vocabulary.takes[own], chosen, made) for own, chosen in sorted(cuts.items())]
    except OSError as error:
        remove_files(made)
        raise PersonError(f"cannot write into the library {library}: {error.strerror}", "--library DIR") from None
    except BaseException:
        remove_files(made)
        raise
    added = {id(step): step for chosen in cuts.values() for _, step in chosen}
    return AddedSteps(
        tuple(step for step in steps if id(step) in added), sum(map(len, cuts.values())), there, tuple(tomls)
    )


def _check_cut(take: Take, step: ProposedStep, number: int) -> None:
    """Cut the step once, so that nothing is written that cannot be danced."""
    update = {"name": step.name, **take.cut(number, step.found.measures)}
    cut_step(replace(take.entry, recording=take.entry.recording.model_copy(update=update)), take.clip)


def _known_cuts(library: Path, takes: Sequence[Take]) -> set[tuple[int, float, int]]:
    """Return recording, begin [ms] and measures of what the library has of the recordings."""
    try:
        files = read_step_files(library)
    except PersonError:
        return set()
    found = set()
    same: dict[tuple[Path, Path], bool] = {}
    for entry in (entry for entries in files.recordings.values() for entry in entries):
        for own, take in enumerate(takes):
            key = (entry.path, take.entry.path)
            if key not in same:
                same[key] = _is_same(entry, take)
            if same[key] and entry.recording.drop_frames == take.entry.recording.drop_frames:
                found.add((own, _begin_ms(entry.recording), entry.recording.measures))
    return found


def _begin_ms(recording: Recording) -> float:
    """Return where a step begins, rounded to a hundredth of a second."""
    measure = recording.beats_per_measure * 60.0 / recording.bpm
    return round(recording.first_beat_s + (recording.start_measure - 1) * measure, 2)


def _is_same(entry: RecordingEntry, take: Take) -> bool:
    try:
        return same_file(entry.path, take.entry.path)
    except OSError:
        return False


def _write_take(library: Path, take: Take, cuts: Sequence[tuple[int, ProposedStep]], made: list[Path]) -> Path:
    """Write the steps of one recording to a new TOML file, and return it."""
    file = import_file(library, take.entry.path, made)
    fields = take.entry.recording.model_dump(exclude_unset=True, exclude_none=True)
    fields["file"] = file.relative_to(library.resolve()).as_posix()
    if take.entry.skeleton is not None:
        skeleton = import_file(library, take.entry.skeleton, made)
        fields["skeleton"] = skeleton.relative_to(library.resolve()).as_posix()
    described = [
        (step.name, take.cut(number, step.found.measures)) for number, step in sorted(cuts, key=lambda c: c[0])
    ]
    text = describe_take(fields, take.comments, described)
    for path in candidate_paths(library, take.entry.path.stem, ".toml"):
        files = StepFiles()
        parse_step_file(text, path, files)
        if files.problems:
            raise PersonError(str(files.problems[0]))
        try:
            with path.open("xb") as out:
                made.append(path)
                out.write(text.encode())
        except FileExistsError:
            continue
        return path
    raise PersonError(f"{library} is full of files called {take.entry.path.stem}.toml", "give the file another name")


def describe_take(
    fields: Mapping[str, Any], comments: Mapping[str, str], cuts: Sequence[tuple[str, Mapping[str, Any]]]
) -> str:
    """Return the TOML text for cuts (name, fields) of one recording: its own fields once, then the steps."""
    lines = []
    for key in _HEADER:
        if key in fields:
            comment = f" # {comments[key]}" if key in comments else ""
            lines.append(f"{key} = {_toml_text(fields[key])}{comment}")
    for name, cut in cuts:
        lines += ["", "[[step]]", f"name = {_toml_text(name)}"]
        for key, value in cut.items():
            comment = f" # {comments[key]}" if key in comments else ""
            lines.append(f"{key} = {_toml_text(value)}{comment}")
    return "\n".join(lines) + "\n"


def _toml_text(value: object) -> str:
    """Return a value as TOML; JSON's strings, numbers, truth values and lists of them are."""
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)
