"""MIDI learning: the patch keeps learned controls, comments stay, and edits and reloads do not conflict."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from live.app.services.midi_service import MidiService
from live.app.window_operator import OperatorInput
from live.base.event_queue import EventQueue
from live.clock.note_energy import NoteEnergy
from live.clock.time_source import ManualClock
from live.control.events import events
from live.control.events.events import ControlEvent, ForgetMidi, LearnMidi
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.registry.control import ArgumentValue
from live.control.registry.registry import Values
from live.show.patch.hot_reload import file_stamp
from live.show.patch.midi_bindings import bindings_of
from live.show.patch.patch_reader import PatchError, read_patch
from live.show.patch.patch_search_path import learned_path
from tests.show.made_show import PATCH, made_show

WRITTEN = """
[[midi.map]]   # mine
cc = 7
control = "/dance/clock/tempo"
[[midi.map]]
note = 50
control = "/dance/go"
"""


class FakeFeedbackOutput:
    """A controller that records the feedback sent to it."""

    def __init__(self) -> None:
        self.told: list[bytes] = []
        self.connected, self.opened = "pads", 1
        self.send = self.told.append


class MidiShow:
    """A show on MIDI without a port, with its patch on disk."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "mine.toml"
        self.path.write_text(PATCH + WRITTEN)
        self.clock = ManualClock(5.0)
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        self.show = made_show(WRITTEN)
        values = Values()
        midi_map = MidiMap((), values)
        self.listens = MidiInput("box", self.inbox, self.clock, midi_map=midi_map, notes=NoteEnergy())
        self.tells = FakeFeedbackOutput()
        self.midi = MidiService(
            self.show, self.clock, self.path,
            midi_input=self.listens, midi_map=midi_map, feedback_output=cast(Any, self.tells), values=values,
        )  # fmt: skip

    def learn(self, address: str, given: str = "") -> None:
        self.midi.handle(
            LearnMidi(
                time=0.0,
                source="osc",
                address=address,
                **dict(zip(("first", "second", "third", "fourth"), given.splitlines(), strict=False)),
            )
        )

    def forget(self, address: str) -> None:
        self.midi.handle(ForgetMidi(time=0.0, source="osc", address=address))

    def play(self, *messages: tuple[int, ...]) -> list[ControlEvent]:
        for message in messages:
            self.listens.decode(message, self.clock.now())
        self.midi.frame()
        self.midi.learning._writer.wait()
        return [event for event in self.inbox.drain() if not isinstance(event, events.NotesHeard)]

    def reload(self) -> None:
        """Update from the patch file, as after a hot reload."""
        self.midi.update_patch(read_patch(self.path))


@pytest.fixture
def midi_show(tmp_path: Path) -> MidiShow:
    return MidiShow(tmp_path)


def test_moved_controller_is_learned_and_saved_beside_patch(midi_show: MidiShow) -> None:
    before = file_stamp(midi_show.path)
    assert [type(event) for event in midi_show.play((0x90, 50, 1))] == [events.Go]
    midi_show.learn("/dance/motion/larger", "front")
    assert "/dance/motion/larger" in midi_show.midi.prompt()
    (moved,) = midi_show.play((0xB0, 7, 1), (0xB0, 7, 9), (0xB0, 7, 0))  # it goes on moving before the next frame
    assert isinstance(moved, events.SetParameter)
    assert midi_show.midi.prompt() == ""
    (moved,) = midi_show.play((0xB0, 7, 127))
    assert isinstance(moved, events.SetParameter)
    assert (moved.value, moved.group) == ((0.5,), "front")
    patch = read_patch(midi_show.path)
    assert [line.control for line in patch.midi.learned] == ["/dance/motion/larger"]
    assert [one.control for one in bindings_of(patch.midi)] == ["/dance/go", "/dance/motion/larger"]
    assert bindings_of(patch.midi) == midi_show.midi.learning.bindings
    assert file_stamp(midi_show.path) != before  # so the watched patch is read anew
    assert midi_show.path.read_text() == PATCH + WRITTEN


def test_reloaded_patch_keeps_controls_learned_meanwhile(midi_show: MidiShow) -> None:
    midi_show.learn("/dance/blackout")
    midi_show.play((0x90, 36, 1))
    old = read_patch(midi_show.path)
    midi_show.learn("/dance/spread")
    midi_show.play((0x90, 37, 1))
    midi_show.midi.update_patch(old)  # it was on its way
    assert [type(event) for event in midi_show.play((0x90, 36, 1), (0x90, 37, 1))] == [
        events.Blackout,
        events.PlaceElement,
    ]
    midi_show.reload()
    assert midi_show.midi.learning._added == []
    assert [type(event) for event in midi_show.play((0x90, 36, 1), (0x90, 37, 1))] == [
        events.Blackout,
        events.PlaceElement,
    ]
    midi_show.forget("/dance/spread")
    midi_show.midi.update_patch(old)
    assert [type(event) for event in midi_show.play((0x90, 36, 1), (0x90, 37, 1))] == [events.Blackout]
    midi_show.reload()
    learned_path(midi_show.path).unlink()  # by the person's hand
    midi_show.reload()
    assert midi_show.play((0x90, 36, 1)) == []


