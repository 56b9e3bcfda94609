"""Reader for a folder of steps, recordings and sketches, as cached step clips (`--steps DIR`, `--library DIR`)."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.graph.step_library import plain_name
from live.library.disk_cache import ClipCache
from live.library.recording_file import no_steps_error, read_step_files
from live.library.recordings import recorded_steps
from live.library.textured_steps import read_textured
from live.motion.step_clip import StepClip

MAX_STEP_BYTES: Final = 200_000
CACHE: Final = ClipCache("steps", max_entries=8)
"""One entry for each of the latest sets of steps, in any checkout."""


class StepsError(PersonError):
    """Steps that cannot be read; the message names the file, and line and field if known."""


def sketched_steps(texts: dict[str, str]) -> list[StepClip]:
    """Return the steps of sketches, `texts` by file name; StepsError if one is invalid."""
    sources = (part for name, text in texts.items() for part in (Path(name).name.encode(), text.encode()))
    return CACHE.load_or_build(sources, lambda: _build_sketches(texts))


def _build_sketches(texts: dict[str, str]) -> list[StepClip]:
    from live.motion.sketch.sketch_clips import step_clips
    from live.motion.sketch.sketch_file import SketchError, parse_sketch

    clips: list[StepClip] = []
    owner: dict[str, str] = {}
    for file, text in texts.items():
        try:
            sketch = parse_sketch(text, file)
            if sketch.name in owner:
                raise StepsError(f"{file}: the step {sketch.name!r} is already in {owner[sketch.name]}")
            owner[sketch.name] = file
            clips += step_clips(sketch)
        except SketchError as error:
            raise StepsError(str(error)) from None
    return clips


def load_folder(directory: Path) -> list[StepClip]:
    """Read all steps of a folder: sketches, then their textured versions, then recordings, each by file name.

    Names that differ only in case, blanks, hyphens or underscores are the same step, spelled as the first of them.
    RecordingError or StepsError (both PersonErrors) with file, line, field and remedy.
    """
    files = read_step_files(directory)
    if not files.sketches and not files.recordings and not files.problems:
        raise no_steps_error(directory)
    sketched = sketched_steps(files.sketches) if files.sketches else []
    return unify_names(sketched + read_textured(files.sketches) + recorded_steps(files))


def unify_names(steps: Sequence[StepClip]) -> list[StepClip]:
    """Return the steps, with one spelling of names that are equal as plain names: that of the first."""
    names: dict[str, str] = {}
    called = [names.setdefault(plain_name(step.step), step.step) for step in steps]
    return [step if step.step == name else replace(step, step=name) for step, name in zip(steps, called, strict=True)]
