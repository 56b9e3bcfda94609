"""Services for MIDI: input, feedback output and clock output, and a MIDI file as tempo map and cue track."""

import queue
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from live.app.bridges import installed_bridges
from live.app.services.midi_learning import MidiLearnSession, MidiMapWriter
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.midi.midi_clock import MidiClock
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
from live.control.midi.midi_ports import UnknownPort, find_port, open_port
from live.control.midi.midi_streams import SCHEMES, Direction, Opener
from live.control.midi.midi_system import MidiUnavailable
from live.control.registry.control import ROLE_RANKS
from live.control.registry.registry import Changes, Values
from live.show.engine import Engine
from live.show.patch.midi_bindings import bindings_of
from live.show.patch.patch import Patch
from live.show.show import Show
from live.show.venue.venue import Venue, VenueMidi

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions


OFF: Final = "off"


class MidiService:
    """Connects the show to its MIDI ports. Thread: the show's."""

    def __init__(
        self,
        show: Show,
        clock: Clock,
        patch: Path,
        *,
        midi_input: MidiInput | None = None,
        midi_map: MidiMap | None = None,
        feedback_output: MidiOutput | None = None,
        clock_output: MidiClockProcess | None = None,
        values: Values | None = None,
    ) -> None:
        """`midi_input`: read through `midi_map`; `feedback_output`: for `values`; `clock_output`: for clock pulses.

        `patch`: the patch's file, next to which learned bindings are saved.
        """
        self._show, self._clock = show, clock
        self._input, self._output, self._clock_output = midi_input, feedback_output, clock_output
        self._values = values or Values()
        self._map = midi_map or MidiMap((), self._values)
        self._feedback = MidiFeedback(self._map, self._values)
        self._opened = 0
        self._save_result = ""
        self._learned: queue.SimpleQueue[Binding] = queue.SimpleQueue()
        self.learning = MidiLearnSession(show.patch.midi, midi_input, MidiMapWriter(patch, self._on_saved))
        if midi_input is not None:
            midi_input.on_learned = self._learned.put
        self._update_bindings()

    def start(self) -> None:
        """Open the ports; missing ports are opened when they appear."""
        for part in (self._input, self._output, self._clock_output):
            if part is not None:
                part.start()

    def stop(self) -> None:
        """Close the ports; the clock output sends a stop."""
        for part in (self._input, self._output, self._clock_output):
            if part is not None:
                part.stop()

    def update_patch(self, patch: Patch) -> None:
        """Use the MIDI map of another patch."""
        self.learning.update_patch(patch.midi)
        self._update_bindings()

    def handle(self, event: ControlEvent) -> None:
        """Handle events that concern MIDI learn."""
        if isinstance(event, LearnMidi | ForgetMidi):
            self.learning.handle(event, self._update_bindings)

    def publish(self, changes: Changes) -> None:
        """Update values that have changed in the show."""
        self._values.update(changes)
        self._feedback.mark_changed(changes)

    def frame(self) -> None:
        """Pass on the beat, learned bindings and feedback, after each frame."""
        timeline = self._show.timeline
        if self._clock_output is not None:
            self._clock_output.set_timeline(timeline)
        if self._input is not None:
            self._input.beats_per_measure = timeline.beats_per_measure
            if self._input.notes is not None:
                self._input.notes.tempo = timeline.tempo
        while not self._learned.empty():
            self.learning.add_learned(self._learned.get())
            self._update_bindings()
        if self._output is not None:
            self._send_feedback(self._output)

    def _send_feedback(self, output: MidiOutput) -> None:
        """Send feedback that has changed; all of it after the port was opened."""
        if output.opened != self._opened:
            self._opened = output.opened
            self._feedback.resend_all()
        if not output.connected:
            return
        now = self._clock.now()
        for message in self._feedback.due_messages(now):
            if self._input is not None:
                self._input.echoes[message] = now
            output.send(message)

    def _update_bindings(self) -> None:
        bindings = self.learning.bindings
        self._map.set_bindings(bindings)
        self._feedback.set_bindings(bindings)

    def _on_saved(self, words: str) -> None:
        self._save_result = words

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        parts = (("in", self._input), ("told", self._output), ("out", self._clock_output))
        facts: dict[str, Any] = {name: part.status() for name, part in parts if part is not None}
        return facts | {
            "learns": self.learning.pending_control,
            "said": self.learning.last_change,
            "kept": self._save_result,
        }

    def problem(self) -> str:
        """Return the first port's problem in words; empty if there is none."""
        parts = (self._input, self._output, self._clock_output)
        told = (f"MIDI {part.name!r}: {part.problem}" for part in parts if part is not None and part.problem)
        return next(told, "")

    def prompt(self) -> str:
        """Return the overlay's prompt while a control is learned; else empty."""
        address = self.learning.pending_control
        return f"MIDI: move the controller for {address} (Esc cancels)" if address else ""

    def last_change(self) -> str:
        """Return the last change of the map and whether it was saved, in words."""
        return "; ".join(words for words in (self.learning.last_change, self._save_result) if words)

    def refusal(self) -> str:
        """Return the last refused input or request to learn, in words."""
        if self.learning.refused:
            return self.learning.refused
        refused = None if self._input is None else self._input.last_rejection
        return "" if refused is None else f"MIDI: {refused}"


