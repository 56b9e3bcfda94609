"""Keyboard commands of the operator: one table for the window, the help text, the overlay and the README.

Keys that change the show call the same registry as OSC. The others (full screen, overlay) concern the window only. Esc
is not in the table: it must never end a show in full screen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from live.control.events.events import ControlEvent
from live.control.pointer import TOOLS
from live.control.registry.registry import REGISTRY

SOURCE: Final = "key"


@dataclass(frozen=True, slots=True)
class Key:
    """Command of a key."""

    description: str
    command: str
    """A control's address, or a command of the window."""
    values: tuple[float, ...] = ()
    """Arguments for the control."""

    @property
    def is_control(self) -> bool:
        """Whether the key changes the show (and so makes an event), not only the window."""
        return self.command.startswith("/")


KEYS: Final[dict[str, Key]] = {
    "Space": Key("tap the beat", "/dance/clock/tap"),
    "1": Key("downbeat: a measure begins now", "/dance/clock/one"),
    "Left": Key("shift the beats 10 ms earlier", "/dance/clock/nudge", (-0.01,)),
    "Right": Key("shift the beats 10 ms later", "/dance/clock/nudge", (0.01,)),
    ",": Key("shift the measure line one beat earlier", "/dance/clock/shift", (-1.0,)),
    ".": Key("shift the measure line one beat later", "/dance/clock/shift", (1.0,)),
    "J": Key("shift half a beat later: off-beats become beats", "/dance/clock/shift", (0.5,)),
    "-": Key("take the measure line that the music suggests", "/dance/clock/take"),
    "Down": Key("half tempo", "/dance/clock/half"),
    "Up": Key("double tempo", "/dance/clock/double"),
    "Z": Key("freeze the tempo, or follow it again", "/dance/clock/hold"),
    "N": Key("count in: one measure, then the downbeat", "/dance/clock/count_in"),
    "M": Key("reopen the microphone (or line); the dance continues", "/dance/audio/restart"),
    "B": Key("blackout on or off", "/dance/blackout"),
    "F": Key("full screen on or off", "window/fullscreen"),
    "O": Key("overlay: tempo, beat, measure, frame times, dancers", "window/overlay"),
    "G": Key("guides: each dancer's agent and target, and locked feet", "window/guides"),
    "S": Key("spread over the stage", "/dance/spread"),
    "W": Key("wander", "/dance/wander"),
    "K": Key("move as a flock", "/dance/flock"),
    "H": Key("hold: stay in place for four measures", "/dance/pause"),
    "C": Key("clear: all elements and evolutions end", "/dance/clear"),
    "Enter": Key("GO: the cue on standby", "/dance/go"),
    "Backspace": Key("cancel a cue that is counting in, or put the previous cue on standby", "/dance/back"),
    "I": Key("hold or resume score, fades and cues", "/dance/hold"),
    "Delete": Key("panic: end everything added, restore the patch's light, hold the score", "/dance/panic"),
    "F5": Key("give the camera to its director", "/dance/camera/director", (1.0,)),
    "Q": Key("show or hide the code for joining the audience", "/dance/audience/qr"),
    "E": Key("undo the last edit", "/dance/undo"),
    "Y": Key("redo the last undone edit", "/dance/redo"),
    "F6": Key("fade the picture out or in within eight beats", "/dance/output/fade"),
    "F7": Key("freeze or unfreeze the picture", "/dance/output/freeze"),
    "F8": Key("next test card, or back to the picture", "window/card"),
    "F9": Key("start or finish editing the projector warp", "window/edit"),
}
"""Keys by name; letters and digits are named by themselves, in upper case."""

FADE_BEATS: Final = 8.0
"""Duration of the key's picture fade [beats]."""

FORMATION_KEYS: Final = "23456789"
"""Keys that send all dancers to the patch's formations, in order: from the next measure on, in four measures."""


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
    """Return the event of a key pressed at `time` [s of the show]; None for unknown keys and keys of the window.

    The other parameters give the present state of the switches that keys toggle: `held_now` (the tempo), `frozen_now`
    (the picture), `dark_now` (faded out or fading out), `code_now` (the join code is shown).
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
    values = switches.get(key.command, key.values)
    result = REGISTRY.call(key.command, values, time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def event_for_formation(name: str, *, time: float) -> ControlEvent | None:
    """Return the event that sends all dancers to formation `name` from the next measure on, in four measures."""
    result = REGISTRY.call("/dance/formation", (name, 4.0, "*", True), time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def help_lines(formations: Sequence[str] = ()) -> list[str]:
    """Return help lines for the keys, the pointer's tools, and those of the patch's `formations` that have a key."""
    rows = [(name, key.description) for name, key in KEYS.items()]
    rows += [(key, f"formation {name}") for key, name in zip(FORMATION_KEYS, formations, strict=False)]
    rows += [(name, f"pointer: {tool.description}") for name, tool in TOOLS.items()]
    return [f"{name:<5}  {description}" for name, description in rows]
