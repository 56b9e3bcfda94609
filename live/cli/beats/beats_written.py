"""What `live beats FILE` writes: a table, JSON, CSV, or the sound with a click on each beat."""

import json
import wave
from collections import Counter
from pathlib import Path

import numpy as np

from live.base.errors import PersonError
from live.clock.estimate import BeatEstimate
from live.control.audio.music_file import Music

CLICK_S = 0.03
"""Length of a click [s]; it falls to 1/e in a fifth of it."""

CLICK_HZ = (1000.0, 1600.0)
"""Pitch of a click, and of one on a downbeat."""


def as_json(file: Path, tracker: str, music: Music, beats: list[BeatEstimate]) -> str:
    """{file, tracker, seconds, bpm, beats_per_measure, beats: [{time_s, named_s, beat, metre, bpm, confidence}]}."""
    return json.dumps(
        {
            "file": file.name,
            "tracker": tracker,
            "seconds": round(music.duration, 3),
            "bpm": _tempo(beats),
            "beats_per_measure": _metre(beats),
            "beats": [
                {
                    "time_s": round(beat.position, 4),
                    "named_s": round(beat.heard, 4),
                    "beat": beat.beat + 1 if beat.beat >= 0 else None,
                    "beats_per_measure": beat.beats_per_measure or None,
                    "bpm": round(60.0 / beat.period, 2),
                    "confidence": round(beat.confidence, 3),
                }
                for beat in beats
            ],
        }
    )


def as_csv(beats: list[BeatEstimate]) -> str:
    """A heading and a line for each beat: time_s, named_s, beat, beats_per_measure, bpm, confidence."""
    lines = ["time_s,named_s,beat,beats_per_measure,bpm,confidence"]
    for beat in beats:
        place = f"{beat.beat + 1},{beat.beats_per_measure}" if beat.beat >= 0 else ","
        lines.append(f"{beat.position:.4f},{beat.heard:.4f},{place},{60.0 / beat.period:.2f},{beat.confidence:.3f}")
    return "\n".join(lines)


def print_table(file: Path, music: Music, beats: list[BeatEstimate], note: str) -> None:
    """A line on the whole, and one for each measure (or each fourth beat) with its time and tempo."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    if note:
        console.print(note)
    if not beats:
        console.print(f"{file}: no beat was heard in {music.duration:.1f} s")
        return
    metre = _metre(beats)
    known = f"{metre} beats a measure" if metre is not None else "measures unknown"
    console.print(f"{file.name}: {len(beats)} beats in {music.duration:.1f} s, {_tempo(beats):g} bpm, {known}")
    for index, beat in enumerate(beats):
        if beat.beat == 0 or (beat.beat < 0 and index % 4 == 0):
            console.print(f"  {beat.position:9.3f} s  {60.0 / beat.period:6.2f} bpm  confidence {beat.confidence:.2f}")


def write_click(path: Path, music: Music, beats: list[BeatEstimate]) -> None:
    """Write the sound, mixed to mono, with a click on each beat: 16 bit WAV at the sound's own rate."""
    rate = music.sample_rate
    sound = 0.6 * music.samples.mean(axis=1, dtype=np.float32)
    time = np.arange(int(CLICK_S * rate)) / rate
    for beat in beats:
        start = round(beat.position * rate)
        if not 0 <= start < sound.size:
            continue
        tone = 0.5 * np.exp(-5.0 * time / CLICK_S) * np.sin(2.0 * np.pi * CLICK_HZ[beat.beat == 0] * time)
        part = sound[start : start + tone.size]
        part += tone[: part.size].astype(np.float32)
    data = (np.clip(sound, -1.0, 1.0) * 32767.0).astype("<i2").tobytes()
    try:
        with wave.open(str(path), "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(rate)
            out.writeframes(data)
    except OSError as error:
        raise PersonError(f"--click {path} cannot be written ({error.strerror or error})") from None


def _tempo(beats: list[BeatEstimate]) -> float | None:
    """The tempo heard most of the time [bpm]; None without beats."""
    return round(60.0 / float(np.median([beat.period for beat in beats])), 2) if beats else None


def _metre(beats: list[BeatEstimate]) -> int | None:
    """The metre heard most of the time; None where none is known."""
    heard = Counter(beat.beats_per_measure for beat in beats if beat.beats_per_measure)
    return heard.most_common(1)[0][0] if heard else None
