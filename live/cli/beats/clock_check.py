"""Command `live clock-check`: decodes a recorded MIDI clock with the show's decoder."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.clock.midi.clock_report import ClockReport


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

    from live.app.offline.clock_stream import read_beats, read_stream
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
