"""Reader for a folder of steps, recordings and sketches, as cached step clips (`--steps DIR`, `--library DIR`)."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Final

import numpy as np

from live.base.errors import PersonError
from live.graph.step_library import plain_name
from live.library.disk_cache import ClipCache
from live.library.recording_file import no_steps_error, read_step_files
from live.library.recordings import recorded_steps
from live.library.textured_steps import read_textured
from live.motion.editing.momentum_variation import vary_steps
from live.motion.editing.path_bend import path_variants, source_name
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
    owner: dict[tuple[str, object], str] = {}
    for file, text in texts.items():
        try:
            sketch = parse_sketch(text, file)
            key = sketch.name, sketch.attributes.get("mood")  # of each mood there may be an example
            if key in owner:
                raise StepsError(f"{file}: the step {sketch.name!r} is already in {owner[key]}")
            owner[key] = file
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


PATHS: Final = ClipCache("paths", max_entries=32)
"""One entry for each set of recorded steps that a show begins with."""


def with_path_variants(steps: Sequence[StepClip]) -> list[StepClip]:
    """Return the steps, each recorded one that travels followed by its copies on shorter and bent paths.

    With them a group follows its agents although its recordings go where they were recorded.
    """
    recorded = [step for step in steps if step.recorded]
    if not recorded:
        return list(steps)
    copies: dict[str, list[StepClip]] = {}
    for copy in PATHS.load_or_build(_contents(recorded), lambda: [v for step in recorded for v in path_variants(step)]):
        copies.setdefault(source_name(copy.clip.name), []).append(copy)
    return [one for step in steps for one in (step, *(copies.pop(step.clip.name, []) if step.recorded else []))]


VARIATIONS: Final = ClipCache("variations", max_entries=32)
"""One entry for each set of steps, number of variations and seed."""


def varied_steps(steps: Sequence[StepClip], count: int, seed: int) -> list[StepClip]:
    """Return `count` variations of each step that is danced, of the same momentum (T142)."""
    if not count:
        return []
    steps = [step for step in steps if not step.unjoined]
    sources = (f"{count} {seed}".encode(), *_contents(steps))
    return VARIATIONS.load_or_build(sources, lambda: vary_steps(steps, count, seed))


def _contents(steps: Sequence[StepClip]) -> Iterator[bytes]:
    for step in steps:
        yield repr([getattr(step, field.name) for field in fields(step) if field.name != "clip"]).encode()
        yield step.clip.name.encode()
        for array in (step.clip.root_position, step.clip.rotation, step.clip.contact):
            yield np.ascontiguousarray(array).tobytes()


def unify_names(steps: Sequence[StepClip]) -> list[StepClip]:
    """Return the steps, with one spelling of names that are equal as plain names: that of the first."""
    names: dict[str, str] = {}
    called = [names.setdefault(plain_name(step.step), step.step) for step in steps]
    return [step if step.step == name else replace(step, step=name) for step, name in zip(steps, called, strict=True)]
