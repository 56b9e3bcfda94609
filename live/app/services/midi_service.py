"""Services for MIDI: input, feedback output and clock output, and a MIDI file as tempo map and cue track."""

import queue
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from live.app.services.midi_learning import MidiKeeping, MidiLearning
from live.base.errors import PersonError
from live.base.event_queue import Inbox
from live.clock.midi.midi_clock import MidiClock
from live.clock.midi.time_code import TimeCodeClock
from live.clock.note_energy import NoteEnergy
from live.clock.ticks import TICK
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent, ForgetMidi, LearnMidi
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_clock_process import MidiClockProcess
from live.control.midi.midi_feedback import MidiFeedback, MidiOutput
from live.control.midi.midi_file import MidiSongPlayer, read_song
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_ports import MidiUnavailable, UnknownPort, find_port
from live.control.midi.midi_streams import Direction
from live.control.registry.control import RANKS
from live.control.registry.registry import Changes, Values
from live.show.engine import Engine
from live.show.patch.patch import Patch
from live.show.show import Show
from live.show.venue.venue import Venue, VenueMidi

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions


OFF: Final = "off"


class OnMidi:
    """Connects the show to its MIDI ports. Thread: the show's."""

    def __init__(
        self,
        show: Show,
        clock: Clock,
        patch: Path,
        *,
        listens: MidiInput | None = None,
        midi_map: MidiMap | None = None,
        tells: MidiOutput | None = None,
        sends: MidiClockProcess | None = None,
        values: Values | None = None,
    ) -> None:
        """`listens`: input through `midi_map`; `tells`: feedback output of `values`; `sends`: clock output.

        `patch`: the patch's file, next to which learned bindings are saved.
        """
        self._show, self._clock = show, clock
        self._listens, self._tells, self._sends = listens, tells, sends
        self._values = values or Values()
        self._map = midi_map or MidiMap((), self._values)
        self._feedback = MidiFeedback(self._map, self._values)
        self._opened = 0
        self._kept = ""
        self._moved: queue.SimpleQueue[Binding] = queue.SimpleQueue()
        self.learning = MidiLearning(show.patch.midi, listens, MidiKeeping(patch, self._hear_kept))
        if listens is not None:
            listens.on_learned = self._moved.put
        self._take()

    def start(self) -> None:
        """Open the ports; missing ports are opened when they appear."""
        for part in (self._listens, self._tells, self._sends):
            if part is not None:
                part.start()

    def stop(self) -> None:
        """Close the ports; the clock output sends a stop."""
        for part in (self._listens, self._tells, self._sends):
            if part is not None:
                part.stop()

    def take_patch(self, patch: Patch) -> None:
        """Use the MIDI map of another patch."""
        self.learning.take(patch.midi)
        self._take()

    def act(self, event: ControlEvent) -> None:
        """Handle events that concern MIDI learn."""
        if isinstance(event, LearnMidi | ForgetMidi):
            self.learning.ask(event, self._take)

    def tell(self, changes: Changes) -> None:
        """Update values that have changed in the show."""
        self._values.take(changes)
        self._feedback.changed(changes)

    def frame(self) -> None:
        """Pass on the beat, learned bindings and feedback, after each frame."""
        timeline = self._show.timeline
        if self._sends is not None:
            self._sends.follow(timeline)
        if self._listens is not None:
            self._listens.beats_per_measure = timeline.beats_per_measure
            if self._listens.notes is not None:
                self._listens.notes.tempo = timeline.tempo
        while not self._moved.empty():
            self.learning.learned(self._moved.get())
            self._take()
        if self._tells is not None:
            self._give(self._tells)

    def _give(self, tells: MidiOutput) -> None:
        """Send feedback that has changed; all of it after the port was opened."""
        if tells.opened != self._opened:
            self._opened = tells.opened
            self._feedback.afresh()
        if not tells.connected:
            return
        now = self._clock.now()
        for message in self._feedback.turn(now):
            if self._listens is not None:
                self._listens.echoes[message] = now
            tells.send(message)

    def _take(self) -> None:
        bindings = self.learning.bindings
        self._map.take(bindings)
        self._feedback.take(bindings)

    def _hear_kept(self, words: str) -> None:
        self._kept = words

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        parts = (("in", self._listens), ("told", self._tells), ("out", self._sends))
        facts: dict[str, Any] = {name: part.facts() for name, part in parts if part is not None}
        return facts | {"learns": self.learning.waits_for, "said": self.learning.said, "kept": self._kept}

    def problem(self) -> str:
        """Return the first port's problem in words; empty if there is none."""
        parts = (self._listens, self._tells, self._sends)
        told = (f"MIDI {part.name!r}: {part.problem}" for part in parts if part is not None and part.problem)
        return next(told, "")

    def note(self) -> str:
        """Return the overlay's prompt while a control is learned; else empty."""
        address = self.learning.waits_for
        return f"MIDI: move the controller for {address} (Esc cancels)" if address else ""

    def said(self) -> str:
        """Return the last change of the map and whether it was saved, in words."""
        return "; ".join(words for words in (self.learning.said, self._kept) if words)

    def refusal(self) -> str:
        """Return the last refused input or request to learn, in words."""
        if self.learning.refused:
            return self.learning.refused
        refused = None if self._listens is None else self._listens.last_rejection
        return "" if refused is None else f"MIDI: {refused}"


