"""Transcription of a reading as a score of unit labels (H026)."""

from dataclasses import dataclass

from live.motion.partner.decoder import Reading
from live.motion.partner.units import Units


@dataclass(frozen=True, slots=True)
class TranscribedUnits:
    """One transcribed unit, or several consecutive units of one recording."""

    begin: float
    """Start time [s]."""
    seconds: float
    label: str
    """Recording, and number of its first unit there, from 1."""
    count: int
    """Number of consecutive units of that recording, each starting where the previous one ended."""


def transcribe(reading: Reading, units: Units) -> list[TranscribedUnits]:
    """Return the transcribed units, in order. Consecutive units of one recording are one entry."""
    found: list[TranscribedUnits] = []
    before: int | None = None
    for n, unit in enumerate(reading.unit.tolist()):
        begin, seconds = float(reading.start[n]) / reading.rate, float(reading.duration[n]) / reading.rate
        if before is not None and is_consecutive(units, before, unit):
            last = found[-1]
            found[-1] = TranscribedUnits(last.begin, begin + seconds - last.begin, last.label, last.count + 1)
        else:
            found.append(TranscribedUnits(begin, seconds, units.label(unit), 1))
        before = unit
    return found


def is_consecutive(units: Units, unit: int, other: int) -> bool:
    """Whether `other` begins in its recording where `unit` ends."""
    same = int(units.example[unit]) == int(units.example[other])
    return same and abs(float(units.start[unit] + units.length[unit] - units.start[other])) < 0.5


def transcript_text(entries: list[TranscribedUnits]) -> str:
    """Return the score as text, one line for each entry: start, length [s], number of units, label."""
    lines = ["# seconds  length  units  recording/unit"]
    lines += [f"{one.begin:9.3f} {one.seconds:7.3f} {one.count:6d}  {one.label}" for one in entries]
    return "\n".join(lines) + "\n"
