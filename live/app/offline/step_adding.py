"""Addition of a recording to the library as a step, with its beats found from claps to a click or song."""

from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any

from rich.console import Console

from live.app.offline.step_listing import user_library
from live.app.option_values import check_range
from live.base.errors import PersonError
from live.library.add_step import RequestedEntry, add_step, known_fields, refuse_duplicate, request_entry
from live.library.beat_alignment import SyncRequest, SyncResult, find_sync
from live.library.library_check import reading_warnings, step_warnings
from live.library.recordings import RecordingReader
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.retarget.body_tracks import body_tracks


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
    _check(fields, reference)
    folder = user_library() if library is None else library
    if folder.is_dir() and reference == ClapReference():
        known, comments = known_fields(folder, file, fields)
        fields = known | fields
        if comments:
            _print_known_guess(console, fields, comments)
    if "bpm" not in fields or "first_beat_s" not in fields:
        fields, heard = _with_beats(console, file, fields, reference)
        comments = comments | heard
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
    feet = reader.feet(entry)
    if feet is not None:
        console.print(
            f"feet:    planted: the recording's own slide at {feet.before.slide:.3f} m/s (now {feet.after.slide:.3f}) and "
            f"are fast and low in {feet.before.low_swing:.0%} of it (now {feet.after.low_swing:.0%}); they were moved by "
            f"{100.0 * feet.largest_shift:.0f} cm at most",
            soft_wrap=True,
            markup=False,
        )
    doubts = step_warnings(entry, step) + _untrimmed_warning(entry, reader) + reading_warnings(entry, reader)
    for field, words in doubts:
        option = entry.problem(field, words).field or "FILE"
        console.print(f"doubtful: {option}: {words}", style="yellow", soft_wrap=True, markup=False)
    console.print(f"written: {added.toml}", soft_wrap=True, markup=False)
    if added.copied:
        console.print(f"copied:  {added.file}", soft_wrap=True, markup=False)
    where = "" if library is None else f" --library {quote(str(library))}"
    console.print(f"see it:  live steps play {quote(step.step)}{where}", style="dim", soft_wrap=True, markup=False)


def _check(fields: dict[str, Any], listening: ClapReference) -> None:
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


def _with_beats(
    console: Console, file: Path, fields: dict[str, Any], listening: ClapReference
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the fields with tempo and first beat found, and comments for the TOML file on how they were found."""
    by_hand = {key for key in ("bpm", "first_beat_s") if key in fields}
    recording = request_entry(file, {"bpm": 120.0, "first_beat_s": 0.0} | fields).recording
    # a given anchor counts from the file's first frame, unless the dropped frames are given too
    kept = recording.drop_frames if "drop_frames" in fields or "first_beat_s" in by_hand else None
    found = find_sync(
        SyncRequest(
            file=file,
            skeleton=None if recording.skeleton is None else Path(recording.skeleton),
            fps=recording.fps,
            up=recording.up,
            drop_frames=kept,
            click_bpm=listening.click,
            count=listening.count,
            song=listening.song,
            anchor_s=recording.first_beat_s if "first_beat_s" in by_hand else None,
            bpm=recording.bpm if "bpm" in by_hand else None,
            beats_per_measure=recording.beats_per_measure,
        )
    )
    reference = found.reference
    comments: dict[str, str] = {}
    for key, value in (("bpm", round(reference.bpm, 3)), ("first_beat_s", round(reference.first_beat_s, 4))):
        if key not in by_hand:
            fields, comments = fields | {key: value}, comments | {key: found.comment}
    if kept is None and found.drop_frames:
        fields = fields | {"drop_frames": found.drop_frames}
        comments["drop_frames"] = "found: a T-pose was put before the dance"
    _say(console, found)
    return fields, comments


def _say(console: Console, found: SyncResult) -> None:
    reference, guessed = found.reference, found.guessed
    console.print(
        f"{'guess, to be confirmed' if guessed else 'music found'}: {reference.bpm:.2f} bpm, first beat at "
        f"{reference.first_beat_s:.3f} s, confidence {reference.confidence:.2f} ({reference.note})",
        style="yellow" if guessed else "",
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
