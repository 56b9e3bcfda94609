"""Marks of a score for the musician: a MIDI file with tempo, metre and markers, and labels for Audacity.

Times are those of the piece: of its measure lines if the patch has them, else of its first downbeat and tempo.
"""

import io
from dataclasses import dataclass
from typing import Any, Final

import mido

from live.clock.measure_map import MeasureLine, MeasureMap
from live.document.sheets.scenes import Scene, arrival_label, measures_words, scene_title
from live.document.sheets.show_record import ShowRecord
from live.show.patch.patch import Patch

PULSES: Final = 480
"""Pulses of a beat."""


@dataclass(frozen=True, slots=True)
class ScoreMark:
    """Something in the score that the musician should see."""

    begin: float
    """Danced beats from the first measure line, as `end`."""
    end: float
    words: str


def score_marks(record: ShowRecord, scenes: tuple[Scene, ...]) -> list[ScoreMark]:
    """Return sections, scenes, segments, elements, signals, calls and waits of a score, in order."""
    beats = record.beats
    marks = []
    for number, one in enumerate(record.course.measures):
        if one.begins:
            again = f", time {one.time}" if one.time > 1 else ""
            marks.append(ScoreMark(number * beats, number * beats, f"section {one.section}{again}"))
        if one.waits:
            end = float((number + 1) * beats)
            marks.append(ScoreMark(end, end, f"{one.section} waits for GO: counts start again"))
    for index, scene in enumerate(scenes, 1):
        words = f"{index}: {measures_words(record, scene)}, {scene_title(scene)}"
        marks.append(ScoreMark(*scene.beats(record), words))
    for led in record.led:
        who = f" ({led.group})" if led.group else ""
        words = f"{led.words}{who}, there at {arrival_label(record, led.end)}"
        marks.append(ScoreMark(float(led.measure * beats), led.end, words))
    for free in record.free:
        who = f" ({free.group})" if free.group else ""
        marks.append(ScoreMark(free.begin, free.end, f"{free.kind}{who}"))
    marks += [ScoreMark(mark.beat, mark.beat, mark.words) for mark in record.marks]
    return sorted(marks, key=lambda mark: mark.begin)


def piece_map(patch: Patch, record: ShowRecord) -> MeasureMap:
    """Return the measure lines of all measures of a score and that of its end, in the time of the piece."""
    known = patch.music.measures
    tempo = patch.music.known_tempo or patch.clock.bpm
    count = record.measures + 1
    lines = list(known.lines[:count]) if known is not None else []
    if not lines:
        lines.append(MeasureLine(patch.music.first_downbeat or 0.0, 1, record.beats))
    lines = [MeasureLine(line.time_s, number, line.beats, line.tempo) for number, line in enumerate(lines, 1)]
    while len(lines) < count:
        before = lines[-1]
        seconds = (
            lines[-1].time_s - lines[-2].time_s if len(lines) > 1 and known is not None else 60.0 * before.beats / tempo
        )
        lines.append(MeasureLine(lines[-1].time_s + seconds, before.measure + 1, before.beats))
    return MeasureMap(lines)


def _time(measures: MeasureMap, record: ShowRecord, beat: float) -> float:
    """Return the time of a danced beat; a measure of the piece may have other beats than those that are danced."""
    measure = min(max(int(beat // record.beats), 0), len(measures.lines) - 2)
    share = beat / record.beats - measure
    return measures.time_at(measures.line_beat(measure) + share * measures.lines[measure].beats)


def labels_of(measures: MeasureMap, record: ShowRecord, marks: list[ScoreMark]) -> bytes:
    """Return a label track of Audacity: measures by their numbers as they are counted, and all marks with their
    spans."""
    rows = [
        (line.time_s, line.time_s, str(one.number))
        for line, one in zip(measures.lines, record.course.measures, strict=False)
    ]
    rows += [(_time(measures, record, mark.begin), _time(measures, record, mark.end), mark.words) for mark in marks]
    rows.sort(key=lambda row: row[0])
    return "".join(f"{begin:.6f}\t{end:.6f}\t{_plain(words)}\n" for begin, end, words in rows).encode()


def _plain(words: str) -> str:
    return " ".join(words.split())


def midi_of(title: str, measures: MeasureMap, record: ShowRecord, marks: list[ScoreMark]) -> bytes:
    """Return a MIDI file of one track: tempo and metre of each measure, and markers; its first pulse is the time 0 of
    the piece. `live music map` can read it."""
    messages: list[tuple[int, int, Any]] = []
    lead = _lead_in(measures, messages)
    pulse, starts = lead, [lead]
    metre = tempo = 0
    for number, (line, after) in enumerate(zip(measures.lines, measures.lines[1:], strict=False)):
        if line.beats != metre:
            metre = line.beats
            messages.append((pulse, 0, mido.MetaMessage("time_signature", numerator=metre, denominator=4)))
        parts = line.beats if line.tempo == "ramp" else 1
        for part in range(parts):
            first = measures.line_beat(number) + part * line.beats / parts
            seconds = measures.time_at(first + line.beats / parts) - measures.time_at(first)
            wanted = round(seconds * parts / line.beats * 1e6)
            if wanted != tempo:
                tempo = wanted
                message = mido.MetaMessage("set_tempo", tempo=min(max(tempo, 1), (1 << 24) - 1))
                messages.append((pulse + part * line.beats * PULSES // parts, 1, message))
        messages.append((pulse, 2, mido.MetaMessage("marker", text=f"measure {line.measure}")))
        pulse += line.beats * PULSES
        starts.append(pulse)
        assert after.time_s > line.time_s
    for mark in marks:
        measure = min(int(mark.begin // record.beats), record.measures)
        beats = measures.lines[measure].beats
        at = starts[measure] + round((mark.begin / record.beats - measure) * beats * PULSES)
        text = _plain(mark.words).encode("latin-1", "replace").decode("latin-1")
        messages.append((at, 3, mido.MetaMessage("marker", text=text[:200])))
    return _file(title, messages, pulse)


def _lead_in(measures: MeasureMap, messages: list[tuple[int, int, Any]]) -> int:
    """Add the time before the first measure, and return its pulses."""
    seconds = measures.lines[0].time_s
    if seconds < 1e-6:
        return 0
    beats = max(round(seconds / 2.0), 1)
    messages.append((0, 0, mido.MetaMessage("time_signature", numerator=1, denominator=4)))
    messages.append((0, 1, mido.MetaMessage("set_tempo", tempo=round(seconds / beats * 1e6))))
    return beats * PULSES


def _file(title: str, messages: list[tuple[int, int, Any]], end: int) -> bytes:
    name = title.encode("latin-1", "replace").decode("latin-1")
    track = mido.MidiTrack([mido.MetaMessage("track_name", name=name)])
    last = 0
    for pulse, _, message in sorted(messages, key=lambda one: one[:2]):
        track.append(message.copy(time=pulse - last))
        last = pulse
    track.append(mido.MetaMessage("end_of_track", time=max(end - last, 0)))
    out = io.BytesIO()
    mido.MidiFile(type=0, ticks_per_beat=PULSES, tracks=[track]).save(file=out)
    return out.getvalue()
