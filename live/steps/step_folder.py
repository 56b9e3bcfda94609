"""A folder of steps: recordings and sketches side by side, as step clips (`--steps DIR`, `--library DIR`)."""

from pathlib import Path

from live.motion.step_clip import StepClip
from live.steps.recording_file import nothing_in, read_step_files
from live.steps.recordings import recorded_steps
from live.steps.sketch_folder import sketched_steps


def load_folder(directory: Path) -> list[StepClip]:
    """All steps of a folder, sketches first, each kind in the order of the file names.

    Raises RecordingError or StepsError (both PersonErrors) with file, line, field and remedy.
    """
    files = read_step_files(directory)
    if not files.sketches and not files.recordings and not files.problems:
        raise nothing_in(directory)
    return (sketched_steps(files.sketches) if files.sketches else []) + recorded_steps(files)
