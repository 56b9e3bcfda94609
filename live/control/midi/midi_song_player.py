"""MidiSongPlayer: a song's messages through the same decoders and map as those of a port, by the show's time alone.

It has no clock and no thread: at each tick it is asked for what the song does until then, so that the same song gives
the same events at the same ticks, live, in a film, and at any frame rate.
"""

from collections.abc import Sequence
from typing import Any

from live.base.inbox import Inbox
from live.clock.midi.midi_clock import MidiClock
from live.clock.note_energy import NoteEnergy
from live.control.events.events import ControlEvent, SetMetre
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_decoder import MidiDecoding
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_song import MidiSong


class MidiSongPlayer:
    """Plays one song once, from the beginning of the show. Thread: the show's."""

    def __init__(self, song: MidiSong, bindings: Sequence[Binding], *, beats_per_measure: int) -> None:
        """`bindings`: what its notes and controllers work; pedals of the song are music, and work nothing else."""
        self.song = song
        self._inbox: Inbox[ControlEvent] = Inbox(capacity=1 << 20)
        self._map = MidiMap(bindings)
        self._notes = NoteEnergy(tempo=song.tempo)
        self._decodes = MidiDecoding(
            self._inbox,
            midi_map=self._map,
            notes=self._notes,
            decoder=MidiClock(beats_per_measure=beats_per_measure, tempo=song.tempo),
        )
        self._next = self._metres = 0
        self._time = 0.0

    def take(self, bindings: Sequence[Binding]) -> None:
        """Its notes work these from now on."""
        self._map.take(bindings)

    def due(self, until: float, *, tempo: float, beats_per_measure: int) -> list[ControlEvent]:
        """What it does up to `until` [s of the show], which now has this tempo and metre."""
        self._notes.tempo = tempo
        self._decodes.beats_per_measure = beats_per_measure
        song, found = self.song, list[ControlEvent]()
        while self._metres < len(song.metres) and song.metres[self._metres][0] <= until:
            time, beats = song.metres[self._metres]
            self._metres += 1
            if beats != beats_per_measure and 2 <= beats <= 12:
                found.append(SetMetre(time=time, source="midi", beats=float(beats)))
                beats_per_measure = self._decodes.beats_per_measure = beats
        while self._next < len(song.messages) and song.messages[self._next][0] <= until:
            time, message = song.messages[self._next]
            self._next += 1
            self._decodes.decode(message, time)
        self._time = until
        self._decodes.look(until)
        return found + self._inbox.drain()

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return {
            "file": self.song.name,
            "at_s": round(min(self._time, self.song.length), 2),
            "length_s": round(self.song.length, 2),
        }
