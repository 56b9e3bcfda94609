"""Recorded MIDI clock streams, and the true beats next to them, for `live clock-check` and the benchmarks."""

import json
import math
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.clock.midi.clock_report import TrueBeat

MAX_BYTES: Final = 200_000_000
_REMEDY: Final = 'a stream has lines like {"t": 1.25, "m": [248]}: seconds, and the bytes of a message'


def _lines(file: Path) -> list[str]:
    try:
        if file.stat().st_size > MAX_BYTES:
            raise PersonError(f"{file}: more than {MAX_BYTES // 1_000_000} MB")
        return file.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise PersonError(f"cannot read {file}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise PersonError(f"{file}: not a text in UTF-8 (byte {error.start})", _REMEDY) from None


def read_stream(file: Path) -> tuple[dict[str, Any], list[tuple[float, list[int]]]]:
    """Return the header ({} if absent) and messages (time [s], bytes) of a stream; raise PersonError with the line."""
    header: dict[str, Any] = {}
    messages: list[tuple[float, list[int]]] = []
    for number, line in enumerate(_lines(file), start=1):
        if not line.strip():
            continue
        try:
            data = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise PersonError(f"{file}, line {number}: not JSON: {error}", _REMEDY) from None
        if number == 1 and isinstance(data, dict) and "m" not in data:
            header = data
            continue
        message = _message(data)
        if message is None:
            raise PersonError(f"{file}, line {number}: not a message: {line[:80]}", _REMEDY)
        if messages and message[0] < messages[-1][0]:
            raise PersonError(f"{file}, line {number}: t goes back to {message[0]:g} s", "sort the lines by t")
        messages.append(message)
    if not messages:
        raise PersonError(f"{file}: no message in it", _REMEDY)
    return header, messages


def _message(data: object) -> tuple[float, list[int]] | None:
    if not isinstance(data, dict):
        return None
    time, message = data.get("t"), data.get("m")
    if isinstance(time, bool) or not isinstance(time, int | float) or not abs(time) < 1e7:
        return None
    if not isinstance(message, list) or not 1 <= len(message) <= 1024:
        return None
    good = all(isinstance(byte, int) and not isinstance(byte, bool) and 0 <= byte <= 255 for byte in message)
    return (float(time), message) if good else None


def read_beats(file: Path) -> list[TrueBeat]:
    """Return the true beats in `file`; raise PersonError with the line."""
    beats = []
    for number, line in enumerate(_lines(file), start=1):
        if not line.strip():
            continue
        try:
            time, beat, bpm = line.split()
            beats.append(TrueBeat(float(time), int(beat) - 1, float(bpm)))
        except ValueError:
            raise PersonError(f"{file}, line {number}: seconds, beat and bpm expected: {line[:80]}") from None
        if not (math.isfinite(beats[-1].time) and 1.0 <= beats[-1].bpm <= 1000.0):
            raise PersonError(f"{file}, line {number}: seconds and 1 to 1000 bpm expected: {line[:80]}")
    return beats
