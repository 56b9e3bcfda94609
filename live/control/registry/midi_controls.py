"""Controls of MIDI learn during a show."""

from typing import Final

from live.control.events.events import ControlEvent
from live.control.events.midi import ForgetMidi, LearnMidi
from live.control.registry.control import Argument, Control

_WORDS: Final = ("first", "second", "third", "fourth")


def _learn(*, time: float, source: str, address: str, **words: str) -> ControlEvent:
    given = "\n".join(words[name] for name in _WORDS if words[name])
    return LearnMidi(time=time, source=source, address=address, given=given)


MIDI_CONTROLS: Final = (
    Control(
        "/dance/midi/learn", _learn,
        (
            Argument("address", "text", "of the control; empty: cancel", default=""),
            *(
                Argument(name, "text", "a fixed value: a group, a scene's name …, or `name=value`", default="")
                for name in _WORDS
            ),
        ),
        "Binds this control to the next MIDI controller, pad or key that is moved; saved with the patch.",
        "operator",
    ),
    Control(
        "/dance/midi/forget", ForgetMidi,
        (Argument("address", "text", "of the control"),),
        "Removes the learned bindings of this control.", "operator",
    ),
)  # fmt: skip
"""The controls under /dance/midi."""
