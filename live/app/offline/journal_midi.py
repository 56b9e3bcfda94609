"""Export of a journal as a MIDI file: tempo track, events as markers, and steps as notes."""

import io
from dataclasses import dataclass, field
from typing import Any, Final

import mido
import numpy as np

from live.clock.ticks import TICK
from live.control.events.audio import MusicHeard
from live.control.events.event_json import event_to_json
from live.control.events.events import BeatHeard, MocapFrame, NotesHeard, TrackerMoved
from live.show.journal.journal_reader import Journal, JournalLine
from live.show.journal.replay import Replayer, ReplayStart

PULSES: Final = 480
"""Pulses per quarter note, which is a beat."""
FIRST_NOTE: Final = 36
"""The note of the library's first step; the others follow."""
CONTINUOUS_EVENTS: Final = (BeatHeard, MusicHeard, NotesHeard, MocapFrame, TrackerMoved)
"""Continuous events, which get no marker."""
Message = tuple[int, Any]


@dataclass(slots=True)
class _Score:
    """Messages and steps of a run, by pulses since its first measure."""

    tempo: list[Message] = field(default_factory=list)
    markers: list[Message] = field(default_factory=list)
    groups: dict[int, list[tuple[int, int, int]]] = field(default_factory=dict)
    """First pulse, last pulse and step for each group."""


def journal_to_midi(journal: Journal, start: ReplayStart) -> bytes:
    """Replay the journal and return its measures, events and steps as a MIDI file.

    A measure's tempo is its mean from first to last beat; the beats within it are even in the file.
    """
    score = _Score()
    show, origin = start.show, start.tick * TICK
    waiting: list[JournalLine] = []
    running = Replayer(show, _collect_events(journal, waiting), tick=start.tick, compare=False)
    begun, pulse = show.timeline.beat_at(origin), 0
    while not running.ended and running.damaged is None:
        number, line = show.span.number, show.span.end
        running.advance(running.tick + 1)
        if show.span.number == number and not running.ended:
            continue
        beat = show.timeline.beat_at(show.time) if show.span.number == number else line
        time = max(show.timeline.time_at(beat), origin + 1e-3)
        beats = max(1, round(beat - begun))
        _add_measure(score, pulse, beats, time - origin)
        over = [line for line in waiting if line.tick <= running.tick]
        del waiting[: len(over)]  # the line after them has already been read
        _add_markers(score, over, pulse, origin, time, beats)
        _add_steps(score, show, pulse, pulse + beats * PULSES)
        pulse, begun, origin = pulse + beats * PULSES, beat, time
    return _file(score, show.patch.name, [group.name for group in show.patch.group], show.graph.library.steps)


def _collect_events(journal: Journal, waiting: list[JournalLine]) -> Any:
    for line in journal.lines_with_damage():
        if line.event is not None and not isinstance(line.event, CONTINUOUS_EVENTS):
            waiting.append(line)
        yield line


def _add_measure(score: _Score, pulse: int, beats: int, seconds: float) -> None:
    tempo = min(max(round(seconds / beats * 1e6), 1), (1 << 24) - 1)
    score.tempo.append((pulse, mido.MetaMessage("set_tempo", tempo=tempo)))
    score.tempo.append((pulse, mido.MetaMessage("time_signature", numerator=beats, denominator=4)))


def _add_markers(score: _Score, lines: list[JournalLine], pulse: int, begin: float, end: float, beats: int) -> None:
    for line in lines:
        if line.event is None:
            continue
        values = event_to_json(line.event)
        kind, source = values.pop("type"), values.pop("source")
        share = (values.pop("time") - begin) / max(end - begin, 1e-9)
        told = " ".join(str(value) for value in values.values() if value not in ("", 0.0, False))
        text = f"{kind} {told} ({source})".encode("ascii", "replace").decode()[:120]
        place = pulse + round(min(max(share, 0.0), 1.0) * beats * PULSES)
        score.markers.append((place, mido.MetaMessage("marker", text=text)))


def _add_steps(score: _Score, show: Any, begin: int, end: int) -> None:
    """Add the most frequent step of each group in the past measure."""
    past = show.dancers.past.node
    for group in range(len(show.patch.group)):
        node = past[(show.group == group) & (past >= 0)]
        if len(node):
            step = int(np.bincount(show.graph.library.node_step[node]).argmax())
            score.groups.setdefault(group, []).append((begin, end, step))


def _file(score: _Score, name: str, groups: list[str], steps: tuple[str, ...]) -> bytes:
    file = mido.MidiFile(ticks_per_beat=PULSES)
    file.tracks.append(_track(name, score.tempo))
    file.tracks.append(_track("events", score.markers))
    for group, danced in sorted(score.groups.items()):
        messages: list[Message] = []
        for begin, end, step in danced:
            note, channel = min(FIRST_NOTE + step, 127), group % 16
            messages.append((begin, mido.MetaMessage("text", text=steps[step].encode("ascii", "replace").decode())))
            messages.append((begin, mido.Message("note_on", note=note, channel=channel, velocity=80)))
            messages.append((end, mido.Message("note_off", note=note, channel=channel)))
        file.tracks.append(_track(groups[group], messages))
    out = io.BytesIO()
    file.save(file=out)
    return out.getvalue()


def _track(name: str, messages: list[Message]) -> Any:
    """Return a track with messages at pulses; note-offs come first at each pulse."""
    track = mido.MidiTrack([mido.MetaMessage("track_name", name=name.encode("ascii", "replace").decode())])
    last = 0
    for pulse, message in sorted(messages, key=lambda one: (one[0], one[1].type != "note_off")):
        track.append(message.copy(time=pulse - last))
        last = pulse
    return track
