"""What hands do on a MIDI port, in a lane of its own: of a fader's values that nobody has taken yet the last counts."""

from live.base.event_queue import Lane
from live.control.events.events import ControlEvent
from live.control.midi.midi_binding import Binding
from live.control.registry.control import Control
from live.control.registry.registry import REGISTRY

WHOLE = ("", "*")
"""Names of all groups."""


def put_by_hand(lane: Lane[ControlEvent], binding: Binding, event: ControlEvent) -> None:
    """Put what `binding` made into the lane, under the key that OSC has for the same; thread: the lane's writer."""
    control: Control = REGISTRY[binding.control]
    if control.kind == "event":
        lane.put(event)
        return
    whom = control.whom([binding.values.get(argument.name) for argument in control.arguments])
    # Who sets one group between two values for all is put behind them: the order matters then.
    lane.put(event, (binding.control, *whom), after=bool(whom) and not control.named and whom[-1].strip() not in WHOLE)