def make_midi(
    options: "LaunchOptions",
    show: Show,
    venue: Venue | None,
    inbox: EventQueue[ControlEvent],
    clock: Clock,
    patch: Path,
) -> MidiService:
    """Return the service for `--midi`, `--midi-out` and `--midi-clock-out`, the venue or the patch, not started.

    It may have no port. `patch`: the patch's file. A port named on the command line must exist: else PersonError,
    which lists the ports.
    """
    section = show.patch.midi
    of_venue = VenueMidi() if venue is None else venue.midi
    bridges = installed_bridges()
    schemes = {**SCHEMES, **bridges.midi_schemes()}
    open_input, open_output = (partial(open_port, way, schemes=schemes) for way in ("input", "output"))
    find = partial(_resolve_port, schemes)
    source = find("input", "--midi", options.midi, of_venue.input, section.input)
    told = find("output", "--midi-out", options.midi_out, of_venue.output, section.output)
    target = find("output", "--midi-clock-out", options.midi_clock_out, of_venue.clock_out, section.clock_out)
    metre, tempo = show.timeline.beats_per_measure, show.follower.tempo
    values = Values()
    midi_map = MidiMap(bindings_of(section), values)
    listens = None
    if source is not None:
        listens = MidiInput(
            source,
            inbox.add_queue(rank=ROLE_RANKS["musician"]),
            clock,
            decoder=MidiClock(beats_per_measure=metre, tempo=tempo),
            clocks=bridges.midi_clocks(show.patch, metre),
            midi_map=midi_map,
            notes=None if options.midi_file is not None else NoteEnergy(tempo=tempo),
            follow_clock=options.midi_file is None,  # else the file leads
            open_by_name=open_input,
        )
    return MidiService(
        show,
        clock,
        patch,
        midi_input=listens,
        midi_map=midi_map,
        feedback_output=None if told is None else MidiOutput(told, clock, open_by_name=open_output),
        clock_output=None if target is None else MidiClockProcess(target, clock),
        values=values,
    )


def _resolve_port(
    schemes: Mapping[str, Opener],
    direction: Direction,
    option: str,
    option_value: str | None,
    of_venue: str | None,
    of_patch: str | None,
) -> str | None:
    """Return the name of the wanted port, in full if it was given on the command line; None for no port."""
    if option_value == OFF:
        return None
    if option_value is None:
        return of_venue or of_patch
    try:
        return find_port(direction, option_value, schemes)
    except (UnknownPort, MidiUnavailable) as error:
        command = "live devices" if isinstance(error, UnknownPort) else "live doctor"
        addresses = ", ".join(f"{scheme}:" for scheme in schemes)
        remedy = f"see `{command}`; addresses begin with {addresses}"
        raise PersonError(f"{option} {option_value!r}: {error}", remedy) from None


class MidiFileService:
    """Plays a MIDI file into a show, live or offline: tempo map and notes. Thread: the show's."""

    def __init__(self, path: Path, show: Show, engine: Engine, *, resume_tick: int = 0) -> None:
        """`resume_tick`: last tick before the show is resumed. Raise PersonError for a file that cannot be options."""
        self._show = show
        song = read_song(path)
        self._player = MidiSongPlayer(song, _bindings(show.patch), beats_per_measure=show.timeline.beats_per_measure)
        if resume_tick:
            self._due((resume_tick + 1) * TICK)  # the engine before has sent these events
        engine.event_sources.append(self._due)

    def update_patch(self, patch: Patch) -> None:
        """Use the MIDI map of another patch."""
        self._player.set_bindings(_bindings(patch))

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
        return self._player.events_until(until, tempo=timeline.tempo, beats_per_measure=timeline.beats_per_measure)


def attach_midi_file(path: Path | None, show: Show, engine: Engine) -> None:
    """Let a MIDI file, if there is one, lead a show that is rendered offline."""
    if path is not None:
        engine.patch_listeners.append(MidiFileService(path, show, engine).update_patch)


def _bindings(patch: Patch) -> tuple[Binding, ...]:
    """Return written and learned bindings; none otherwise, as the default map is for live controllers."""
    return bindings_of(patch.midi) if patch.midi.map or patch.midi.learned else ()
