"""A folder of steps: recordings and sketches side by side, as step clips (`--steps DIR`, `--library DIR`)."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from live.library.recording_file import nothing_in, read_step_files
from live.library.recordings import recorded_steps
from live.library.sketch_folder import sketched_steps
from live.library.textured import read_textured
from live.motion.step_clip import StepClip


def load_folder(directory: Path) -> list[StepClip]:
    """All steps of a folder, sketches first, then their textured versions, then recordings, in the order of file names.

    A name that comes again in other letters is the same step's, for case, blanks, hyphens and underscores do not matter
    where steps are called: it is written as it came first. Raises RecordingError or StepsError (both PersonErrors) with
    file, line, field and remedy.
    """
    files = read_step_files(directory)
    if not files.sketches and not files.recordings and not files.problems:
        raise nothing_in(directory)
    sketched = sketched_steps(files.sketches) if files.sketches else []
    return named_alike(sketched + read_textured(files.sketches) + recorded_steps(files))


def plain_name(name: str) -> str:
    """The name of a step as names are compared: case, blanks, hyphens and underscores do not matter."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def named_alike(steps: Sequence[StepClip]) -> list[StepClip]:
    """The same steps; those of one plain name are called as the first of them."""
    names: dict[str, str] = {}
    called = [names.setdefault(plain_name(step.step), step.step) for step in steps]
    return [step if step.step == name else replace(step, step=name) for step, name in zip(steps, called, strict=True)]
