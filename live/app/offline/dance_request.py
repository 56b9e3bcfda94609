"""Input of `live dance`: the step library and the requested sequence."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.graph.search.sequence import parse_sequence
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.step_library import StepLibrary, build_library
from live.library.step_folder import load_folder
from live.motion.step_clip import StepClip
from live.show.patch.patch_search_path import PATCHES

SKETCHES: Final = "sketches"
"""Name of the built-in steps."""
MAX_BYTES: Final = 4_000_000
"""Maximum size of a sequence file [bytes]."""


def read_clips(library: str) -> list[StepClip]:
    """Read the steps of a folder, or the built-in ones."""
    return load_folder(PATCHES / "steps" if library == SKETCHES else Path(library))


def read_text(sequence: str) -> str:
    """Return the sequence, read from a file if it begins with @; in a file, line ends count as commas."""
    if not sequence.startswith("@"):
        return sequence
    file = Path(sequence[1:])
    try:
        if not file.is_file():
            what = "that is not a file" if file.exists() else "there is no such file"
            raise PersonError(f"--sequence @{file}: {what}", "after @ give a text file, its lines steps with commas")
        if os.path.getsize(file) > MAX_BYTES:
            raise PersonError(f"--sequence @{file}: a file of at most {MAX_BYTES // 1_000_000} MB expected")
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        words = error.strerror if isinstance(error, OSError) and error.strerror else "it is not a text in UTF-8"
        raise PersonError(f"--sequence {file}: cannot be read: {words}") from None
    lines = [line.split("#")[0].strip().strip(",") for line in text.splitlines()]
    return ",".join(line for line in lines if line)


def read_wanted(clips: Sequence[StepClip], text: str) -> tuple[StepLibrary, list[SequenceEntry]]:
    """Return the library of the metre that has all steps of the sequence, and the parsed sequence."""
    metres = [clip.beats_per_measure for clip in clips]
    errors: list[PersonError] = []
    for beats in sorted(set(metres), key=lambda beats: (-metres.count(beats), beats)):
        library = build_library([clip for clip in clips if clip.beats_per_measure == beats])
        try:
            return library, parse_sequence(text, library)
        except PersonError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    listed = " and ".join(map(str, sorted(set(metres))))
    raise PersonError(
        f"no metre has all of the sequence: {'; '.join(error.message for error in errors)}",
        f"steps of {listed} beats a measure are there, and a dance has one metre",
    )


def check_attributes(library: StepLibrary, wanted: Sequence[SequenceEntry]) -> None:
    """Raise PersonError if variations of a wanted step differ in `weight_transfer`, which belongs to the step."""
    for step in sorted({entry.step for entry in wanted if entry.step is not None}):
        clips = [clip for clip in library.clips if clip.step == library.steps[step]]
        said = {clip.weight_transfer: clip for clip in reversed(clips)}
        if len(said) == 2:
            raise PersonError(
                f"the step {library.steps[step]!r} contradicts itself: {said[True].clip.name!r} transfers the weight, "
                f"{said[False].clip.name!r} does not",
                "write the same weight_transfer for all its variations",
            )