def test_comments_and_handwritten_entries_are_kept(midi_show: MidiShow) -> None:
    text = '# my pads\n[[midi.learned]]\nnote = 40  # top left\ncontrol = "/dance/go"\n\n'
    text += '[[midi.learned]]\nnote = 41\ncontrol = "/dance/clear"\n'
    learned_path(midi_show.path).write_text(text)
    midi_show.reload()
    midi_show.learn("/dance/blackout")
    midi_show.play((0x93, 44, 1))
    now = learned_path(midi_show.path).read_text()
    assert now.startswith(text)
    midi_show.learn("/dance/panic")
    midi_show.play((0x93, 44, 1))  # the same pad: it does one thing
    patch = read_patch(midi_show.path)
    assert [line.control for line in patch.midi.learned] == ["/dance/go", "/dance/clear", "/dance/panic"]
    for address in ("/dance/panic", "/dance/clear"):
        midi_show.forget(address)
        midi_show.midi.learning._writer.wait()
    assert learned_path(midi_show.path).read_text().strip() == text.partition("\n\n")[0]


def test_invalid_learn_and_forget_requests_are_refused(midi_show: MidiShow) -> None:
    midi_show.learn("/dance/nowhere")
    assert "no control is called" in midi_show.midi.refusal()
    midi_show.learn("/dance/clock/tempo")
    assert midi_show.midi.refusal() == ""
    midi_show.learn("")
    assert midi_show.midi.prompt() == ""
    assert len(midi_show.play((0xB0, 7, 1), (0xB0, 7, 60))) == 2  # the patch's own map again
    midi_show.forget("/dance/clock/tempo")
    assert "the patch's own map" in midi_show.midi.refusal()
    midi_show.forget("/dance/panic")
    assert "nothing was learned" in midi_show.midi.refusal()
    deaf = MidiService(midi_show.show, midi_show.clock, midi_show.path)
    deaf.handle(LearnMidi(time=0.0, source="osc", address="/dance/go"))
    assert "--midi NAME" in deaf.refusal()


def test_unsaved_learning_is_reported_and_show_continues(midi_show: MidiShow) -> None:
    learned_path(midi_show.path).write_text("[[midi.learned]]\nnote = 400\n")
    midi_show.learn("/dance/blackout")
    midi_show.play((0x90, 36, 1))
    assert "NOT SAVED" in midi_show.midi.last_change()
    assert "line 2" in midi_show.midi.last_change()
    assert [type(event) for event in midi_show.play((0x90, 36, 1))] == [events.Blackout]
    with pytest.raises(PatchError, match=r"mine\.midi\.toml, line 2"):
        read_patch(midi_show.path)


def test_echoed_feedback_is_not_taken_as_input(midi_show: MidiShow) -> None:
    midi_show.learn("/dance/blackout")
    midi_show.play((0x90, 36, 1))

    def show_says(on: ArgumentValue) -> None:
        midi_show.midi.publish({"/dance/blackout": (("", (on,)),)})
        midi_show.clock.advance(0.1)
        midi_show.midi.frame()

    show_says(True)
    assert midi_show.tells.told == [b"\x90\x24\x7f"]
    assert midi_show.play((0x90, 36, 127)) == []  # the echo
    (event,) = midi_show.play((0x90, 36, 127))
    assert isinstance(event, events.Blackout)
    assert not event.on


def test_escape_in_window_ends_learning_before_show(midi_show: MidiShow) -> None:
    posted: list[ControlEvent] = []
    session = SimpleNamespace(midi=midi_show.midi, inbox=SimpleNamespace(put=posted.append))
    window = SimpleNamespace(_session=session, _window=SimpleNamespace(fullscreen=False), close_requested=False)
    midi_show.learn("/dance/go")
    OperatorInput._escape(cast(Any, window), 2.0)
    assert posted == [LearnMidi(time=2.0, source="key", address="")]
    assert not window.close_requested
    midi_show.midi.handle(posted[0])
    OperatorInput._escape(cast(Any, window), 3.0)
    assert window.close_requested
    assert len(posted) == 1
