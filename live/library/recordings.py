"""Recorded steps: what TOML files say about recordings, as step clips cut at the measure lines (T019, T039, T040)."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Final

from live.library.clip_cache import ClipCache
from live.library.cut_step import cut_step
from live.library.motion_file import MAX_BYTES
from live.library.recording import Problem, RecordingEntry, RecordingError, error_of
from live.library.recording_file import StepFiles, nothing_in, read_step_files
from live.library.recording_reader import RecordingReader
from live.library.stream import cut_recording
from live.motion.step_clip import StepClip

__all__ = ["RecordingError", "cut_step", "load_recordings", "recorded_steps"]

CACHE: Final = ClipCache("recordings", kept=1000)
"""One for each TOML file, so that a change in one leaves the others as they are."""
_BESIDE: Final = {".amc": ".asf", ".gltf": ".bin"}
"""What a file of the one ending may read beside it."""


def load_recordings(directory: Path) -> list[StepClip]:
    """All steps that the TOML files of `directory` describe, in order, each followed by its mirror image if asked.

    Raises RecordingError with all problems found: file, line, field, what was read and what is allowed.
    """
    files = read_step_files(directory)
    if not files.recordings and not files.problems:
        raise nothing_in(directory)
    return recorded_steps(files)


def recorded_steps(files: StepFiles) -> list[StepClip]:
    """The same for files that were read already. What was cut before comes out of a cache that follows the files."""
    problems = list(files.problems)
    steps: list[StepClip] = []
    for toml, entries in files.recordings.items():
        try:
            steps += _cut(files.texts[toml], entries)
        except RecordingError as error:
            problems += error.problems
    if problems:
        raise error_of(problems)
    return steps


def _cut(text: str, entries: list[RecordingEntry]) -> list[StepClip]:
    """The steps of one TOML file, out of the cache if they are there."""
    sources = _sources(text, entries)
    if sources is not None:
        try:
            return CACHE.clips(sources, partial(_build, entries))
        except OSError:  # a file that is there and cannot be read: building the steps says which, and why
            pass
    return _build(entries)


def _sources(text: str, entries: list[RecordingEntry]) -> Iterator[bytes] | None:
    """All that the steps of one TOML file depend on; None if a file is missing, so that building them tells it."""
    paths: set[Path] = set()
    for entry in entries:
        paths.add(entry.path)
        if entry.skeleton is not None:
            paths.add(entry.skeleton)
        for ending, other in _BESIDE.items():
            if entry.path.suffix.lower() == ending:
                paths.update(path for path in entry.path.parent.iterdir() if path.suffix.lower() == other)
    try:
        if not all(path.is_file() and path.stat().st_size <= MAX_BYTES for path in paths):
            return None
        return _contents(text, sorted(paths))
    except (OSError, ValueError):
        return None


def _contents(text: str, paths: list[Path]) -> Iterator[bytes]:
    yield text.encode()
    for path in paths:
        yield path.read_bytes()


def _build(entries: list[RecordingEntry]) -> list[StepClip]:
    reader = RecordingReader()
    steps: list[StepClip] = []
    problems: list[Problem] = []
    for entry in entries:
        try:
            steps += cut_recording(entry, reader.clip(entry))
        except RecordingError as error:
            problems += error.problems
    if problems:
        raise error_of(problems)
    return steps
