"""The part of a live show that is on MIDI: a port that is listened to, and one that the beat is sent to."""

from typing import TYPE_CHECKING, Any, Final

from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.clock.midi_clock import MidiClock
from live.clock.source import Clock
from live.clock.time_code import TimeCodeClock
from live.control.events import ControlEvent
from live.control.midi_clock_process import MidiClockProcess
from live.control.midi_input import MidiInput
from live.control.midi_map import MidiMap
from live.control.midi_ports import Direction, MidiUnavailable, UnknownPort, find_port
from live.show.core import Show
from live.show.patch import Patch
from live.show.venue import Venue, VenueMidi

if TYPE_CHECKING:
    from live.cli.wish import Wish

OFF: Final = "off"


class OnMidi:
    """Between the show and its MIDI ports. Thread: the one that runs the show."""

    def __init__(self, show: Show, listens: MidiInput | None, sends: MidiClockProcess | None) -> None:
        self._show = show
        self._listens = listens
        self._sends = sends

    def start(self) -> None:
        """Open the ports; those that are not there are waited for."""
        for part in (self._listens, self._sends):
            if part is not None:
                part.start()

    def stop(self) -> None:
        """Close them; listeners of the clock are told to stop."""
        for part in (self._listens, self._sends):
            if part is not None:
                part.stop()

    def take_patch(self, patch: Patch) -> None:
        """Notes and controllers do what another patch says from now on."""
        if self._listens is not None:
            self._listens.take_map(MidiMap(patch.midi.bindings))

    def frame(self) -> None:
        """After each frame: how the show runs."""
        timeline = self._show.timeline
        if self._sends is not None:
            self._sends.follow(timeline)
        if self._listens is not None:
            self._listens.beats_per_measure = timeline.beats_per_measure

    def status(self) -> dict[str, Any]:
        """For the status line."""
        parts = (("in", self._listens), ("out", self._sends))
        return {name: part.facts() for name, part in parts if part is not None}

    def problem(self) -> str:
        """What a person should know."""
        parts = (self._listens, self._sends)
        told = (f"MIDI {part.name!r}: {part.problem}" for part in parts if part is not None and part.problem)
        return next(told, "")

    def refusal(self) -> str:
        """What was played and refused last."""
        refused = None if self._listens is None else self._listens.last_rejection
        return "" if refused is None else f"MIDI: {refused}"


def make_midi(wish: "Wish", show: Show, venue: Venue | None, inbox: Inbox[ControlEvent], clock: Clock) -> OnMidi | None:
    """What `--midi` and `--midi-clock-out`, the venue or the patch ask for, to be started; None if nothing.

    A port that is named on the command line must be there: PersonError, which lists those that are.
    """
    section = show.patch.midi
    of_venue = VenueMidi() if venue is None else venue.midi
    source = _named("input", "--midi", wish.midi, of_venue.input, section.input)
    target = _named("output", "--midi-clock-out", wish.midi_clock_out, of_venue.clock_out, section.clock_out)
    if source is None and target is None:
        return None
    metre, tempo = show.timeline.beats_per_measure, show.follower.tempo
    listens = None
    if source is not None:
        listens = MidiInput(
            source,
            inbox,
            clock,
            decoder=MidiClock(beats_per_measure=metre, tempo=tempo),
            time_code=TimeCodeClock(
                tempo=section.time_code_bpm or show.patch.clock.bpm,
                offset=section.time_code_offset_s,
                beats_per_measure=metre,
            ),
            midi_map=MidiMap(section.bindings),
        )
    return OnMidi(show, listens, None if target is None else MidiClockProcess(target, clock))


def _named(
    direction: Direction, option: str, wished: str | None, of_venue: str | None, of_patch: str | None
) -> str | None:
    """The port that is asked for, its whole name where it is there."""
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
