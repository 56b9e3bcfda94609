"""Decoder from one sender's MIDI messages to events: clocks, notes and mapped controls.

It has no port, thread or clock: messages are passed in with their times, from a port (`MidiInput`) or a file
(`MidiSongPlayer`).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from live.base.event_queue import EventQueue, PriorityQueue
from live.clock.midi.midi_clock import ClockBeat, ClockEvent, ClockState, MessageClock, MidiClock
from live.clock.note_energy import NoteEnergy
from live.control.events.events import BeatHeard, ControlEvent, NotesHeard, SourceChanged
from live.control.midi.channel_messages import MidiAction
from live.control.midi.midi_binding import CONTINUOUS_KINDS, Binding, merge_bindings
from live.control.midi.midi_learn import MidiLearn
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_queue import put_mapped_event
from live.control.registry.rejections import Rejection

ECHO_TIME: Final = 0.06
"""Seconds within which a message sent to a controller may come back."""

BACKGROUND_MESSAGES: Final = frozenset((0xF8, 0xFE))
"""Messages that come all the time: clock and active sensing."""


class MidiEventDecoder:
    """Puts BeatHeard, SourceChanged, NotesHeard and the map's events into the inbox. Use from one thread at a time."""

    def __init__(
        self,
        inbox: EventQueue[ControlEvent] | PriorityQueue[ControlEvent],
        *,
        decoder: MidiClock | None = None,
        clocks: Mapping[str, MessageClock] | None = None,
        midi_map: MidiMap | None = None,
        notes: NoteEnergy | None = None,
        follow_clock: bool = True,
    ) -> None:
        """`inbox`: pass a separate lane if others share the inbox, so that they are not crowded out.

        `clocks`: other clocks made of the messages, by their sources. `follow_clock`: whether clocks are followed; else
        only notes and controllers are.
        """
        self.messages = 0
        self.last_rejection: Rejection | None = None
        """The last refusal of the map."""
        self.decoder = decoder if decoder is not None else MidiClock()
        self._clocks: dict[str, MessageClock] = {"midi": self.decoder, **(clocks or {})}
        self.notes = notes
        self.learning: MidiLearn | None = None
        """The active MIDI learn, or None. May be set from any thread."""
        self.on_learned: Callable[[Binding], None] = lambda _: None
        """Called with the learned binding, on the thread of the messages."""
        self.echoes: dict[bytes, float] = {}
        """Messages sent to the controller, with their times [s]; their echoes are ignored."""
        self._follow_clock = follow_clock
        self._map = midi_map
        self._inbox = inbox

    @property
    def beats_per_measure(self) -> int:
        """Beats per measure; MIDI clock does not carry them."""
        return self.decoder.beats_per_measure

    @beats_per_measure.setter
    def beats_per_measure(self, beats: int) -> None:
        for clock in self._clocks.values():
            clock.beats_per_measure = beats

    def decode(self, message: Sequence[int], time: float) -> None:
        """Decode one message that arrived at `time` [s of the show]."""
        self.messages += 1
        if not message:
            self.decoder.rejected += 1
            return
        if self._follow_clock:
            for source, clock in self._clocks.items():
                self._put(source, clock.receive(message, time))
        if message[0] in BACKGROUND_MESSAGES or (
            self.echoes and time - self.echoes.pop(bytes(message), -ECHO_TIME) < ECHO_TIME
        ):
            return
        if self.notes is not None:
            self.notes.receive(message, time)
            self._put_notes(time)
        if self._map is not None:
            self._apply_actions(self._map, self._map.decoder.decode(message), time)

    def _apply_actions(self, midi_map: MidiMap, played: list[MidiAction], time: float) -> None:
        """Apply actions to the map; while MIDI learn is active, movements go to it instead."""
        learning = self.learning
        if learning is not None and played:
            found = learning.process(played)
            if found is not None:
                self.learning = None
                midi_map.set_bindings(merge_bindings(midi_map.bindings, [found]))  # at once: the movement continues
                self.on_learned(found)
                return
            if played[0].kind in CONTINUOUS_KINDS:
                return
        for binding, made in (made for one in played for made in midi_map.apply(one, time)):
            if isinstance(made, Rejection):
                self.last_rejection = made
            elif isinstance(self._inbox, PriorityQueue):
                put_mapped_event(self._inbox, binding, made)
            else:
                self._inbox.put(made)

    def _put_notes(self, time: float) -> None:
        if self.notes is None:
            return
        told = self.notes.advance(time)
        if told is not None:
            self._inbox.put(
                NotesHeard(
                    time=told.time,
                    source="midi",
                    beats=told.beats,
                    energy=told.energy,
                    density=told.density,
                    chord=told.chord,
                    pitch=told.pitch,
                )
            )

    def advance(self, now: float) -> None:
        """Advance time to `now` without a message, to detect missing clocks."""
        for source, clock in self._clocks.items():
            self._put(source, clock.advance(now))
        self._put_notes(now)

    def _put(self, source: str, news: list[ClockEvent]) -> None:
        for item in news:
            self._inbox.put(to_event(item, source, self.decoder.beats_per_measure))

    def unplugged(self, now: float) -> None:
        """Handle the loss of the sender."""
        for source, clock in self._clocks.items():
            self._put(source, clock.handle_disconnect(now))
        if self.notes is not None:
            self.notes.silence()


def to_event(item: ClockEvent, source: str, beats_per_measure: int) -> ControlEvent:
    """Return a clock decoder's report as an event of the show."""
    if isinstance(item, ClockState):
        return SourceChanged(time=item.time, source=source, state=item.state, detail=item.detail)
    beat: ClockBeat = item
    return BeatHeard(
        time=beat.time,
        source=source,
        beat_time=beat.beat_time,
        period=beat.period,
        confidence=beat.confidence,
        beat=beat.beat,
        beats_per_measure=beats_per_measure if beat.anchored else 0,
        measure=beat.measure,
        jump=beat.jump,
        anchored=beat.anchored,
    )
