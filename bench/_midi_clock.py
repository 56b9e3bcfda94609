"""The rows of MIDI clock for the bench of the clock: the shared streams through the real decoder, and two peers.

The peers are what is commonly written: the period as the average of the last 24 pulses, and a least squares line over
the last 72; both predict the next beat at each beat, and count.
"""

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from live.app.offline.clock_stream import read_beats, read_stream
from live.cli.bench import Row
from live.clock.midi.clock_report import ClockErrors, DecodedBeat, clock_errors, replay

PHASE_BAR_MS = 3.0
TEMPO_BAR_BPM = 0.1
TEMPO_BAR_NOISY_BPM = 0.3
PULSES = 24

Messages = list[tuple[float, list[int]]]


@dataclass(frozen=True)
class Result:
    """One stream: how it was made, and the errors of each decoder."""

    name: str
    steady: bool
    jitter_ms: float
    ours: ClockErrors
    peers: dict[str, ClockErrors]
    cpu: float


def rows(full: bool, shared: Path | None) -> list[Row]:
    """All rows; with `full` some for each stream as well. Values are None where the streams are absent."""
    results = _results(shared)
    steady = [r for r in results if r.steady]
    calm = [r for r in steady if r.jitter_ms <= 2.0]
    noisy = [r for r in steady if r.jitter_ms > 2.0]
    found = [
        _row("phase p95, worst steady stream", steady, "ms", PHASE_BAR_MS, lambda e: e.phase_p95_ms),
        _row("phase p95, worst stream of all", results, "ms", None, lambda e: e.phase_p95_ms),
        _row("a beat ahead, p95, worst steady stream", steady, "ms", PHASE_BAR_MS, lambda e: e.ahead_p95_ms),
        _row("tempo after 8 beats, jitter to 2 ms", calm, "bpm", TEMPO_BAR_BPM, lambda e: e.tempo_max_bpm),
        _row("tempo after 8 beats, jitter to 5 ms", noisy, "bpm", TEMPO_BAR_NOISY_BPM, lambda e: e.tempo_max_bpm),
        _row("beats until a tempo step is followed", results, "beats", 1.0, lambda e: float(e.step_beats)),
        _row("number in the measure right", results, "share", 1.0, lambda e: e.measure_right, least=True),
        Row("MIDI clock: decoder", max((r.cpu for r in results), default=None), "cores"),
    ]
    if full:
        for r in results:
            found += [
                _row(f"{r.name}: phase p95", [r], "ms", None, lambda e: e.phase_p95_ms),
                _row(f"{r.name}: tempo p95", [r], "bpm", None, lambda e: e.tempo_p95_bpm),
            ]
    return found


def _row(
    name: str, results: list[Result], unit: str, bar: float | None, value: Callable[[ClockErrors], float],
    *, least: bool = False,
) -> Row:  # fmt: skip
    worst = min if least else max
    if not results:
        return Row(f"MIDI clock: {name}", None, unit, bar, "at least" if least else "at most")
    peers = {peer: worst(value(r.peers[peer]) for r in results) for peer in results[0].peers}
    ours = worst(value(r.ours) for r in results)
    return Row(f"MIDI clock: {name}", ours, unit, bar, "at least" if least else "at most", peers)


def _results(shared: Path | None) -> list[Result]:
    folder = shared / "beats" / "midiclock" if shared is not None else None
    if folder is None or not folder.is_dir():
        return []
    results = []
    for file in sorted(folder.glob("*.jsonl")):
        truth = read_beats(file.with_suffix(".beats"))
        if not truth:
            continue
        _, messages = read_stream(file)
        made = json.loads(file.with_suffix(".truth.json").read_text(encoding="utf-8"))
        begin = time.process_time()
        report = replay(messages)
        cpu = (time.process_time() - begin) / (messages[-1][0] - messages[0][0])
        ours = clock_errors(report.beats, truth)
        peers = {name: clock_errors(_peer(messages, fit), truth) for name, fit in PEERS.items()}
        if ours is None or any(errors is None for errors in peers.values()):
            continue
        one_tempo = len({true.bpm for true in truth}) == 1
        steady = one_tempo and not made["dropouts"]
        jitter = max(made["jitter_ms"], made["usb_frame_ms"] / 2.0)
        kept = {name: errors for name, errors in peers.items() if errors is not None}
        results.append(Result(made["name"], steady, jitter, ours, kept, cpu))
    return results


def _average(times: Sequence[float]) -> tuple[float, float]:
    """(time of the newest pulse, period) from the last 24."""
    last = times[-PULSES - 1 :]
    return last[-1], (last[-1] - last[0]) / max(len(last) - 1, 1)


def _least_squares(times: Sequence[float]) -> tuple[float, float]:
    """(time of the newest pulse, period) of the line through the last 72."""
    last = times[-3 * PULSES :]
    slope, offset = np.polyfit(np.arange(len(last)) - len(last) + 1.0, last, 1)
    return float(offset), float(slope)


PEERS: dict[str, Callable[[Sequence[float]], tuple[float, float]]] = {
    "average of 24": _average,
    "least squares, 72": _least_squares,
}


def _peer(messages: Messages, fit: Callable[[Sequence[float]], tuple[float, float]]) -> list[DecodedBeat]:
    """The beats that a decoder names which predicts the next beat at each beat and counts pulses."""
    times: list[float] = []
    beats = []
    position, running, held = 0, False, 0
    for at, message in messages:
        status = message[0]
        if status == 0xF8:
            times.append(at)
            if running and position % PULSES == 0 and len(times) > 2:
                newest, period = fit(times)
                number, due = position // PULSES + 1, newest + PULSES * period
                beats.append(DecodedBeat(due, at, 60.0 / (PULSES * period), number % 4, number // 4, due))
            position += running
        elif status in (0xFA, 0xFB):
            position, running = (0 if status == 0xFA else held), True
        elif status == 0xFC:
            held, running = position, False
        elif status == 0xF2:
            held = (message[1] + 128 * message[2]) * 6
    return beats
