"""The operator's keys and pointer as data: one table for the window, the help text, the overlay and the README.

Keys that change the show go through the same registry as OSC; the others (full screen, overlay) concern the window.
Esc is not in the table: it must never end a show in full screen.
"""

from dataclasses import dataclass
from typing import Final, Literal

from live.control.events import ControlEvent
from live.control.registry import REGISTRY

SOURCE: Final = "key"
POINTER_SOURCE: Final = "pointer"


@dataclass(frozen=True, slots=True)
class Key:
    """What a key does: `what` is the address of a control, or what the window does by itself."""

    description: str
    what: Literal[
        "/dance/clock/tap",
        "/dance/clock/one",
        "/dance/blackout",
        "/dance/spread",
        "window/fullscreen",
        "window/overlay",
    ]

    @property
    def is_control(self) -> bool:
        """Whether it changes the show (and so makes an event), not only the window."""
        return self.what.startswith("/")


KEYS: Final[dict[str, Key]] = {
    "Space": Key("tap the beat", "/dance/clock/tap"),
    "1": Key("this is the one: a measure begins now", "/dance/clock/one"),
    "B": Key("blackout, and back", "/dance/blackout"),
    "F": Key("full screen, and back", "window/fullscreen"),
    "O": Key("overlay: tempo, beat, measure, frame times, dancers", "window/overlay"),
    "S": Key("spread over the stage", "/dance/spread"),
}
"""Keys by name: a letter or digit stands for itself, in upper case."""

POINTER: Final[dict[str, str]] = {
    "click or drag on the floor": "attractor: dancers gather there",
    "Shift + click or drag": "repulsor: dancers leave the place",
}
"""What the pointer does, for the help text."""


def event_for_key(name: str, *, time: float, blackout_now: bool) -> ControlEvent | None:
    """The event of a key pressed at `time` [s of the show]; None for keys that make none (unknown, or the window's)."""
    key = KEYS.get(name.upper() if len(name) == 1 else name)
    if key is None or not key.is_control:
        return None
    values = (not blackout_now,) if key.what == "/dance/blackout" else ()
    result = REGISTRY.call(key.what, values, time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def event_for_pointer(x: float, z: float, shift: bool, time: float) -> ControlEvent | None:
    """An attractor, with shift a repulsor, at (x, z) [m]; None where the floor is too far away or not hit (NaN)."""
    place = (float(x), float(z))  # the window computes with numpy's floats, the registry knows only plain ones
    result = REGISTRY.call("/dance/repel" if shift else "/dance/attract", place, time, POINTER_SOURCE)
    return result if isinstance(result, ControlEvent) else None


def help_lines() -> list[str]:
    """One line for each key and for the pointer."""
    rows = [(name, key.description) for name, key in KEYS.items()] + list(POINTER.items())
    width = max(len(name) for name, _ in rows)
    return [f"{name:<{width}}  {description}" for name, description in rows]
