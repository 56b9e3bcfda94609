"""The operator's keys and pointer as data: one table for the window, the help text, the overlay and the README.

Keys that change the show go through the same registry as OSC; the others (full screen, overlay) concern the window.
Esc is not in the table: it must never end a show in full screen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.control.events.events import ControlEvent
from live.control.pointer import TOOLS
from live.control.registry.registry import REGISTRY

SOURCE: Final = "key"


@dataclass(frozen=True, slots=True)
class Key:
    """What a key does: `what` is the address of a control, or what the window does by itself."""

    description: str
    what: Literal[
        "/dance/clock/tap",
        "/dance/clock/one",
        "/dance/clock/nudge",
        "/dance/clock/shift",
        "/dance/clock/half",
        "/dance/clock/double",
        "/dance/clock/hold",
        "/dance/clock/count_in",
        "/dance/audio/restart",
        "/dance/blackout",
        "/dance/spread",
        "/dance/wander",
        "/dance/flock",
        "/dance/pause",
        "/dance/clear",
        "/dance/go",
        "/dance/back",
        "/dance/panic",
        "/dance/hold",
        "/dance/output/fade",
        "/dance/output/freeze",
        "/dance/audience/qr",
        "/dance/undo",
        "/dance/redo",
        "window/fullscreen",
        "window/overlay",
        "window/guides",
        "window/card",
        "window/edit",
    ]

    values: tuple[float, ...] = ()
    """What the key gives to the control."""

    @property
    def is_control(self) -> bool:
        """Whether it changes the show (and so makes an event), not only the window."""
        return self.what.startswith("/")


KEYS: Final[dict[str, Key]] = {
    "Space": Key("tap the beat", "/dance/clock/tap"),
    "1": Key("this is the one: a measure begins now", "/dance/clock/one"),
    "Left": Key("the beats 10 ms earlier", "/dance/clock/nudge", (-0.01,)),
    "Right": Key("the beats 10 ms later", "/dance/clock/nudge", (0.01,)),
    ",": Key("the measure line a beat earlier", "/dance/clock/shift", (-1.0,)),
    ".": Key("the measure line a beat later", "/dance/clock/shift", (1.0,)),
    "J": Key("half a beat later: the off-beat is the beat", "/dance/clock/shift", (0.5,)),
    "Down": Key("half tempo", "/dance/clock/half"),
    "Up": Key("double tempo", "/dance/clock/double"),
    "Z": Key("freeze the tempo, and follow again", "/dance/clock/hold"),
    "N": Key("count in: a measure, then the one", "/dance/clock/count_in"),
    "M": Key("open the microphone (or line) anew; the dance goes on", "/dance/audio/restart"),
    "B": Key("blackout, and back", "/dance/blackout"),
    "F": Key("full screen, and back", "window/fullscreen"),
    "O": Key("overlay: tempo, beat, measure, frame times, dancers", "window/overlay"),
    "G": Key("guides: where each dancer's agent is, where she is sent, which feet are held", "window/guides"),
    "S": Key("spread over the stage", "/dance/spread"),
    "W": Key("wander", "/dance/wander"),
    "K": Key("go as a flock", "/dance/flock"),
    "H": Key("hold: stay in place for four measures", "/dance/pause"),
    "C": Key("clear: all elements and evolutions end", "/dance/clear"),
    "Enter": Key("GO: the cue that stands by", "/dance/go"),
    "Backspace": Key("take back a cue that is counting in, or let the one before stand by", "/dance/back"),
    "I": Key("hold score, fades and cues, and let them go on", "/dance/hold"),
    "Delete": Key("panic: all that was added ends, the patch's own light, the score held", "/dance/panic"),
    "Q": Key("show the code that the audience joins by, and hide it", "/dance/audience/qr"),
    "E": Key("undo the last edit", "/dance/undo"),
    "Y": Key("make it again", "/dance/redo"),
    "F6": Key("fade the picture out within eight beats, and in again", "/dance/output/fade"),
    "F7": Key("freeze the picture, and let it go on", "/dance/output/freeze"),
    "F8": Key("the next test card, or the picture again", "window/card"),
    "F9": Key("bend the picture on the projector, and be done with it", "window/edit"),
}
"""Keys by name: a letter or digit stands for itself, in upper case."""

FADE_BEATS: Final = 8.0
"""Beats in which the key fades the picture."""

FORMATION_KEYS: Final = "23456789"
"""Keys that send everybody to the patch's formations, in their order; from the next measure, in four measures."""


def event_for_key(
    name: str,
    *,
    time: float,
    blackout_now: bool,
    held_now: bool = False,
    show_held_now: bool = False,
    frozen_now: bool = False,
    dark_now: bool = False,
    code_now: bool = False,
) -> ControlEvent | None:
    """The event of a key pressed at `time` [s of the show]; None for keys that make none (unknown, or the window's).

    `blackout_now`, `held_now` (the tempo), `show_held_now`, `frozen_now` (the picture), `dark_now` (it is faded out, or
    fades out), `code_now` (the code is shown): how those switches stand; their keys turn them over.
    """
    key = KEYS.get(name.upper() if len(name) == 1 else name)
    if key is None or not key.is_control:
        return None
    switches: dict[str, tuple[float, ...]] = {
        "/dance/blackout": (not blackout_now,),
        "/dance/clock/hold": (not held_now,),
        "/dance/hold": (not show_held_now,),
        "/dance/output/freeze": (not frozen_now,),
        "/dance/audience/qr": (not code_now,),
        "/dance/output/fade": (float(dark_now), FADE_BEATS),
    }
    values = switches.get(key.what, key.values)
    result = REGISTRY.call(key.what, values, time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def event_for_formation(name: str, *, time: float) -> ControlEvent | None:
    """Everybody goes to the formation `name` from the next measure line on, in four measures."""
    result = REGISTRY.call("/dance/formation", (name, 4.0, "*", True), time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def help_lines(formations: Sequence[str] = ()) -> list[str]:
    """One line for each key, for the pointer's tools, and for the patch's `formations` that have a key."""
    rows = [(name, key.description) for name, key in KEYS.items()]
    rows += [(key, f"formation {name}") for key, name in zip(FORMATION_KEYS, formations, strict=False)]
    rows += [(name, f"pointer: {tool.description}") for name, tool in TOOLS.items()]
    return [f"{name:<5}  {description}" for name, description in rows]
