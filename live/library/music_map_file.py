"""Measure maps in the forms of other programs: Sonic Visualiser CSV, Audacity labels, MIDI tempo map, TOML of a patch.

A line's label is its measure and its beats, `7 4`, and `ramp` if its tempo runs; a phrase's label is `phrase NAME`.
"""

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Final

import mido

from live.base.errors import PersonError
from live.clock.measure_map import MeasureLine, MeasureMap, Phrase
from live.library.whole_file import write_atomically

TICKS_PER_BEAT: Final = 480
RAMP_PARTS: Final = 8
"""Tempo events for each beat of a ramp."""
MAX_BYTES: Final = 4_000_000
MAX_LINES: Final = 100_000
LABEL_HELP: Final = "a label is the measure's number, or number and beats: 7 4"


def write_map(found: MeasureMap, path: Path) -> None:
    """Write a map in the form that the file's name asks for; PersonError if it cannot be written."""
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise PersonError(f"--out {path}: a name that ends in {', '.join(_WRITERS)} expected")
    write_atomically(writer(found), path, "--out")


def read_map(path: Path) -> MeasureMap:
    """Read a map; PersonError with the file's line for a faulty one."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise PersonError(f"{path}: a name that ends in {', '.join(_READERS)} expected")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: {path.stat().st_size} bytes; at most {MAX_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise PersonError(f"cannot read {path}: {error.strerror}") from None
    return reader(data, path)


def _label(line: MeasureLine) -> str:
    return f"{line.measure} {line.beats}" + (" ramp" if line.tempo == "ramp" else "")


def _to_csv(found: MeasureMap) -> bytes:
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    for line in found.lines:
        rows.writerow([f"{line.time_s:.9f}", _label(line)])
    return out.getvalue().encode()


def _to_labels(found: MeasureMap) -> bytes:
    rows = [(line.time_s, line.time_s, _label(line)) for line in found.lines]
    starts = {line.measure: line.time_s for line in found.lines}
    ends = [*(starts.get(each.measure, 0.0) for each in found.phrases[1:]), found.lines[-1].time_s]
    for phrase, end in zip(found.phrases, ends, strict=False):
        if phrase.measure in starts:
            rows.append((starts[phrase.measure], max(end, starts[phrase.measure]), f"phrase {phrase.name}".strip()))
    return "".join(
        f"{begin:.6f}\t{end:.6f}\t{text}\n" for begin, end, text in sorted(rows, key=lambda row: row[0])
    ).encode()


def _to_midi(found: MeasureMap) -> bytes:
    """Lead-in and measures as tempo, metre and markers; the first line stands at its time from the file's start."""
    track = mido.MidiTrack()
    due = 0  # ticks since the last event

    def put(message: mido.MetaMessage) -> None:
        nonlocal due
        track.append(message.copy(time=due))
        due = 0

    if found.lines[0].time_s > 1e-6:
        beats = max(round(found.lines[0].time_s / 2.0), 1)  # a beat of about 2 s: a lead-in is no music
        put(mido.MetaMessage("time_signature", numerator=1, denominator=4))
        put(mido.MetaMessage("set_tempo", tempo=round(found.lines[0].time_s / beats * 1e6)))
        due += beats * TICKS_PER_BEAT
    names = {phrase.measure: phrase.name for phrase in found.phrases}
    metre = 0
    for index, line in enumerate(found.lines):
        if line.beats != metre:
            metre = line.beats
            put(mido.MetaMessage("time_signature", numerator=metre, denominator=4))
        put(mido.MetaMessage("marker", text=f"measure {line.measure}"))
        if line.measure in names:
            put(mido.MetaMessage("cue_marker", text=f"phrase {names[line.measure]}".strip()))
        parts = line.beats * (RAMP_PARTS if line.tempo == "ramp" else 1)
        ticks = line.beats * TICKS_PER_BEAT // parts
        first = found.line_beat(index)
        for part in range(parts):
            begin, end = (found.time_at(first + line.beats * k / parts) for k in (part, part + 1))
            if line.tempo == "ramp" or part == 0:
                put(mido.MetaMessage("set_tempo", tempo=round((end - begin) / ticks * TICKS_PER_BEAT * 1e6)))
            due += ticks
    track.append(mido.MetaMessage("end_of_track", time=due))
    file = mido.MidiFile(type=0, ticks_per_beat=TICKS_PER_BEAT, tracks=[track])
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue()


def map_tables(found: MeasureMap) -> str:
    """Return a map as the tables of a patch."""
    blocks = [
        f"[[music.line]]\ntime_s = {line.time_s}\nmeasure = {line.measure}\nbeats = {line.beats}\n"
        + ('tempo = "ramp"\n' if line.tempo == "ramp" else "")
        for line in found.lines
    ]
    for phrase in found.phrases:
        name = phrase.name.replace("\\", "\\\\").replace('"', '\\"')
        blocks.append(f'[[music.phrase]]\nmeasure = {phrase.measure}\nname = "{name}"\n')
    return "\n".join(blocks)


_WRITERS: Final[dict[str, Callable[[MeasureMap], bytes]]] = {
    ".csv": _to_csv, ".txt": _to_labels, ".mid": _to_midi, ".toml": lambda found: map_tables(found).encode(),
}  # fmt: skip


