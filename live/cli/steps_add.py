"""`live steps add`: a recording becomes a step of the library."""

from pathlib import Path
from typing import Any

from rich.console import Console

from live.cli.steps_library import user_library
from live.steps.adding import add_step, asked_entry
from live.steps.doubts import doubts_about


def add_to_library(file: Path, fields: dict[str, Any], library: Path | None) -> None:
    """Add the step that the options describe, and say what it became; PersonError if it cannot be."""
    folder = user_library() if library is None else library
    added = add_step(folder, asked_entry(file, fields))
    step, recording = added.step, added.entry.recording
    console = Console(highlight=False)
    console.print(
        f"added {step.step!r}: {step.measures} {'measure' if step.measures == 1 else 'measures'} of "
        f"{step.beats_per_measure} beats at {step.bpm:g} bpm, from measure {recording.start_measure} of {file.name}; "
        f"{step.direction}, {step.distance_m:.2f} m",
        style="green",
        soft_wrap=True,
        markup=False,
    )
    for field, words in doubts_about(added.entry, step):
        problem = added.entry.problem(field, words)
        console.print(f"doubtful: {problem.field or 'FILE'}: {words}", style="yellow", soft_wrap=True, markup=False)
    console.print(f"written: {added.toml}", soft_wrap=True, markup=False)
    if added.copied:
        console.print(f"copied:  {added.file}", soft_wrap=True, markup=False)
    where = "" if library is None else f" --library {library}"
    console.print(f'see it:  live steps play "{step.step}"{where}', style="dim", soft_wrap=True, markup=False)