def make_midi(
    options: "LaunchOptions", show: Show, venue: Venue | None, inbox: Inbox[ControlEvent], clock: Clock, patch: Path
) -> OnMidi:
    """Return the service for `--midi`, `--midi-out` and `--midi-clock-out`, the venue or the patch, not started.

    It may have no port. `patch`: the patch's file. A port named on the command line must exist: else PersonError,
    which lists the ports.
    """
    section = show.patch.midi
    of_venue = VenueMidi() if venue is None else venue.midi
    source = _named("input", "--midi", options.midi, of_venue.input, section.input)
    told = _named("output", "--midi-out", options.midi_out, of_venue.output, section.output)
    target = _named("output", "--midi-clock-out", options.midi_clock_out, of_venue.clock_out, section.clock_out)
    metre, tempo = show.timeline.beats_per_measure, show.follower.tempo
    values = Values()
    midi_map = MidiMap(section.bindings, values)
    listens = None
    if source is not None:
        listens = MidiInput(
            source,
            inbox.lane(rank=RANKS["musician"]),
            clock,
            decoder=MidiClock(beats_per_measure=metre, tempo=tempo),
            time_code=TimeCodeClock(
                tempo=section.time_code_bpm or show.patch.clock.bpm,
                offset=section.time_code_offset_s,
                beats_per_measure=metre,
            ),
            midi_map=midi_map,
            notes=None if options.midi_file is not None else NoteEnergy(tempo=tempo),
            clocked=options.midi_file is None,  # else the file leads
        )
    return OnMidi(
        show,
        clock,
        patch,
        listens=listens,
        midi_map=midi_map,
        tells=None if told is None else MidiOutput(told, clock),
        sends=None if target is None else MidiClockProcess(target, clock),
        values=values,
    )


def _named(
    direction: Direction, option: str, wished: str | None, of_venue: str | None, of_patch: str | None
) -> str | None:
    """Return the name of the wanted port, in full if it was given on the command line; None for no port."""
    if wished == OFF:
        return None
    if wished is None:
        return of_venue or of_patch
    try:
        return find_port(direction, wished)
    except UnknownPort as error:
        raise PersonError(f"{option} {wished!r}: {error}", "see `live devices`") from None
    except MidiUnavailable as error:
        raise PersonError(f"{option} {wished!r}: {error}", "see `live doctor`") from None


class MidiFilePart:
    """Plays a MIDI file into a show, live or offline: tempo map and notes. Thread: the show's."""

    def __init__(self, path: Path, show: Show, engine: Engine, *, begun: int = 0) -> None:
        """`begun`: the last tick before the show is resumed. Raise PersonError for a file that cannot be options."""
        self._show = show
        song = read_song(path)
        self._player = MidiSongPlayer(song, _bindings(show.patch), beats_per_measure=show.timeline.beats_per_measure)
        if begun:
            self._due((begun + 1) * TICK)  # the engine before has sent these events
        engine.timed.append(self._due)
        engine.patched.append(self.take_patch)

    def take_patch(self, patch: Patch) -> None:
        """Use the MIDI map of another patch."""
        self._player.take(_bindings(patch))

    def start(self) -> None:
        """Do nothing: there is no port."""

    def stop(self) -> None:
        """Do nothing: there is no port."""

    def frame(self) -> None:
        """Do nothing: events are due by tick, not by frame."""

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return self._player.facts()

    def _due(self, until: float) -> list[ControlEvent]:
        timeline = self._show.timeline
        return self._player.due(until, tempo=timeline.tempo, beats_per_measure=timeline.beats_per_measure)


def play_file(path: Path | None, show: Show, engine: Engine) -> None:
    """Let a MIDI file, if there is one, lead a show that is rendered offline."""
    if path is not None:
        MidiFilePart(path, show, engine)


def _bindings(patch: Patch) -> tuple[Binding, ...]:
    """Return written and learned bindings; none otherwise, as the default map is for live controllers."""
    return patch.midi.bindings if patch.midi.map or patch.midi.learned else ()