def _from_rows(rows: list[tuple[int, float, str]], path: Path) -> MeasureMap:
    """Return the map of rows: the file's line, the time and the label."""
    lines: list[MeasureLine] = []
    phrases: list[tuple[float, str]] = []
    for number, time, label in rows:
        where = f"{path}, line {number}"
        words = label.split()
        if words[:1] == ["phrase"]:
            phrases.append((time, " ".join(words[1:])))
            continue
        numbers = [word for word in words if word.isdecimal()]
        if label.strip() and (not numbers or len(numbers) > 2):
            raise PersonError(f"{where}: the label {label[:60]!r} is no measure", LABEL_HELP)
        if lines and time <= lines[-1].time_s:
            words_text = f"{time:g} s is not after {lines[-1].time_s:g} s"
            raise PersonError(f"{where}: the lines go back: {words_text}", "sort them by time")
        measure = int(numbers[0]) if numbers else len(lines) + 1
        beats = int(numbers[1]) if len(numbers) > 1 else lines[-1].beats if lines else 4
        if not 1 <= beats <= 16:
            raise PersonError(f"{where}: a measure of {beats} beats; 1 to 16 expected")
        lines.append(MeasureLine(time, measure, beats, "ramp" if "ramp" in words else "step"))
    try:
        found = MeasureMap(lines)
        marks = [Phrase(_measure_at(found, time), name) for time, name in phrases]
        return MeasureMap(found.lines, marks)
    except ValueError as error:
        raise PersonError(f"{path}: {error}") from None


def _measure_at(found: MeasureMap, time: float) -> int:
    return min(found.lines, key=lambda line: abs(line.time_s - time)).measure


def _text(data: bytes, path: Path) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise PersonError(f"{path}: not a text in UTF-8 (byte {error.start})") from None


def _from_csv(data: bytes, path: Path) -> MeasureMap:
    rows = []
    try:
        for number, row in enumerate(csv.reader(io.StringIO(_text(data, path))), start=1):
            if not row or (number == 1 and not _is_number(row[0])):  # empty, or a heading
                continue
            rows.append((number, _time(row[0], f"{path}, line {number}"), row[-1] if len(row) > 1 else ""))
    except csv.Error as error:
        raise PersonError(f"{path}: {error}") from None
    return _from_rows(rows[:MAX_LINES], path)


def _from_labels(data: bytes, path: Path) -> MeasureMap:
    rows = []
    for number, row in enumerate(_text(data, path).splitlines(), start=1):
        if not row.strip() or row.startswith("\\"):  # Audacity writes frequency ranges so
            continue
        columns = row.split("\t")
        label = columns[2] if len(columns) > 2 else ""
        rows.append((number, _time(columns[0], f"{path}, line {number}"), label))
    return _from_rows(rows[:MAX_LINES], path)


def _from_midi(data: bytes, path: Path) -> MeasureMap:
    """Measures by tempo and metre; with markers `measure N`, as written here, from the first of them on."""
    try:
        file = mido.MidiFile(file=io.BytesIO(data))
        messages = list(mido.merge_tracks(file.tracks))
    except Exception as error:  # mido raises many kinds for damaged files
        raise PersonError(f"{path}: not a MIDI file: {error}") from None
    ticks_per_beat = file.ticks_per_beat or TICKS_PER_BEAT
    tick, time, tempo = 0, 0.0, 500_000
    tempos, metres, marks, cues = [(0, 0.0, tempo)], [(0, 4.0, 4)], list[int](), list[tuple[int, str]]()
    for message in messages:
        time += message.time * tempo / 1e6 / ticks_per_beat
        tick += message.time
        if message.type == "set_tempo":
            tempo = message.tempo
            tempos.append((tick, time, tempo))
        elif message.type == "time_signature":
            metres.append((tick, 4.0 * message.numerator / message.denominator, message.numerator))
        elif message.type == "marker" and message.text.startswith("measure "):
            marks.append(tick)
        elif message.type == "cue_marker" and message.text.startswith("phrase"):
            cues.append((tick, message.text[7:]))
    starts = marks or _measure_ticks(metres, tick, ticks_per_beat)
    lines = []
    for number, start in enumerate(starts[:MAX_LINES], start=1):
        beats = [row for row in metres if row[0] <= start][-1][2]
        ends = starts[number] if number < len(starts) else tick
        changes = sum(1 for at, _, _ in tempos if start < at < ends)
        lines.append(
            MeasureLine(_seconds(tempos, start, ticks_per_beat), number, beats, "ramp" if changes > 1 else "step")
        )
    try:
        names = {start: number for number, start in enumerate(starts, start=1)}
        return MeasureMap(lines, [Phrase(names[at], name) for at, name in cues if at in names])
    except ValueError as error:
        raise PersonError(f"{path}: {error}") from None


def _measure_ticks(metres: list[tuple[int, float, int]], end: int, ticks_per_beat: int) -> list[int]:
    starts, tick = [0], 0
    while tick < end and len(starts) < MAX_LINES:
        quarters = [row for row in metres if row[0] <= tick][-1][1]
        tick += max(round(quarters * ticks_per_beat), 1)
        starts.append(tick)
    return starts[:-1] or [0]


def _seconds(tempos: list[tuple[int, float, int]], tick: int, ticks_per_beat: int) -> float:
    at, time, tempo = [row for row in tempos if row[0] <= tick][-1]
    return time + (tick - at) * tempo / 1e6 / ticks_per_beat


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _time(text: str, where: str) -> float:
    try:
        time = float(text.strip().replace(",", "."))
    except ValueError:
        raise PersonError(f"{where}: {text[:40]!r} is no time in seconds") from None
    if not 0.0 <= time <= 36_000.0:
        raise PersonError(f"{where}: {time:g} s; 0 to 36000 expected")
    return time


_READERS: Final[dict[str, Callable[[bytes, Path], MeasureMap]]] = {
    ".csv": _from_csv, ".txt": _from_labels, ".mid": _from_midi,
}  # fmt: skip
