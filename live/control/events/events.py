"""All event types: every input that can change a show, as a frozen value with time and source.

The journal of a show is its patch, its seed and its events, each with the tick at which it was applied.
"""

from typing import Final

from live.control.events import (
    audience,
    audio,
    capture,
    clock,
    cues,
    document,
    elements,
    groups,
    launches,
    midi,
    motion,
    output,
    parameters,
    partners,
    scenes,
    score,
    system,
)
from live.control.events.audience import *  # noqa: F403
from live.control.events.audio import *  # noqa: F403
from live.control.events.capture import *  # noqa: F403
from live.control.events.clock import *  # noqa: F403
from live.control.events.cues import *  # noqa: F403
from live.control.events.document import *  # noqa: F403
from live.control.events.elements import *  # noqa: F403
from live.control.events.event import ControlEvent as ControlEvent
from live.control.events.groups import *  # noqa: F403
from live.control.events.launches import *  # noqa: F403
from live.control.events.midi import *  # noqa: F403
from live.control.events.motion import *  # noqa: F403
from live.control.events.output import *  # noqa: F403
from live.control.events.parameters import *  # noqa: F403
from live.control.events.partners import *  # noqa: F403
from live.control.events.scenes import *  # noqa: F403
from live.control.events.score import *  # noqa: F403
from live.control.events.system import *  # noqa: F403

MODULES: Final = (
    elements, groups, motion, launches, parameters, partners, scenes, cues, output, audience, clock, audio, score,
    capture, system, midi, document,
)  # fmt: skip
"""The modules that declare commands and events, in the order of the reference."""

EVENT_TYPES: Final[dict[str, type[ControlEvent]]] = {
    name: cls
    for module in MODULES
    for name, cls in vars(module).items()
    if isinstance(cls, type) and issubclass(cls, ControlEvent) and cls.__module__ == module.__name__
}
"""All event types by their names in the journal."""
