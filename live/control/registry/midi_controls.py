"""What MIDI controllers work, taught while a show runs."""

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
            Argument("address", "text", "of the control; empty: nothing after all", default=""),
            *(
                Argument(name, "text", "always the same: a group, a scene's name …, or `name=value`", default="")
                for name in _WORDS
            ),
        ),
        "The next MIDI controller, pad or key that is moved works this control from then on; the patch keeps it.",
        "operator",
    ),
    Control(
        "/dance/midi/forget", ForgetMidi,
        (Argument("address", "text", "of the control"),),
        "What was learned for this control works it no more.", "operator",
    ),
)  # fmt: skip
"""The addresses under /dance/midi."""
