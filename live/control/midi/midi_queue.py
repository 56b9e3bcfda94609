"""Queueing of events from a MIDI port: a fader's value replaces its earlier unread value."""

from live.base.event_queue import PriorityQueue
from live.control.events.events import ControlEvent
from live.control.midi.midi_binding import Binding
from live.control.registry.control import Control
from live.control.registry.registry import REGISTRY

ALL_GROUPS = ("", "*")
"""Names that mean all groups."""


def put_mapped_event(lane: PriorityQueue[ControlEvent], binding: Binding, event: ControlEvent) -> None:
    """Put an event of `binding` into the lane, under the same key as OSC. Call from the lane's writer thread."""
    control: Control = REGISTRY[binding.control]
    if control.kind == "event":
        lane.put(event)
        return
    whom = control.addressees([binding.values.get(argument.name) for argument in control.arguments])
    # A value for one group keeps its place among values for all groups, because their order matters.
    lane.put(
        event, (binding.control, *whom), ordered=bool(whom) and not control.named and whom[-1].strip() not in ALL_GROUPS
    )
