"""Reader and player for Standard MIDI Files.

Files are read by mido; any failure becomes a PersonError. A beat is a quarter note, and the tempo map is converted to
MIDI clock. The player has no clock or thread: at each tick it returns the events up to that time. The same song
therefore gives the same events at the same ticks, live, in a film, and at any frame rate.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import mido

from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.midi.midi_clock import CLOCK, PULSES_PER_BEAT, START, STOP, MidiClock
from live.clock.note_energy import NoteEnergy
from live.control.events.events import ControlEvent, SetMetre
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_decoder import MidiEventDecoder
from live.control.midi.midi_mapping import MidiMap

MAX_BYTES: Final = 16_000_000
MAX_MESSAGES: Final = 1_000_000
MAX_SECONDS: Final = 24 * 3600.0
"""Maximum length of a song [s]."""
OPTION: Final = "--midi-file"


@dataclass(frozen=True, slots=True)
class MidiSong:
    """A song as (time [s] from its start, bytes) in order, including start, 24 clock pulses per beat, and stop."""

    name: str
    messages: tuple[tuple[float, bytes], ...]
    metres: tuple[tuple[float, int], ...]
    """(time [s], quarter notes per measure from then on)."""
    tempo: float
    """Initial tempo [bpm]."""
    length: float
    """Time of the end of its last beat [s]."""


class _TempoMap:
    """Tempo map: converts ticks to seconds; ticks must not decrease between calls."""

    def __init__(self, ticks_per_beat: int, changes: list[tuple[int, int]]) -> None:
        """`changes`: (tick, microseconds of a quarter note) in order."""
        self._per_beat, self._changes = ticks_per_beat, changes
        self._next, self._tick, self._time, self._quarter = 0, 0.0, 0.0, 500_000

    def seconds(self, tick: float) -> float:
        """Return the time of a tick [s]."""
        while self._next < len(self._changes) and self._changes[self._next][0] <= tick:
            at, quarter = self._changes[self._next]
            self._time += (at - self._tick) * self._quarter / self._per_beat * 1e-6
            self._tick, self._quarter, self._next = float(at), quarter, self._next + 1
        return self._time + (tick - self._tick) * self._quarter / self._per_beat * 1e-6


def read_song(path: Path) -> MidiSong:
    """Return the song in a Standard MIDI File of format 0 or 1; PersonError if it is invalid or too long."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{OPTION} {path}: larger than {MAX_BYTES // 1_000_000} MB")
        file = mido.MidiFile(path, clip=True)
        per_beat = int(file.ticks_per_beat)
        if per_beat <= 0:
            raise PersonError(f"{OPTION} {path}: counts in frames of time code", "export it in ticks of a quarter note")
        if file.type == 2:
            raise PersonError(f"{OPTION} {path}: holds several songs (format 2)", "export it as format 0 or 1")
        track: list[Any] = mido.merge_tracks(file.tracks)
    except OSError as error:
        raise PersonError(f"{OPTION} {path}: {error.strerror or error or 'it ends too early'}") from None
    except PersonError:
        raise
    except Exception as error:  # mido raises many kinds for a broken file
        raise PersonError(f"{OPTION} {path}: not a MIDI file that can be read: {type(error).__name__}") from None
    return _song(path.name, track, per_beat, f"{OPTION} {path}")


def _song(name: str, track: list[Any], per_beat: int, where: str) -> MidiSong:
    if len(track) > MAX_MESSAGES:
        raise PersonError(f"{where}: more than {MAX_MESSAGES} messages")
    ticks, tick = [], 0
    for message in track:
        tick += message.time
        ticks.append(tick)
    changes = [(at, one.tempo) for at, one in zip(ticks, track, strict=True) if one.type == "set_tempo" and one.tempo]
    last = max((at for at, one in zip(ticks, track, strict=True) if not one.is_meta), default=0)
    beats = math.ceil(last / per_beat)
    length = _TempoMap(per_beat, changes).seconds(beats * per_beat)
    if not 0.0 < length <= MAX_SECONDS or beats * PULSES_PER_BEAT > MAX_MESSAGES:
        raise PersonError(f"{where}: {length:.0f} s long", "a song needs notes, and may last a day at most")
    time_of = _TempoMap(per_beat, changes)
    played: list[tuple[float, bytes]] = []
    metres = []
    for at, one in zip(ticks, track, strict=True):
        if one.type == "time_signature" and one.denominator == 4:
            metres.append((time_of.seconds(at), int(one.numerator)))
        elif not one.is_meta and not one.is_realtime and at <= last:
            played.append((time_of.seconds(at), bytes(one.bytes())))
    pulses = _TempoMap(per_beat, changes)
    clock = [(pulses.seconds(n * per_beat / PULSES_PER_BEAT), bytes((CLOCK,))) for n in range(beats * PULSES_PER_BEAT)]
    stop = (length, bytes((STOP,)))
    messages = sorted([(0.0, bytes((START,))), *clock, *played, stop], key=lambda row: row[0])  # stable: start, clock
    first = next((quarter for at, quarter in changes if at == 0), 500_000)
    return MidiSong(name, tuple(messages), tuple(metres), 60e6 / first, length)


class MidiSongPlayer:
    """Plays one song once from the start of the show, with a port's decoders and map. Use from the show's thread."""

    def __init__(self, song: MidiSong, bindings: Sequence[Binding], *, beats_per_measure: int) -> None:
        """`bindings`: the map for its notes and controllers; no default bindings, since the song's pedals are music."""
        self.song = song
        self._inbox: EventQueue[ControlEvent] = EventQueue(capacity=1 << 20)
        self._map = MidiMap(bindings)
        self._notes = NoteEnergy(tempo=song.tempo)
        self._decoder = MidiEventDecoder(
            self._inbox,
            midi_map=self._map,
            notes=self._notes,
            decoder=MidiClock(beats_per_measure=beats_per_measure, tempo=song.tempo),
        )
        self._next = self._metres = 0
        self._time = 0.0

    def set_bindings(self, bindings: Sequence[Binding]) -> None:
        """Replace the bindings."""
        self._map.set_bindings(bindings)

    def events_until(self, until: float, *, tempo: float, beats_per_measure: int) -> list[ControlEvent]:
        """Return the events up to `until` [s of the show], given the show's current tempo and metre."""
        self._notes.tempo = tempo
        self._decoder.beats_per_measure = beats_per_measure
        song, found = self.song, list[ControlEvent]()
        while self._metres < len(song.metres) and song.metres[self._metres][0] <= until:
            time, beats = song.metres[self._metres]
            self._metres += 1
            if beats != beats_per_measure and 2 <= beats <= 12:
                found.append(SetMetre(time=time, source="midi", beats=beats))
                beats_per_measure = self._decoder.beats_per_measure = beats
        while self._next < len(song.messages) and song.messages[self._next][0] <= until:
            time, message = song.messages[self._next]
            self._next += 1
            self._decoder.decode(message, time)
        self._time = until
        self._decoder.advance(until)
        return found + self._inbox.drain()

    def facts(self) -> dict[str, Any]:
        """Return figures for the status line."""
        return {
            "file": self.song.name,
            "at_s": round(min(self._time, self.song.length), 2),
            "length_s": round(self.song.length, 2),
        }
