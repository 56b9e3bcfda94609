"""Addition of a recording to the library as a step, with its beats found from claps to a click or song."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any, Final

from rich.console import Console

from live.app.offline.step_listing import user_library
from live.app.option_values import check_range
from live.base.errors import PersonError
from live.library.add_step import (
    RequestedEntry,
    add_step,
    known_fields,
    refuse_duplicate,
    request_entry,
    with_beats,
)
from live.library.beat_alignment import SyncResult
from live.library.library_check import reading_warnings, step_warnings
from live.library.recordings import RecordingReader
from live.motion.cleanup.foot_planting import PlantedClip
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.retarget.body_tracks import body_tracks

MIN_FOOT_FAULT: Final = 0.02
"""Slide [m/s] and share of dragged swings from which a recording's own faults are told."""


@dataclass(frozen=True, slots=True)
class ClapReference:
    """Sound that was clapped to: a click of `click` bpm (of `count` beats, if known), or an audio file."""

    click: float | None = None
    count: int | None = None
    song: Path | None = None


def add_to_library(file: Path, fields: dict[str, Any], library: Path | None, reference: ClapReference) -> None:
    """Add the step that the options describe, and print the result; raise PersonError if that fails.

    Given --bpm or --anchor have priority. Missing values are estimated from the recording, and reported as a guess if
    there are no claps.
    """
    console = Console(highlight=False)
    comments: dict[str, str] = {}
    check_beat_options(fields, reference)
    folder = user_library() if library is None else library
    if folder.is_dir() and reference == ClapReference():
        known, comments = known_fields(folder, file, fields)
        fields = known | fields
        if comments:
            _print_known_guess(console, fields, comments)
    if "bpm" not in fields or "first_beat_s" not in fields:
        fields, heard, found = with_beats(
            file, fields, click=reference.click, count=reference.count, song=reference.song
        )
        comments = comments | heard
        print_beats(console, found)
    reader = RecordingReader()
    entry = request_entry(file, fields)
    refuse_duplicate(folder, entry)
    added = add_step(folder, entry, comments=comments, reader=reader)
    step = added.step
    console.print(
        f"added {step.step!r}: {step.measures} {'measure' if step.measures == 1 else 'measures'} of "
        f"{step.beats_per_measure} beats at {step.bpm:g} bpm, from measure {entry.recording.start_measure} of "
        f"{file.name}; {step.direction}, {step.distance_m:.2f} m",
        style="green",
        soft_wrap=True,
        markup=False,
    )
    doubts = step_warnings(entry, step) + _untrimmed_warning(entry, reader) + reading_warnings(entry, reader)
    for field, words in doubts:
        option = entry.problem(field, words).field or "FILE"
        console.print(f"doubtful: {option}: {words}", style="yellow", soft_wrap=True, markup=False)
    _print_feet(console, reader.feet(entry))
    console.print(f"written: {added.toml}", soft_wrap=True, markup=False)
    if added.copied:
        console.print(f"copied:  {added.file}", soft_wrap=True, markup=False)
    where = "" if library is None else f" --library {quote(str(library))}"
    console.print(f"see it:  live steps play {quote(step.step)}{where}", style="dim", soft_wrap=True, markup=False)


def check_beat_options(fields: dict[str, Any], listening: ClapReference) -> None:
    """Raise PersonError for options about the beat that are out of range or exclude each other."""
    check_range(listening.click, "--click", 20, 400)
    check_range(listening.count, "--count", 1, 1000)
    if listening.click is not None and listening.song is not None:
        raise PersonError("--click and --song exclude each other", "--click for a click, --song for a music file")
    if listening.count is not None and listening.click is None:
        raise PersonError("--count counts the beats of a click", f"--click BPM --count {listening.count}")
    if "bpm" in fields and "first_beat_s" in fields and (listening.click or listening.song):
        what = "--click" if listening.click else "--song"
        raise PersonError(
            f"{what}: --bpm and --anchor say already where the music is", f"leave out {what}, or one of them"
        )


def print_beats(console: Console, found: SyncResult) -> None:
    """Print tempo and first beat, with how they were found."""
    reference, guessed = found.reference, found.guessed
    console.print(
        f"{'guess, to be confirmed' if guessed else 'music found'}: {reference.bpm:.2f} bpm, first beat at "
        f"{reference.first_beat_s:.3f} s, confidence {reference.confidence:.2f} ({reference.note})",
        style="yellow" if guessed else "",
        soft_wrap=True,
        markup=False,
    )


def _print_feet(console: Console, planted: PlantedClip | None) -> None:
    """Print what was wrong with the recorded feet, and what is left of it."""
    if planted is None or max(planted.before.slide, planted.before.low_swing) < MIN_FOOT_FAULT:
        return
    before, after = planted.before, planted.after
    console.print(
        f"feet:    in the recording standing feet slide at {before.slide:.3f} m/s and swings drag in "
        f"{before.low_swing:.0%} of it; planted: {after.slide:.3f} m/s and {after.low_swing:.0%}, feet moved by up to "
        f"{planted.largest_shift:.2f} m (plant_feet = false leaves them as recorded)",
        soft_wrap=True,
        markup=False,
    )


def _print_known_guess(console: Console, fields: dict[str, Any], comments: dict[str, str]) -> None:
    told = {"bpm": f"{fields['bpm']:.2f} bpm", "first_beat_s": f"first beat at {fields['first_beat_s']:.3f} s"}
    words = ", ".join(told[key] for key in comments)
    console.print(
        f"guess, to be confirmed: {words} (the library's, where it is not confirmed yet)",
        style="yellow",
        soft_wrap=True,
    )


def _untrimmed_warning(entry: RequestedEntry, reader: RecordingReader) -> list[tuple[str, str]]:
    """Return a warning if a T-pose before the dance is not dropped."""
    recording, motion = entry.recording, reader.motion(entry)
    frames = find_recording_start(body_tracks(motion, fps=recording.fps, up=recording.up)).drop_frames
    if frames <= recording.drop_frames:
        return []
    less = (frames - recording.drop_frames) / (recording.fps or motion.header_fps)
    words = (
        f"the first {frames} frames are a T-pose and the way out of it, put before the dance; --drop-frames {frames} "
        f"leaves them out, and --anchor is then {less:.3f} s less"
    )
    return [("drop_frames", words)]
