"""Command `live clock-check`: decodes a recorded MIDI clock with the show's decoder."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from live.base.errors import PersonError

if TYPE_CHECKING:
    from live.clock.midi.clock_report import ClockReport, TrueBeat

MAX_BYTES = 200_000_000
_REMEDY = 'a stream has lines like {"t": 1.25, "m": [248]}: seconds, and the bytes of a message'


def clock_check(
    file: Annotated[Path, typer.Argument(help="A stream: JSON lines with t (seconds) and m (bytes).")],
    metre: Annotated[int, typer.Option(help="Beats per measure, which MIDI clock does not contain.")] = 4,
    json_out: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Replay a recorded MIDI clock and print its beats, and their errors if NAME.beats is next to the file.

    A line B has the time of the beat, the time of its last prediction, beat and measure from 1, and the tempo.
    NAME.beats has a line for each true beat: seconds, beat of the measure from 1, bpm.
    """
    from dataclasses import asdict

    from live.app.option_values import check_range
    from live.clock.midi.clock_report import clock_errors, replay

    check_range(metre, "--metre", 1, 16)
    header, messages = read_stream(file)
    report = replay(messages, beats_per_measure=metre)
    beats_file = file.with_suffix(".beats")
    truth = read_beats(beats_file) if beats_file.is_file() else None
    errors = clock_errors(report.beats, truth) if truth else None
    if json_out:
        found = {
            "name": header.get("name", file.stem),
            "beats": [_nan_to_none(asdict(beat)) for beat in report.beats],
            "states": [asdict(state) for state in report.states],
            "pulses": report.pulses,
            "lost": report.lost,
            "rejected": report.rejected,
            "errors": _nan_to_none(asdict(errors)) if errors is not None else None,
        }
        print(json.dumps(found))
        return
    _print(report)
    if errors is not None:
        words = ", ".join(f"{key} {_short(value)}" for key, value in asdict(errors).items())
        print(f"# {words}")
    elif truth is not None:
        print("# no true beats to compare with")


def _nan_to_none(values: dict[str, Any]) -> dict[str, Any]:
    """Replace NaN, which JSON does not have, with None."""
    return {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in values.items()}


def _short(value: float) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def _print(report: "ClockReport") -> None:
    for beat in report.beats:
        where = f"{beat.beat + 1} {beat.measure + 1}" if beat.beat >= 0 else "- -"
        print(f"B {beat.time:.6f} {beat.emitted:.6f} {where} {beat.bpm:.3f}")
    for state in report.states:
        print(f"# {state.time:.3f} {state.state}" + (f" ({state.detail})" if state.detail else ""))
    print(f"# {report.pulses} pulses, {report.lost} lost and filled in by time, {report.rejected} messages rejected")


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


def read_beats(file: Path) -> "list[TrueBeat]":
    """Return the true beats in `file`; raise PersonError with the line."""
    from live.clock.midi.clock_report import TrueBeat

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
