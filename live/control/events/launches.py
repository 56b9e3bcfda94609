"""Commands of pads: what is launched for some dancers, at once, on the beat, on the measure or on the section."""

from dataclasses import dataclass
from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import Dancers, command
from live.control.registry.control import Argument


@command("/dance/launch", "operator", edits="launches")
class Launch(ControlEvent):
    """Launches a pad for these dancers. They have one of each at a time: steps, a formation, an element, a look; the
    later one counts."""

    pad: Annotated[
        str,
        Argument.text("kind and name: `step couru`, `phrase 2`, `formation circle`, `element spread`, `scene dusk`, "
                      "`cue 3`, `own NAME` of a [[pad]]"),
    ]  # fmt: skip
    group: Dancers = "*"
    when: Annotated[
        str,
        Argument.label("`now`, `beat`, `measure` or `section`: when it begins; without sections the last one is the "
                       "end of a phrase of the music, or of eight measures"),
    ] = "measure"  # fmt: skip
    measures: Annotated[
        float, Argument.number("how long it lasts; 0: as its [[pad]] says, else 4", 0, 1024, "measures")
    ] = 0.0
    follow: Annotated[
        str,
        Argument.label("what follows it: `stop`, `again`, `next`, `first`, `other`, of the pads of its kind; left out: "
                       "as its [[pad]] says, else `stop`"),
    ] = ""  # fmt: skip


@command("/dance/launch/stop", "operator")
class StopLaunches(ControlEvent):
    """Stops what was launched for these dancers, also what waits: back to the score. `*` stops everything."""

    group: Dancers = "*"


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchEnded(ControlEvent):
    """Something launched ends before its own end, or has none. Its `source` is that of the launched event."""

    what: str
    """`step`, `phrase`, `motion` or `elements`."""
    group: str
    """The dancers for whom it was launched."""
