"""A show is taught its controllers, and the patch keeps them: comments stay, edits and reloads fight nothing."""

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


class Tells:
    """A controller that is told."""

    def __init__(self) -> None:
        self.told: list[bytes] = []
        self.connected, self.opened = "pads", 1
        self.send = self.told.append


class Stage:
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
        self.tells = Tells()
        self.midi = MidiService(
            self.show, self.clock, self.path,
            midi_input=self.listens, midi_map=midi_map, feedback_output=cast(Any, self.tells), values=values,
        )  # fmt: skip

    def learn(self, address: str, given: str = "") -> None:
        self.midi.handle(LearnMidi(time=0.0, source="osc", address=address, given=given))

    def forget(self, address: str) -> None:
        self.midi.handle(ForgetMidi(time=0.0, source="osc", address=address))

    def play(self, *messages: tuple[int, ...]) -> list[ControlEvent]:
        for message in messages:
            self.listens.decode(message, self.clock.now())
        self.midi.frame()
        self.midi.learning._writer.wait()
        return [event for event in self.inbox.drain() if not isinstance(event, events.NotesHeard)]

    def reload(self) -> None:
        """As when the watched patch is taken."""
        self.midi.update_patch(read_patch(self.path))


@pytest.fixture
def stage(tmp_path: Path) -> Stage:
    return Stage(tmp_path)


def test_what_is_moved_works_the_control_and_stands_beside_the_patch(stage: Stage) -> None:
    before = file_stamp(stage.path)
    assert [type(event) for event in stage.play((0x90, 50, 1))] == [events.Go]
    stage.learn("/dance/motion/larger", "front")
    assert "/dance/motion/larger" in stage.midi.prompt()
    (moved,) = stage.play((0xB0, 7, 1), (0xB0, 7, 9), (0xB0, 7, 0))  # it goes on moving before the next frame
    assert isinstance(moved, events.SetMotion)
    assert stage.midi.prompt() == ""
    (moved,) = stage.play((0xB0, 7, 127))
    assert isinstance(moved, events.SetMotion)
    assert (moved.value, moved.group) == (0.5, "front")
    patch = read_patch(stage.path)
    assert [line.control for line in patch.midi.learned] == ["/dance/motion/larger"]
    assert [one.control for one in patch.midi.bindings] == ["/dance/go", "/dance/motion/larger"]
    assert patch.midi.bindings == stage.midi.learning.bindings
    assert file_stamp(stage.path) != before  # so the watched patch is read anew
    assert stage.path.read_text() == PATCH + WRITTEN


def test_a_patch_that_is_read_anew_takes_nothing_away_that_was_learned_meanwhile(stage: Stage) -> None:
    stage.learn("/dance/blackout")
    stage.play((0x90, 36, 1))
    old = read_patch(stage.path)
    stage.learn("/dance/spread")
    stage.play((0x90, 37, 1))
    stage.midi.update_patch(old)  # it was on its way
    assert [type(event) for event in stage.play((0x90, 36, 1), (0x90, 37, 1))] == [events.Blackout, events.Spread]
    stage.reload()
    assert stage.midi.learning._added == []
    assert [type(event) for event in stage.play((0x90, 36, 1), (0x90, 37, 1))] == [events.Blackout, events.Spread]
    stage.forget("/dance/spread")
    stage.midi.update_patch(old)
    assert [type(event) for event in stage.play((0x90, 36, 1), (0x90, 37, 1))] == [events.Blackout]
    stage.reload()
    learned_path(stage.path).unlink()  # by the person's hand
    stage.reload()
    assert stage.play((0x90, 36, 1)) == []


def test_comments_and_what_a_person_wrote_stay(stage: Stage) -> None:
    text = '# my pads\n[[midi.learned]]\nnote = 40  # top left\ncontrol = "/dance/go"\n\n'
    text += '[[midi.learned]]\nnote = 41\ncontrol = "/dance/clear"\n'
    learned_path(stage.path).write_text(text)
    stage.reload()
    stage.learn("/dance/blackout")
    stage.play((0x93, 44, 1))
    now = learned_path(stage.path).read_text()
    assert now.startswith(text)
    stage.learn("/dance/panic")
    stage.play((0x93, 44, 1))  # the same pad: it does one thing
    patch = read_patch(stage.path)
    assert [line.control for line in patch.midi.learned] == ["/dance/go", "/dance/clear", "/dance/panic"]
    for address in ("/dance/panic", "/dance/clear"):
        stage.forget(address)
        stage.midi.learning._writer.wait()
    assert learned_path(stage.path).read_text().strip() == text.partition("\n\n")[0]


def test_what_cannot_be_learned_or_forgotten_is_said(stage: Stage) -> None:
    stage.learn("/dance/nowhere")
    assert "no control is called" in stage.midi.refusal()
    stage.learn("/dance/clock/tempo")
    assert stage.midi.refusal() == ""
    stage.learn("")
    assert stage.midi.prompt() == ""
    assert len(stage.play((0xB0, 7, 1), (0xB0, 7, 60))) == 2  # the patch's own map again
    stage.forget("/dance/clock/tempo")
    assert "the patch's own map" in stage.midi.refusal()
    stage.forget("/dance/panic")
    assert "nothing was learned" in stage.midi.refusal()
    deaf = MidiService(stage.show, stage.clock, stage.path)
    deaf.handle(LearnMidi(time=0.0, source="osc", address="/dance/go"))
    assert "--midi NAME" in deaf.refusal()


def test_a_file_that_cannot_be_kept_is_said_and_the_show_goes_on(stage: Stage) -> None:
    learned_path(stage.path).write_text("[[midi.learned]]\nnote = 400\n")
    stage.learn("/dance/blackout")
    stage.play((0x90, 36, 1))
    assert "NOT SAVED" in stage.midi.last_change()
    assert "line 2" in stage.midi.last_change()
    assert [type(event) for event in stage.play((0x90, 36, 1))] == [events.Blackout]
    with pytest.raises(PatchError, match=r"mine\.midi\.toml, line 2"):
        read_patch(stage.path)


def test_what_a_pad_is_told_that_comes_back_over_a_cable_is_no_hand(stage: Stage) -> None:
    stage.learn("/dance/blackout")
    stage.play((0x90, 36, 1))

    def show_says(on: ArgumentValue) -> None:
        stage.midi.publish({"/dance/blackout": (("", (on,)),)})
        stage.clock.advance(0.1)
        stage.midi.frame()

    show_says(True)
    assert stage.tells.told == [b"\x90\x24\x7f"]
    assert stage.play((0x90, 36, 127)) == []  # the echo
    (event,) = stage.play((0x90, 36, 127))
    assert isinstance(event, events.Blackout)
    assert not event.on


def test_esc_in_the_window_ends_learning_and_then_the_show(stage: Stage) -> None:
    posted: list[ControlEvent] = []
    session = SimpleNamespace(midi=stage.midi, inbox=SimpleNamespace(put=posted.append))
    window = SimpleNamespace(_session=session, _window=SimpleNamespace(fullscreen=False), close_requested=False)
    stage.learn("/dance/go")
    OperatorInput._escape(cast(Any, window), 2.0)
    assert posted == [LearnMidi(time=2.0, source="key", address="")]
    assert not window.close_requested
    stage.midi.handle(posted[0])
    OperatorInput._escape(cast(Any, window), 3.0)
    assert window.close_requested
    assert len(posted) == 1
