"""Guesses: tempo and first beat that nobody has confirmed, by the comment behind them in the TOML file (T017)."""

from live.library.recording import RecordingEntry
from live.library.sync import GUESS


def guessed_fields(entry: RecordingEntry, text: str) -> list[str]:
    """Which of the fields bpm and first_beat_s of one step are marked as guesses in the TOML `text` it comes from."""
    lines = text.splitlines()
    found = []
    for field in ("bpm", "first_beat_s"):
        line = entry.problem(field, "").line
        if line is not None and line <= len(lines) and GUESS in lines[line - 1].partition("#")[2]:
            found.append(field)
    return found


def guess_doubts(entry: RecordingEntry, text: str) -> list[tuple[str, str]]:
    """Field and words for each guess that stands in the file unconfirmed."""
    return [
        (
            field,
            f"{getattr(entry.recording, field):g} is a guess; look at the step on the beat (live steps play), correct "
            f"the number, and take the comment {GUESS!r} away",
        )
        for field in guessed_fields(entry, text)
    ]
